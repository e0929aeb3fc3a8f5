//! Locks on a target, at once and in steps.

use crate::frame::{smr_frame, smr_rect};
use crate::pointer;
use crate::status::{SMR_ERROR_BOX_EMPTY, SMR_ERROR_BOX_OUTSIDE_FRAME, smr_status, status_of};
use crate::tracker::{ask, smr_tracker, whole, with_frame};
use smr_core::Rect;

/// The pixels of a frame that #smr_lock reads for a target. Firmware need not read out more.
///
/// @param tracker  Made by #smr_init.
/// @param width    Width of the frame.
/// @param height   Height of the frame.
/// @param bbox     The box, completely inside the frame.
/// @param window   Is set to a rectangle, always inside the frame. The paper's tracker: the box. The robust tracker: the box and its
///                 surroundings. Unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_BOX_EMPTY or
///                 #SMR_ERROR_BOX_OUTSIDE_FRAME.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_lock_window(
    tracker: *const smr_tracker,
    width: u16,
    height: u16,
    bbox: *const smr_rect,
    window: *mut smr_rect,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        ask(tracker, window, |tracker| {
            let bbox = Rect::from(pointer::read(bbox)?);
            let window = tracker.lock_window(Rect::new(0, 0, width, height), bbox);
            match (bbox.is_empty(), window.is_empty()) {
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
/// as much as 11 to 16 updates. #smr_lock_step does the same in steps.
///
/// @param tracker  Made by #smr_init.
/// @param frame    The frame. Its parts in memory cover #smr_lock_window.
/// @param bbox     The box, completely inside the frame; for the paper's tracker at most #SMR_PIXELS pixels.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, an error of the frame
///                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME) or of the box (#SMR_ERROR_BOX_EMPTY to
///                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY). After an error the tracker keeps its previous target.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_lock(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    bbox: *const smr_rect,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| {
            let bbox = pointer::read(bbox)?.into();
            tracker.cancel();
            whole(|| tracker.lock_step(frame, &bbox, u32::MAX))
        })
    })
}

/// Locks in steps of bounded work, for programs with a deadline: begins the lock, or goes on with it if `bbox` and the
/// size of the frame are those of the last step. Call it until it returns another status than #SMR_UNDER_WAY; there is
/// no target until then. Units of work: see #smr_update_step; a lock takes at most 50.6 million. The paper's tracker does
/// all work in one step.
///
/// @param tracker  Made by #smr_init.
/// @param frame    As for #smr_lock. Its pixels are the same in every step.
/// @param bbox     As for #smr_lock.
/// @param work     Units of work to do; 0 means 1.
/// @return         #SMR_UNDER_WAY, or as #smr_lock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_lock_step(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    bbox: *const smr_rect,
    work: u32,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| tracker.lock_step(frame, &pointer::read(bbox)?.into(), work))
    })
}
