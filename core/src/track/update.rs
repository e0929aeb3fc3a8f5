//! Updates and locks in steps: one protocol for both trackers and for C.
//!
//! Target and workspace refer to each other. The workspace stores the address and the generation of its target; the target
//! stores the address of its workspace. `lock`, `begin`, `restore` and `moved` change the generation. So `resume` detects a
//! workspace that served another target, a target that changed, and either of them moved in memory.
//!
//! Each step is granted an amount of work, which is counted down. The total is counted only to be reported.

use super::{Answer, LockError, Quality, UpdateError};
use crate::image::{Frame, Rect};
use core::{fmt, ptr};

/// Only this crate can make one, so only this crate can call the sealed methods of [`Steps`].
#[derive(Debug)]
pub struct Seal(());

pub(super) const SEAL: &Seal = &Seal(());

/// What a target stores about an update or lock under way.
#[derive(Clone, Copy, Debug)]
pub struct Ticket {
    generation: u32,
    /// The address of the workspace; 0 if nothing is under way.
    workspace: usize,
}

impl Ticket {
    pub(super) const NEW: Self = Self { generation: 0, workspace: 0 };

    /// The target changed: cancels what is under way.
    pub(super) const fn change(&mut self) {
        *self = Self { generation: self.generation.wrapping_add(1), workspace: 0 };
    }
}

/// The kind of call that is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Nothing,
    Lock,
    Update,
}

/// What a workspace stores about an update or lock under way.
#[derive(Clone, Copy, Debug)]
pub struct UnderWay {
    kind: Kind,
    /// The address and the generation of the target.
    target: usize,
    generation: u32,
    /// The work that the present step may still do.
    granted: u32,
    /// The work of all steps so far. Saturates.
    done: u32,
}

impl UnderWay {
    pub(super) const NOTHING: Self = Self { kind: Kind::Nothing, target: 0, generation: 0, granted: 0, done: 0 };

    /// Nothing is under way any more.
    pub(super) const fn end(&mut self) {
        self.kind = Kind::Nothing;
    }

    pub(super) const fn granted(&self) -> u32 {
        self.granted
    }

    pub(super) const fn done(&self) -> u32 {
        self.done
    }

    pub(super) const fn is_spent(&self) -> bool {
        self.granted == 0
    }

    /// Counts work done. It may exceed the grant if a piece of work cannot be divided.
    #[cfg_attr(smr_small, inline(never))] // one copy
    pub(super) const fn spend(&mut self, work: u32) {
        self.granted = self.granted.saturating_sub(work);
        self.done = self.done.saturating_add(work);
    }

    /// 0 counts as 1, so that every step makes progress.
    const fn grant(&mut self, work: u32) {
        self.granted = if work == 0 { 1 } else { work };
    }
}

/// The stages of an update or a lock, and the workspace they use. A supertrait of [`Target`](crate::Target), sealed like it.
pub trait Steps: Sized {
    /// Scratch memory for an update or a lock.
    type Workspace: Default;

    /// What the target stores about an update or lock under way.
    #[doc(hidden)]
    fn ticket(&mut self, _: &Seal) -> &mut Ticket;

    /// What the workspace stores about it.
    #[doc(hidden)]
    fn under_way<'a>(workspace: &'a mut Self::Workspace, _: &Seal) -> &'a mut UnderWay;

    /// The work of the update or lock that is under way in this workspace, or was last: see [`Tracker::work`](crate::Tracker::work).
    fn work(workspace: &Self::Workspace) -> u32;

    /// Whether an update with `frame` is possible.
    ///
    /// # Errors
    /// All but [`NotBegun`](UpdateError::NotBegun).
    #[doc(hidden)]
    fn check(&self, frame: &Frame<'_>, _: &Seal) -> Result<(), UpdateError>;

    /// Whether the box `target` in `frame` can be locked.
    ///
    /// # Errors
    /// All but [`NotBegun`](LockError::NotBegun).
    #[doc(hidden)]
    fn check_lock(&self, frame: &Frame<'_>, target: Rect, _: &Seal) -> Result<(), LockError>;

    /// Whether the lock under way in this workspace, which is one of this target, can continue with `frame`.
    ///
    /// # Errors
    /// As [`Steps::check_lock`].
    #[doc(hidden)]
    fn check_lock_under_way(&self, workspace: &Self::Workspace, frame: &Frame<'_>, _: &Seal) -> Result<(), LockError>;

    /// Begins an update. The frame was checked.
    #[doc(hidden)]
    fn start(&mut self, workspace: &mut Self::Workspace, _: &Seal);

    /// Begins a lock and forgets the target before. The frame was checked.
    #[doc(hidden)]
    fn start_lock(&mut self, workspace: &mut Self::Workspace, bounds: Rect, target: Rect, _: &Seal);

    /// Continues until the grant is spent. True if only `conclude` or `conclude_lock` is left.
    #[doc(hidden)]
    fn advance(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> bool;

    /// Ends an update: changes the target and returns the answer.
    #[doc(hidden)]
    fn conclude(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> Answer;

    /// Ends a lock: sets the target.
    #[doc(hidden)]
    fn conclude_lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> Quality;
}

/// Makes target and workspace refer to each other.
#[inline(never)] // one copy in flash
fn begin<T: Steps>(target: &mut T, workspace: &mut T::Workspace, kind: Kind) {
    let (address, workspace_address) = (ptr::from_ref(target).addr(), ptr::from_ref(workspace).addr());
    let ticket = target.ticket(SEAL);
    ticket.change();
    ticket.workspace = workspace_address;
    let generation = ticket.generation;
    *T::under_way(workspace, SEAL) = UnderWay { kind, target: address, generation, ..UnderWay::NOTHING };
}

/// True if target and workspace refer to each other for this `kind`.
#[inline(never)] // one copy in flash
fn is_under_way<T: Steps>(target: &mut T, workspace: &mut T::Workspace, kind: Kind) -> bool {
    let (address, workspace_address) = (ptr::from_ref(target).addr(), ptr::from_ref(workspace).addr());
    let Ticket { generation, workspace: begun_in } = *target.ticket(SEAL);
    let under_way = T::under_way(workspace, SEAL);
    under_way.kind == kind
        && (under_way.target, under_way.generation) == (address, generation)
        && begun_in == workspace_address
}

/// An update under way, from [`Target::begin`](crate::Target::begin) or [`Tracker::begin`](crate::Tracker::begin).
///
/// If it is dropped before [`Update::finish`], only the workspace has changed. [`Target::resume`](crate::Target::resume) continues
/// it; `begin` and `update` start again.
///
/// ```
/// # use smr_core::{Frame, Image, Paper, Rect, Tracker, paper};
/// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
/// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
/// # let mut tracker = Tracker::<Paper<256, 161>>::new(paper::Config::camera())?;
/// # tracker.lock(&frame, Rect::new(20, 10, 16, 16))?;
/// let mut update = tracker.begin(&frame)?;
/// while !update.step(10_000) {
///     // other work with a deadline
/// }
/// let answer = update.finish();
/// assert_eq!(answer.bbox, Rect::new(20, 10, 16, 16));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct Update<'a, T: Steps>(Running<'a, T>);

/// A lock under way, from [`Target::begin_lock`](crate::Target::begin_lock) or
/// [`Tracker::begin_lock`](crate::Tracker::begin_lock).
///
/// There is no target until [`Lock::finish`]. [`Target::resume_lock`](crate::Target::resume_lock) continues a lock that was
/// dropped.
///
/// ```
/// # use smr_core::{Frame, Image, Rect, Robust, Tracker, robust};
/// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
/// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
/// let mut tracker = Box::new(Tracker::<Robust>::new(robust::Config::robust())?);
/// let mut lock = tracker.begin_lock(&frame, Rect::new(20, 10, 16, 16))?;
/// while !lock.step(200_000) {
///     // other work with a deadline
/// }
/// assert!(!lock.finish().is_poor());
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct Lock<'a, T: Steps>(Running<'a, T>);

/// What a step needs.
struct Running<'a, T: Steps> {
    target: &'a mut T,
    workspace: &'a mut T::Workspace,
    frame: Frame<'a>,
}

impl<T: Steps> Running<'_, T> {
    fn step(&mut self, work: u32) -> bool {
        step(self.target, self.workspace, &self.frame, work)
    }
}

/// For the C interface, which keeps neither an [`Update`] nor a [`Lock`]: no call has a copy of the frame on its stack.
#[doc(hidden)]
pub mod calls {
    use super::{Answer, Frame, Kind, LockError, Quality, SEAL, Steps, UpdateError, is_under_way};

    /// A step of the lock that is under way. True if only [`conclude_lock`] is left.
    ///
    /// # Errors
    /// As [`Target::resume_lock`](crate::Target::resume_lock).
    pub fn step_lock<T: Steps>(
        target: &mut T,
        workspace: &mut T::Workspace,
        frame: &Frame<'_>,
        work: u32,
    ) -> Result<bool, LockError> {
        if !is_under_way(target, workspace, Kind::Lock) {
            return Err(LockError::NotBegun);
        }
        target.check_lock_under_way(workspace, frame, SEAL)?;
        Ok(super::step(target, workspace, frame, work))
    }

    /// A step of the update that is under way. True if only [`conclude`] is left.
    ///
    /// # Errors
    /// As [`Target::resume`](crate::Target::resume).
    pub fn step<T: Steps>(
        target: &mut T,
        workspace: &mut T::Workspace,
        frame: &Frame<'_>,
        work: u32,
    ) -> Result<bool, UpdateError> {
        if !is_under_way(target, workspace, Kind::Update) {
            return Err(UpdateError::NotBegun);
        }
        target.check(frame, SEAL)?;
        Ok(super::step(target, workspace, frame, work))
    }

    /// Ends an update whose last step was true.
    pub fn conclude<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Answer {
        super::end(target, workspace);
        target.conclude(workspace, frame, SEAL)
    }

    /// Ends a lock whose last step was true.
    pub fn conclude_lock<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Quality {
        super::end(target, workspace);
        target.conclude_lock(workspace, frame, SEAL)
    }
}

/// Continues for about `work` units of work.
fn step<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>, work: u32) -> bool {
    T::under_way(workspace, SEAL).grant(work);
    target.advance(workspace, frame, SEAL)
}

/// Nothing is under way any more.
fn end<T: Steps>(target: &mut T, workspace: &mut T::Workspace) {
    T::under_way(workspace, SEAL).end();
    target.ticket(SEAL).change();
}

/// Does all remaining steps.
fn complete<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) {
    while !step(target, workspace, frame, u32::MAX) {}
    end(target, workspace);
}

/// A whole lock. Unlike [`Lock`] it keeps no second copy of the frame on the stack.
pub(super) fn lock<T: Steps>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
    rect: Rect,
) -> Result<Quality, LockError> {
    target.check_lock(frame, rect, SEAL)?;
    begin(target, workspace, Kind::Lock);
    target.start_lock(workspace, frame.bounds(), rect, SEAL);
    complete(target, workspace, frame);
    Ok(target.conclude_lock(workspace, frame, SEAL))
}

impl<'a, T: Steps> Update<'a, T> {
    pub(super) fn begin(
        target: &'a mut T,
        workspace: &'a mut T::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Self, UpdateError> {
        target.check(frame, SEAL)?;
        begin(target, workspace, Kind::Update);
        target.start(workspace, SEAL);
        Ok(Self(Running { target, workspace, frame: *frame }))
    }

    pub(super) fn resume(
        target: &'a mut T,
        workspace: &'a mut T::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Self, UpdateError> {
        if !is_under_way(target, workspace, Kind::Update) {
            return Err(UpdateError::NotBegun);
        }
        target.check(frame, SEAL)?;
        Ok(Self(Running { target, workspace, frame: *frame }))
    }

    /// Continues for about `work` units of work; 0 counts as 1. True if only [`Update::finish`] is left.
    ///
    /// | | [`Paper`](crate::Paper) | [`Robust`](crate::Robust) |
    /// |---|---|---|
    /// | a unit | a comparison of two bytes | about one instruction of a Cortex-M4: a product is 1 unit, a pixel of the grid 64, a comparison of one 32 |
    /// | most work beyond `work` ([`MostWork::beyond_a_step`](crate::MostWork::beyond_a_step)) | max(pixels of the template, 2 * pixels of a row of the window) + 7 * `SPAN` | 128,000 |
    /// | left to `finish` | one pass over the template | one pass over the weights and the template |
    pub fn step(&mut self, work: u32) -> bool {
        self.0.step(work)
    }

    /// An upper bound of the work since the update was begun: comparisons that scoring skipped are counted too. Saturates at
    /// `u32::MAX`, which [`Paper`](crate::Paper) can reach in windows of more than 200x200 offsets.
    #[must_use]
    pub fn work(&self) -> u32 {
        T::work(self.0.workspace)
    }

    /// Does the remaining work and returns the answer.
    #[must_use]
    pub fn finish(self) -> Answer {
        let Running { target, workspace, frame } = &mut { self.0 };
        complete(*target, workspace, frame);
        target.conclude(workspace, frame, SEAL)
    }
}

impl<'a, T: Steps> Lock<'a, T> {
    pub(super) fn begin(
        target: &'a mut T,
        workspace: &'a mut T::Workspace,
        frame: &Frame<'a>,
        rect: Rect,
    ) -> Result<Self, LockError> {
        target.check_lock(frame, rect, SEAL)?;
        begin(target, workspace, Kind::Lock);
        target.start_lock(workspace, frame.bounds(), rect, SEAL);
        Ok(Self(Running { target, workspace, frame: *frame }))
    }

    pub(super) fn resume(
        target: &'a mut T,
        workspace: &'a mut T::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Self, LockError> {
        if !is_under_way(target, workspace, Kind::Lock) {
            return Err(LockError::NotBegun);
        }
        target.check_lock_under_way(workspace, frame, SEAL)?;
        Ok(Self(Running { target, workspace, frame: *frame }))
    }

    /// As [`Update::step`]; true if only [`Lock::finish`] is left. [`Paper`](crate::Paper) does all work in `finish`.
    pub fn step(&mut self, work: u32) -> bool {
        self.0.step(work)
    }

    /// The work since the lock was begun, in the units of [`Update::step`].
    #[must_use]
    pub fn work(&self) -> u32 {
        T::work(self.0.workspace)
    }

    /// Does the remaining work and sets the target. Returns how distinct it is.
    pub fn finish(self) -> Quality {
        let Running { target, workspace, frame } = &mut { self.0 };
        complete(*target, workspace, frame);
        target.conclude_lock(workspace, frame, SEAL)
    }
}

impl<T: Steps> fmt::Debug for Update<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Update").field("work", &self.work()).finish_non_exhaustive()
    }
}

impl<T: Steps> fmt::Debug for Lock<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Lock").field("work", &self.work()).finish_non_exhaustive()
    }
}
