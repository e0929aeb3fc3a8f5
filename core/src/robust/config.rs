//! What the robust tracker is made with.

use super::tuning::Tuning;
use crate::similarity::{Backend, Table};

/// The configuration of a [`Tracker`](super::Tracker).
///
/// ```
/// use smr_core::robust::{Config, Tracker};
/// let tracker = Tracker::new(Config::robust());
/// assert!(tracker.window().is_none());
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Config {
    /// The similarity of two pixels by their difference.
    pub table: &'static Table,
    /// How scores are computed; it changes nothing but the time. `None` is the fastest way that the machine has.
    pub backend: Option<Backend>,
    /// Under trial.
    pub tuning: Tuning,
}

impl Config {
    /// All parts.
    #[must_use]
    pub const fn robust() -> Self {
        Self { table: &Table::PAPER, backend: None, tuning: Tuning::BEST }
    }
}

impl Default for Config {
    fn default() -> Self {
        Self::robust()
    }
}
