//! What the robust tracker is made with: its parts and their switches.

use crate::similarity::{Backend, Table};

/// The configuration of a [`Tracker`](super::Tracker): all parts in [`Config::robust`].
///
/// ```
/// use smr_core::robust::{Config, Tracker};
/// let mut config = Config::robust();
/// config.size = false; // a target whose distance does not change
/// let tracker = Tracker::new(config);
/// assert!(tracker.window().is_none());
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Config {
    /// The similarity of two pixels by their difference.
    pub table: &'static Table,
    /// Whether a target that moves is expected to go on; without, it is expected where it was.
    pub velocity: bool,
    /// Whether places far from where the target is expected must answer more clearly.
    pub near: bool,
    /// Whether the box follows the target's size.
    pub size: bool,
    /// Whether an early template is asked if it is still the target: without, the state is always tracking.
    pub verification: bool,
    /// Whether what does not agree with the early template is kept from being learned; needs `verification`.
    pub caution: bool,
    /// Whether a lost target is looked for all over the frame; needs `verification`.
    pub sweep: bool,
    /// How sums are computed; it changes nothing but the time. `None` is the fastest way that the machine has.
    pub backend: Option<Backend>,
}

impl Config {
    /// All parts.
    #[must_use]
    pub const fn robust() -> Self {
        Self {
            table: &Table::PAPER,
            velocity: true,
            near: true,
            size: true,
            verification: true,
            caution: true,
            sweep: true,
            backend: None,
        }
    }
}

impl Default for Config {
    fn default() -> Self {
        Self::robust()
    }
}
