//! The trait that both trackers implement, for generic code.

use super::update::{SEAL, Steps};
use super::{Answer, ConfigError, LockError, MostWork, Quality, RestoreError, SaveError, State, UpdateError};
use crate::image::{FineRect, Frame, Rect, Windows};

/// A target as a tracker remembers it: configuration, templates and track. Plain data.
///
/// An update also needs scratch memory, the *workspace*. One workspace serves any number of targets, one update at a
/// time, also in steps ([`Target::update_step`]). A [`Tracker`](crate::Tracker) holds one of each. Only [`Paper`](crate::Paper) and [`Robust`](crate::Robust)
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

    /// The letter of the tracker in saved targets and records.
    #[doc(hidden)]
    const LETTER: u8;

    /// Upper bounds of the work of an update, a lock and a step for a box of `width` x `height` pixels, for any frame.
    fn most_work(config: &Self::Config, width: u16, height: u16) -> MostWork;

    /// A target that is not locked, with the default configuration. All its bytes are 0.
    #[doc(hidden)]
    const UNLOCKED: Self;

    /// As [`Target::UNLOCKED`], made in its place at run time: a constant may be copied from flash.
    #[doc(hidden)]
    fn unlocked() -> Self;

    /// A workspace whose bytes are all 0.
    #[doc(hidden)]
    const UNUSED: Self::Workspace;

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

    /// Locks in steps of bounded work: begins a lock, or continues one with the same `bbox` and frame size. The pixels
    /// must be the same in every step. `None` while work remains. The first step forgets the old target, so there is no
    /// target until the lock is done. Units of work, and calls that end a lock under way: see [`Target::update_step`].
    /// [`Paper`](crate::Paper) needs one step, whatever `work` is.
    ///
    /// # Errors
    /// [`LockError`]. Nothing is then changed.
    fn lock_step(
        &mut self,
        workspace: &mut Self::Workspace,
        frame: &Frame<'_>,
        bbox: Rect,
        work: u32,
    ) -> Result<Option<Quality>, LockError> {
        super::update::lock_step(self, workspace, frame, bbox, work)
    }

    /// The windows of the frame that the next update may read: [`Target::window`] and [`Target::sweep_window`]. `None`
    /// before the first lock. Firmware may read out only these pixels: see [`Frame::of_windows`] and
    /// [`Readout`](crate::readout::Readout).
    fn windows(&self) -> Option<Windows> {
        Some(Windows::new(self.window()?, self.sweep_window()))
    }

    /// The first of [`Target::windows`]: the surroundings of the place where the target is expected. Inside the frame
    /// and never empty; `None` before the first lock.
    fn window(&self) -> Option<Rect>;

    /// The second of [`Target::windows`]: a part of the frame in which a lost target is searched. Inside the frame and
    /// never empty; `None` in most frames, and always for `Paper`.
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
    /// Reads only the pixels in [`Target::windows`]. Cost: [`Paper`](crate::Paper) takes up
    /// to [`Target::most_work`] if nothing matches, and far less if the target is clearly visible.
    /// [`Robust`](crate::Robust) takes at most 726 products for each of at most 2000 weights.
    ///
    /// # Errors
    /// [`UpdateError`]. The target is then unchanged.
    fn update(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        super::update::update(self, workspace, frame)
    }

    /// Updates in steps of bounded work: begins an update, or continues the one of this target that is under way in
    /// `workspace`. `None` while work remains. The answer does not depend on the steps. The pixels must be the same in
    /// every step. Units of `work`, and the most work of a step: see [`Tracker::update_step`](crate::Tracker::update_step).
    ///
    /// Targets that share a workspace take turns, one update at a time. The first step of another target in the same
    /// workspace, or its update or lock, discards the update under way; so does every other call that changes this
    /// target, and a move of this target in memory, unless the workspace moves with it. The next step then begins anew,
    /// so no target continues the update of another. A call that fails discards nothing.
    ///
    /// ```
    /// use smr_core::{Frame, Image, Rect, Robust, Target, robust};
    /// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    /// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
    /// let mut workspace: robust::Workspace = robust::Workspace::new();
    /// let mut targets = [Robust::new(), Robust::new()];
    /// for (target, x) in targets.iter_mut().zip([4, 40]) {
    ///     while target.lock_step(&mut workspace, &frame, Rect::new(x, 10, 16, 16), 200_000)?.is_none() {}
    /// }
    /// let mut steps = 0;
    /// for (target, x) in targets.iter_mut().zip([4, 40]) {
    ///     let answer = loop {
    ///         // Other work with a deadline comes between the steps, but no step of the other target.
    ///         steps += 1;
    ///         if let Some(answer) = target.update_step(&mut workspace, &frame, 100_000)? {
    ///             break answer;
    ///         }
    ///     };
    ///     assert_eq!(answer.bbox.x, x);
    /// }
    /// assert!(steps > 10);
    /// # Ok::<(), smr_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`UpdateError`]. Nothing is then changed.
    fn update_step(
        &mut self,
        workspace: &mut Self::Workspace,
        frame: &Frame<'_>,
        work: u32,
    ) -> Result<Option<Answer>, UpdateError> {
        super::update::update_step(self, workspace, frame, work)
    }

    /// Discards the update or lock of this target that is under way, for example because a newer frame is there: the
    /// next step begins anew. After a discarded lock there is no target. Takes a few instructions.
    fn cancel(&mut self) {
        self.ticket(SEAL).end();
    }

    /// Repeats [`Target::update_step`] with 10,000 units of work until the answer is there or `expired` returns true.
    /// The call may exceed a deadline by one step: up to 140,000 units for [`Robust`](crate::Robust). After `None`,
    /// continue with the same frame in the next period. `expired` is called after each step that leaves work.
    ///
    /// ```
    /// use smr_core::{Answer, Frame, Target, UpdateError};
    ///
    /// /// One period of a control loop, with either tracker: `None` if the answer must wait for the next one.
    /// fn period<T: Target>(
    ///     target: &mut T,
    ///     workspace: &mut T::Workspace,
    ///     frame: &Frame<'_>,
    ///     now: impl Fn() -> u32,
    /// ) -> Result<Option<Answer>, UpdateError> {
    ///     let end = now() + 500; // microseconds
    ///     target.update_step_until(workspace, frame, || now() >= end)
    /// }
    /// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    /// # let frame = Frame::whole(smr_core::Image::new(&pixels, 64, 48)?);
    /// # let (mut robust, mut workspace) = (<smr_core::Robust>::new(), smr_core::robust::Workspace::new());
    /// # robust.lock(&mut workspace, &frame, smr_core::Rect::new(20, 10, 16, 16))?;
    /// # let clock = core::cell::Cell::new(0);
    /// # let now = || clock.replace(clock.get() + 100);
    /// # let mut periods = 1;
    /// # while period(&mut robust, &mut workspace, &frame, &now)?.is_none() {
    /// #     periods += 1;
    /// # }
    /// # assert!(periods > 2);
    /// # Ok::<(), smr_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Target::update_step`].
    fn update_step_until(
        &mut self,
        workspace: &mut Self::Workspace,
        frame: &Frame<'_>,
        mut expired: impl FnMut() -> bool,
    ) -> Result<Option<Answer>, UpdateError> {
        loop {
            let answer = self.update_step(workspace, frame, 10_000)?;
            if answer.is_some() || expired() {
                return Ok(answer);
            }
        }
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
