//! The tracker in storage of the caller: making it, and every call on it.

use crate::answer::{smr_answer, smr_state};
use crate::capacity::ALIGNMENT;
use crate::config::smr_config;
use crate::frame::{smr_fine_rect, smr_frame, smr_image, smr_rect};
use crate::method::{Tracked, smr_method};
use crate::pointer::{self, Out};
use crate::status::{
    SMR_ERROR_BOX_EMPTY, SMR_ERROR_BOX_OUTSIDE_FRAME, SMR_ERROR_BUFFER_TOO_SMALL, SMR_ERROR_MISALIGNED,
    SMR_ERROR_NOT_INITIALISED, SMR_ERROR_NOT_LOCKED, SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE, SMR_ERROR_STORAGE_TOO_SMALL,
    SMR_ERROR_WORKSPACE_TOO_SMALL, smr_status, status_of,
};
use core::ffi::c_void;
use core::ptr::{self, addr_of};
use smr_core::{Frame, Rect};

/// Follows one target. Lives in storage that the caller gives to #smr_init; needs no clean-up.
///
/// Several targets are several trackers. Calls on one tracker must not overlap in time, and neither must calls on trackers that
/// share a workspace; others may.
pub struct smr_tracker {
    /// [`mark_of`] its own address, so that other memory is not taken for a tracker.
    mark: usize,
    /// What lies behind it.
    held: *mut dyn Tracked,
}

impl smr_tracker {
    /// The handle of a tracker at `address`.
    pub(crate) fn new(address: *const Self, held: *mut dyn Tracked) -> Self {
        Self { mark: mark_of(address), held }
    }
}

/// What a tracker at `address` is marked with. Never 0, whatever the alignment.
fn mark_of(address: *const smr_tracker) -> usize {
    address.addr() ^ 0x534D_5231 // "SMR1"
}

/// The size that the storage of a tracker must have: #SMR_PAPER_TARGET_SIZE or #SMR_ROBUST_TARGET_SIZE of the library as it was
/// built.
///
/// @param config  Made by one of the calls smr_config_...
/// @return        Bytes; 0 if `config` is NULL or was not made so. Differs from the macro if this program defines other
///                capacities than the library was built with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_target_size(config: *const smr_config) -> usize {
    // SAFETY: as the header asks of the caller.
    unsafe { given(config) }.map_or(0, |(_, method)| method.target_size)
}

/// The size that the workspace of a tracker must have: #SMR_PAPER_WORKSPACE_SIZE or #SMR_ROBUST_WORKSPACE_SIZE of the library as
/// it was built.
///
/// @param config  Made by one of the calls smr_config_...
/// @return        As #smr_target_size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_workspace_size(config: *const smr_config) -> usize {
    // SAFETY: as the header asks of the caller.
    unsafe { given(config) }.map_or(0, |(_, method)| method.workspace_size)
}

/// Makes a tracker without a target.
///
/// @param storage         Memory for what the tracker remembers, such as an #smr_paper_target or an #smr_robust_target; aligned to
///                        #SMR_ALIGNMENT. It must stay where it is, untouched, as long as the tracker is used; then it may be used
///                        for anything.
/// @param storage_size    Bytes at `storage`; at least #smr_target_size.
/// @param workspace       Scratch memory for updates, such as an #smr_paper_workspace or an #smr_robust_workspace; aligned to
///                        #SMR_ALIGNMENT. As `storage`, but trackers of the same kind may share one: an update that another
///                        tracker has begun in it is then given up.
/// @param workspace_size  Bytes at `workspace`; at least #smr_workspace_size.
/// @param config          Says which tracker it is. Is copied, except for a table of its own: see #smr_paper_config.
/// @param tracker         Is set to the tracker, or to NULL if there is none.
/// @return                #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_STORAGE_TOO_SMALL,
///                        #SMR_ERROR_WORKSPACE_TOO_SMALL, #SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE, #SMR_ERROR_NOT_INITIALISED (the
///                        configuration, or its table) or what is wrong with the configuration (#SMR_ERROR_ZERO_DENOMINATOR to
///                        #SMR_ERROR_CONFIG_OUT_OF_RANGE).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_init(
    storage: *mut c_void,
    storage_size: usize,
    workspace: *mut c_void,
    workspace_size: usize,
    config: *const smr_config,
    tracker: *mut *mut smr_tracker,
) -> smr_status {
    // SAFETY: the caller gives memory for a pointer.
    let out = match unsafe { Out::new(tracker) } {
        Ok(out) => out,
        Err(status) => return status,
    };
    // SAFETY: as the header asks of the caller.
    let made = unsafe { init(storage, storage_size, workspace, workspace_size, config) };
    out.write(if made.is_ok() { storage.cast() } else { ptr::null_mut() });
    status_of(made)
}

/// # Safety
/// As `smr_init` asks.
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
    // SAFETY: as the caller says.
    let (config, method) = unsafe { given(config)? };
    if storage_size < method.target_size {
        return Err(SMR_ERROR_STORAGE_TOO_SMALL);
    }
    if workspace_size < method.workspace_size {
        return Err(SMR_ERROR_WORKSPACE_TOO_SMALL);
    }
    let [ours, theirs] =
        [pointer::range(storage, method.target_size), pointer::range(workspace, method.workspace_size)];
    if pointer::overlap(&ours, &theirs) {
        return Err(SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE);
    }
    // SAFETY: sizes and alignment were checked; of the table the caller says it.
    unsafe { (method.make)(storage, workspace, config) }
}

/// A configuration, and the method that it names.
///
/// # Safety
/// A `config` that passes `pointer::check` points to one that stays, and whose method is NULL or was filled in.
unsafe fn given<'a>(config: *const smr_config) -> Result<(&'a smr_config, &'static smr_method), smr_status> {
    pointer::check(config)?;
    // SAFETY: as the caller says.
    let config = unsafe { &*config };
    let method = config.method;
    // SAFETY: as the caller says. What is filled in is static.
    unsafe { method.as_ref() }.map(|method| (config, method)).ok_or(SMR_ERROR_NOT_INITIALISED)
}

/// The pixels of a frame that #smr_lock reads for a target. Firmware may read out just these.
///
/// @param tracker  Made by #smr_init.
/// @param width    Width of the frame.
/// @param height   Height of the frame.
/// @param target   The box, wholly inside the frame.
/// @param window   Is set to the rectangle, always inside the frame: for the paper's tracker the box, for the robust one its
///                 surroundings, too. Left alone after an error.
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
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        answer_to(tracker, window, |tracker| {
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

/// Starts on the target in a box, at any time; whatever was followed before is forgotten. Only the pixels in #smr_lock_window are
/// read.
///
/// Cost: for the paper's tracker a copy of the box and two comparisons for each of its pixels, for the robust one as much as 25
/// updates. #smr_begin_lock, #smr_step and #smr_finish_lock do the same in parts.
///
/// @param tracker  Made by #smr_init.
/// @param frame    The frame; what is in memory covers #smr_lock_window.
/// @param target   The box, wholly inside the frame; of at most #SMR_PIXELS pixels for the paper's tracker.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the
///                 frame (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME) or with the box (#SMR_ERROR_BOX_EMPTY to
///                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY). After an error the tracker goes on with what it had, and so does an
///                 update that is under way.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_lock(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    target: *const smr_rect,
) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| {
            tracker.begin_lock(frame, pointer::read(target)?.into())?;
            tracker.finish_lock(frame)
        })
    })
}

/// Begins a lock that is made in steps of a bounded amount of work, for those who have a deadline: #smr_step as often as it takes,
/// then #smr_finish_lock. From now on there is no target, until the lock is finished.
///
/// @param tracker  Made by #smr_init.
/// @param frame    As for #smr_lock. Its pixels must stay as they are until #smr_finish_lock.
/// @param target   As for #smr_lock.
/// @return         As #smr_lock.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_begin_lock(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    target: *const smr_rect,
) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| tracker.begin_lock(frame, pointer::read(target)?.into()))
    })
}

/// Does what is left of the lock that #smr_begin_lock has begun. From now on there is a target.
///
/// @param tracker  As for #smr_begin_lock.
/// @param frame    The same frame, with the same pixels.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, what is wrong with the frame
///                 (#SMR_ERROR_FRAME_EMPTY to #SMR_ERROR_OUTSIDE_FRAME), #SMR_ERROR_NOT_BEGUN, #SMR_ERROR_FRAME_SIZE_CHANGED or
///                 #SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY. After an error the lock is still under way.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_finish_lock(tracker: *mut smr_tracker, frame: *const smr_frame) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe { with_frame(tracker, frame, |tracker, frame| tracker.finish_lock(frame)) })
}

/// How well the target could be told from what lies beside it when it was locked. A flat target, an edge and a single pixel look the
/// same beside their place: the tracker follows such a target, but may slip along it without noticing.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param quality  Is set to the quality in units of 1/65535, poor below #SMR_POOR_QUALITY; left alone after an error.
/// @return         As #smr_window.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_quality(tracker: *const smr_tracker, quality: *mut u16) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        answer_to(tracker, quality, |tracker| Ok(tracker.quality().ok_or(SMR_ERROR_NOT_LOCKED)?.value()))
    })
}

/// Looks for the target in the next frame.
///
/// Of the frame only the pixels in #smr_window and #smr_sweep_window are read; the rest need not be in memory. Cost of the paper's
/// tracker: for boxes of 8x8 pixels and windows of +-4 or more at most 1.25 times (offsets in the window) x (pixels of the template)
/// comparisons, far fewer where the target is seen clearly. In the frame in which a tracked target begins to leave the picture, at
/// most twice that. Cost of the robust tracker: about the same in every frame, at most 894 products for each of at most 2000
/// weights. #smr_begin, #smr_step and #smr_finish do the same in parts.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param frame    The frame; what is in memory covers #smr_window, and #smr_sweep_window where there is one.
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
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| {
            let out = Out::new(answer)?;
            tracker.begin(frame)?;
            tracker.finish(frame, out)
        })
    })
}

/// Begins an update that is made in steps of a bounded amount of work, for those who have a deadline. The answer is that of
/// #smr_update, however it is cut. An update that was begun before in this workspace, and not finished, is given up.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param frame    As for #smr_update. Its pixels must stay as they are until #smr_finish.
/// @return         As #smr_update.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_begin(tracker: *mut smr_tracker, frame: *const smr_frame) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe { with_frame(tracker, frame, |tracker, frame| tracker.begin(frame)) })
}

/// Goes on with the update that #smr_begin has begun, or with the lock that #smr_begin_lock has.
///
/// @param tracker  As for #smr_begin or #smr_begin_lock.
/// @param frame    The same frame, with the same pixels.
/// @param work     Units of work to be done; 0 is taken for 1. For the paper's tracker a unit is a comparison of two bytes; a few
///                 more are made, to come to a stop: at most the template's pixels or twice the pixels of a row of #smr_window,
///                 whichever is more, and seven for each of #SMR_SPAN offsets. For the robust tracker it is about an instruction
///                 of a Cortex-M4: an update takes at most 6.5 million, a lock 50.5 million, and a step at most 128,000 more than
///                 it was asked for.
/// @param done     Is set to 1 if nothing is left to do but #smr_finish or #smr_finish_lock, else to 0; left alone after an error.
/// @return         As #smr_update or #smr_finish_lock, or #SMR_ERROR_NOT_BEGUN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_step(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    work: u32,
    done: *mut u8,
) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| {
            let out = Out::new(done)?;
            out.write(tracker.step(frame, work)?.into());
            Ok(())
        })
    })
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
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe { with_frame(tracker, frame, |tracker, frame| tracker.finish(frame, Out::new(answer)?)) })
}

/// The pixels of the frame that the next #smr_update may read. Firmware may read out just these, and those of #smr_sweep_window.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param window   Is set to the rectangle, always inside the frame and never empty; left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED or #SMR_ERROR_NOT_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_window(tracker: *const smr_tracker, window: *mut smr_rect) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe { answer_to(tracker, window, |tracker| Ok(tracker.window().ok_or(SMR_ERROR_NOT_LOCKED)?.into())) })
}

/// The pixels of a second place that the next #smr_update may read, where it looks for a lost target: only the robust tracker
/// does, and not in every frame.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param window   Is set to the rectangle, always inside the frame; its width and height are 0 if there is none. Left alone
///                 after an error.
/// @return         As #smr_window.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_sweep_window(tracker: *const smr_tracker, window: *mut smr_rect) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        answer_to(tracker, window, |tracker| {
            tracker.window().ok_or(SMR_ERROR_NOT_LOCKED)?;
            Ok(tracker.sweep_window().unwrap_or_default().into())
        })
    })
}

/// The box and the state of the last answer: after #smr_lock and #smr_restore, too.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param bbox     Is set to the box; left alone after an error.
/// @param state    Is set to the state; left alone after an error.
/// @return         As #smr_window.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_last(
    tracker: *const smr_tracker,
    bbox: *mut smr_fine_rect,
    state: *mut smr_state,
) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        answer_to(tracker, bbox, |tracker| {
            let out = Out::new(state)?;
            let (bbox, state) = tracker.last().ok_or(SMR_ERROR_NOT_LOCKED)?;
            out.write(state.into());
            Ok(bbox.into())
        })
    })
}

/// Says that the picture has moved since the last frame because the camera turned: what was at (x, y) is expected at
/// (x + right, y + down). An update that is under way is given up.
///
/// The search window moves along, so that a turn of the camera does not take the target out of it. The box is kept within reach
/// of the frame. The paper's tracker rounds to whole pixels. Before the first lock it does nothing.
///
/// @param tracker  Made by #smr_init.
/// @param right    In units of 1/256 pixel.
/// @param down     In units of 1/256 pixel.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_moved(tracker: *mut smr_tracker, right: i32, down: i32) -> smr_status {
    // SAFETY: as the header asks of the caller.
    status_of(unsafe { borrow(tracker) }.map(|tracker| tracker.moved(right, down)))
}

/// The most bytes that #smr_save writes: #SMR_PAPER_SAVED_SIZE or #SMR_ROBUST_SAVED_SIZE of the library as it was built.
///
/// @param tracker  Made by #smr_init.
/// @param size     Is set to the bytes; left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_saved_size(tracker: *const smr_tracker, size: *mut usize) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe { answer_to(tracker, size, |tracker| Ok(tracker.most_saved_size())) })
}

/// Writes the target to memory: template and track, and of the configuration a checksum. The bytes are the same on every
/// platform.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param bytes    Memory outside of the tracker's own; left alone after an error.
/// @param size     Bytes there; #smr_saved_size are always enough.
/// @param written  Is set to how many were written; left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
///                 #SMR_ERROR_OVERLAPS_TRACKER,
///                 #SMR_ERROR_NOT_LOCKED or #SMR_ERROR_BUFFER_TOO_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_save(
    tracker: *const smr_tracker,
    bytes: *mut u8,
    size: usize,
    written: *mut usize,
) -> smr_status {
    // SAFETY: as the header asks of the caller, of each: so there are `size` bytes, used here alone.
    status_of(unsafe {
        answer_to(tracker, written, |tracker| {
            pointer::check_bytes(bytes, size, &tracker.memory())?;
            let needed = tracker.saved_size()?;
            if size < needed {
                return Err(SMR_ERROR_BUFFER_TOO_SMALL);
            }
            bytes.write_bytes(0, needed); // a slice holds initialised bytes
            tracker.save(core::slice::from_raw_parts_mut(bytes, needed))
        })
    })
}

/// Goes on with a target that #smr_save wrote: with identical answers, or not at all.
///
/// @param tracker  Made by #smr_init with the same configuration.
/// @param bytes    What #smr_save wrote, on any platform, outside of the tracker's own memory.
/// @param size     Bytes there; more than were written do no harm.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
///                 #SMR_ERROR_OVERLAPS_TRACKER,
///                 #SMR_ERROR_OTHER_METHOD or what is wrong with the bytes (#SMR_ERROR_NOT_SAVED to #SMR_ERROR_SAVED_TOO_LARGE).
///                 After an error the tracker goes on with what it had.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_restore(tracker: *mut smr_tracker, bytes: *const u8, size: usize) -> smr_status {
    // SAFETY: as the header asks of the caller: so there are `size` bytes, and nobody writes them.
    status_of(unsafe {
        borrow(tracker).and_then(|tracker| {
            pointer::check_bytes(bytes, size, &tracker.memory())?;
            tracker.restore(core::slice::from_raw_parts(bytes, size))
        })
    })
}

/// The template of the paper's tracker: the target's last believed appearance.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param image    Is set to the pixels, in the tracker's storage: they are good until the next call on this tracker that changes
///                 it, and may only be read. Left alone after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_NOT_LOCKED or
///                 #SMR_ERROR_OTHER_METHOD.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_template(tracker: *const smr_tracker, image: *mut smr_image) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe { answer_to(tracker, image, |tracker| tracker.template()?.ok_or(SMR_ERROR_NOT_LOCKED)) })
}

/// alpha of the next #smr_update of the paper's tracker.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param alpha    Is set to alpha in gray levels, rounded up (1..256); left alone after an error.
/// @return         As #smr_template.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_alpha(tracker: *const smr_tracker, alpha: *mut u16) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        answer_to(tracker, alpha, |tracker| {
            let alpha = tracker.alpha()?;
            tracker.window().map(|_| alpha).ok_or(SMR_ERROR_NOT_LOCKED)
        })
    })
}

/// The early template of the robust tracker, by which the track is verified.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param pixels   Memory for its pixels, outside of the tracker's own: they are copied there, row by row, without gaps.
/// @param size     Bytes at `pixels`; #SMR_ROBUST_PIXELS are always enough.
/// @param image    Is set to the pixels and their shape. After an error it is left alone, and so are the pixels.
/// @return         As #smr_template, or #SMR_ERROR_BUFFER_TOO_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_early_template(
    tracker: *const smr_tracker,
    pixels: *mut u8,
    size: usize,
    image: *mut smr_image,
) -> smr_status {
    // SAFETY: as the header asks of the caller, of each.
    status_of(unsafe {
        answer_to(tracker, image, |tracker| {
            pointer::check_bytes(pixels, size, &tracker.memory())?;
            tracker.early_template(pixels, size)
        })
    })
}

/// Writes what `question` answers.
///
/// # Safety
/// As for [`borrow`]; an `out` that is not NULL has memory for a `T`.
unsafe fn answer_to<T>(
    tracker: *const smr_tracker,
    out: *mut T,
    question: impl FnOnce(&dyn Tracked) -> Result<T, smr_status>,
) -> Result<(), smr_status> {
    // SAFETY: as the caller says, of both. The tracker is not written through this borrow.
    let (tracker, out) = unsafe { (borrow(tracker.cast_mut())?, Out::new(out)?) };
    out.write(question(tracker)?);
    Ok(())
}

/// Does `work` on a tracker and a frame, which do not share memory.
///
/// # Safety
/// As for [`borrow`]; a `frame` that is not NULL points to an `smr_frame`, whose pixels can be read during the call.
unsafe fn with_frame(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    work: impl FnOnce(&mut dyn Tracked, &Frame<'_>) -> Result<(), smr_status>,
) -> Result<(), smr_status> {
    // SAFETY: as the caller says, of each.
    unsafe {
        let tracker = borrow(tracker)?;
        pointer::check(frame)?;
        let frame = (*frame).frame(&tracker.memory())?;
        work(tracker, &frame)
    }
}

/// The tracker that `smr_init` has put there.
///
/// # Safety
/// A `tracker` that is not NULL points to memory of the size of one, and nobody else uses it as long as the result lives.
unsafe fn borrow<'a>(tracker: *mut smr_tracker) -> Result<&'a mut dyn Tracked, smr_status> {
    pointer::check(tracker)?;
    // SAFETY: neither NULL nor misaligned, and there is memory. Only the mark is read, and every usize is one.
    let mark = unsafe { addr_of!((*tracker).mark).read() };
    if mark != mark_of(tracker) {
        return Err(SMR_ERROR_NOT_INITIALISED);
    }
    // SAFETY: the mark says that a whole tracker was made here, and the caller that it is used alone.
    Ok(unsafe { &mut *(*tracker).held })
}
