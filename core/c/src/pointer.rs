//! What C's pointers are checked for before they are used: not NULL, and aligned.
//!
//! What cannot be checked is the caller's part, and the header says it once: a pointer that passes points to as much
//! memory as its type or the size beside it says, and nobody else writes there during the call.

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

/// A copy of what `from` points to.
///
/// # Safety
/// A `from` that passes [`check`] points to a `T`.
pub(crate) unsafe fn read<T: Copy>(from: *const T) -> Result<T, smr_status> {
    check(from)?;
    // SAFETY: checked just now to be neither NULL nor misaligned; the caller says that a T is there.
    Ok(unsafe { from.read() })
}

/// The memory that a result goes to, checked before the work is begun.
pub(crate) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// # Safety
    /// A `to` that passes [`check`] points to memory for a `T`, until [`Out::write`].
    pub(crate) unsafe fn new(to: *mut T) -> Result<Self, smr_status> {
        check(to)?;
        Ok(Self(to))
    }

    pub(crate) fn write(self, value: T) {
        // SAFETY: `new` has checked it, and its caller says that there is memory for a T.
        unsafe { self.0.write(value) }
    }
}

/// Checks bytes that must not lie in the `taken` addresses of a tracker.
///
/// # Errors
/// Also `SMR_ERROR_MEMORY_TOO_LARGE` and `SMR_ERROR_OVERLAPS_TRACKER`.
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

/// The addresses of `size` bytes at `start`.
pub(crate) fn range<T: ?Sized>(start: *const T, size: usize) -> Range<usize> {
    let start = start.addr();
    start..start.saturating_add(size)
}

/// True if the two share a byte.
pub(crate) fn overlap(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start < b.end && b.start < a.end
}
