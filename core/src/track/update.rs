//! Updates and locks in steps: one protocol for both trackers and for C.
//!
//! The workspace stores the call under way and its progress; it and the target store the same [`Ticket`]. A call continues
//! only with the target and the workspace that have its ticket. Every other call that changes the target takes the
//! ticket away, and a call with another target replaces the one in the workspace. A call that fails does neither.

use super::{Answer, LockError, Quality, UpdateError};
use crate::image::{Frame, Rect};

/// The key to the sealed methods of [`Steps`]. Only this crate can create one, so only this crate can call them.
#[derive(Debug)]
pub struct Seal(());

pub(super) const SEAL: Seal = Seal(());

/// The latest call of a target, as the target and its workspace know it.
///
/// No number is unique without a global variable, which this crate must not have. So a call is known by the addresses
/// that its target and its workspace had when it began, and by a count that is above those of all earlier calls of this
/// target and of this workspace. It continues only while target and workspace have the same distance in memory, as in a
/// [`Tracker`](crate::Tracker) that moves. So no target continues the call of another, as long as a program neither
/// replaces a target by a new one at the same place nor exchanges workspaces between the steps of a call: then it must
/// call [`Target::cancel`](crate::Target::cancel) first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ticket {
    target: usize,
    workspace: usize,
    count: u32,
}

impl Ticket {
    pub(super) const NONE: Self = Self { target: 0, workspace: 0, count: 0 };

    /// Ends the update or lock that is under way, in whichever workspace it is. The count stays, so that no later
    /// ticket equals an earlier one.
    pub(super) const fn end(&mut self) {
        self.target = 0;
    }

    /// The ticket of a call that begins after the calls of `self` and `other`.
    const fn next(self, other: Self, target: usize, workspace: usize) -> Self {
        let latest = if self.count > other.count { self.count } else { other.count };
        Self { target, workspace, count: latest.wrapping_add(1) }
    }

    const fn is_at_distance(self, distance: usize) -> bool {
        self.target.wrapping_sub(self.workspace) == distance
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)] // `Nothing` is 0, so that a workspace in a `static` begins as zeroes
enum Call {
    Nothing,
    Update,
    /// A lock: the size of the frame, and the box.
    Lock([u16; 2], Rect),
}

/// The work that is left to the present step, and the work of all steps so far. A unit is about one instruction of a
/// Cortex-M4, or for the paper tracker a comparison of two bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    granted: u32,
    /// The work of all steps so far; saturates at `u32::MAX`.
    done: u32,
}

impl Budget {
    pub(super) const NOTHING: Self = Self { granted: 0, done: 0 };

    pub(super) const fn granted(&self) -> u32 {
        self.granted
    }

    pub(super) const fn done(&self) -> u32 {
        self.done
    }

    pub(super) const fn is_spent(&self) -> bool {
        self.granted == 0
    }

    /// Subtracts work from the grant. The work may exceed it, because a piece of work cannot be divided.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) const fn spend(&mut self, work: u32) {
        self.granted = self.granted.saturating_sub(work);
        self.done = self.done.saturating_add(work);
    }

    /// Grants a step its work. 0 counts as 1, so that every step makes progress.
    pub(super) const fn grant(&mut self, work: u32) {
        self.granted = if work == 0 { 1 } else { work };
    }
}

pub(super) fn units(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

pub(super) const fn largest(of: &[u32]) -> u32 {
    let (mut rest, mut largest) = (of, 0);
    while let [work, others @ ..] = rest {
        largest = if *work > largest { *work } else { largest };
        rest = others;
    }
    largest
}

/// The call under way in a workspace, and its budget.
#[derive(Clone, Copy, Debug)]
pub struct UnderWay {
    call: Call,
    ticket: Ticket,
    pub(super) budget: Budget,
}

impl UnderWay {
    pub(super) const NOTHING: Self = Self { call: Call::Nothing, ticket: Ticket::NONE, budget: Budget::NOTHING };

    pub(super) const fn end(&mut self) {
        self.call = Call::Nothing;
    }

    /// The lock under way: the bounds of its frame, and the box to lock. Both are empty if no lock is under way.
    pub(super) const fn locking(&self) -> (Rect, Rect) {
        let Call::Lock([width, height], bbox) = self.call else {
            return (Rect::new(0, 0, 0, 0), Rect::new(0, 0, 0, 0));
        };
        (Rect::new(0, 0, width, height), bbox)
    }
}

/// The stages of an update or a lock, and their workspace. A sealed supertrait of [`Target`](crate::Target).
pub trait Steps: Sized {
    /// Scratch memory for an update or a lock.
    type Workspace: Default;

    /// The state of the call under way in the workspace.
    #[doc(hidden)]
    fn under_way(workspace: &mut Self::Workspace, _: Seal) -> &mut UnderWay;

    /// The work of the present or last update or lock in this workspace: see [`Tracker::work`](crate::Tracker::work).
    fn work(workspace: &Self::Workspace) -> u32;

    /// The ticket of the latest call of this target.
    #[doc(hidden)]
    fn ticket(&mut self, _: Seal) -> &mut Ticket;

    /// Checks that an update with `frame` is possible.
    ///
    /// # Errors
    /// [`UpdateError`].
    #[doc(hidden)]
    fn check(&self, frame: &Frame<'_>, _: Seal) -> Result<(), UpdateError>;

    /// Checks that `bbox` in `frame` can be locked.
    ///
    /// # Errors
    /// [`LockError`].
    #[doc(hidden)]
    fn check_lock(&self, frame: &Frame<'_>, bbox: Rect, _: Seal) -> Result<(), LockError>;

    /// Begins an update with a checked frame.
    #[doc(hidden)]
    fn start(&mut self, workspace: &mut Self::Workspace, _: Seal);

    /// Begins a lock in a checked frame, and forgets the previous target.
    #[doc(hidden)]
    fn start_lock(&mut self, workspace: &mut Self::Workspace, bounds: Rect, bbox: Rect, _: Seal);

    /// Continues an update until the grant is spent. True if only `commit` remains.
    #[doc(hidden)]
    fn step(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: Seal) -> bool;

    /// Continues a lock until the grant is spent. True if only `commit_lock` remains.
    #[doc(hidden)]
    fn step_lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: Seal) -> bool;

    /// Ends an update: changes the target and returns the answer.
    #[doc(hidden)]
    fn commit(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: Seal) -> Answer;

    /// Ends a lock: sets the target.
    #[doc(hidden)]
    fn commit_lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: Seal) -> Quality;
}

pub mod calls {
    //! The stages of an update or a lock one by one: check, begin, step, commit. For interfaces to other languages, such
    //! as the one for C, which write the answer directly to the caller's memory and record the frame of an update when
    //! it begins. Everybody else calls [`Target::update_step`](crate::Target::update_step), which does the same.
    //!
    //! ```
    //! use smr_core::calls::{self, Checked};
    //! use smr_core::{Frame, Image, Rect, Robust, Target, robust};
    //! # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    //! # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
    //! let (mut target, mut workspace) = (<Robust>::new(), robust::Workspace::new());
    //! target.lock(&mut workspace, &frame, Rect::new(20, 10, 16, 16))?;
    //! let answer = loop {
    //!     let begins = Checked::update(&target, &frame)?.begin(&mut target, &mut workspace, Some(100_000));
    //!     if begins {
    //!         // The update begins with this step.
    //!     }
    //!     if calls::step(&mut target, &mut workspace, &frame, Some(100_000)) {
    //!         break calls::commit(&mut target, &mut workspace, &frame);
    //!     }
    //! };
    //! assert_eq!(answer.bbox, Rect::new(20, 10, 16, 16));
    //! # Ok::<(), smr_core::Error>(())
    //! ```

    use super::{Answer, Budget, Call, Frame, LockError, Quality, Rect, SEAL, Steps, UnderWay, UpdateError};
    use core::ptr;

    /// An update or a lock that has passed its checks. Only such a call can replace the one under way in a workspace, so
    /// a refused call leaves that one as it is.
    #[must_use]
    #[derive(Debug)]
    pub struct Checked(Call);

    impl Checked {
        /// Checks that `target` can be updated with `frame`. Reads no pixel.
        ///
        /// # Errors
        /// As [`Target::update`](crate::Target::update).
        pub fn update<T: Steps>(target: &T, frame: &Frame<'_>) -> Result<Self, UpdateError> {
            target.check(frame, SEAL)?;
            Ok(Self(Call::Update))
        }

        /// Checks that `target` can lock on `bbox` in `frame`. Reads no pixel.
        ///
        /// # Errors
        /// As [`Target::lock`](crate::Target::lock).
        pub fn lock<T: Steps>(target: &T, frame: &Frame<'_>, bbox: Rect) -> Result<Self, LockError> {
            target.check_lock(frame, bbox, SEAL)?;
            let Rect { width, height, .. } = frame.bounds();
            Ok(Self(Call::Lock([width, height], bbox)))
        }

        /// Begins this call of the checked target, in place of any other call under way of the target or in the
        /// workspace, or continues it if it is under way there. Grants its next step about `work` units. `None`: begins
        /// in any case, and grants everything. Returns true if the call begins.
        #[inline(always)] // one place calls it for each tracker in C
        pub fn begin<T: Steps>(self, target: &mut T, workspace: &mut T::Workspace, work: Option<u32>) -> bool {
            let Self(call) = self;
            let (place, scratch) = (ptr::from_ref(target).addr(), ptr::from_ref(workspace).addr());
            let (ticket, under_way) = (target.ticket(SEAL), T::under_way(workspace, SEAL));
            let is_same = under_way.call == call
                && under_way.ticket == *ticket
                && ticket.is_at_distance(place.wrapping_sub(scratch));
            let begins = work.is_none() || !is_same;
            if begins {
                *ticket = ticket.next(under_way.ticket, place, scratch);
                *under_way = UnderWay { call, ticket: *ticket, budget: Budget::NOTHING };
            }
            under_way.budget.grant(work.unwrap_or(u32::MAX));
            match call {
                Call::Update if begins => target.start(workspace, SEAL),
                Call::Lock([width, height], bbox) if begins => {
                    target.start_lock(workspace, Rect::new(0, 0, width, height), bbox, SEAL);
                }
                _ => {}
            }
            begins
        }
    }

    /// Continues the call under way after [`Checked::begin`], with the same `work`. True if only [`commit`] or
    /// [`commit_lock`] remains, which is so if `work` is `None`.
    pub fn step<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>, work: Option<u32>) -> bool {
        loop {
            let is_done = match T::under_way(workspace, SEAL).call {
                Call::Lock(..) => target.step_lock(workspace, frame, SEAL),
                _ => target.step(workspace, frame, SEAL),
            };
            if is_done || work.is_some() {
                return is_done;
            }
            T::under_way(workspace, SEAL).budget.grant(u32::MAX);
        }
    }

    /// Ends an update after [`step`] has returned true.
    pub fn commit<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Answer {
        T::under_way(workspace, SEAL).end();
        target.commit(workspace, frame, SEAL)
    }

    /// Ends a lock after [`step`] has returned true.
    pub fn commit_lock<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Quality {
        let quality = target.commit_lock(workspace, frame, SEAL);
        T::under_way(workspace, SEAL).end();
        quality
    }
}

pub(super) fn update<T: Steps>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
) -> Result<Answer, UpdateError> {
    calls::Checked::update(target, frame)?.begin(target, workspace, None);
    calls::step(target, workspace, frame, None);
    Ok(calls::commit(target, workspace, frame))
}

pub(super) fn lock<T: Steps>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
    bbox: Rect,
) -> Result<Quality, LockError> {
    calls::Checked::lock(target, frame, bbox)?.begin(target, workspace, None);
    calls::step(target, workspace, frame, None);
    Ok(calls::commit_lock(target, workspace, frame))
}

pub(super) fn update_step<T: Steps>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
    work: u32,
) -> Result<Option<Answer>, UpdateError> {
    calls::Checked::update(target, frame)?.begin(target, workspace, Some(work));
    let is_done = calls::step(target, workspace, frame, Some(work));
    Ok(is_done.then(|| calls::commit(target, workspace, frame)))
}

pub(super) fn lock_step<T: Steps>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
    bbox: Rect,
    work: u32,
) -> Result<Option<Quality>, LockError> {
    calls::Checked::lock(target, frame, bbox)?.begin(target, workspace, Some(work));
    let is_done = calls::step(target, workspace, frame, Some(work));
    Ok(is_done.then(|| calls::commit_lock(target, workspace, frame)))
}
