//! Updates and locks in steps: one protocol for both trackers and for C.
//!
//! The result of an update depends only on the target's state and on the frame. The workspace therefore stores a
//! fingerprint of the state of the target that began the update, and `resume` accepts any target in that state: the one
//! that began, wherever it lies, or a copy. A lock, the end of an update, `restore` and `moved` change the state, and
//! so they end an update under way. A lock under way is part of the state: its box, and the weights learned so far.

use super::budget::Budget;
use super::{Answer, LockError, Quality, UpdateError};
use crate::image::{Frame, Rect};
use core::{fmt, mem};

/// The key to the sealed methods of [`Steps`]. Only this crate can make one, so only this crate can call them.
#[derive(Debug)]
pub struct Seal(());

pub(super) const SEAL: &Seal = &Seal(());

/// Identifies the target of an update or lock under way by a fingerprint of its state.
///
/// The fingerprint is two sums of 32 bits. Each word of the state is added to the first sum, and the first sum to the
/// second: 10 instructions of a Cortex-M0+ for each word. Two different states have the same fingerprint only by
/// chance, once in 2^64. It protects from confusion, not from malice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    word: u32,
    sum: u32,
}

impl Owner {
    const NOBODY: Self = Self { word: 0, sum: 0 };

    /// The fingerprint of a target.
    #[inline(never)]
    fn of<T: Steps>(target: &T) -> Self {
        let mut owner = Self::NOBODY;
        target.identify(&mut owner, SEAL);
        owner
    }

    /// Identifies a tracker of C by its address: such a tracker does not move.
    #[must_use]
    pub const fn at(address: usize) -> Self {
        let [word, sum] = halves((address as u64).to_le_bytes());
        Self { word, sum }
    }

    /// Adds a number of the state. Odd factors and rotations lose no bits, so states that differ in one word never have
    /// the same fingerprint.
    #[inline(always)] // six instructions
    pub(super) const fn add(&mut self, number: u32) {
        self.word = (self.word ^ number).wrapping_mul(0x9E37_79B1).rotate_left(15);
        self.sum = self.sum.wrapping_add(self.word).wrapping_mul(0x85EB_CA77).rotate_left(13);
    }

    pub(super) const fn add_long(&mut self, number: i64) {
        let [low, high] = halves(number.to_le_bytes());
        self.add(low);
        self.add(high);
    }

    pub(super) const fn add_rect(&mut self, rect: Rect) {
        self.add(rect.x.cast_unsigned());
        self.add(rect.y.cast_unsigned());
        self.add((rect.width as u32) << 16 | rect.height as u32);
    }

    /// Adds bytes, four at a time. It does not add their number; the caller must.
    #[inline(never)]
    pub(super) fn add_bytes(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        words.iter().for_each(|&word| self.add(u32::from_le_bytes(word)));
        rest.iter().for_each(|&byte| self.add(byte.into()));
    }
}

/// The words of a long number.
const fn halves([a, b, c, d, e, f, g, h]: [u8; 8]) -> [u32; 2] {
    [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])]
}

/// The lock that is under way on a target: frame size and box. The box is empty if no lock is under way. While there is
/// a track, it has no meaning.
#[derive(Clone, Copy, Debug)]
pub(super) struct Locking {
    /// Width and height of the frame.
    frame: [u16; 2],
    /// The box, which is inside the frame: left, top, width, height.
    target: [u16; 4],
}

impl Locking {
    pub(super) const NOTHING: Self = Self { frame: [0; 2], target: [0; 4] };

    pub(super) fn new(bounds: Rect, target: Rect) -> Self {
        let place = |at: i32| u16::try_from(at).unwrap_or(0);
        let target = [place(target.x), place(target.y), target.width, target.height];
        Self { frame: [bounds.width, bounds.height], target }
    }

    pub(super) const fn bounds(&self) -> Rect {
        let [width, height] = self.frame;
        Rect::new(0, 0, width, height)
    }

    pub(super) fn target(&self) -> Rect {
        let [x, y, width, height] = self.target;
        Rect::new(x.into(), y.into(), width, height)
    }

    pub(super) fn identify(&self, owner: &mut Owner) {
        self.frame.into_iter().chain(self.target).for_each(|number| owner.add(number.into()));
    }
}

/// The kind of call that is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// No call.
    Nothing,
    /// A lock.
    Lock,
    /// An update.
    Update,
}

/// What a workspace stores about an update or lock under way.
#[derive(Clone, Copy, Debug)]
pub struct UnderWay {
    kind: Kind,
    owner: Owner,
    /// True if the last step of a lock has changed the target.
    changed: bool,
    pub(super) budget: Budget,
}

impl UnderWay {
    pub(super) const NOTHING: Self =
        Self { kind: Kind::Nothing, owner: Owner::NOBODY, changed: false, budget: Budget::NOTHING };

    /// Ends the update or lock under way.
    pub(super) const fn end(&mut self) {
        self.kind = Kind::Nothing;
    }

    /// Notes that this step of a lock has changed the target.
    pub(super) const fn change(&mut self) {
        self.changed = true;
    }
}

/// The stages of an update or a lock, and the workspace they use. A supertrait of [`Target`](crate::Target), sealed
/// like it.
pub trait Steps: Sized {
    /// Scratch memory for an update or a lock.
    type Workspace: Default;

    /// Adds to `owner` all of the target's state that the rest of an update or lock depends on.
    #[doc(hidden)]
    fn identify(&self, owner: &mut Owner, _: &Seal);

    /// What the workspace stores about an update or lock under way.
    #[doc(hidden)]
    fn under_way<'a>(workspace: &'a mut Self::Workspace, _: &Seal) -> &'a mut UnderWay;

    /// The work of the present or last update or lock in this workspace: see [`Tracker::work`](crate::Tracker::work).
    fn work(workspace: &Self::Workspace) -> u32;

    /// Checks that an update with `frame` is possible.
    ///
    /// # Errors
    /// All but [`NotBegun`](UpdateError::NotBegun).
    #[doc(hidden)]
    fn check(&self, frame: &Frame<'_>, _: &Seal) -> Result<(), UpdateError>;

    /// Checks that the box `target` in `frame` can be locked.
    ///
    /// # Errors
    /// All but [`NotBegun`](LockError::NotBegun).
    #[doc(hidden)]
    fn check_lock(&self, frame: &Frame<'_>, target: Rect, _: &Seal) -> Result<(), LockError>;

    /// Checks that the lock under way can continue with `frame`.
    ///
    /// # Errors
    /// [`LockError::FrameSizeChanged`], [`LockError::LockWindowNotInMemory`].
    #[doc(hidden)]
    fn check_lock_under_way(&self, frame: &Frame<'_>, _: &Seal) -> Result<(), LockError>;

    /// Begins an update. The frame was checked.
    #[doc(hidden)]
    fn start(&mut self, workspace: &mut Self::Workspace, _: &Seal);

    /// Begins a lock and forgets the previous target. The frame was checked.
    #[doc(hidden)]
    fn start_lock(&mut self, workspace: &mut Self::Workspace, bounds: Rect, target: Rect, _: &Seal);

    /// Continues an update until the grant is spent. True if only `commit` is left.
    #[doc(hidden)]
    fn step(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> bool;

    /// Continues a lock until the grant is spent. True if only `commit_lock` is left.
    #[doc(hidden)]
    fn step_lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> bool;

    /// Ends an update: changes the target and returns the answer.
    #[doc(hidden)]
    fn commit(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> Answer;

    /// Ends a lock: sets the target.
    #[doc(hidden)]
    fn commit_lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: &Seal) -> Quality;
}

/// Checks the frame and begins an update that has no owner yet. It can be resumed once [`own`] has set its owner.
fn begin<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Result<(), UpdateError> {
    target.check(frame, SEAL)?;
    *T::under_way(workspace, SEAL) = UnderWay::NOTHING;
    target.start(workspace, SEAL);
    Ok(())
}

/// Checks frame and box and begins a lock that has no owner yet: see [`begin`].
fn begin_lock<T: Steps>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
    rect: Rect,
) -> Result<(), LockError> {
    target.check_lock(frame, rect, SEAL)?;
    *T::under_way(workspace, SEAL) = UnderWay::NOTHING;
    target.start_lock(workspace, frame.bounds(), rect, SEAL);
    Ok(())
}

/// Sets the owner of the update or lock that has begun in this workspace.
fn own<T: Steps>(workspace: &mut T::Workspace, kind: Kind, owner: Owner) {
    let under_way = T::under_way(workspace, SEAL);
    (under_way.kind, under_way.owner) = (kind, owner);
}

/// True if an update or lock of `owner` is under way.
fn is_under_way<T: Steps>(workspace: &mut T::Workspace, kind: Kind, owner: impl FnOnce() -> Owner) -> bool {
    let under_way = T::under_way(workspace, SEAL);
    under_way.kind == kind && under_way.owner == owner()
}

/// An update under way, from [`Target::begin`](crate::Target::begin) or [`Tracker::begin`](crate::Tracker::begin).
///
/// If it is dropped before [`Update::finish`], only the workspace has changed.
/// [`Target::resume`](crate::Target::resume) continues it, wherever target and workspace are then; `begin` and `update`
/// start again.
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
/// There is no target until [`Lock::finish`]. [`Target::resume_lock`](crate::Target::resume_lock) continues a lock that
/// was dropped.
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

/// The target, workspace and frame of an [`Update`] or [`Lock`].
struct Running<'a, T: Steps> {
    target: &'a mut T,
    workspace: &'a mut T::Workspace,
    frame: Frame<'a>,
}

/// The calls of the C interface. It keeps neither an [`Update`] nor a [`Lock`], so no call has a copy of the frame on
/// its stack.
///
/// A tracker of C does not move, so each step compares its address ([`Owner::at`]), not the whole target. In return, C
/// must call [`cancel`](calls::cancel) after any other call that changes a target.
#[doc(hidden)]
pub mod calls {
    use super::{Answer, Frame, LockError, Quality, Rect, SEAL, Steps, UpdateError, own};
    pub use super::{Kind, Owner};

    /// See [`Target::begin_lock`](crate::Target::begin_lock).
    ///
    /// # Errors
    /// Those of that call.
    pub fn begin_lock<T: Steps>(
        (target, workspace, owner): (&mut T, &mut T::Workspace, Owner),
        frame: &Frame<'_>,
        rect: Rect,
    ) -> Result<(), LockError> {
        super::begin_lock(target, workspace, frame, rect)?;
        own::<T>(workspace, Kind::Lock, owner);
        Ok(())
    }

    /// See [`Target::begin`](crate::Target::begin).
    ///
    /// # Errors
    /// Those of that call.
    pub fn begin<T: Steps>(
        (target, workspace, owner): (&mut T, &mut T::Workspace, Owner),
        frame: &Frame<'_>,
    ) -> Result<(), UpdateError> {
        super::begin(target, workspace, frame)?;
        own::<T>(workspace, Kind::Update, owner);
        Ok(())
    }

    /// The kind of call of `owner` that is under way.
    pub fn under_way<T: Steps>(workspace: &mut T::Workspace, owner: Owner) -> Kind {
        let under_way = T::under_way(workspace, SEAL);
        if under_way.owner == owner { under_way.kind } else { Kind::Nothing }
    }

    /// A step of the lock that is [under way](under_way). True if only [`commit_lock`] is left.
    ///
    /// # Errors
    /// Those of [`Target::resume_lock`](crate::Target::resume_lock).
    pub fn step_lock<T: Steps>(
        target: &mut T,
        workspace: &mut T::Workspace,
        frame: &Frame<'_>,
        work: u32,
    ) -> Result<bool, LockError> {
        target.check_lock_under_way(frame, SEAL)?;
        Ok(super::step_lock(target, workspace, frame, work))
    }

    /// A step of the update that is [under way](under_way). True if only [`commit`] is left.
    ///
    /// # Errors
    /// Those of [`Target::resume`](crate::Target::resume).
    pub fn step<T: Steps>(
        target: &mut T,
        workspace: &mut T::Workspace,
        frame: &Frame<'_>,
        work: u32,
    ) -> Result<bool, UpdateError> {
        target.check(frame, SEAL)?;
        Ok(super::step(target, workspace, frame, work))
    }

    /// Ends an update whose last step was true.
    pub fn commit<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Answer {
        T::under_way(workspace, SEAL).end();
        target.commit(workspace, frame, SEAL)
    }

    /// Ends a lock whose last step was true.
    pub fn commit_lock<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Quality {
        T::under_way(workspace, SEAL).end();
        target.commit_lock(workspace, frame, SEAL)
    }

    /// Ends the update or lock of `owner`, if one is under way, because the target has changed.
    pub fn cancel<T: Steps>(workspace: &mut T::Workspace, owner: Owner) {
        let under_way = T::under_way(workspace, SEAL);
        if under_way.owner == owner {
            under_way.end();
        }
    }
}

/// Continues an update for about `work` units of work.
fn step<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>, work: u32) -> bool {
    T::under_way(workspace, SEAL).budget.grant(work);
    target.step(workspace, frame, SEAL)
}

/// Continues a lock for about `work` units of work.
fn step_lock<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>, work: u32) -> bool {
    T::under_way(workspace, SEAL).budget.grant(work);
    target.step_lock(workspace, frame, SEAL)
}

/// Does the remaining work of an update.
fn finish<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Answer {
    while !step(target, workspace, frame, u32::MAX) {}
    T::under_way(workspace, SEAL).end();
    target.commit(workspace, frame, SEAL)
}

/// Does the remaining work of a lock.
fn finish_lock<T: Steps>(target: &mut T, workspace: &mut T::Workspace, frame: &Frame<'_>) -> Quality {
    while !step_lock(target, workspace, frame, u32::MAX) {}
    T::under_way(workspace, SEAL).end();
    target.commit_lock(workspace, frame, SEAL)
}

/// Does a whole lock. Unlike [`Lock`] it keeps no second copy of the frame on the stack.
pub(super) fn lock<T: Steps>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
    rect: Rect,
) -> Result<Quality, LockError> {
    begin_lock(target, workspace, frame, rect)?;
    Ok(finish_lock(target, workspace, frame))
}

/// Does a whole update. Unlike [`Update`] it keeps no second copy of the frame on the stack.
pub(super) fn update<T: Steps>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
) -> Result<Answer, UpdateError> {
    begin(target, workspace, frame)?;
    Ok(finish(target, workspace, frame))
}

impl<'a, T: Steps> Update<'a, T> {
    pub(super) fn begin(
        target: &'a mut T,
        workspace: &'a mut T::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Self, UpdateError> {
        begin(target, workspace, frame)?;
        own::<T>(workspace, Kind::Update, Owner::of(target));
        Ok(Self(Running { target, workspace, frame: *frame }))
    }

    pub(super) fn resume(
        target: &'a mut T,
        workspace: &'a mut T::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Self, UpdateError> {
        if !is_under_way::<T>(workspace, Kind::Update, || Owner::of(target)) {
            return Err(UpdateError::NotBegun);
        }
        target.check(frame, SEAL)?;
        Ok(Self(Running { target, workspace, frame: *frame }))
    }

    /// Continues for about `work` units of work; 0 counts as 1. True if only [`Update::finish`] is left.
    ///
    /// | | [`Paper`](crate::Paper) | [`Robust`](crate::Robust) |
    /// |---|---|---|
    /// | a unit | a comparison of two bytes | about one instruction of a Cortex-M4 |
    /// | most work beyond `work` | max(pixels of the template, 2 * pixels in a window's row) + 7 * `SPAN` | 128,000 |
    /// | left to `finish` | one pass over the template | one pass over the weights and the template |
    ///
    /// For [`Robust`](crate::Robust) a product is 1 unit, a pixel of the grid 64 and the comparison of a pixel 12. The
    /// most work beyond `work` for a configuration is [`MostWork::beyond_a_step`](crate::MostWork::beyond_a_step).
    pub fn step(&mut self, work: u32) -> bool {
        let Running { target, workspace, frame } = &mut self.0;
        step(*target, workspace, frame, work)
    }

    /// An upper bound of the work since the update was begun: it includes comparisons that scoring skipped. It
    /// saturates at `u32::MAX`, which [`Paper`](crate::Paper) can reach in windows of more than 200x200 offsets.
    #[must_use]
    pub fn work(&self) -> u32 {
        T::work(self.0.workspace)
    }

    /// Does the remaining work and returns the answer.
    #[must_use]
    pub fn finish(self) -> Answer {
        let Running { target, workspace, frame } = &mut { self.0 };
        finish(*target, workspace, frame)
    }
}

impl<'a, T: Steps> Lock<'a, T> {
    pub(super) fn begin(
        target: &'a mut T,
        workspace: &'a mut T::Workspace,
        frame: &Frame<'a>,
        rect: Rect,
    ) -> Result<Self, LockError> {
        begin_lock(target, workspace, frame, rect)?;
        own::<T>(workspace, Kind::Lock, Owner::of(target));
        Ok(Self(Running { target, workspace, frame: *frame }))
    }

    pub(super) fn resume(
        target: &'a mut T,
        workspace: &'a mut T::Workspace,
        frame: &Frame<'a>,
    ) -> Result<Self, LockError> {
        if !is_under_way::<T>(workspace, Kind::Lock, || Owner::of(target)) {
            return Err(LockError::NotBegun);
        }
        target.check_lock_under_way(frame, SEAL)?;
        Ok(Self(Running { target, workspace, frame: *frame }))
    }

    /// Continues for about `work` units of work: see [`Update::step`]. True if only [`Lock::finish`] is left.
    /// [`Paper`](crate::Paper) does all work in `finish`.
    ///
    /// A step that changes the weights (25 in a lock) reads the whole target once more, as
    /// [`Target::resume`](crate::Target::resume) does.
    pub fn step(&mut self, work: u32) -> bool {
        let Running { target, workspace, frame } = &mut self.0;
        let done = step_lock(*target, workspace, frame, work);
        if mem::take(&mut T::under_way(workspace, SEAL).changed) {
            own::<T>(workspace, Kind::Lock, Owner::of(*target));
        }
        done
    }

    /// The work since the lock was begun, in the units of [`Update::step`].
    #[must_use]
    pub fn work(&self) -> u32 {
        T::work(self.0.workspace)
    }

    /// Does the remaining work and sets the target. Returns how distinct it is.
    pub fn finish(self) -> Quality {
        let Running { target, workspace, frame } = &mut { self.0 };
        finish_lock(*target, workspace, frame)
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
