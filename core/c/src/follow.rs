//! The calls that construct a tracker, lock it and update it, at once or in steps of bounded work.

use crate::answer::smr_answer;
use crate::capacity::ALIGNMENT;
use crate::config::smr_config;
use crate::frame::{smr_frame, smr_rect};
use crate::pointer::{self, Out};
use crate::setting::deref;
use crate::status::{
    SMR_ERROR_BOX_EMPTY, SMR_ERROR_BOX_OUTSIDE_FRAME, SMR_ERROR_MISALIGNED, SMR_ERROR_NOT_LOCKED,
    SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE, SMR_ERROR_STORAGE_TOO_SMALL, SMR_ERROR_WORKSPACE_TOO_SMALL, smr_status,
    status_of,
};
use crate::tracker::{Call, Event, Known, borrow, each, smr_tracker, with_frame, write_result};
use core::ffi::c_void;
use core::ptr;
use smr_core::{Rect, Target};

/// Bytes of a tracker's storage: the value that #SMR_PAPER_TARGET_SIZE or #SMR_ROBUST_TARGET_SIZE had when the library
/// was built.
///
/// @param config  Filled by one of the calls smr_config_...
/// @return        Bytes; 0 if `config` is NULL or not filled. Can differ from the macro: see #SMR_PIXELS.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_target_size(config: *const smr_config) -> usize {
    // SAFETY: by the header, `config` points to an `smr_config` with a preset's method or none, if it passes
    // `pointer::check`.
    unsafe { deref(config) }.map_or(0, |(_, method)| method.target_size)
}

/// Bytes of a tracker's workspace: the value that #SMR_PAPER_WORKSPACE_SIZE or #SMR_ROBUST_WORKSPACE_SIZE had when the
/// library was built.
///
/// @param config  Filled by one of the calls smr_config_...
/// @return        As #smr_target_size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_workspace_size(config: *const smr_config) -> usize {
    // SAFETY: by the header, `config` points to an `smr_config` with a preset's method or none, if it passes
    // `pointer::check`.
    unsafe { deref(config) }.map_or(0, |(_, method)| method.workspace_size)
}

/// Constructs a tracker in the caller's memory. It has no target before #smr_lock.
///
/// @param storage         Memory of the tracker, such as an #smr_paper_target or an #smr_robust_target, aligned to
///                        #SMR_ALIGNMENT. It must stay where it is, untouched, as long as the tracker is used.
/// @param storage_size    Bytes at `storage`; at least #smr_target_size.
/// @param workspace       Scratch memory for updates, such as an #smr_paper_workspace or an #smr_robust_workspace. It
///                        must be aligned and stay as `storage` must, but trackers of the same kind may share it.
///                        #smr_init cancels an update that another tracker has begun in it.
/// @param workspace_size  Bytes at `workspace`; at least #smr_workspace_size.
/// @param config          The choice of a tracker and its settings. It is copied.
/// @param tracker         Is set to the tracker, or to NULL after an error.
/// @return                #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_STORAGE_TOO_SMALL,
///                        #SMR_ERROR_WORKSPACE_TOO_SMALL, #SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE,
///                        #SMR_ERROR_NOT_INITIALISED (the configuration) or an error of a setting
///                        (#SMR_ERROR_CONFIG_OUT_OF_RANGE, #SMR_ERROR_LIMIT_BELOW_WINDOW,
///                        #SMR_ERROR_UNCERTAIN_BELOW_LOST or #SMR_ERROR_REFINER_NOT_BUILT_IN).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_init(
    storage: *mut c_void,
    storage_size: usize,
    workspace: *mut c_void,
    workspace_size: usize,
    config: *const smr_config,
    tracker: *mut *mut smr_tracker,
) -> smr_status {
    // SAFETY: by the header, `tracker` points to memory for a pointer, if it passes `pointer::check`.
    let out = match unsafe { Out::new(tracker) } {
        Ok(out) => out,
        Err(status) => return status,
    };
    // SAFETY: by the header, `storage` and `workspace` have as many bytes as stated, which only trackers use from now
    // on, and `config` is an `smr_config` with a preset's method or none.
    let made = unsafe { init(storage, storage_size, workspace, workspace_size, config) };
    out.write(if made.is_ok() { storage.cast() } else { ptr::null_mut() });
    status_of(made)
}

/// # Safety
/// `storage_size` bytes at `storage` and `workspace_size` bytes at `workspace` can be written. As long as the tracker is
/// used, only its calls use the former, and only calls on trackers that share it the latter. A `config` that passes `pointer::check` points to an `smr_config`, whose
/// method is NULL or from a preset.
unsafe fn init(
    storage: *mut c_void,
    storage_size: usize,
    workspace: *mut c_void,
    workspace_size: usize,
    config: *const smr_config,
) -> Result<(), smr_status> {
    pointer::check(storage)?;
    pointer::check(workspace)?;
    if !storage.addr().is_multiple_of(ALIGNMENT) || !workspace.addr().is_multiple_of(ALIGNMENT) {
        return Err(SMR_ERROR_MISALIGNED);
    }
    // SAFETY: `config` points to an `smr_config` with a preset's method or none, if it passes `pointer::check`.
    let (config, method) = unsafe { deref(config)? };
    if storage_size < method.target_size {
        return Err(SMR_ERROR_STORAGE_TOO_SMALL);
    }
    if workspace_size < method.workspace_size {
        return Err(SMR_ERROR_WORKSPACE_TOO_SMALL);
    }
    let [storage_range, workspace_range] =
        [pointer::range(storage, method.target_size), pointer::range(workspace, method.workspace_size)];
    if pointer::overlap(&storage_range, &workspace_range) {
        return Err(SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE);
    }
    // SAFETY: `storage` and `workspace` are aligned, apart, and have as many bytes as the method needs, which only
    // trackers use from now on.
    unsafe { (method.make)(storage, workspace, config) }
}

/// Computes the window that #smr_lock reads for a given box. Firmware need not read out the frame's other pixels.
///
/// @param tracker  Made by #smr_init.
/// @param width    Width of the frame in pixels.
/// @param height   Height of the frame in pixels.
/// @param bbox     The box, completely inside the frame.
/// @param window   Is set to a rectangle inside the frame. The paper tracker: the box. The robust tracker: the box
///                 and its surroundings. Unchanged after an error.
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
    // SAFETY: by the header, nobody else uses `tracker` during the call, `bbox` points to a rectangle, and `window` to
    // memory for one.
    status_of(unsafe {
        write_result(tracker, window, |tracker| {
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

/// The argument of a call that may take several steps.
enum Argument {
    Box(*const smr_rect),
    Answer(*mut smr_answer),
}

/// Locks or updates for about `work` units; `None`: begins in any case, and does all of the work.
///
/// # Safety
/// Each pointer that passes `pointer::check` points to memory of its type: `tracker` to a handle whose tracker nobody
/// else uses during the call, `frame` to a frame whose pixels can be read and stay unchanged during the call,
/// `argument` to a box or to memory for an answer.
#[inline(never)] // one copy in flash
unsafe fn follow(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    argument: Argument,
    work: Option<u32>,
) -> smr_status {
    // SAFETY: nobody else uses the tracker during the call. The pixels of `frame` can be read. `argument` points to a
    // box or to memory for an answer.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| {
            let call = match argument {
                Argument::Box(bbox) => Call::Lock(pointer::read(bbox)?.into()),
                Argument::Answer(answer) => Call::Update(Out::new(answer)?),
            };
            tracker.begin(frame, &call, work)?;
            tracker.step(frame, &call, work)
        })
    })
}

/// Starts to follow the target in a box, and forgets any previous target. Reads only the pixels in #smr_lock_window.
///
/// Cost: a copy of the box and two comparisons per pixel (paper tracker), or two to three updates (robust tracker).
///
/// @param tracker  Made by #smr_init.
/// @param frame    The frame. Its parts in memory cover #smr_lock_window.
/// @param bbox     The box, completely inside the frame; for the paper tracker at most #SMR_PIXELS pixels.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, an error of the frame
///                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME) or of the box (#SMR_ERROR_BOX_EMPTY to
///                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_lock(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    bbox: *const smr_rect,
) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, the pixels of `frame` can be read, and `bbox`
    // points to a rectangle.
    unsafe { follow(tracker, frame, Argument::Box(bbox), None) }
}

/// Does one bounded step of a lock, for programs with a deadline. Begins a lock, or continues the one under way if
/// `bbox` and the frame's size are unchanged. Call it again while it returns #SMR_UNDER_WAY; the tracker has no target
/// before the last step. A lock takes at most 11.2 million units of work (see #smr_update_step). The paper tracker
/// locks in one step.
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
    // SAFETY: by the header, nobody else uses `tracker` during the call, the pixels of `frame` can be read, and `bbox`
    // points to a rectangle.
    unsafe { follow(tracker, frame, Argument::Box(bbox), Some(work)) }
}

/// Finds the target in the next frame. Reads only the pixels in #smr_windows.
///
/// Cost of the paper tracker, for boxes of at least 8x8 pixels and windows of at least +-4: at most 1.25 * (offsets
/// in the window) * (pixels of the template) comparisons, twice that in the frame in which the target begins to leave,
/// and far fewer if it is clearly visible. Cost of the robust tracker: at most 726 * 2000 products.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param frame    The frame. Its parts in memory cover #smr_windows.
/// @param answer   Is set to the answer; unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, an error of the frame
///                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_LOCKED, #SMR_ERROR_FRAME_SIZE_CHANGED or
///                 #SMR_ERROR_WINDOW_NOT_IN_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_update(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    answer: *mut smr_answer,
) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, the pixels of `frame` can be read, and
    // `answer` points to memory for an answer.
    unsafe { follow(tracker, frame, Argument::Answer(answer), None) }
}

/// Does one bounded step of an update, for programs with a deadline. Begins an update, or continues the one under way.
/// Call it again while it returns #SMR_UNDER_WAY. The answer equals that of #smr_update, however small the steps. Any
/// other call that changes the tracker cancels the update; so does a lock or an update of another tracker in the same
/// workspace. A call that fails, of this or the other tracker, does not.
///
/// The unit of work depends on the tracker:
/// - The paper's: a comparison of two bytes. A step may exceed `work` by at most max(pixels of the template, 2 * pixels
///   of a row of the first of #smr_windows) + 7 * #SMR_SPAN.
/// - The robust one: about an instruction of a Cortex-M4. A step may exceed `work` by at most 128,000. An update takes
///   at most 13.8 million units (17.4 with the refiner), or 6.1 (8.1) with a `sweep` of 1.
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
    // SAFETY: by the header, nobody else uses `tracker` during the call, the pixels of `frame` can be read, and
    // `answer` points to memory for an answer.
    unsafe { follow(tracker, frame, Argument::Answer(answer), Some(work)) }
}

/// The two windows of the next frame that #smr_update may read. Firmware need not read out other pixels.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param windows  Are set to two rectangles inside the frame. The first is never empty. The second, where the robust
///                 tracker searches for a lost target, is empty in most frames. Unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
/// cbindgen:ptrs-as-arrays=[[windows; 2]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_windows(tracker: *const smr_tracker, windows: *mut smr_rect) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, and `windows` points to memory for two
    // rectangles.
    status_of(unsafe {
        write_result(tracker, windows.cast::<[smr_rect; 2]>(), |tracker| {
            let mut windows = tracker.windows().ok_or(SMR_ERROR_NOT_LOCKED)?.into_iter();
            Ok([windows.next(), windows.next()].map(|window| window.unwrap_or_default().into()))
        })
    })
}

/// Reports a turn of the camera since the last frame: what was at (x, y) is expected at (x + right, y + down). Moves
/// the box and the search window by this motion, but keeps the box in or near the frame. The paper tracker rounds the
/// motion to whole pixels. Cancels a lock or an update under way. Without a target, nothing moves.
///
/// @param tracker  Made by #smr_init.
/// @param right    Motion to the right in units of 1/256 pixel.
/// @param down     Motion downwards in units of 1/256 pixel.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_moved(tracker: *mut smr_tracker, right: i32, down: i32) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call.
    status_of(unsafe { borrow(tracker) }.map(|tracker| {
        each!(tracker.known(), target => target.moved(right, down));
        tracker.record(&Event::Moved(right, down));
    }))
}
