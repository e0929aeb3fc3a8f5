//! The trait that both trackers implement, for generic code.

use super::update::Steps;
use super::{Answer, ConfigError, LockError, MostWork, Quality, RestoreError, SaveError, State, UpdateError};
use crate::image::{FineRect, Frame, Rect};

/// A target as a tracker remembers it: configuration, templates and track. Plain data.
///
/// An update also needs scratch memory, the *workspace*. One workspace serves any number of targets, one update at a
/// time. A [`Tracker`](crate::Tracker) holds one of each. Only [`Paper`](crate::Paper) and [`Robust`](crate::Robust)
/// implement the trait: it is sealed.
///
/// ```
/// use smr_core::{Frame, Image, Rect, Target, Tracker, UpdateError};
///
/// /// The centre of the target, with either tracker.
/// fn middle<T: Target>(tracker: &mut Tracker<T>, frame: &Frame) -> Result<(i32, i32), UpdateError> {
///     let bbox = tracker.update(frame)?.bbox;
///     Ok((bbox.x + i32::from(bbox.width) / 2, bbox.y + i32::from(bbox.height) / 2))
/// }
///
/// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
/// let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
/// let mut paper = Tracker::<smr_core::Paper<256, 161>>::new();
/// let mut robust = Tracker::<smr_core::Robust>::new();
/// paper.lock(&frame, Rect::new(20, 10, 16, 16))?;
/// robust.lock(&frame, Rect::new(20, 10, 16, 16))?;
/// assert_eq!([middle(&mut paper, &frame)?, middle(&mut robust, &frame)?], [(28, 18); 2]);
/// # Ok::<(), smr_core::Error>(())
/// ```
///
/// Two targets with one workspace:
///
/// ```
/// use smr_core::{Frame, Image, Paper, Rect, Target, paper};
/// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
/// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
/// let mut workspace = paper::Workspace::<256, 161>::new();
/// let mut left = Paper::with(paper::Config::camera())?;
/// let mut right = Paper::with(paper::Config::camera())?;
/// left.lock(&mut workspace, &frame, Rect::new(4, 10, 16, 16))?;
/// right.lock(&mut workspace, &frame, Rect::new(40, 10, 16, 16))?;
/// assert_eq!(left.update(&mut workspace, &frame)?.bbox.x, 4);
/// assert_eq!(right.update(&mut workspace, &frame)?.bbox.x, 40);
/// # Ok::<(), smr_core::Error>(())
/// ```
pub trait Target: Steps {
    /// The configuration of the tracker.
    type Config: Copy;

    /// The largest size of a saved target in bytes: see [`Target::save`].
    const SAVED_SIZE: usize;

    /// Upper bounds of the work of an update, a lock and a step for a box of `width` x `height` pixels, for any frame.
    fn most_work(config: &Self::Config, width: u16, height: u16) -> MostWork;

    /// A target that is not locked, with the default configuration.
    #[doc(hidden)]
    fn unlocked() -> Self;

    /// A target that is not locked.
    ///
    /// # Errors
    /// [`ConfigError`] if the configuration is invalid.
    #[inline(always)]
    fn with(config: Self::Config) -> Result<Self, ConfigError> {
        Self::check_config(&config)?;
        let mut target = Self::unlocked();
        target.set_config(config);
        Ok(target)
    }

    /// Sets the configuration and forgets the target.
    ///
    /// # Errors
    /// [`ConfigError`] if the configuration is invalid. Nothing is then changed.
    fn configure(&mut self, config: Self::Config) -> Result<(), ConfigError> {
        Self::check_config(&config)?;
        self.set_config(config);
        Ok(())
    }

    /// Checks the configuration.
    ///
    /// # Errors
    /// As [`Target::configure`].
    #[doc(hidden)]
    fn check_config(config: &Self::Config) -> Result<(), ConfigError>;

    /// Sets a checked configuration and forgets the target.
    #[doc(hidden)]
    fn set_config(&mut self, config: Self::Config);

    /// The configuration in use.
    fn config(&self) -> &Self::Config;

    /// The pixels that [`Target::lock`] reads for `bbox` in a frame of size `bounds`; empty if `bbox` cannot be locked.
    fn lock_window(&self, bounds: Rect, bbox: Rect) -> Rect;

    /// Starts to follow the target in `bbox` and forgets the previous target. Returns how distinct the new one is.
    ///
    /// Reads only the pixels in [`Target::lock_window`]. Cost: [`Paper`](crate::Paper) copies the box and makes two
    /// comparisons per pixel; [`Robust`](crate::Robust) takes as long as two or three updates.
    ///
    /// # Errors
    /// [`LockError`]. The target is then unchanged.
    fn lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, bbox: Rect) -> Result<Quality, LockError> {
        super::update::lock(self, workspace, frame, bbox)
    }

    /// The part of the frame that the next update may read; `None` before the first lock, never empty. Firmware may
    /// read out only these pixels and those of [`Target::sweep_window`]: see [`Frame::part`].
    fn window(&self) -> Option<Rect>;

    /// A second window that the next update may read for a lost target. `None` in most frames, and always for `Paper`.
    fn sweep_window(&self) -> Option<Rect>;

    /// The box of the last answer, in units of 1/256 pixel; `None` before the first lock.
    fn bbox(&self) -> Option<FineRect>;

    /// The state of the last answer; tracking after a lock, `None` before the first lock.
    fn state(&self) -> Option<State>;

    /// The quality that the last lock returned; `None` before the first lock.
    fn quality(&self) -> Option<Quality>;

    /// Tells the tracker that the camera turned: what was at (x, y) in the last frame is expected at (x + `right`, y +
    /// `down`) in the next, in units of 1/256 pixel. Box and search window shift by as much, but stay on or near the
    /// frame. [`Paper`](crate::Paper) rounds the shift of each call to whole pixels.
    fn moved(&mut self, right: i32, down: i32);

    /// The number of bytes that [`Target::save`] writes; at most [`Target::SAVED_SIZE`].
    ///
    /// # Errors
    /// [`SaveError::NotLocked`].
    fn saved_size(&self) -> Result<usize, SaveError>;

    /// Writes the target into `bytes` and returns the number of bytes written, [`Target::saved_size`]. They are the
    /// same on every platform, and hold the target's state and its configuration. `restore` compares that configuration
    /// with the one in use.
    ///
    /// # Errors
    /// [`SaveError`]. `bytes` are then unchanged.
    fn save(&self, bytes: &mut [u8]) -> Result<usize, SaveError>;

    /// Continues with a target that [`Target::save`] wrote. The answers are identical to those of the saved target.
    ///
    /// # Errors
    /// [`RestoreError`] if the bytes are damaged or from another tracker or configuration; the target is then
    /// unchanged.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError>;

    /// Checks that the bytes are whole and were saved with this configuration.
    ///
    /// # Errors
    /// As [`Target::restore`].
    #[doc(hidden)]
    fn check_saved(&self, bytes: &[u8]) -> Result<(), RestoreError>;

    /// Finds the target in the next frame.
    ///
    /// Reads only the pixels in [`Target::window`] and [`Target::sweep_window`]. Cost: [`Paper`](crate::Paper) takes up
    /// to [`Target::most_work`] if nothing matches, and far less if the target is clearly visible.
    /// [`Robust`](crate::Robust) takes at most 726 products for each of at most 2000 weights.
    ///
    /// # Errors
    /// [`UpdateError`]. The target is then unchanged.
    fn update(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        super::update::update(self, workspace, frame)
    }
}

pub(super) fn lockable(bounds: Rect, bbox: Rect) -> Result<(), LockError> {
    if bbox.is_empty() {
        return Err(LockError::BoxEmpty);
    }
    if bounds.contains(bbox) { Ok(()) } else { Err(LockError::BoxOutsideFrame) }
}

/// An option with a tag that is 0 when it is empty; `Option` does not promise that. So a new tracker can consist of
/// zero bytes, and takes no flash as a `static`.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub(super) enum Slot<T> {
    Empty = 0,
    Full(T),
}

impl<T> Slot<T> {
    pub(super) const fn get(&self) -> Option<&T> {
        match self {
            Self::Empty => None,
            Self::Full(value) => Some(value),
        }
    }

    pub(super) const fn get_mut(&mut self) -> Option<&mut T> {
        match self {
            Self::Empty => None,
            Self::Full(value) => Some(value),
        }
    }

    pub(super) const fn or<'a>(&'a self, other: &'a T) -> &'a T {
        match self {
            Self::Empty => other,
            Self::Full(value) => value,
        }
    }
}
