//! What both trackers can do: the trait that generic code takes.

use super::update::Steps;
use super::{
    Answer, ConfigError, Lock, LockError, MostWork, Quality, RestoreError, SaveError, State, Update, UpdateError,
};
use crate::image::{FineRect, Frame, Rect};

/// A target, as a tracker remembers it: its configuration, its templates and its track. Plain data, and no more than that.
///
/// What an update needs beside it is scratch, the *workspace*. One workspace serves any number of targets, one update at a time. If there
/// is one target only, a [`Tracker`](crate::Tracker) holds both. [`Paper`](crate::Paper) and [`Robust`](crate::Robust) are the two
/// trackers; the trait is not for others to implement.
///
/// ```
/// use smr_core::{Frame, Image, Rect, Target, Tracker, UpdateError};
///
/// /// The middle of the target after a frame, by any tracker.
/// fn middle<T: Target>(tracker: &mut Tracker<T>, frame: &Frame) -> Result<(i32, i32), UpdateError> {
///     let bbox = tracker.update(frame)?.bbox;
///     Ok((bbox.x + i32::from(bbox.width) / 2, bbox.y + i32::from(bbox.height) / 2))
/// }
///
/// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
/// let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
/// let mut paper = Tracker::<smr_core::Paper<256, 161>>::new(smr_core::paper::Config::camera())?;
/// let mut robust = Tracker::<smr_core::Robust>::new(smr_core::robust::Config::robust())?;
/// paper.lock(&frame, Rect::new(20, 10, 16, 16))?;
/// robust.lock(&frame, Rect::new(20, 10, 16, 16))?;
/// assert_eq!([middle(&mut paper, &frame)?, middle(&mut robust, &frame)?], [(28, 18); 2]);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// Two targets with one workspace:
///
/// ```
/// use smr_core::{Frame, Image, Paper, Rect, Target, paper};
/// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
/// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
/// let mut workspace = paper::Workspace::<256, 161>::new();
/// let mut left = Paper::new(paper::Config::camera())?;
/// let mut right = Paper::new(paper::Config::camera())?;
/// left.lock(&mut workspace, &frame, Rect::new(4, 10, 16, 16))?;
/// right.lock(&mut workspace, &frame, Rect::new(40, 10, 16, 16))?;
/// assert_eq!(left.update(&mut workspace, &frame)?.bbox.x, 4);
/// assert_eq!(right.update(&mut workspace, &frame)?.bbox.x, 40);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub trait Target: Steps {
    /// The numbers of the method.
    type Config: Copy;

    /// The most bytes that [`Target::save`] writes.
    const SAVED_SIZE: usize;

    /// The most work of an update, a lock and a step for a box of this size: what a deadline is planned by. It holds for any frame.
    fn most_work(config: &Self::Config, width: u16, height: u16) -> MostWork;

    /// No target yet.
    ///
    /// # Errors
    /// [`ConfigError`], if a number of the configuration cannot be used.
    fn new(config: Self::Config) -> Result<Self, ConfigError>;

    /// The configuration.
    fn config(&self) -> &Self::Config;

    /// The pixels of a frame with these bounds that [`Target::lock`] reads for a box; always inside the frame. For a box
    /// that cannot be locked on it is empty.
    fn lock_window(&self, bounds: Rect, target: Rect) -> Rect;

    /// Starts on the target in `target`, at any time; whatever was followed before is forgotten. Says how well the target can be told from
    /// what lies beside it.
    ///
    /// Of the frame only the pixels in [`Target::lock_window`] are read. Cost of [`Paper`](crate::Paper): a copy of the box, and two
    /// comparisons for each of its pixels. Of [`Robust`](crate::Robust): as much as 25 updates.
    ///
    /// # Errors
    /// [`LockError`]; the target is then as it was before, and so is an update that is under way.
    fn lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, target: Rect) -> Result<Quality, LockError> {
        super::update::lock(self, workspace, frame, target)
    }

    /// The same lock in steps of a bounded amount of work. See [`Lock`].
    ///
    /// From now on there is no target, until the lock is finished.
    ///
    /// # Errors
    /// As [`Target::lock`].
    fn begin_lock<'a>(
        &'a mut self,
        workspace: &'a mut Self::Workspace,
        frame: &Frame<'a>,
        target: Rect,
    ) -> Result<Lock<'a, Self>, LockError> {
        Lock::begin(self, workspace, frame, target)
    }

    /// Takes up a lock that was begun and dropped before it was finished.
    ///
    /// # Errors
    /// [`LockError::NotBegun`] if there is none, [`LockError::FrameSizeChanged`], [`LockError::LockWindowNotInMemory`]. That `frame` holds the
    /// same pixels as before is up to the caller.
    fn resume_lock<'a>(
        &'a mut self,
        workspace: &'a mut Self::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Lock<'a, Self>, LockError> {
        Lock::resume(self, workspace, frame)
    }

    /// The pixels of the frame that the next update may read; `None` before the first lock. Firmware may deliver just these, as a
    /// [`Frame::part`], and those of [`Target::sweep_window`] beside them.
    ///
    /// It is never empty: where the box of [`Paper`](crate::Paper) lies beyond the edge of the frame, it is the pixels at that edge.
    fn window(&self) -> Option<Rect>;

    /// The pixels of a second place that the next update may read, where it looks for a lost target; `None` in most frames, and
    /// always from [`Paper`](crate::Paper).
    fn sweep_window(&self) -> Option<Rect>;

    /// The box of the last answer, in units of 1/256 pixel; `None` before the first lock.
    fn bbox(&self) -> Option<FineRect>;

    /// The state of the last answer; `None` before the first lock, and tracking after it.
    fn state(&self) -> Option<State>;

    /// How well the target could be told from what lies beside it when it was locked; `None` before the first lock.
    fn quality(&self) -> Option<Quality>;

    /// Says that the picture has moved since the last frame because the camera turned: what was at (x, y) is expected at
    /// (x + `right`, y + `down`). Both in units of 1/256 pixel. An update that is under way is given up.
    ///
    /// The search window moves along, so that a turn of the camera does not take the target out of it. The box is kept within reach of the
    /// frame. [`Paper`](crate::Paper) rounds to whole pixels.
    fn moved(&mut self, right: i32, down: i32);

    /// How many bytes [`Target::save`] writes: at most [`Target::SAVED_SIZE`].
    ///
    /// # Errors
    /// [`SaveError::NotLocked`].
    fn saved_size(&self) -> Result<usize, SaveError>;

    /// Writes the target into `bytes`, and says how many were written: [`Target::saved_size`].
    ///
    /// The bytes are the same on every platform. They hold template and track; of the configuration only a checksum, for
    /// [`Target::restore`] to compare.
    ///
    /// # Errors
    /// [`SaveError`]; `bytes` are then as they were before.
    fn save(&self, bytes: &mut [u8]) -> Result<usize, SaveError>;

    /// Goes on with a target that [`Target::save`] wrote: with identical answers, or not at all.
    ///
    /// # Errors
    /// [`RestoreError`], if the bytes are damaged, foreign, or of a target with another configuration; the target is then as it
    /// was before.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError>;

    /// Looks for the target in the next frame.
    ///
    /// Of the frame only the pixels in [`Target::window`] and [`Target::sweep_window`] are read; the rest need not be in memory. Cost of
    /// [`Paper`](crate::Paper): far less than [`Target::most_work`] where the target is seen clearly, and up to that where nothing matches.
    /// Cost of [`Robust`](crate::Robust): about the same in every frame, at most 894 products for each of at most 2000 weights.
    ///
    /// # Errors
    /// [`UpdateError`]; the target is then as it was before.
    fn update(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        Ok(self.begin(workspace, frame)?.finish())
    }

    /// The same update in steps of a bounded amount of work, for those who have a deadline; the answer does not depend on
    /// how it is cut. See [`Update`].
    ///
    /// # Errors
    /// [`UpdateError`]; the target is then as it was before.
    fn begin<'a>(
        &'a mut self,
        workspace: &'a mut Self::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Update<'a, Self>, UpdateError> {
        Update::begin(self, workspace, frame)
    }

    /// Takes up an update that was begun and dropped before it was finished: for code that cannot keep it, such as C.
    ///
    /// # Errors
    /// [`UpdateError::NotBegun`] if there is none. The others as for [`Target::begin`]. That `frame` holds the same pixels as
    /// before is up to the caller: of two frames the answer would be neither's.
    fn resume<'a>(
        &'a mut self,
        workspace: &'a mut Self::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Update<'a, Self>, UpdateError> {
        Update::resume(self, workspace, frame)
    }
}

/// Refuses a box that no tracker can start on.
pub(super) fn lockable(bounds: Rect, target: Rect) -> Result<(), LockError> {
    if target.is_empty() {
        return Err(LockError::BoxEmpty);
    }
    if bounds.contains(target) { Ok(()) } else { Err(LockError::BoxOutsideFrame) }
}

/// Refuses a frame by which a lock that was begun on another one cannot go on; `window` is what it reads.
pub(super) fn lock_goes_on(frame: &Frame<'_>, bounds: Rect, window: Rect) -> Result<(), LockError> {
    if frame.bounds() != bounds {
        return Err(LockError::FrameSizeChanged);
    }
    if frame.covers(window) { Ok(()) } else { Err(LockError::LockWindowNotInMemory) }
}
