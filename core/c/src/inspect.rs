//! What a tracker knows about its target: the last box, the quality, the templates.

use crate::answer::smr_state;
use crate::frame::{smr_fine_rect, smr_image};
use crate::pointer::{self, Out};
use crate::status::{SMR_ERROR_BUFFER_TOO_SMALL, SMR_ERROR_NOT_LOCKED, smr_status, status_of};
use crate::tracker::{Known, ask, each, smr_tracker};
use smr_core::Target;

/// How distinct the target was from its surroundings at the lock. A flat target, an edge or a single pixel looks the
/// same when shifted: the tracker follows it, but may slip along it without noticing.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param quality  Is set to the quality in units of 1/65535, poor below #SMR_POOR_QUALITY; unchanged after an error.
/// @return         As #smr_windows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_quality(tracker: *const smr_tracker, quality: *mut u16) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        ask(tracker, quality, |tracker| {
            let quality = each!(tracker.known(), target => target.quality());
            Ok(quality.ok_or(SMR_ERROR_NOT_LOCKED)?.value())
        })
    })
}

/// The box and the state of the last answer; also after #smr_lock and #smr_restore.
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
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        ask(tracker, bbox, |tracker| {
            let out = Out::new(state)?;
            let last = each!(tracker.known(), target => target.bbox().zip(target.state()));
            let (bbox, state) = last.ok_or(SMR_ERROR_NOT_LOCKED)?;
            out.write(state.into());
            Ok(bbox.into())
        })
    })
}

/// A copy of the template: the appearance of the target at the last update of the paper's template, or the robust
/// tracker's early template, with which it verifies the target.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param pixels   Memory outside the tracker's own, for the pixels, row by row without gaps.
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
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        ask(tracker, image, |tracker| {
            pointer::check_bytes(pixels, size, &tracker.memory())?;
            let copied = match tracker.known() {
                Known::Paper(target) => target.template().map(|image| {
                    let (width, height) = (image.width(), image.height());
                    copy(smr_image { pixels, width, height }, size, image.rows().flatten().copied())
                }),
                Known::Robust(target) => target.grid().zip(target.early_template()).map(|(grid, template)| {
                    copy(smr_image { pixels, width: grid.columns, height: grid.rows }, size, template)
                }),
            };
            copied.ok_or(SMR_ERROR_NOT_LOCKED)?
        })
    })
}

/// # Safety
/// There is memory for `size` bytes at the pixels of `to`.
unsafe fn copy(to: smr_image, size: usize, from: impl Iterator<Item = u8>) -> Result<smr_image, smr_status> {
    let area = usize::from(to.width) * usize::from(to.height);
    if size < area {
        return Err(SMR_ERROR_BUFFER_TOO_SMALL);
    }
    for (at, pixel) in (0..area).zip(from) {
        // SAFETY: the caller ensures that there is memory for `size` pixels, and `size` is at least their number.
        unsafe { to.pixels.cast_mut().add(at).write(pixel) }
    }
    Ok(to)
}
