//! Updates and locks in steps: the one protocol that both trackers and C go by.
//!
//! What is under way is written down on both sides. The workspace knows its target by address and generation, the target knows
//! its workspace by address. Every lock, restore, move and beginning gives the target another generation. So a workspace
//! that served another target, a target that has changed, and one that has been moved in memory do not fit each other any more, and
//! are refused.
//!
//! Each call is granted an amount of work, which is counted down. Nothing depends on the sum of all work.

use super::{Answer, LockError, Quality, UpdateError};
use crate::image::{Frame, Rect};
use core::ptr;

/// Only this crate has one, so only this crate can call [`Steps`].
pub struct Seal(());

pub(super) const SEAL: &Seal = &Seal(());

/// What a target knows of what is under way.
#[derive(Clone, Copy)]
pub struct Ticket {
    generation: u32,
    /// The address of the workspace; 0, where none can be, if nothing is under way.
    workspace: usize,
}

impl Ticket {
    pub(super) const NEW: Self = Self { generation: 0, workspace: 0 };

    /// The target has changed: what was under way is given up.
    pub(super) const fn change(&mut self) {
        *self = Self { generation: self.generation.wrapping_add(1), workspace: 0 };
    }
}

/// What is made in steps.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Nothing,
    Lock,
    Update,
}

/// What a workspace knows of what is under way in it.
#[derive(Clone, Copy)]
pub struct UnderWay {
    kind: Kind,
    /// The target's address and its generation.
    target: usize,
    generation: u32,
    /// Units of work that the present call may still do.
    granted: u32,
    /// Units of work that were done in all calls. It is only shown, so it may stop at its largest number.
    done: u32,
}

impl UnderWay {
    pub(super) const NOTHING: Self = Self { kind: Kind::Nothing, target: 0, generation: 0, granted: 0, done: 0 };

    /// What was under way is given up, or done.
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

    /// So much work has been done: more than what is granted where a unit of work could not be divided.
    pub(super) const fn spend(&mut self, work: u32) {
        self.granted = self.granted.saturating_sub(work);
        self.done = self.done.saturating_add(work);
    }

    /// 0 is taken for 1, so that every call goes on.
    const fn grant(&mut self, work: u32) {
        self.granted = if work == 0 { 1 } else { work };
    }
}

/// What a tracker does in an update or a lock. What changes something is sealed: nobody outside of the crate can call it.
pub trait Steps: Sized {
    /// Scratch memory for an update.
    type Workspace: Default;

    /// The target's side of what is under way.
    fn ticket(&mut self, _: &Seal) -> &mut Ticket;

    /// The workspace's side of it.
    fn under_way<'a>(workspace: &'a mut Self::Workspace, _: &Seal) -> &'a mut UnderWay;

    /// The work of what is under way in this workspace, or was last: see [`Tracker::work`](super::Tracker::work).
    fn work(workspace: &Self::Workspace) -> u32;

    /// Whether an update by `frame` can be made.
    ///
    /// # Errors
    /// All but [`NotBegun`](UpdateError::NotBegun).
    fn check(&self, frame: &Frame<'_>, _: &Seal) -> Result<(), UpdateError>;

    /// Whether `target` can be locked on in `frame`.
    ///
    /// # Errors
    /// All but [`NotBegun`](LockError::NotBegun).
    fn check_lock(&self, frame: &Frame<'_>, target: Rect, _: &Seal) -> Result<(), LockError>;

    /// Whether the lock that was begun last in this workspace, which is one of this target, can go on with `frame`.
    ///
    /// # Errors
    /// As [`Steps::check_lock`].
    fn check_lock_under_way(&self, workspace: &Self::Workspace, frame: &Frame<'_>, _: &Seal) -> Result<(), LockError>;

    /// Begins an update, by a frame that was checked.
    fn start(&mut self, workspace: &mut Self::Workspace, _: &Seal);

    /// Begins a lock, by a frame that was checked. The former target is forgotten.
    fn start_lock(&mut self, workspace: &mut Self::Workspace, bounds: Rect, target: Rect, _: &Seal);

    /// Goes on with either of them until what is granted is spent; true when nothing is left to do but to conclude.
    fn advance(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> bool;

    /// Ends an update: changes the target, and gives the answer.
    fn conclude(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> Answer;

    /// Ends a lock: from now on there is a target.
    fn conclude_lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> Quality;
}

/// Writes down on both sides that something begins.
#[inline(never)] // one copy in flash
fn begin<T: Steps>(target: &mut T, workspace: &mut T::Workspace, kind: Kind) {
    let (address, workspace_address) = (ptr::from_ref(target).addr(), ptr::from_ref(workspace).addr());
    let ticket = target.ticket(SEAL);
    ticket.change();
    ticket.workspace = workspace_address;
    let generation = ticket.generation;
    *T::under_way(workspace, SEAL) = UnderWay { kind, target: address, generation, ..UnderWay::NOTHING };
}

/// True if it is this target's, and both sides say so.
#[inline(never)] // one copy in flash
fn is_under_way<T: Steps>(target: &mut T, workspace: &mut T::Workspace, kind: Kind) -> bool {
    let (address, workspace_address) = (ptr::from_ref(target).addr(), ptr::from_ref(workspace).addr());
    let Ticket { generation, workspace: begun_in } = *target.ticket(SEAL);
    let under_way = T::under_way(workspace, SEAL);
    under_way.kind == kind
        && (under_way.target, under_way.generation) == (address, generation)
        && begun_in == workspace_address
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
pub struct Update<'a, T: Steps>(Under<'a, T>);

/// A lock under way, from [`Target::begin_lock`](super::Target::begin_lock) or [`Tracker::begin_lock`](super::Tracker::begin_lock).
///
/// From the beginning on there is no target, until [`Lock::finish`] has been called.
/// [`Target::resume_lock`](super::Target::resume_lock) takes up a lock that was dropped.
///
/// ```
/// # use smr_core::{Frame, Image, Rect, Robust, Tracker, robust};
/// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
/// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
/// let mut tracker = Box::new(Tracker::<Robust>::new(robust::Config::robust())?);
/// let mut lock = tracker.begin_lock(&frame, Rect::new(20, 10, 16, 16))?;
/// while !lock.step(200_000) {
///     // something else that must not wait
/// }
/// assert!(!lock.finish().is_poor());
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct Lock<'a, T: Steps>(Under<'a, T>);

/// All that goes on takes.
struct Under<'a, T: Steps> {
    target: &'a mut T,
    workspace: &'a mut T::Workspace,
    frame: Frame<'a>,
}

impl<T: Steps> Under<'_, T> {
    fn step(&mut self, work: u32) -> bool {
        T::under_way(self.workspace, SEAL).grant(work);
        self.target.advance(self.workspace, &self.frame, SEAL)
    }
}

/// Does all that is left but to conclude.
fn complete<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) {
    T::under_way(workspace, SEAL).grant(u32::MAX);
    while !target.advance(workspace, frame, SEAL) {
        T::under_way(workspace, SEAL).grant(u32::MAX);
    }
    T::under_way(workspace, SEAL).end();
    target.ticket(SEAL).change();
}

/// A lock at once: without the frame on the stack once more.
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
        Ok(Self(Under { target, workspace, frame: *frame }))
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
        Ok(Self(Under { target, workspace, frame: *frame }))
    }

    /// Goes on until `work` units of work have been done, and a few more to come to a stop. True when nothing is left to do but
    /// [`Update::finish`]. With 0 it does as much as with 1, so that it comes to an end.
    ///
    /// | | [`Paper`](crate::Paper) | [`Robust`](crate::Robust) |
    /// |---|---|---|
    /// | a unit | a comparison of two bytes | about an instruction of a Cortex-M4: a product counts 1, a pixel of the grid 64, or 32 where it is compared |
    /// | more than `work`, at most: [`MostWork::beyond_a_step`](crate::MostWork::beyond_a_step) | the template's pixels or twice the pixels of a row of the window, and 7 `SPAN` | 128,000 |
    /// | left to `finish` | once through the template | once through the weights and the template |
    pub fn step(&mut self, work: u32) -> bool {
        self.0.step(work)
    }

    /// How much work has been done since the update was begun, at most: what could be left out is counted, too. It stops at
    /// `u32::MAX`, which [`Paper`](crate::Paper) can reach in windows of more than 200x200 offsets.
    #[must_use]
    pub fn work(&self) -> u32 {
        T::work(self.0.workspace)
    }

    /// Does what is left, and gives the answer.
    #[must_use]
    pub fn finish(self) -> Answer {
        let Under { target, workspace, frame } = self.0;
        complete(target, workspace, &frame);
        target.conclude(workspace, &frame, SEAL)
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
        Ok(Self(Under { target, workspace, frame: *frame }))
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
        Ok(Self(Under { target, workspace, frame: *frame }))
    }

    /// Goes on, as [`Update::step`]; true when nothing is left to do but [`Lock::finish`].
    ///
    /// [`Paper`](crate::Paper) does everything in `finish`: it copies the box.
    pub fn step(&mut self, work: u32) -> bool {
        self.0.step(work)
    }

    /// How much work has been done since the lock was begun, in the units of [`Update::step`].
    #[must_use]
    pub fn work(&self) -> u32 {
        T::work(self.0.workspace)
    }

    /// Does what is left. From now on there is a target; how well it can be told from what lies beside it is returned.
    pub fn finish(self) -> Quality {
        let Under { target, workspace, frame } = self.0;
        complete(target, workspace, &frame);
        target.conclude_lock(workspace, &frame, SEAL)
    }
}
