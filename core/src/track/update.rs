//! An update in steps.

use super::Answer;
use crate::image::Frame;

/// What a tracker does in an update. All calls but the first need one that is under way.
pub trait Steps: Sized {
    /// Scratch memory for an update. It is made by `new`.
    type Workspace;

    /// A workspace.
    fn workspace() -> Self::Workspace;

    /// Whether an update by `frame` can be made.
    ///
    /// # Errors
    /// All but [`NotBegun`](super::UpdateError::NotBegun).
    fn check(&self, frame: &Frame<'_>) -> Result<(), super::UpdateError>;

    /// Begins an update of this target.
    fn start(&mut self, workspace: &mut Self::Workspace);

    /// True if the update in this workspace is one of this target as it is now.
    fn is_under_way(&self, workspace: &Self::Workspace) -> bool;

    /// Goes on; true when nothing is left to do but `conclude`.
    fn advance(&self, workspace: &mut Self::Workspace, frame: &Frame<'_>, work: u32) -> bool;

    /// The work since the update was begun.
    fn work(workspace: &Self::Workspace) -> u32;

    /// Does what is left, changes the target, and gives the answer.
    fn conclude(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>) -> Answer;
}

/// An update under way, from [`Target::begin`](super::Target::begin) or [`Tracker::begin`](super::Tracker::begin).
///
/// Dropped before [`Update::finish`] it has changed nothing but the workspace: [`Target::resume`](super::Target::resume) takes it up,
/// `begin` and `update` start anew.
///
/// ```
/// # use smr_core::{Frame, Image, Paper, Rect, Tracker, paper};
/// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
/// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
/// # let mut tracker = Tracker::<Paper<256, 161>>::new(paper::Config::camera())?;
/// # tracker.lock(&frame, Rect::new(20, 10, 16, 16))?;
/// let mut update = tracker.begin(&frame)?;
/// while !update.step(10_000) {
///     // something else that must not wait
/// }
/// let answer = update.finish();
/// assert_eq!(answer.bbox, Rect::new(20, 10, 16, 16));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct Update<'a, T: Steps> {
    pub(super) target: &'a mut T,
    pub(super) workspace: &'a mut T::Workspace,
    pub(super) frame: Frame<'a>,
}

impl<T: Steps> Update<'_, T> {
    /// Goes on until `work` units of work have been done, and a few more to come to a stop. True when nothing is left to do but
    /// [`Update::finish`]. With 0 it does as much as with 1, so that it comes to an end.
    ///
    /// | | [`Paper`](crate::Paper) | [`Robust`](crate::Robust) |
    /// |---|---|---|
    /// | a unit | a comparison of two bytes | about an instruction of a Cortex-M4: a product counts 1, a pixel of the grid 64, or 32 where it is compared |
    /// | more than `work`, at most | the template's pixels or twice the pixels of a row of the window, and 7 `SPAN` | 130,000, and the pixels of the frame under six rows of the grid |
    /// | left to `finish` | once through the template | once through the weights and the template |
    pub fn step(&mut self, work: u32) -> bool {
        self.target.advance(self.workspace, &self.frame, work)
    }

    /// How much work has been done since the update was begun, at most: what could be left out is counted, too.
    #[must_use]
    pub fn work(&self) -> u32 {
        T::work(self.workspace)
    }

    /// Does what is left, and gives the answer.
    #[must_use]
    pub fn finish(self) -> Answer {
        self.target.conclude(self.workspace, &self.frame)
    }
}
