//! The handle `smr_tracker` that C uses, and the access to the tracker behind it.

use crate::answer::smr_answer;
use crate::capacity::{PaperTarget, SmallTarget};
use crate::frame::smr_frame;
use crate::pointer::{self, Out};
use crate::status::{SMR_ERROR_NOT_INITIALISED, smr_status};
use core::ops::Range;
use core::ptr::addr_of;
use smr_core::{Frame, Rect, Robust, Windows};

/// A tracker of one target, in storage that the caller gives to #smr_init. It needs no clean-up and must not move.
///
/// Calls on the same tracker, or on trackers that share a workspace, must not overlap in time. Other calls may.
pub struct smr_tracker {
    /// Equals [`mark_of`] of the handle's address, else the memory is not a tracker.
    mark: usize,
    /// The receiver of calls: `own`, or a recorder, whose code is linked only if the program calls `smr_record`.
    receiver: *mut dyn Tracked,
    /// The tracker itself, in the same storage as this handle.
    pub(crate) own: *mut dyn Tracked,
}

impl smr_tracker {
    pub(crate) fn new(address: *const Self, receiver: *mut dyn Tracked) -> Self {
        Self { mark: mark_of(address), receiver, own: receiver }
    }

    pub(crate) const fn send_to(&mut self, receiver: *mut dyn Tracked) {
        self.receiver = receiver;
    }
}

/// The mark of a handle at `address`. Never 0: an aligned address is even, and the constant is odd.
fn mark_of(address: *const smr_tracker) -> usize {
    address.addr() ^ 0x534D_5231 // "SMR1"
}

/// The target with its concrete type. Rarely used calls match on it instead of being methods of [`Tracked`], because a
/// program links all methods of that trait, used or not.
pub(crate) enum Known<'a> {
    Paper(&'a mut PaperTarget),
    Robust(&'a mut Robust),
    Small(&'a mut SmallTarget),
}

/// Evaluates `$result` with `$of` bound to the target, for each type of target.
macro_rules! each {
    ($known:expr, $of:ident => $result:expr) => {
        match $known {
            Known::Paper($of) => $result,
            Known::Robust($of) => $result,
            Known::Small($of) => $result,
        }
    };
}
pub(crate) use each;

#[derive(Clone, Copy)]
pub(crate) enum Event<'a> {
    Begin,
    Lock(&'a Frame<'a>, Rect),
    Window(&'a Frame<'a>),
    /// The answer, which is already in the caller's memory.
    Answer(&'a Out<smr_answer>),
    Moved(i32, i32),
    Restored(&'a [u8]),
}

/// A call that may take several steps.
pub(crate) enum Call {
    Lock(Rect),
    /// The answer is written to the caller's memory, because a returned answer would be on the stack twice.
    Update(Out<smr_answer>),
}

/// The calls on a tracker of either type.
pub(crate) trait Tracked {
    fn known(&mut self) -> Known<'_>;
    /// The addresses of the storage and of the workspace.
    fn memory(&self) -> [Range<usize>; 2];
    fn lock_window(&self, bounds: Rect, target: Rect) -> Rect;
    /// Checks a call, and begins it or continues the one under way; `None`: begins it in any case. Returns true if it
    /// begins.
    fn begin(&mut self, frame: &Frame<'_>, call: &Call, work: Option<u32>) -> Result<bool, smr_status>;
    /// Does the work of a call after [`Tracked::begin`]: about `work` units; `None`: all. Returns
    /// [`SMR_UNDER_WAY`](crate::status::SMR_UNDER_WAY) while work remains.
    fn step(&mut self, frame: &Frame<'_>, call: &Call, work: Option<u32>) -> Result<(), smr_status>;
    /// Passes an event to the recorder, if there is one.
    fn record(&mut self, _: &Event<'_>) {}
    fn windows(&self) -> Option<Windows>;
    #[cfg(feature = "unstable")]
    fn work(&self) -> Result<u32, smr_status>;
    #[cfg(feature = "unstable")]
    fn response_map(&mut self, frame: &Frame<'_>) -> Result<ResponseMap, smr_status>;
}

/// The robust tracker's filter responses: `[reach + y][reach + x]` for an offset of (x, y) cells, `reach` at most 8.
#[cfg(feature = "unstable")]
pub(crate) type ResponseMap = [[i32; 17]; 17];

/// The tracker that `smr_init` made at this address.
///
/// # Safety
/// A `tracker` that is not NULL points to a handle that `smr_init` made, or to memory of that size without its mark.
/// Nobody else uses the tracker while the result lives.
#[inline(never)] // one copy in flash
pub(crate) unsafe fn borrow<'a>(tracker: *mut smr_tracker) -> Result<&'a mut dyn Tracked, smr_status> {
    pointer::check(tracker)?;
    // SAFETY: `tracker` passed `check`, so there is memory for a handle. Only the mark is read, and any bytes are a
    // usize.
    let mark = unsafe { addr_of!((*tracker).mark).read() };
    if mark != mark_of(tracker) {
        return Err(SMR_ERROR_NOT_INITIALISED);
    }
    // SAFETY: the mark shows that `smr_init` made a tracker here, and nobody else uses it while the result lives.
    Ok(unsafe { &mut *(*tracker).receiver })
}

/// Writes the result of `question` to `out`. A `question` only reads the tracker.
///
/// # Safety
/// A `tracker` that is not NULL points to a handle that `smr_init` made, or to memory of that size without its mark.
/// Nobody else uses the tracker during the call. An `out` that passes `pointer::check` points to memory for a `T`.
pub(crate) unsafe fn write_result<T>(
    tracker: *const smr_tracker,
    out: *mut T,
    question: impl FnOnce(&mut dyn Tracked) -> Result<T, smr_status>,
) -> Result<(), smr_status> {
    // SAFETY: nobody else uses the tracker, which is not written through this borrow, and `out` points to memory for a
    // T.
    let (tracker, out) = unsafe { (borrow(tracker.cast_mut())?, Out::new(out)?) };
    out.write(question(tracker)?);
    Ok(())
}

/// Calls `work` with a tracker and a frame. The frame's pixels must lie outside the tracker's memory.
///
/// # Safety
/// A `tracker` that is not NULL points to a handle that `smr_init` made, or to memory of that size without its mark.
/// Nobody else uses the tracker during the call. A `frame` that passes `pointer::check` points to an `smr_frame`, whose
/// pixels can be read, and stay unchanged, during the call.
pub(crate) unsafe fn with_frame(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    work: impl FnOnce(&mut dyn Tracked, &Frame<'_>) -> Result<(), smr_status>,
) -> Result<(), smr_status> {
    // Not `?`, which would copy the frame.
    // SAFETY: nobody else uses the tracker, and the pixels of `frame` can be read, until `work` returns.
    match &mut unsafe { framed(tracker, frame) } {
        Ok((tracker, frame)) => work(*tracker, frame),
        Err(error) => Err(*error),
    }
}

/// Dereferences the pointers of [`with_frame`], and checks that the frame lies outside the tracker's memory.
///
/// # Safety
/// A `tracker` that is not NULL points to a handle that `smr_init` made, or to memory of that size without its mark.
/// Nobody else uses the tracker while the result lives. A `frame` that passes `pointer::check` points to an
/// `smr_frame`, whose pixels can be read, and stay unchanged, while the result lives.
#[inline(never)] // one copy in flash
unsafe fn framed<'a>(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
) -> Result<(&'a mut dyn Tracked, Frame<'a>), smr_status> {
    // SAFETY: nobody else uses the tracker, and the pixels of `frame` can be read, while the result lives. `frame` is
    // dereferenced after `check` has passed it.
    unsafe {
        let tracker = borrow(tracker)?;
        pointer::check(frame)?;
        let frame = (*frame).frame(&tracker.memory())?;
        Ok((tracker, frame))
    }
}
