//! Locks on a target, at once and in steps.

use crate::frame::{smr_frame, smr_rect};
use crate::pointer;
use crate::status::{SMR_ERROR_BOX_EMPTY, SMR_ERROR_BOX_OUTSIDE_FRAME, smr_status, status_of};
use crate::tracker::{ask, smr_tracker, with_frame};
use smr_core::Rect;

/// The pixels of a frame that #smr_lock reads for a target. Firmware need not read out more.
///
/// @param tracker  Made by #smr_init.
/// @param width    Width of the frame.
/// @param height   Height of the frame.
/// @param target   The box, completely inside the frame.
/// @param window   Is set to a rectangle, always inside the frame. The paper's tracker: the box. The robust tracker: the box and its
///                 surroundings. Unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_BOX_EMPTY or
///                 #SMR_ERROR_BOX_OUTSIDE_FRAME.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_lock_window(
    tracker: *const smr_tracker,
    width: u16,
    height: u16,
    target: *const smr_rect,
    window: *mut smr_rect,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        ask(tracker, window, |tracker| {
            let target = Rect::from(pointer::read(target)?);
            let window = tracker.lock_window(Rect::new(0, 0, width, height), target);
            match (target.is_empty(), window.is_empty()) {
                (true, _) => Err(SMR_ERROR_BOX_EMPTY),
                (_, true) => Err(SMR_ERROR_BOX_OUTSIDE_FRAME),
                _ => Ok(window.into()),
            }
        })
    })
}

/// Starts following the target in a box. You can call it at any time; a previous target is forgotten. It reads only the
/// pixels in #smr_lock_window.
///
/// Cost: for the paper's tracker a copy of the box and two comparisons for each of its pixels, for the robust tracker
/// as much as 11 to 14 updates. #smr_begin_lock, #smr_step and #smr_finish_lock do the same in steps.
///
/// @param tracker  Made by #smr_init.
/// @param frame    The frame. Its parts in memory cover #smr_lock_window.
/// @param target   The box, completely inside the frame; for the paper's tracker at most #SMR_PIXELS pixels.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, an error of the frame
///                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME) or of the box (#SMR_ERROR_BOX_EMPTY to
///                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY). After an error the tracker keeps its previous target and an update that
///                 is under way.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_lock(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    target: *const smr_rect,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| {
            tracker.begin_lock(frame, pointer::read(target)?.into())?;
            tracker.finish_lock(frame)
        })
    })
}

/// Begins a lock in steps of bounded work, for programs with a deadline: call #smr_step until it is done, then
/// #smr_finish_lock. The tracker has no target until the lock is finished.
///
/// @param tracker  Made by #smr_init.
/// @param frame    As for #smr_lock. Its pixels must not change until #smr_finish_lock.
/// @param target   As for #smr_lock.
/// @return         As #smr_lock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_begin_lock(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    target: *const smr_rect,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| tracker.begin_lock(frame, pointer::read(target)?.into()))
    })
}

/// Does the rest of the lock that #smr_begin_lock has begun. After it the tracker has a target.
///
/// @param tracker  As for #smr_begin_lock.
/// @param frame    The same frame with the same pixels.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, an error of the frame
///                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_BEGUN, #SMR_ERROR_FRAME_SIZE_CHANGED or
///                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY. After an error the lock is still under way.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_finish_lock(tracker: *mut smr_tracker, frame: *const smr_frame) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe { with_frame(tracker, frame, |tracker, frame| tracker.finish_lock(frame)) })
}
