//! The calls that read a target: its quality, its last box, its template, and its saved form.

use crate::answer::smr_state;
use crate::capacity::{PAPER_SAVED_SIZE, ROBUST_SAVED_SIZE, ROBUST_SMALL_SAVED_SIZE};
use crate::frame::{smr_fine_rect, smr_image};
use crate::pointer::{self, Out};
use crate::setting::name_in_c;
use crate::status::{SMR_ERROR_BUFFER_TOO_SMALL, SMR_ERROR_NOT_LOCKED, smr_status, status_of};
use crate::tracker::{Event, Known, borrow, each, smr_tracker, write_result};
use core::ffi::c_char;
use core::ptr;
use smr_core::robust::Size;
use smr_core::{RestoreError, Robust, Target};

/// Quality of the target at the lock: its difference from shifted copies of itself. It is 0 for a flat target, an edge
/// along an axis or a single pixel: the tracker follows such a target, but may slip along it without noticing.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param quality  Is set to the quality in units of 1/65535, poor below #SMR_POOR_QUALITY; unchanged after an error.
/// @return         As #smr_windows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_quality(tracker: *const smr_tracker, quality: *mut u16) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, and `quality` points to memory for a number.
    status_of(unsafe {
        write_result(tracker, quality, |tracker| {
            let quality = each!(tracker.known(), target => target.quality());
            Ok(quality.ok_or(SMR_ERROR_NOT_LOCKED)?.value())
        })
    })
}

/// The current box and state: those of the last answer, or as #smr_lock or #smr_restore has set them.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param bbox     Is set to the box; unchanged after an error.
/// @param state    Is set to the state; unchanged after an error.
/// @return         As #smr_windows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_last(
    tracker: *const smr_tracker,
    bbox: *mut smr_fine_rect,
    state: *mut smr_state,
) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, and `bbox` and `state` point to memory of
    // their types.
    status_of(unsafe {
        write_result(tracker, bbox, |tracker| {
            let out = Out::new(state)?;
            let last = each!(tracker.known(), target => target.bbox().zip(target.state()));
            let (bbox, state) = last.ok_or(SMR_ERROR_NOT_LOCKED)?;
            out.write(state.into());
            Ok(bbox.into())
        })
    })
}

/// Copies the current template (paper tracker) or the early template, which verifies the target (robust tracker).
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param pixels   Memory for the pixels, row by row without gaps, outside the tracker's own memory.
/// @param size     Bytes at `pixels`; #SMR_PIXELS or #SMR_ROBUST_PIXELS are always enough.
/// @param image    Is set to the pixels and their width and height. After an error it and the pixels are unchanged.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
///                 #SMR_ERROR_OVERLAPS_TRACKER, #SMR_ERROR_NOT_LOCKED or #SMR_ERROR_BUFFER_TOO_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_template(
    tracker: *const smr_tracker,
    pixels: *mut u8,
    size: usize,
    image: *mut smr_image,
) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, `size` bytes can be written at `pixels`, and
    // `image` points to memory for an image.
    status_of(unsafe {
        write_result(tracker, image, |tracker| {
            pointer::check_bytes(pixels, size, &tracker.memory())?;
            let copied = match tracker.known() {
                Known::Paper(target) => target.template().map(|image| {
                    let (width, height) = (image.width(), image.height());
                    copy(smr_image { pixels, width, height }, size, image.rows().flatten().copied())
                }),
                Known::Robust(target) => early(target, pixels, size),
                Known::Small(target) => early(target, pixels, size),
            };
            copied.ok_or(SMR_ERROR_NOT_LOCKED)?
        })
    })
}

/// # Safety
/// `size` bytes can be written at `pixels`.
unsafe fn early<S: Size>(target: &Robust<S>, pixels: *mut u8, size: usize) -> Option<Result<smr_image, smr_status>> {
    let (grid, template) = target.grid().zip(target.early_template())?;
    // SAFETY: `size` bytes can be written at `pixels`.
    Some(unsafe { copy(smr_image { pixels, width: grid.columns, height: grid.rows }, size, template) })
}

/// # Safety
/// `size` bytes can be written at `to.pixels`.
unsafe fn copy(to: smr_image, size: usize, from: impl Iterator<Item = u8>) -> Result<smr_image, smr_status> {
    let area = usize::from(to.width) * usize::from(to.height);
    if size < area {
        return Err(SMR_ERROR_BUFFER_TOO_SMALL);
    }
    for (at, pixel) in (0..area).zip(from) {
        // SAFETY: `size` bytes can be written there, and `at` is below `area`, which is at most `size`.
        unsafe { to.pixels.cast_mut().add(at).write(pixel) }
    }
    Ok(to)
}

impl Known<'_> {
    #[inline(never)] // one copy in flash
    fn save(&self, bytes: &mut [u8]) -> Result<usize, smr_status> {
        Ok(each!(self, target => target.save(bytes))?)
    }

    #[inline(never)] // keeps its stack out of that of the calls before
    fn restore(&mut self, bytes: &[u8]) -> Result<(), smr_status> {
        Ok(each!(self, target => target.restore(bytes))?)
    }
}

/// Largest size of this tracker's saved target in bytes. Equals the value of #SMR_PAPER_SAVED_SIZE,
/// #SMR_ROBUST_SAVED_SIZE or #SMR_ROBUST_SMALL_SAVED_SIZE with which the library was built.
///
/// @param tracker  Made by #smr_init.
/// @param size     Is set to the number of bytes; unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_saved_size(tracker: *const smr_tracker, size: *mut usize) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, and `size` points to memory for a number.
    status_of(unsafe {
        write_result(tracker, size, |tracker| match tracker.known() {
            Known::Paper(_) => Ok(PAPER_SAVED_SIZE),
            Known::Robust(_) => Ok(ROBUST_SAVED_SIZE),
            Known::Small(_) => Ok(ROBUST_SMALL_SAVED_SIZE),
        })
    })
}

/// Saves the target and the tracker's settings as bytes, the same on every platform. #smr_restore needs equal settings.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param bytes    Memory outside the tracker's own; unchanged after an error.
/// @param size     Bytes at `bytes`; #smr_saved_size are always enough.
/// @param written  Is set to the number of bytes written; unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
///                 #SMR_ERROR_OVERLAPS_TRACKER, #SMR_ERROR_NOT_LOCKED or #SMR_ERROR_BUFFER_TOO_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_save(
    tracker: *const smr_tracker,
    bytes: *mut u8,
    size: usize,
    written: *mut usize,
) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, nor the `size` bytes at `bytes`, and `written`
    // points to memory for a number.
    status_of(unsafe {
        write_result(tracker, written, |tracker| {
            pointer::check_bytes(bytes, size, &tracker.memory())?;
            let target = tracker.known();
            let needed = each!(&target, target => target.saved_size())?;
            if size < needed {
                return Err(SMR_ERROR_BUFFER_TOO_SMALL);
            }
            bytes.write_bytes(0, needed); // the bytes of a slice must be initialised
            target.save(core::slice::from_raw_parts_mut(bytes, needed))
        })
    })
}

/// Continues with a target that #smr_save wrote. Given the same frames, answers equal those of the saving tracker.
///
/// @param tracker  Made by #smr_init with the same configuration.
/// @param bytes    The bytes that #smr_save wrote, on any platform, outside the tracker's own memory.
/// @param size     The number of bytes; excess bytes are ignored.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
///                 #SMR_ERROR_OVERLAPS_TRACKER, #SMR_ERROR_OTHER_METHOD or an error of the bytes (#SMR_ERROR_NOT_SAVED to
///                 #SMR_ERROR_SAVED_TOO_LARGE).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_restore(tracker: *mut smr_tracker, bytes: *const u8, size: usize) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, `size` bytes can be read at `bytes`, and
    // nobody writes them.
    status_of(unsafe {
        borrow(tracker).and_then(|tracker| {
            pointer::check_bytes(bytes, size, &tracker.memory())?;
            let bytes = core::slice::from_raw_parts(bytes, size);
            tracker.known().restore(bytes)?;
            tracker.record(&Event::Restored(bytes));
            Ok(())
        })
    })
}

/// Names the tracker's first setting whose saved value differs, after #smr_restore returned #SMR_ERROR_OTHER_CONFIG.
///
/// @param tracker  Made by #smr_init.
/// @param bytes    The bytes that #smr_save wrote, on any platform, outside the tracker's own memory.
/// @param size     The number of bytes; excess bytes are ignored.
/// @param name     Is set to the field's name, a static string such as "gate_lost"; to NULL if no setting differs.
/// @return         #SMR_OK, or an error of #smr_restore other than #SMR_ERROR_OTHER_CONFIG.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_other_setting(
    tracker: *const smr_tracker,
    bytes: *const u8,
    size: usize,
    name: *mut *const c_char,
) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, `size` bytes can be read at `bytes`, and
    // nobody writes them. `name` points to memory for a pointer.
    status_of(unsafe {
        write_result(tracker, name, |tracker| {
            pointer::check_bytes(bytes, size, &tracker.memory())?;
            match each!(tracker.known(), target => target.check_saved(core::slice::from_raw_parts(bytes, size))) {
                Ok(()) => Ok(ptr::null()),
                Err(RestoreError::OtherConfig(name)) => Ok(name_in_c(name)),
                Err(error) => Err(error.into()),
            }
        })
    })
}
