//! The robust tracker in storage of the caller: making it, and every call on it.

use super::capacity::ROBUST_STORAGE_SIZE;
use super::types::{smr_robust_answer, smr_robust_config};
use crate::pointer::{self, Out};
use crate::status::{smr_status, status_of};
use crate::types::{smr_frame, smr_image, smr_rect};
use core::ffi::c_void;
use core::ptr::{self, addr_of};
use smr_core::robust::{Config, Tracker};
use smr_core::{Frame, Rect};

/// Follows one target whose size, light and view may change. Lives in storage that the caller gives to #smr_robust_init;
/// needs no clean-up.
///
/// Several targets are several trackers. Calls on one tracker must not overlap in time; calls on different ones may.
pub struct smr_robust_tracker {
    /// [`mark_of`] its own address, so that other memory is not taken for a tracker.
    mark: usize,
    tracker: Tracker,
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
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_STORAGE_TOO_SMALL.
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
    let config = unsafe { pointer::read(config)?.config() };
    if cfg!(debug_assertions) {
        // Copied, as a build that is not optimised would make it on the stack, several times over.
        static EMPTY: Tracker = Tracker::new(Config::robust());
        // SAFETY: `Out` says that there is memory for both fields. The copy is a tracker as good as the original, which is
        // never dropped.
        let tracker = unsafe {
            (&raw mut (*storage).mark).write(mark_of(storage));
            (&raw mut (*storage).tracker).copy_from_nonoverlapping(&raw const EMPTY, 1);
            &mut (*storage).tracker
        };
        tracker.configure(config);
    } else {
        out.write(smr_robust_tracker { mark: mark_of(storage), tracker: Tracker::new(config) });
    }
    Ok(storage)
}

/// The pixels of a frame that #smr_robust_lock reads for a target. Firmware may read out just these.
///
/// @param full_width   Width of the full frame.
/// @param full_height  Height of the full frame.
/// @param target       The box, wholly inside the frame, of any size.
/// @param window       Is set to the rectangle, always inside the frame; left alone after an error.
/// @return             #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_BOX_EMPTY or #SMR_ERROR_BOX_OUTSIDE_FRAME.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_lock_window(
    full_width: u16,
    full_height: u16,
    target: *const smr_rect,
    window: *mut smr_rect,
) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { lock_window(Rect::new(0, 0, full_width, full_height), target, window) })
}

unsafe fn lock_window(bounds: Rect, target: *const smr_rect, window: *mut smr_rect) -> Result<(), smr_status> {
    // SAFETY: as the caller of `smr_robust_lock_window` says, of each.
    let (target, out) = unsafe { (Rect::from(pointer::read(target)?), Out::new(window)?) };
    if target.is_empty() {
        return Err(smr_status::SMR_ERROR_BOX_EMPTY);
    }
    if !bounds.contains(target) {
        return Err(smr_status::SMR_ERROR_BOX_OUTSIDE_FRAME);
    }
    out.write(Tracker::lock_window(bounds, target).into());
    Ok(())
}

/// Starts on the target in a box, at any time; whatever was followed before is forgotten.
///
/// Of the frame only the pixels in #smr_robust_lock_window are read: the target and its surroundings.
/// Cost: about that of five calls of #smr_robust_update.
///
/// @param tracker  Made by #smr_robust_init.
/// @param frame    The frame, or a part of it that covers #smr_robust_lock_window.
/// @param target   The box, wholly inside the frame, of any size.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
///                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_BOX_EMPTY,
///                 #SMR_ERROR_BOX_OUTSIDE_FRAME or #SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY. After an error the tracker goes on
///                 with what it had.
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

/// Looks for the target in the next frame.
///
/// Of the frame only the pixels in #smr_robust_window are read; the rest need not be in memory.
/// Cost, for a filter of W weights (at most 2000) and a template of P pixels (at most #SMR_ROBUST_PIXELS): 307 W products to
/// look for the target and its size; then, to learn, up to 2028 W products, or, while it is lost, 289 W products to look
/// elsewhere; and 9 P comparisons for each look.
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

/// The pixels of the frame that the next #smr_robust_update may read. Firmware may read out just these. While the target is
/// uncertain or lost, the place where it is looked for next is in it, too.
///
/// @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
/// @param window   Is set to the rectangle, always inside the frame; left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_window(tracker: *const smr_robust_tracker, window: *mut smr_rect) -> smr_status {
    // SAFETY: as the header asks of the caller, who gives memory for an smr_rect.
    status_of(unsafe { ask(tracker, window, |tracker| tracker.window().map(smr_rect::from)) })
}

/// The early template, by which the track is verified.
///
/// @param tracker  Made by #smr_robust_init, locked by #smr_robust_lock.
/// @param pixels   Memory for its pixels, outside of the tracker's storage: they are copied there, row by row, without gaps.
/// @param size     Bytes at `pixels`; #SMR_ROBUST_PIXELS are always enough.
/// @param image    Is set to the pixels and their shape. After an error it is left alone, and so are the pixels.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_NOT_LOCKED or
///                 #SMR_ERROR_BUFFER_TOO_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_robust_early_template(
    tracker: *const smr_robust_tracker,
    pixels: *mut u8,
    size: usize,
    image: *mut smr_image,
) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { early_template(tracker, pixels, size, image) })
}

unsafe fn early_template(
    tracker: *const smr_robust_tracker,
    pixels: *mut u8,
    size: usize,
    image: *mut smr_image,
) -> Result<(), smr_status> {
    pointer::check(pixels)?;
    // SAFETY: as the caller of `smr_robust_early_template` says, of both. The tracker is not written through this borrow.
    let (tracker, out) = unsafe { (borrow(tracker.cast_mut())?, Out::new(image)?) };
    let (Some(grid), Some(template)) = (tracker.grid(), tracker.early_template()) else {
        return Err(smr_status::SMR_ERROR_NOT_LOCKED);
    };
    if size < template.len() {
        return Err(smr_status::SMR_ERROR_BUFFER_TOO_SMALL);
    }
    for (at, pixel) in template.enumerate() {
        // SAFETY: the caller says that there is memory for `size` pixels, which are not fewer.
        unsafe { pixels.add(at).write(pixel) }
    }
    out.write(smr_image { pixels, width: grid.columns, height: grid.rows });
    Ok(())
}

/// Writes what `question` answers; no answer means that there is no target yet.
///
/// # Safety
/// As for [`borrow`]; an `out` that is not NULL has memory for a `T`.
unsafe fn ask<T>(
    tracker: *const smr_robust_tracker,
    out: *mut T,
    question: impl FnOnce(&Tracker) -> Option<T>,
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
unsafe fn borrow<'a>(tracker: *mut smr_robust_tracker) -> Result<&'a mut Tracker, smr_status> {
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
