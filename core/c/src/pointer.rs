//! The checks of pointers from C: not NULL, aligned, and, for bytes such as pixels, outside the tracker's memory.
//!
//! The header demands the rest of the caller, because it cannot be checked: the pointer points to memory of the size of
//! its type, or of the stated size, and nobody else writes there during the call.

use crate::status::smr_status;
use core::ops::Range;

/// # Errors
/// `SMR_ERROR_NULL`, `SMR_ERROR_MISALIGNED`.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), smr_status> {
    if pointer.is_null() {
        return Err(smr_status::SMR_ERROR_NULL);
    }
    if !pointer.is_aligned() {
        return Err(smr_status::SMR_ERROR_MISALIGNED);
    }
    Ok(())
}

/// # Safety
/// A `from` that passes [`check`] points to a `T`.
pub(crate) unsafe fn read<T: Copy>(from: *const T) -> Result<T, smr_status> {
    check(from)?;
    // SAFETY: `from` passed `check`, so it is neither NULL nor misaligned and points to a T.
    Ok(unsafe { from.read() })
}

/// The caller's memory for a result, checked before any work is done.
pub(crate) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// # Safety
    /// A `to` that passes [`check`] points to memory for a `T` while the result lives.
    pub(crate) unsafe fn new(to: *mut T) -> Result<Self, smr_status> {
        check(to)?;
        Ok(Self(to))
    }

    pub(crate) fn write(&self, value: T) {
        // SAFETY: `new` has checked the pointer, which points to memory for a T while `self` lives.
        unsafe { self.0.write(value) }
    }

    /// Reads back the value that `write` has stored.
    pub(crate) fn read(&self) -> T
    where
        T: Copy,
    {
        // SAFETY: `new` has checked the pointer, which points to memory for a T, and `write` has stored one there.
        unsafe { self.0.read() }
    }
}

/// Checks that `bytes` is not NULL, `size` is at most `isize::MAX`, and no byte lies in the memory ranges `taken`.
///
/// # Errors
/// The errors of [`check`], `SMR_ERROR_MEMORY_TOO_LARGE`, `SMR_ERROR_OVERLAPS_TRACKER`.
pub(crate) fn check_bytes(bytes: *const u8, size: usize, taken: &[Range<usize>; 2]) -> Result<(), smr_status> {
    check(bytes)?;
    if isize::try_from(size).is_err() {
        return Err(smr_status::SMR_ERROR_MEMORY_TOO_LARGE);
    }
    let bytes = range(bytes, size);
    if taken.iter().any(|taken| overlap(taken, &bytes)) {
        return Err(smr_status::SMR_ERROR_OVERLAPS_TRACKER);
    }
    Ok(())
}

pub(crate) fn range<T: ?Sized>(start: *const T, size: usize) -> Range<usize> {
    let start = start.addr();
    start..start.saturating_add(size)
}

pub(crate) fn overlap(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start < b.end && b.start < a.end
}
