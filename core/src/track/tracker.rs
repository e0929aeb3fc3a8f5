//! A target together with its workspace, for following a single target.

use super::update;
use super::{Answer, ConfigError, LockError, Quality, RestoreError, SaveError, State, Target, UpdateError};
use crate::image::{FineRect, Frame, Rect, Windows};
use core::fmt;

/// Follows one target: a [`Target`] and its workspace. Holds all memory; there is no heap.
///
/// `Tracker<Paper<PIXELS, SPAN>>` is the paper tracker, `Tracker<Robust>` the robust one. All calls are the same. The
/// [crate's example](crate) uses whole frames. This one reads out only the windows that the tracker needs:
///
/// ```
/// use smr_core::paper::{Config, Radius};
/// use smr_core::{Frame, Paper, Rect, Tracker, Windows};
/// # fn read_out(windows: Windows) -> Vec<u8> {
/// #     let pixel = |x: i32, y: i32| ((x * x + 3 * y * y) % 251) as u8;
/// #     let row = |window: Rect, y| (window.x..window.right()).map(move |x| pixel(x, y));
/// #     windows.iter().flat_map(|window| (window.y..window.bottom()).flat_map(move |y| row(window, y))).collect()
/// # }
/// # fn main() -> Result<(), smr_core::Error> {
/// let mut config = Config::camera();
/// config.window = Radius { x: 8, y: 8 };
/// config.window_limit = config.window;
/// let mut tracker = Tracker::<Paper<64, 17>>::with(config)?;
///
/// // A box of 8x8 pixels on a sensor of 320x240.
/// let (sensor, target) = (Rect::new(0, 0, 320, 240), Rect::new(100, 50, 8, 8));
/// assert_eq!(tracker.lock_window(sensor, target), target);
/// let pixels = read_out(target.into());
/// tracker.lock(&Frame::of_windows(&pixels, target, (320, 240))?, target)?;
///
/// // The next update reads the box and 8 pixels around it.
/// let windows = tracker.windows().unwrap();
/// assert_eq!(windows, Rect::new(92, 42, 24, 24).into());
/// let pixels = read_out(windows);
/// let answer = tracker.update(&Frame::of_windows(&pixels, windows, (320, 240))?)?;
/// assert_eq!(answer.bbox, target);
/// # Ok(())
/// # }
/// ```
pub struct Tracker<T: Target> {
    target: T,
    workspace: T::Workspace,
}

/// Defines methods that return the result of the target's method of the same name.
macro_rules! of_the_target {
    ($($name:ident: $type:ty),+) => {$(
        #[doc = concat!("See [`Target::", stringify!($name), "`].")]
        pub fn $name(&self) -> Option<$type> {
            self.target.$name()
        }
    )+};
}

impl<T: Target> Tracker<T> {
    /// A tracker without a target, with the default configuration: [`robust::Config::robust`](crate::robust::Config::robust)
    /// within the size of the tracker, or [`paper::Config::camera`](crate::paper::Config::camera) limited to windows that
    /// fit `SPAN`. All its bytes are 0, so a `static` takes no flash. At run time, `Tracker::default()` writes these zeroes,
    /// where `new` may copy them from flash.
    ///
    /// ```
    /// use smr_core::{Robust, Tracker, robust::Config};
    /// use std::sync::Mutex; // in firmware: the mutex of critical-section or Embassy
    ///
    /// static TRACKER: Mutex<Tracker<Robust>> = Mutex::new(Tracker::new());
    /// let mut config = Config::robust();
    /// config.reach = 6;
    /// TRACKER.lock().unwrap().configure(config)?;
    /// assert!(TRACKER.lock().unwrap().window().is_none());
    /// # Ok::<(), smr_core::Error>(())
    /// ```
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self { target: T::UNLOCKED, workspace: T::UNUSED }
    }

    /// A tracker without a target, with this configuration.
    ///
    /// # Errors
    /// [`ConfigError`] if the configuration is invalid.
    #[inline(always)]
    pub fn with(config: T::Config) -> Result<Self, ConfigError> {
        T::check_config(&config)?;
        let mut tracker = Self::default();
        tracker.target.set_config(config);
        Ok(tracker)
    }

    /// Sets the configuration and forgets the target.
    ///
    /// # Errors
    /// [`ConfigError`] if the configuration is invalid. Nothing is then changed.
    pub fn configure(&mut self, config: T::Config) -> Result<(), ConfigError> {
        self.target.configure(config)
    }

    /// The target.
    #[must_use]
    pub const fn target(&self) -> &T {
        &self.target
    }

    /// The workspace (scratch memory).
    #[must_use]
    pub const fn workspace(&self) -> &T::Workspace {
        &self.workspace
    }

    /// Borrows target and workspace separately, for [`Target`]'s calls. Another target may use the workspace: that
    /// discards an update or lock of this tracker that is under way.
    pub const fn parts(&mut self) -> (&mut T, &mut T::Workspace) {
        (&mut self.target, &mut self.workspace)
    }

    /// The configuration.
    pub fn config(&self) -> &T::Config {
        self.target.config()
    }

    /// See [`Target::lock_window`].
    pub fn lock_window(&self, bounds: Rect, bbox: Rect) -> Rect {
        self.target.lock_window(bounds, bbox)
    }

    /// See [`Target::lock`].
    ///
    /// # Errors
    /// [`LockError`]. Nothing is then changed.
    pub fn lock(&mut self, frame: &Frame<'_>, bbox: Rect) -> Result<Quality, LockError> {
        update::lock(&mut self.target, &mut self.workspace, frame, bbox)
    }

    /// See [`Target::lock_step`].
    ///
    /// # Errors
    /// [`LockError`]. Nothing is then changed.
    pub fn lock_step(&mut self, frame: &Frame<'_>, bbox: Rect, work: u32) -> Result<Option<Quality>, LockError> {
        update::lock_step(&mut self.target, &mut self.workspace, frame, bbox, work)
    }

    of_the_target! { windows: Windows, window: Rect, sweep_window: Rect, bbox: FineRect, state: State, quality: Quality }

    /// See [`Target::moved`].
    pub fn moved(&mut self, right: i32, down: i32) {
        self.target.moved(right, down);
    }

    /// See [`Target::update`].
    ///
    /// # Errors
    /// [`UpdateError`]. Nothing is then changed.
    pub fn update(&mut self, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        update::update(&mut self.target, &mut self.workspace, frame)
    }

    /// An upper bound of the work of the present or last update or lock, in the units of [`Tracker::update_step`]: it
    /// includes comparisons that scoring skipped, and depends slightly on the steps. It saturates at `u32::MAX`, which
    /// [`Paper`](crate::Paper) can reach in two searches of 200x200 offsets with a template of 60,000 pixels.
    pub fn work(&self) -> u32 {
        T::work(&self.workspace)
    }

    /// Updates in steps of bounded work: begins an update, or continues the one under way. `None` while work remains.
    /// The answer does not depend on the steps. The pixels must be the same in every step.
    ///
    /// The tracker stores the update under way. Every other call that changes the target ([`update`](Self::update),
    /// `lock`, `lock_step`, `moved`, `restore`, `configure`, `cancel`) ends it, and the next step begins a new one. A call
    /// that fails changes nothing: the update or lock under way continues as if the call had not been made. The tracker
    /// may move in memory between two steps.
    ///
    /// | | [`Paper`](crate::Paper) | [`Robust`](crate::Robust) |
    /// |---|---|---|
    /// | a unit of `work` (0 counts as 1) | a comparison of two bytes | about one instruction of a Cortex-M4 |
    /// | most work beyond `work` | max(pixels of the template, 2 * pixels in a window's row) + 7 * `SPAN` | 128,000 |
    /// | the last step, in addition | one pass over the template | one pass over the weights and the template |
    ///
    /// For [`Robust`](crate::Robust) a product is 1 unit, a pixel of the grid 64 and the comparison of a pixel 12. The
    /// most work beyond `work` for a configuration is [`MostWork::beyond_a_step`](crate::MostWork::beyond_a_step).
    ///
    /// ```
    /// # use smr_core::{Frame, Image, Paper, Rect, Tracker, paper};
    /// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    /// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
    /// let mut tracker = Tracker::<Paper<256, 161>>::new();
    /// while tracker.lock_step(&frame, Rect::new(20, 10, 16, 16), 200_000)?.is_none() {}
    /// let answer = loop {
    ///     if let Some(answer) = tracker.update_step(&frame, 10_000)? {
    ///         break answer;
    ///     }
    ///     // other work with a deadline
    /// };
    /// assert_eq!(answer.bbox, Rect::new(20, 10, 16, 16));
    /// # Ok::<(), smr_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`UpdateError`]. Nothing is then changed.
    pub fn update_step(&mut self, frame: &Frame<'_>, work: u32) -> Result<Option<Answer>, UpdateError> {
        update::update_step(&mut self.target, &mut self.workspace, frame, work)
    }

    /// See [`Target::cancel`].
    pub fn cancel(&mut self) {
        self.target.cancel();
    }

    /// Repeats [`Tracker::update_step`] with 10,000 units of work until the answer is there or `expired` returns true.
    /// The call may exceed a deadline by one step: up to 140,000 units for [`Robust`](crate::Robust). After `None`,
    /// continue with the same frame in the next period: `update_step_until(&frame, || Instant::now() >= end)?`.
    ///
    /// # Errors
    /// As [`Tracker::update_step`].
    pub fn update_step_until(
        &mut self,
        frame: &Frame<'_>,
        expired: impl FnMut() -> bool,
    ) -> Result<Option<Answer>, UpdateError> {
        self.target.update_step_until(&mut self.workspace, frame, expired)
    }

    /// See [`Target::saved_size`].
    ///
    /// # Errors
    /// [`SaveError::NotLocked`].
    pub fn saved_size(&self) -> Result<usize, SaveError> {
        self.target.saved_size()
    }

    /// See [`Target::save`].
    ///
    /// # Errors
    /// [`SaveError`].
    pub fn save(&self, bytes: &mut [u8]) -> Result<usize, SaveError> {
        self.target.save(bytes)
    }

    /// See [`Target::restore`].
    ///
    /// # Errors
    /// [`RestoreError`]. Nothing is then changed.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        self.target.restore(bytes)
    }
}

impl<T: Target> Default for Tracker<T> {
    #[inline(always)]
    fn default() -> Self {
        Self { target: T::unlocked(), workspace: T::Workspace::default() }
    }
}

impl<T: Target> fmt::Debug for Tracker<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tracker").field("state", &self.state()).field("bbox", &self.bbox()).finish_non_exhaustive()
    }
}
