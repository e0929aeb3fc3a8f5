//! Updates: follows the target from frame to frame, at once and in steps.

use crate::answer::smr_answer;
use crate::frame::{smr_frame, smr_rect};
use crate::pointer::Out;
use crate::status::{SMR_ERROR_NOT_LOCKED, smr_status, status_of};
use crate::tracker::{Event, Known, ask, borrow, each, smr_tracker, whole, with_frame};
use smr_core::Target;

/// Finds the target in the next frame.
///
/// It reads only the pixels in #smr_windows; the rest of the frame need not be in memory.
///
/// Cost of the paper's tracker, for boxes of at least 8x8 pixels and windows of at least +-4: at most 1.25 * (offsets
/// in the window) * (pixels of the template) comparisons, and far fewer if the target is clearly visible. In the frame
/// in which a tracked target begins to leave the picture it is at most twice that. Cost of the robust tracker: about
/// the same in every frame, at most 894 products for each of at most 2000 weights. #smr_update_step
/// does the same in steps.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param frame    The frame. Its parts in memory cover #smr_windows.
/// @param answer   Is set to the answer; unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, an error of the frame
///                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_LOCKED, #SMR_ERROR_FRAME_SIZE_CHANGED or
///                 #SMR_ERROR_WINDOW_NOT_IN_MEMORY. After an error the tracker is unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_update(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    answer: *mut smr_answer,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| {
            let out = Out::new(answer)?;
            tracker.cancel();
            whole(|| tracker.update_step(frame, u32::MAX, &out))
        })
    })
}

/// Updates in steps of bounded work, for programs with a deadline: begins an update, or goes on with the one under way.
/// Call it until it returns another status than #SMR_UNDER_WAY. The answer is that of #smr_update, whatever the size of
/// the steps. Every other call that may change the tracker ends the update, and so does another tracker that uses the
/// workspace; the next step then begins a new one.
///
/// The unit of work depends on the tracker:
/// - The paper's: a comparison of two bytes. A step may exceed `work` by at most max(pixels of the template, 2 * pixels
///   of a row of the first of #smr_windows) + 7 * #SMR_SPAN.
/// - The robust one: about an instruction of a Cortex-M4. An update takes at most 6.5 million units. A step may exceed
///   `work` by at most 128,000.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param frame    As for #smr_update. Its pixels are the same in every step.
/// @param work     Units of work to do; 0 means 1.
/// @param answer   Is set to the answer; unchanged unless the status is #SMR_OK.
/// @return         #SMR_UNDER_WAY, or as #smr_update.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_update_step(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    work: u32,
    answer: *mut smr_answer,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| tracker.update_step(frame, work, &Out::new(answer)?))
    })
}

/// The pixels of the frame that the next #smr_update may read. Firmware need not read out more.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param windows  Are set to two rectangles, both inside the frame. The first is never empty. In the second the robust tracker searches
///                 for a lost target: in most frames, and always for the paper's tracker, its width and height are 0. Unchanged after an
///                 error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
/// cbindgen:ptrs-as-arrays=[[windows; 2]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_windows(tracker: *const smr_tracker, windows: *mut smr_rect) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        ask(tracker, windows.cast::<[smr_rect; 2]>(), |tracker| {
            let window = tracker.window().ok_or(SMR_ERROR_NOT_LOCKED)?;
            Ok([window, tracker.sweep_window().unwrap_or_default()].map(Into::into))
        })
    })
}

/// Tells the tracker that the picture has moved since the last frame because the camera turned: what was at (x, y) is
/// expected at (x + right, y + down). It cancels an update under way.
///
/// The search window moves along. The box stays within reach of the frame. The
/// paper's tracker rounds to whole pixels. Before the first lock the call does nothing.
///
/// @param tracker  Made by #smr_init.
/// @param right    In units of 1/256 pixel.
/// @param down     In units of 1/256 pixel.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_moved(tracker: *mut smr_tracker, right: i32, down: i32) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe { borrow(tracker) }.map(|tracker| {
        tracker.cancel();
        each!(tracker.known(), target => target.moved(right, down));
        tracker.tell(&Event::Moved(right, down));
    }))
}
