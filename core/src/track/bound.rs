//! The most work that a tracker can do, whatever the frames show: what a deadline is planned by.

/// The most work of a tracker, in the units of [`Update::step`](crate::Update::step): what [`Target::most_work`](crate::Target::most_work)
/// computes from the numbers of the code itself.
///
/// ```
/// use smr_core::{Paper, Robust, Target, paper, robust};
/// // A box of 64x64 pixels in a window of +-16.
/// let mut config = paper::Config::camera();
/// config.window = paper::Radius { x: 16, y: 16 };
/// config.window_limit = config.window;
/// let most = Paper::<4096, 33>::most_work(&config, 64, 64);
/// let every_offset = 33 * 33 * 64 * 64;
/// // Where a tracked target begins to leave the picture, the window is gone through twice.
/// assert!(most.update > 2 * every_offset && most.update < every_offset * 9 / 4);
/// // Its size does not matter to the robust tracker.
/// assert_eq!(robust::Config::robust().most_work(), Robust::most_work(&robust::Config::robust(), 640, 480));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct MostWork {
    /// Of an update.
    pub update: u64,
    /// Of a lock.
    pub lock: u64,
    /// By how much a step may go beyond the work that was asked for: a unit of work that cannot be divided. Nor does the beginning of an
    /// update or a lock do more.
    pub beyond_a_step: u32,
}
