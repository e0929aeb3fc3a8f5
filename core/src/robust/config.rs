//! What the robust tracker consists of: its parts and their switches.

use crate::Fraction;
use crate::similarity::{Backend, Table};

/// Where alpha comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ThresholdRule {
    /// 7/5 of the template's mean absolute deviation from its mean, 8 to 100 gray levels.
    Contrast,
    /// The paper's: this part of the largest change of a pixel from one template to the next.
    LargestChange(Fraction),
}

/// The parts of [`Tracker`](super::Tracker), all of them in [`Config::robust`]; without one it does what the paper's tracker
/// does in its place.
///
/// ```
/// use smr_core::robust::{Config, Tracker};
/// let mut config = Config::robust();
/// config.cells = false; // a target whose distance does not change
/// let tracker: Tracker = Tracker::new(config);
/// assert!(tracker.window().is_none());
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Config {
    /// The similarity of two pixels by their difference.
    pub table: &'static Table,
    /// Small targets are enlarged, up to twice; without, the grid is never finer than the frame.
    pub enlarging: bool,
    /// Where alpha comes from.
    pub threshold: ThresholdRule,
    /// Whether a running mean of the patches is compared beside the last one.
    pub slow_template: bool,
    /// Whether the early template, in the light of the last patch, has a say in where between the templates' peaks the target
    /// is; it drifts least of all.
    pub anchor: bool,
    /// Whether positions are finer than a pixel of the grid.
    pub sub_pixel: bool,
    /// Whether the box follows the target's size.
    pub cells: bool,
    /// Whether an early template is asked, part by part, if it is still the target; without, the state is always tracking.
    pub verification: bool,
    /// Whether a lost or doubtful target is looked for all over the frame; needs `verification`.
    pub sweep: bool,
    /// How scores are computed; it changes nothing but the time. `None` is the fastest way that the machine has.
    pub backend: Option<Backend>,
    /// Whether offsets that cannot matter are left out; it changes nothing but the time.
    pub pruning: bool,
}

impl Config {
    /// All parts.
    #[must_use]
    pub const fn robust() -> Self {
        Self {
            table: &Table::PAPER,
            enlarging: true,
            threshold: ThresholdRule::Contrast,
            slow_template: true,
            anchor: true,
            sub_pixel: true,
            cells: true,
            verification: true,
            sweep: true,
            backend: None,
            pruning: true,
        }
    }
}

impl Default for Config {
    fn default() -> Self {
        Self::robust()
    }
}
