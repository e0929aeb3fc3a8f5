//! Saves a target as bytes, and restores it.

use crate::capacity::{PAPER_SAVED_SIZE, ROBUST_SAVED_SIZE};
use crate::pointer::{self, Out};
use crate::status::{SMR_ERROR_BUFFER_TOO_SMALL, SMR_ERROR_NOT_SAVED, smr_status, status_of};
use crate::tracker::{Known, ask, borrow, each, smr_tracker};
use core::ffi::c_char;
use core::ptr;
use smr_core::{RestoreError, Target, copies};

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

/// Writes the target, as a copy with a number if there is one.
///
/// # Safety
/// As for [`ask`]; nobody else uses the `size` bytes.
unsafe fn save(
    tracker: *const smr_tracker,
    copy: Option<u32>,
    bytes: *mut u8,
    size: usize,
    written: *mut usize,
) -> Result<(), smr_status> {
    // SAFETY: as the caller ensures.
    unsafe {
        ask(tracker, written, |tracker| {
            pointer::check_bytes(bytes, size, &tracker.memory())?;
            let target = tracker.known();
            let saved = each!(&target, target => target.saved_size())?;
            let needed = if copy.is_some() { copies::size(saved) } else { saved };
            if size < needed {
                return Err(SMR_ERROR_BUFFER_TOO_SMALL);
            }
            bytes.write_bytes(0, needed); // the bytes of a slice must be initialised
            let bytes = core::slice::from_raw_parts_mut(bytes, needed);
            let saved = target.save(bytes)?;
            Ok(copy.map_or(Ok(saved), |number| copies::seal(number, saved, bytes))?)
        })
    }
}

/// The most bytes that #smr_save writes: #SMR_PAPER_SAVED_SIZE or #SMR_ROBUST_SAVED_SIZE of the library as it was
/// built.
///
/// @param tracker  Made by #smr_init.
/// @param size     Is set to the number of bytes; unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_saved_size(tracker: *const smr_tracker, size: *mut usize) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        ask(tracker, size, |tracker| match tracker.known() {
            Known::Paper(_) => Ok(PAPER_SAVED_SIZE),
            Known::Robust(_) => Ok(ROBUST_SAVED_SIZE),
        })
    })
}

/// Writes the target to memory: what the tracker remembers of it, and the numbers of the configuration to compare with.
/// The bytes are the same on every platform.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param bytes    Memory outside the tracker's own; unchanged after an error.
/// @param size     Bytes there; #smr_saved_size are always enough.
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
    // SAFETY: as the header demands of the caller.
    status_of(unsafe { save(tracker, None, bytes, size, written) })
}

/// One of two saved copies.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_saved_copy {
    /// 0: the first place, 1: the second.
    pub place: u32,
    /// The number that it was written with.
    pub number: u32,
    /// The saved target, for #smr_restore.
    pub bytes: *const u8,
    /// Bytes there.
    pub size: usize,
}

/// Writes the target as one of two copies. Write them in turn, each with the next number: if the power fails while one
/// is written, the other one is whole. It takes #SMR_COPY_AROUND bytes more than #smr_save.
///
/// @param tracker  Made by #smr_init, locked by #smr_lock.
/// @param number   The number after that of the newest copy; 1 if there is none. After the largest comes 0.
/// @param bytes    Memory outside the tracker's own; unchanged after an error.
/// @param size     Bytes there.
/// @param written  Is set to the number of bytes written; unchanged after an error.
/// @return         As #smr_save.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_save_copy(
    tracker: *const smr_tracker,
    number: u32,
    bytes: *mut u8,
    size: usize,
    written: *mut usize,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe { save(tracker, Some(number), bytes, size, written) })
}

/// Finds the newer one of two copies. Write the next one in the other place, with the next number.
///
/// @param first        The bytes of the first place; there may be more than were written.
/// @param first_size   Bytes there.
/// @param second       The bytes of the second place.
/// @param second_size  Bytes there.
/// @param copy         Is set to the newer copy that is whole; unchanged after an error. It points into `first` or `second`.
/// @return             #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE, or #SMR_ERROR_NOT_SAVED if neither
///                     is whole.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_newest_copy(
    first: *const u8,
    first_size: usize,
    second: *const u8,
    second_size: usize,
    copy: *mut smr_saved_copy,
) -> smr_status {
    let find = || {
        // SAFETY: as the header demands of the caller.
        let copy = unsafe { Out::new(copy)? };
        let places = [(first, first_size), (second, second_size)];
        for (bytes, size) in places {
            pointer::check_bytes(bytes, size, &[0..0, 0..0])?;
        }
        // SAFETY: not NULL, at most isize::MAX bytes, and bytes are always aligned; the rest as the header demands of
        // the caller.
        let [first, second] = places.map(|(bytes, size)| unsafe { core::slice::from_raw_parts(bytes, size) });
        let found = copies::newest(first, second).ok_or(SMR_ERROR_NOT_SAVED)?;
        let place = u32::from(found.place != 0);
        copy.write(smr_saved_copy {
            place,
            number: found.number,
            bytes: ptr::from_ref(found.saved).cast(),
            size: found.saved.len(),
        });
        Ok(())
    };
    status_of(find())
}

/// Continues with a target that #smr_save wrote. Its answers are then identical to those of the saved tracker.
///
/// @param tracker  Made by #smr_init with the same configuration.
/// @param bytes    The bytes that #smr_save wrote, on any platform, outside the tracker's own memory.
/// @param size     Bytes there; there may be more than were written.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_NOT_INITIALISED, #SMR_ERROR_MEMORY_TOO_LARGE,
///                 #SMR_ERROR_OVERLAPS_TRACKER, #SMR_ERROR_OTHER_METHOD or an error of the bytes (#SMR_ERROR_NOT_SAVED to
///                 #SMR_ERROR_SAVED_TOO_LARGE). After an error the tracker is unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_restore(tracker: *mut smr_tracker, bytes: *const u8, size: usize) -> smr_status {
    // SAFETY: as the header demands of the caller: there are `size` bytes, and nobody writes them.
    status_of(unsafe {
        borrow(tracker).and_then(|tracker| {
            pointer::check_bytes(bytes, size, &tracker.memory())?;
            tracker.known().restore(core::slice::from_raw_parts(bytes, size))?;
            tracker.cancel();
            Ok(())
        })
    })
}

/// Names the setting for which #smr_restore refuses a target with #SMR_ERROR_OTHER_CONFIG: the first one of the
/// configuration that differs.
///
/// @param tracker  Made by #smr_init.
/// @param bytes    The bytes that #smr_save wrote, on any platform, outside the tracker's own memory.
/// @param size     Bytes there; there may be more than were written.
/// @param name     Is set to a static string, such as "refiner" or "gate.lost", the field of the configuration; to NULL if no setting
///                 differs. Unchanged after an error.
/// @return         #SMR_OK, or an error of #smr_restore other than #SMR_ERROR_OTHER_CONFIG.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_other_setting(
    tracker: *const smr_tracker,
    bytes: *const u8,
    size: usize,
    name: *mut *const c_char,
) -> smr_status {
    // SAFETY: as the header demands of the caller: there are `size` bytes, and nobody writes them.
    status_of(unsafe {
        ask(tracker, name, |tracker| {
            pointer::check_bytes(bytes, size, &tracker.memory())?;
            match each!(tracker.known(), target => target.check_saved(core::slice::from_raw_parts(bytes, size))) {
                Ok(()) => Ok(ptr::null()),
                Err(RestoreError::OtherConfig(setting)) => Ok(setting.name_with_zero().as_ptr().cast()),
                Err(error) => Err(error.into()),
            }
        })
    })
}
