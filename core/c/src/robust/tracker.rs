//! The robust tracker in storage of the caller: making it, and every call on it.

use super::capacity::{PIXELS, ROBUST_STORAGE_SIZE, WINDOW};
use super::types::{smr_robust_answer, smr_robust_config};
use crate::pointer::{self, Out};
use crate::status::{smr_status, status_of};
use crate::types::{smr_frame, smr_image, smr_rect};
use core::ffi::c_void;
use core::ptr::{self, addr_of};
use smr_core::robust::Tracker;
use smr_core::{Frame, Image};

/// Follows one target whose size, light and view may change. Lives in storage that the caller gives to #smr_robust_init;
/// needs no clean-up.
///
/// Several targets are several trackers. Calls on one tracker must not overlap in time; calls on different ones may.
pub struct smr_robust_tracker {
    /// [`mark_of`] its own address, so that other memory is not taken for a tracker.
    mark: usize,
    tracker: Tracker<PIXELS, WINDOW>,
}

/// What a tracker at `address` is marked with. Never 0, whatever the alignment; and not the paper's tracker's.
fn mark_of(address: *const smr_robust_tracker) -> usize {
    address.addr() ^ 0x534D_5233 // "SMR3"
}

/// The size that storage must have, in bytes: #SMR_ROBUST_TRACKER_SIZE.
///
/// @return  Bytes.
#[unsafe(no_mangle)]
pub extern "C" fn smr_robust_tracker_size() -> usize {
    ROBUST_STORAGE_SIZE
}

/// Makes a robust tracker without a target.
///
/// @param storage  Memory for the tracker, such as an #smr_robust_storage; aligned to #SMR_ROBUST_TRACKER_ALIGN. It must
///                 stay where it is, untouched, as long as the tracker is used; then it may be used for anything.
/// @param size     Bytes at `storage`; at least #smr_robust_tracker_size.
/// @param config   Is copied.
/// @param tracker  Is set to the tracker, or to NULL if there is none.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_STORAGE_TOO_SMALL,
///                 #SMR_ERROR_ZERO_DENOMINATOR or #SMR_ERROR_NOTHING_COUNTS (`k`, where it has a meaning).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_init(
    storage: *mut c_void,
    size: usize,
    config: *const smr_robust_config,
    tracker: *mut *mut smr_robust_tracker,
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
/// `storage` has `size` bytes for the tracker alone; `config` points to a configuration.
unsafe fn init(
    storage: *mut smr_robust_tracker,
    size: usize,
    config: *const smr_robust_config,
) -> Result<*mut smr_robust_tracker, smr_status> {
    // SAFETY: not written to before `size` is checked.
    let out = unsafe { Out::new(storage)? };
    if size < ROBUST_STORAGE_SIZE {
        return Err(smr_status::SMR_ERROR_STORAGE_TOO_SMALL);
    }
    // SAFETY: as the caller says.
    let config = unsafe { pointer::read(config)?.config()? };
    out.write(smr_robust_tracker { mark: mark_of(storage), tracker: Tracker::new(config) });
    Ok(storage)
}

/// Starts on the target in a box, at any time; whatever was followed before is forgotten. Only the pixels of the box and one
/// more on each side are read. Takes about 8 KB of stack.
///
/// @param tracker  Made by #smr_robust_init.
/// @param frame    The frame, or a part of it that covers the box and, as far as the frame goes, the pixels next to it.
/// @param target   The box, wholly inside the frame, of any size.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
///                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_BOX_EMPTY,
///                 #SMR_ERROR_BOX_OUTSIDE_FRAME or #SMR_ERROR_BOX_NOT_IN_MEMORY. After an error the tracker goes on with
///                 what it had.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_lock(
    tracker: *mut smr_robust_tracker,
    frame: *const smr_frame,
    target: *const smr_rect,
) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { lock(tracker, frame, target) })
}

unsafe fn lock(
    tracker: *mut smr_robust_tracker,
    frame: *const smr_frame,
    target: *const smr_rect,
) -> Result<(), smr_status> {
    // SAFETY: as the caller of `smr_robust_lock` says, of each.
    let (tracker, frame, target) = unsafe { (borrow(tracker)?, frame_for(tracker, frame)?, pointer::read(target)?) };
    Ok(tracker.lock(&frame, target.into())?)
}

/// Looks for the target in the next frame. Takes about 8 KB of stack.
///
/// Of the frame only the pixels in #smr_robust_window are read; the rest need not be in memory.
/// Cost: two searches of 65x65 offsets over the template's pixels, of which the most are left out where the target is seen
/// clearly, and at most 156,800 comparisons for the cells; while the target is lost or doubtful, one product more for each
/// offset and each of a quarter of the template's pixels.
///
/// @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
/// @param frame    The frame, or a part of it that covers #smr_robust_window.
/// @param answer   Is set to the answer; left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
///                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_LOCKED,
///                 #SMR_ERROR_FRAME_SIZE_CHANGED or #SMR_ERROR_WINDOW_NOT_IN_MEMORY. After an error the tracker is as it
///                 was before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_update(
    tracker: *mut smr_robust_tracker,
    frame: *const smr_frame,
    answer: *mut smr_robust_answer,
) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { update(tracker, frame, answer) })
}

unsafe fn update(
    tracker: *mut smr_robust_tracker,
    frame: *const smr_frame,
    answer: *mut smr_robust_answer,
) -> Result<(), smr_status> {
    // SAFETY: as the caller of `smr_robust_update` says, of each.
    let (tracker, frame, out) = unsafe { (borrow(tracker)?, frame_for(tracker, frame)?, Out::new(answer)?) };
    out.write(tracker.update(&frame)?.into());
    Ok(())
}

/// The pixels of the frame that the next #smr_robust_update may read. Firmware may read out just these.
///
/// @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
/// @param window   Is set to the rectangle, always inside the frame; left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_window(tracker: *const smr_robust_tracker, window: *mut smr_rect) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for an smr_rect.
    status_of(unsafe { ask(tracker, window, |tracker| tracker.window().map(smr_rect::from)) })
}

/// The last patch on the grid.
///
/// @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
/// @param image    Is set to the pixels, in the tracker's storage: they are good until the next call of #smr_robust_lock
///                 or #smr_robust_update on this tracker, and may only be read. Left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_template(tracker: *const smr_robust_tracker, image: *mut smr_image) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for an smr_image.
    status_of(unsafe { ask(tracker, image, |tracker| tracker.template().map(pixels_of)) })
}

/// The running mean of the patches, which is compared beside the last one.
///
/// @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
/// @param image    As for #smr_robust_template.
/// @return         As #smr_robust_template.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_slow_template(
    tracker: *const smr_robust_tracker,
    image: *mut smr_image,
) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for an smr_image.
    status_of(unsafe { ask(tracker, image, |tracker| tracker.slow_template().map(pixels_of)) })
}

/// The early template, by which the track is verified.
///
/// @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
/// @param image    As for #smr_robust_template.
/// @return         As #smr_robust_template.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_early_template(
    tracker: *const smr_robust_tracker,
    image: *mut smr_image,
) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for an smr_image.
    status_of(unsafe { ask(tracker, image, |tracker| tracker.early_template().map(pixels_of)) })
}

/// alpha of the next #smr_robust_update.
///
/// @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
/// @param alpha    Is set to alpha in gray levels, rounded up (0..256); left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_alpha(tracker: *const smr_robust_tracker, alpha: *mut u16) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for a uint16_t.
    status_of(unsafe { ask(tracker, alpha, |tracker| tracker.grid().map(|_| tracker.alpha())) })
}

/// A template's, which is stored without gaps.
fn pixels_of(template: Image<'_>) -> smr_image {
    smr_image { pixels: template.row(0).as_ptr(), width: template.width(), height: template.height() }
}

/// Writes what `question` answers; no answer means that there is no target yet.
///
/// # Safety
/// As for [`borrow`]; an `out` that is not NULL has memory for a `T`.
unsafe fn ask<T>(
    tracker: *const smr_robust_tracker,
    out: *mut T,
    question: impl FnOnce(&Tracker<PIXELS, WINDOW>) -> Option<T>,
) -> Result<(), smr_status> {
    // SAFETY: as the caller says, of both. The tracker is not written through this borrow.
    let (tracker, out) = unsafe { (borrow(tracker.cast_mut())?, Out::new(out)?) };
    out.write(question(tracker).ok_or(smr_status::SMR_ERROR_NOT_LOCKED)?);
    Ok(())
}

/// The tracker that `smr_robust_init` has put there.
///
/// # Safety
/// A `tracker` that is not NULL points to memory of the size of one, and nobody else uses it as long as the result lives.
unsafe fn borrow<'a>(tracker: *mut smr_robust_tracker) -> Result<&'a mut Tracker<PIXELS, WINDOW>, smr_status> {
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
unsafe fn frame_for<'a>(tracker: *const smr_robust_tracker, frame: *const smr_frame) -> Result<Frame<'a>, smr_status> {
    // SAFETY: as the caller says, of the frame and of its pixels.
    unsafe { pointer::read(frame)?.frame(tracker.addr(), ROBUST_STORAGE_SIZE) }
}
