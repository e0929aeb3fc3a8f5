//! A target together with its workspace, for following a single target.

use super::{
    Answer, ConfigError, Lock, LockError, Quality, RestoreError, SaveError, State, Target, Update, UpdateError,
};
use crate::image::{FineRect, Frame, Rect};
use core::fmt;

/// Follows one target: a [`Target`] and its workspace. Holds all memory; there is no heap.
///
/// `Tracker<Paper<PIXELS, SPAN>>` is the paper's tracker, `Tracker<Robust>` the robust one. All calls are the same. The
/// [crate's example](crate) uses whole frames. This one reads out only the window that the tracker needs:
///
/// ```
/// use smr_core::paper::{Config, Radius};
/// use smr_core::{Frame, Image, Paper, Rect, Tracker};
/// # fn read_out(window: Rect) -> Vec<u8> {
/// #     let pixel = |x: i32, y: i32| ((x * x + 3 * y * y) % 251) as u8;
/// #     (window.y..window.bottom()).flat_map(|y| (window.x..window.right()).map(move |x| pixel(x, y))).collect()
/// # }
/// # fn main() -> Result<(), Box<dyn core::error::Error>> {
/// let mut config = Config::camera();
/// config.window = Radius { x: 8, y: 8 };
/// config.window_limit = config.window;
/// let mut tracker = Tracker::<Paper<64, 17>>::new(config)?;
///
/// // A box of 8x8 pixels on a sensor of 320x240.
/// let (sensor, target) = (Rect::new(0, 0, 320, 240), Rect::new(100, 50, 8, 8));
/// assert_eq!(tracker.lock_window(sensor, target), target);
/// let pixels = read_out(target);
/// tracker.lock(&Frame::part(Image::new(&pixels, 8, 8)?, 100, 50, 320, 240)?, target)?;
///
/// // The next update reads the box and 8 pixels around it.
/// let window = tracker.window().unwrap();
/// assert_eq!((window, tracker.sweep_window()), (Rect::new(92, 42, 24, 24), None));
/// let pixels = read_out(window);
/// let answer = tracker.update(&Frame::part(Image::new(&pixels, 24, 24)?, 92, 42, 320, 240)?)?;
/// assert_eq!(answer.bbox, target);
/// # Ok(())
/// # }
/// ```
pub struct Tracker<T: Target> {
    target: T,
    workspace: T::Workspace,
}

impl<T: Target> Tracker<T> {
    /// A tracker without a target.
    ///
    /// # Errors
    /// [`ConfigError`] if the configuration is invalid.
    #[inline(always)]
    pub fn new(config: T::Config) -> Result<Self, ConfigError> {
        Ok(Self { target: T::new(config)?, workspace: T::Workspace::default() })
    }

    /// A tracker from a target and a workspace. A `static` is built at compile time and takes no stack:
    ///
    /// ```
    /// use smr_core::robust::{Config, Workspace};
    /// use smr_core::{Robust, Tracker};
    /// use std::sync::Mutex; // in firmware: the mutex of critical-section or Embassy
    ///
    /// static TRACKER: Mutex<Tracker<Robust>> =
    ///     Mutex::new(Tracker::from_parts(Robust::const_new(Config::robust()), Workspace::new()));
    /// assert!(TRACKER.lock()?.window().is_none());
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    #[must_use]
    #[inline(always)]
    pub const fn from_parts(target: T, workspace: T::Workspace) -> Self {
        Self { target, workspace }
    }

    /// The target.
    #[must_use]
    pub const fn target(&self) -> &T {
        &self.target
    }

    /// The workspace.
    #[must_use]
    pub const fn workspace(&self) -> &T::Workspace {
        &self.workspace
    }

    /// Target and workspace, borrowed separately.
    pub const fn parts(&mut self) -> (&mut T, &mut T::Workspace) {
        (&mut self.target, &mut self.workspace)
    }

    /// The configuration.
    pub fn config(&self) -> &T::Config {
        self.target.config()
    }

    /// See [`Target::lock_window`].
    pub fn lock_window(&self, bounds: Rect, target: Rect) -> Rect {
        self.target.lock_window(bounds, target)
    }

    /// See [`Target::lock`].
    ///
    /// # Errors
    /// [`LockError`]. The target is then unchanged.
    pub fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<Quality, LockError> {
        self.target.lock(&mut self.workspace, frame, target)
    }

    /// See [`Target::begin_lock`].
    ///
    /// # Errors
    /// [`LockError`]. The target is then unchanged.
    pub fn begin_lock<'a>(&'a mut self, frame: &Frame<'a>, target: Rect) -> Result<Lock<'a, T>, LockError> {
        self.target.begin_lock(&mut self.workspace, frame, target)
    }

    /// See [`Target::resume_lock`].
    ///
    /// # Errors
    /// Those of [`Target::resume_lock`].
    pub fn resume_lock<'a>(&'a mut self, frame: &Frame<'a>) -> Result<Lock<'a, T>, LockError> {
        self.target.resume_lock(&mut self.workspace, frame)
    }

    /// See [`Target::window`].
    pub fn window(&self) -> Option<Rect> {
        self.target.window()
    }

    /// See [`Target::sweep_window`].
    pub fn sweep_window(&self) -> Option<Rect> {
        self.target.sweep_window()
    }

    /// See [`Target::bbox`].
    pub fn bbox(&self) -> Option<FineRect> {
        self.target.bbox()
    }

    /// See [`Target::state`].
    pub fn state(&self) -> Option<State> {
        self.target.state()
    }

    /// See [`Target::quality`].
    pub fn quality(&self) -> Option<Quality> {
        self.target.quality()
    }

    /// See [`Target::moved`].
    pub fn moved(&mut self, right: i32, down: i32) {
        self.target.moved(right, down);
    }

    /// See [`Target::update`].
    ///
    /// # Errors
    /// [`UpdateError`]. The target is then unchanged.
    pub fn update(&mut self, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        self.target.update(&mut self.workspace, frame)
    }

    /// The work of the last update or lock, in the units of [`Update::step`]. It depends slightly on the steps.
    pub fn work(&self) -> u32 {
        T::work(&self.workspace)
    }

    /// See [`Target::begin`].
    ///
    /// # Errors
    /// [`UpdateError`]. The target is then unchanged.
    pub fn begin<'a>(&'a mut self, frame: &Frame<'a>) -> Result<Update<'a, T>, UpdateError> {
        self.target.begin(&mut self.workspace, frame)
    }

    /// See [`Target::resume`].
    ///
    /// # Errors
    /// Those of [`Target::resume`].
    pub fn resume<'a>(&'a mut self, frame: &Frame<'a>) -> Result<Update<'a, T>, UpdateError> {
        self.target.resume(&mut self.workspace, frame)
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
    /// [`RestoreError`]. The target is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        self.target.restore(bytes)
    }
}

impl<T: Target> fmt::Debug for Tracker<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tracker").field("state", &self.state()).field("bbox", &self.bbox()).finish_non_exhaustive()
    }
}
