//! The tracker in storage of the caller: making it, and every call on it.

use crate::capacity::{PIXELS, SPAN, STORAGE_SIZE};
use crate::pointer::{self, Out};
use crate::status::{smr_status, status_of};
use crate::types::{smr_answer, smr_config, smr_frame, smr_image, smr_rect};
use core::ffi::c_void;
use core::ptr::{self, addr_of};
use smr_core::{Frame, Tracker};

/// Follows one target. Lives in storage that the caller gives to #smr_init; needs no clean-up.
///
/// Several targets are several trackers. Calls on one tracker must not overlap in time; calls on different ones may.
pub struct smr_tracker {
    /// [`mark_of`] its own address, so that other memory is not taken for a tracker.
    mark: usize,
    tracker: Tracker<PIXELS, SPAN>,
}

/// What a tracker at `address` is marked with. Never 0, whatever the alignment.
fn mark_of(address: *const smr_tracker) -> usize {
    address.addr() ^ 0x534D_5231 // "SMR1"
}

/// The size that storage must have, in bytes: #SMR_TRACKER_SIZE of the library as it was built.
///
/// @return  Bytes; differs from #SMR_TRACKER_SIZE if this program defines other capacities than the library was built with.
#[unsafe(no_mangle)]
pub extern "C" fn smr_tracker_size() -> usize {
    STORAGE_SIZE
}

/// Makes a tracker without a target.
///
/// @param storage  Memory for the tracker, such as an #smr_storage; aligned to #SMR_TRACKER_ALIGN. It must stay where it
///                 is, untouched, as long as the tracker is used; then it may be used for anything.
/// @param size     Bytes at `storage`; at least #smr_tracker_size.
/// @param config   Is copied, except for a table of its own: see #smr_config.
/// @param tracker  Is set to the tracker, or to NULL if there is none.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_STORAGE_TOO_SMALL,
///                 #SMR_ERROR_NOT_INITIALISED (the table), #SMR_ERROR_ZERO_DENOMINATOR, #SMR_ERROR_NOTHING_COUNTS or
///                 #SMR_ERROR_LIMIT_BELOW_WINDOW.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_init(
    storage: *mut c_void,
    size: usize,
    config: *const smr_config,
    tracker: *mut *mut smr_tracker,
) -> smr_status {
    // SAFETY: the caller gives memory for a pointer.
    let out = match unsafe { Out::new(tracker) } {
        Ok(out) => out,
        Err(status) => return status,
    };
    // SAFETY: as the header asks of the caller.
    let made = unsafe { init(storage.cast(), size, config) };
    out.write(made.unwrap_or(ptr::null_mut()));
    status_of(made.map(|_| ()))
}

/// # Safety
/// `storage` has `size` bytes for the tracker alone; `config` points to a configuration, its table stays.
unsafe fn init(
    storage: *mut smr_tracker,
    size: usize,
    config: *const smr_config,
) -> Result<*mut smr_tracker, smr_status> {
    // SAFETY: not written to before `size` is checked.
    let out = unsafe { Out::new(storage)? };
    if size < STORAGE_SIZE {
        return Err(smr_status::SMR_ERROR_STORAGE_TOO_SMALL);
    }
    // SAFETY: as the caller says, of the configuration and of its table.
    let config = unsafe { pointer::read(config)?.config()? };
    config.check()?; // before anything is changed
    if cfg!(debug_assertions) {
        // Copied, as a build that is not optimised would make it on the stack, several times over: a hundred kilobytes.
        static EMPTY: Tracker<PIXELS, SPAN> = Tracker::camera();
        // SAFETY: `Out` says that there is memory for both fields. The copy is a tracker as good as the original, which is
        // never dropped.
        let tracker = unsafe {
            (&raw mut (*storage).mark).write(mark_of(storage));
            (&raw mut (*storage).tracker).copy_from_nonoverlapping(&raw const EMPTY, 1);
            &mut (*storage).tracker
        };
        tracker.configure(config)?;
    } else {
        out.write(smr_tracker { mark: mark_of(storage), tracker: Tracker::new(config)? });
    }
    Ok(storage)
}

/// Starts on the target in a box, at any time; whatever was followed before is forgotten. Only the pixels of the box are
/// read.
///
/// @param tracker  Made by #smr_init.
/// @param frame    The frame, or a part of it that covers the box.
/// @param target   The box, wholly inside the frame, of at most #SMR_PIXELS pixels.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
///                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), what is wrong with the box
///                 (#SMR_ERROR_BOX_EMPTY to #SMR_ERROR_BOX_NOT_IN_MEMORY) or #SMR_ERROR_WINDOW_TOO_LARGE. After an
///                 error the tracker goes on with what it had.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_lock(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    target: *const smr_rect,
) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { lock(tracker, frame, target) })
}

unsafe fn lock(tracker: *mut smr_tracker, frame: *const smr_frame, target: *const smr_rect) -> Result<(), smr_status> {
    // SAFETY: as the caller of `smr_lock` says, of each.
    let (tracker, frame, target) = unsafe { (borrow(tracker)?, frame_for(tracker, frame)?, pointer::read(target)?) };
    Ok(tracker.lock(&frame, target.into())?)
}

/// Looks for the target in the next frame.
///
/// Of the frame only the pixels in #smr_window are read; the rest need not be in memory.
/// Cost: at most (offsets in the window) x (pixels of the template) comparisons and about an eighth of it more; far fewer
/// where the target is seen clearly. In the frame in which a tracked target begins to leave the picture, at most twice that.
/// #smr_begin, #smr_step and #smr_finish do the same in parts.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param frame    The frame, or a part of it that covers #smr_window.
/// @param answer   Is set to the answer; left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
///                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_LOCKED,
///                 #SMR_ERROR_FRAME_SIZE_CHANGED or #SMR_ERROR_WINDOW_NOT_IN_MEMORY. After an error the tracker is as it
///                 was before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_update(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    answer: *mut smr_answer,
) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { update(tracker, frame, answer) })
}

unsafe fn update(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    answer: *mut smr_answer,
) -> Result<(), smr_status> {
    // SAFETY: as the caller of `smr_update` says, of each.
    let (tracker, frame, out) = unsafe { (borrow(tracker)?, frame_for(tracker, frame)?, Out::new(answer)?) };
    out.write(tracker.update(&frame)?.into());
    Ok(())
}

/// Begins an update that is made in steps of a bounded amount of work, for those who have a deadline. The answer is that of
/// #smr_update, however it is cut. An update that was begun before, and not finished, is forgotten.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param frame    The frame, or a part of it that covers #smr_window. Its pixels must stay as they are until #smr_finish.
/// @return         As #smr_update.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_begin(tracker: *mut smr_tracker, frame: *const smr_frame) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { begin(tracker, frame) })
}

unsafe fn begin(tracker: *mut smr_tracker, frame: *const smr_frame) -> Result<(), smr_status> {
    // SAFETY: as the caller of `smr_begin` says, of each.
    let (tracker, frame) = unsafe { (borrow(tracker)?, frame_for(tracker, frame)?) };
    tracker.begin(&frame)?;
    Ok(())
}

/// Goes on with the update that #smr_begin has begun.
///
/// @param tracker  As for #smr_begin.
/// @param frame    The same frame, with the same pixels.
/// @param work     Comparisons of bytes to be made; a few more are, to come to a stop: at most the template's pixels or
///                 twice the pixels of a row of #smr_window, whichever is more, and seven for each of #SMR_SPAN offsets.
///                 0 is taken for 1.
/// @param done     Is set to 1 if nothing is left to do but #smr_finish, else to 0; left alone after an error.
/// @return         As #smr_update, or #SMR_ERROR_NOT_BEGUN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_step(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    work: u32,
    done: *mut u8,
) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { step(tracker, frame, work, done) })
}

unsafe fn step(tracker: *mut smr_tracker, frame: *const smr_frame, work: u32, done: *mut u8) -> Result<(), smr_status> {
    // SAFETY: as the caller of `smr_step` says, of each.
    let (tracker, frame, out) = unsafe { (borrow(tracker)?, frame_for(tracker, frame)?, Out::new(done)?) };
    out.write(tracker.resume(&frame)?.step(work).into());
    Ok(())
}

/// Does what is left of the update that #smr_begin has begun, and gives its answer.
///
/// @param tracker  As for #smr_begin.
/// @param frame    The same frame, with the same pixels.
/// @param answer   Is set to the answer; left alone after an error.
/// @return         As #smr_update, or #SMR_ERROR_NOT_BEGUN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_finish(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    answer: *mut smr_answer,
) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { finish(tracker, frame, answer) })
}

unsafe fn finish(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    answer: *mut smr_answer,
) -> Result<(), smr_status> {
    // SAFETY: as the caller of `smr_finish` says, of each.
    let (tracker, frame, out) = unsafe { (borrow(tracker)?, frame_for(tracker, frame)?, Out::new(answer)?) };
    out.write(tracker.resume(&frame)?.finish().into());
    Ok(())
}

/// The pixels of the frame that the next #smr_update may read. Firmware may read out just these.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param window   Is set to the rectangle, always inside the frame; left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_window(tracker: *const smr_tracker, window: *mut smr_rect) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for an smr_rect.
    status_of(unsafe { ask(tracker, window, |tracker| tracker.window().map(smr_rect::from)) })
}

/// The template: the target's last believed appearance.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param image    Is set to the pixels, in the tracker's storage: they are good until the next call of #smr_lock or
///                 #smr_update on this tracker, and may only be read. Left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_template(tracker: *const smr_tracker, image: *mut smr_image) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for an smr_image.
    status_of(unsafe {
        ask(tracker, image, |tracker| {
            let (width, height) = tracker.template().map(|template| (template.width(), template.height()))?;
            let pixels = tracker.template()?.row(0).as_ptr();
            Some(smr_image { pixels, width, height })
        })
    })
}

/// alpha of the next #smr_update.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param alpha    Is set to alpha in gray levels, rounded up (0..256); left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_alpha(tracker: *const smr_tracker, alpha: *mut u16) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for a uint16_t.
    status_of(unsafe { ask(tracker, alpha, |tracker| tracker.window().map(|_| tracker.alpha())) })
}

/// Writes what `question` answers; no answer means that there is no target yet.
///
/// # Safety
/// As for [`borrow`]; an `out` that is not NULL has memory for a `T`.
unsafe fn ask<T>(
    tracker: *const smr_tracker,
    out: *mut T,
    question: impl FnOnce(&Tracker<PIXELS, SPAN>) -> Option<T>,
) -> Result<(), smr_status> {
    // SAFETY: as the caller says, of both. The tracker is not written through this borrow.
    let (tracker, out) = unsafe { (borrow(tracker.cast_mut())?, Out::new(out)?) };
    out.write(question(tracker).ok_or(smr_status::SMR_ERROR_NOT_LOCKED)?);
    Ok(())
}

/// The tracker that `smr_init` has put there.
///
/// # Safety
/// A `tracker` that is not NULL points to memory of the size of one, and nobody else uses it as long as the result lives.
unsafe fn borrow<'a>(tracker: *mut smr_tracker) -> Result<&'a mut Tracker<PIXELS, SPAN>, smr_status> {
    pointer::check(tracker)?;
    // SAFETY: neither NULL nor misaligned, and there is memory. Only the mark is read, and every usize is one.
    let mark = unsafe { addr_of!((*tracker).mark).read() };
    if mark != mark_of(tracker) {
        return Err(smr_status::SMR_ERROR_NOT_INITIALISED);
    }
    // SAFETY: the mark says that `init` has written a whole tracker here, and the caller that it is used alone.
    Ok(unsafe { &mut (*tracker).tracker })
}

/// The frame of a call on `tracker`, which is to be borrowed for writing: the two must not share memory.
///
/// # Safety
/// A `frame` that is not NULL points to an `smr_frame`, and its pixels can be read as long as the result lives.
unsafe fn frame_for<'a>(tracker: *const smr_tracker, frame: *const smr_frame) -> Result<Frame<'a>, smr_status> {
    // SAFETY: as the caller says, of the frame and of its pixels.
    unsafe { pointer::read(frame)?.frame(tracker.addr(), STORAGE_SIZE) }
}
