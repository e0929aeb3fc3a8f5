//! The most work of a tracker, for planning deadlines.

/// The most work of a tracker for any frame, in the units of [`Tracker::update_step`](crate::Tracker::update_step). Computed by
/// [`Target::most_work`](crate::Target::most_work).
///
/// ```
/// use smr_core::{Paper, Robust, Target, paper, robust};
/// // A box of 64x64 pixels in a window of +-16.
/// let mut config = paper::Config::camera();
/// config.window = paper::Radius { x: 16, y: 16 };
/// config.window_limit = config.window;
/// let most = Paper::<4096, 33>::most_work(&config, 64, 64);
/// let every_offset = 33 * 33 * 64 * 64;
/// // If the peak of a tracked target is partly outside the frame, the window is searched twice.
/// assert!(most.update > 2 * every_offset && most.update < every_offset * 9 / 4);
/// // For the robust tracker the size of the box does not matter.
/// assert_eq!(robust::Config::robust().most_work(), Robust::most_work(&robust::Config::robust(), 640, 480));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct MostWork {
    /// The most work of an update.
    pub update: u64,
    /// The most work of a lock.
    pub lock: u64,
    /// The most work by which a step exceeds its grant: its last piece of work cannot be divided. The last step of a
    /// call makes one more pass over the template and the weights.
    pub beyond_a_step: u32,
}
