//! Every way a call can end, by number and by name.

use core::ffi::{CStr, c_char};
use smr_core::similarity::TableError;
use smr_core::{ConfigError, FrameError, ImageError, LockError, UpdateError, robust};

/// How a call ended. The numbers stay as they are from version to version; new ones may be added.
///
/// A call that does not end with #SMR_OK has changed nothing, except that #smr_init and #smr_robust_init set their
/// `*tracker` to NULL.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum smr_status {
    /// Done.
    SMR_OK = 0,
    /// A pointer is NULL.
    SMR_ERROR_NULL = 1,
    /// A pointer is not aligned for what it points to.
    SMR_ERROR_MISALIGNED = 2,
    /// The storage is smaller than #smr_tracker_size, or #smr_robust_tracker_size.
    SMR_ERROR_STORAGE_TOO_SMALL = 3,
    /// The tracker was not made by #smr_init or #smr_robust_init, or was moved or overwritten since; or the table was not
    /// made by #smr_table_init.
    SMR_ERROR_NOT_INITIALISED = 4,
    /// The scale of a table is not in 1..4096.
    SMR_ERROR_SCALE_OUT_OF_RANGE = 5,
    /// A fraction of the configuration has a denominator of 0.
    SMR_ERROR_ZERO_DENOMINATOR = 6,
    /// `k` or `first_threshold` is 0: no pixel would ever count.
    SMR_ERROR_NOTHING_COUNTS = 7,
    /// `window_limit` is smaller than `window`.
    SMR_ERROR_LIMIT_BELOW_WINDOW = 8,
    /// Width or height of a frame is 0.
    SMR_ERROR_FRAME_EMPTY = 9,
    /// The stride is smaller than the width.
    SMR_ERROR_STRIDE_TOO_SMALL = 10,
    /// `size` ends before the last pixel of the last row.
    SMR_ERROR_FRAME_TOO_SHORT = 11,
    /// `size` is more than any object can have (PTRDIFF_MAX).
    SMR_ERROR_FRAME_TOO_LARGE = 12,
    /// The pixels lie in the tracker's own storage.
    SMR_ERROR_FRAME_OVERLAPS_TRACKER = 13,
    /// The part in memory reaches beyond the edge of the full frame.
    SMR_ERROR_OUTSIDE_FRAME = 14,
    /// The box has no pixels.
    SMR_ERROR_BOX_EMPTY = 15,
    /// A part of the box lies outside the frame.
    SMR_ERROR_BOX_OUTSIDE_FRAME = 16,
    /// The box has more than #SMR_PIXELS pixels.
    SMR_ERROR_BOX_TOO_LARGE = 17,
    /// A part of the box lies within the frame, but not in the part of it that is in memory.
    SMR_ERROR_BOX_NOT_IN_MEMORY = 18,
    /// The window could grow to more than #SMR_SPAN offsets on an axis.
    SMR_ERROR_WINDOW_TOO_LARGE = 19,
    /// There is no target yet: #smr_lock, or #smr_robust_lock, comes first.
    SMR_ERROR_NOT_LOCKED = 20,
    /// The full frame is not of the size of the one that was locked on.
    SMR_ERROR_FRAME_SIZE_CHANGED = 21,
    /// The part of the frame in memory does not cover #smr_window, or #smr_robust_window.
    SMR_ERROR_WINDOW_NOT_IN_MEMORY = 22,
    /// No update was begun, or it was finished, or the tracker has locked since: #smr_begin comes first.
    SMR_ERROR_NOT_BEGUN = 23,
    /// The part of the frame in memory does not cover #smr_robust_lock_window.
    SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY = 24,
    /// The memory for the pixels is too small for the template.
    SMR_ERROR_BUFFER_TOO_SMALL = 25,
}

use smr_status::{
    SMR_ERROR_BOX_EMPTY, SMR_ERROR_BOX_NOT_IN_MEMORY, SMR_ERROR_BOX_OUTSIDE_FRAME, SMR_ERROR_BOX_TOO_LARGE,
    SMR_ERROR_BUFFER_TOO_SMALL, SMR_ERROR_FRAME_EMPTY, SMR_ERROR_FRAME_OVERLAPS_TRACKER, SMR_ERROR_FRAME_SIZE_CHANGED,
    SMR_ERROR_FRAME_TOO_LARGE, SMR_ERROR_FRAME_TOO_SHORT, SMR_ERROR_LIMIT_BELOW_WINDOW, SMR_ERROR_MISALIGNED,
    SMR_ERROR_NOT_BEGUN, SMR_ERROR_NOT_INITIALISED, SMR_ERROR_NOT_LOCKED, SMR_ERROR_NOTHING_COUNTS, SMR_ERROR_NULL,
    SMR_ERROR_OUTSIDE_FRAME, SMR_ERROR_SCALE_OUT_OF_RANGE, SMR_ERROR_STORAGE_TOO_SMALL, SMR_ERROR_STRIDE_TOO_SMALL,
    SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY, SMR_ERROR_WINDOW_NOT_IN_MEMORY, SMR_ERROR_WINDOW_TOO_LARGE,
    SMR_ERROR_ZERO_DENOMINATOR, SMR_OK,
};

/// Name by number; complete, and tested to be.
static NAMES: [(smr_status, &CStr); 26] = [
    (SMR_OK, c"SMR_OK"),
    (SMR_ERROR_NULL, c"SMR_ERROR_NULL"),
    (SMR_ERROR_MISALIGNED, c"SMR_ERROR_MISALIGNED"),
    (SMR_ERROR_STORAGE_TOO_SMALL, c"SMR_ERROR_STORAGE_TOO_SMALL"),
    (SMR_ERROR_NOT_INITIALISED, c"SMR_ERROR_NOT_INITIALISED"),
    (SMR_ERROR_SCALE_OUT_OF_RANGE, c"SMR_ERROR_SCALE_OUT_OF_RANGE"),
    (SMR_ERROR_ZERO_DENOMINATOR, c"SMR_ERROR_ZERO_DENOMINATOR"),
    (SMR_ERROR_NOTHING_COUNTS, c"SMR_ERROR_NOTHING_COUNTS"),
    (SMR_ERROR_LIMIT_BELOW_WINDOW, c"SMR_ERROR_LIMIT_BELOW_WINDOW"),
    (SMR_ERROR_FRAME_EMPTY, c"SMR_ERROR_FRAME_EMPTY"),
    (SMR_ERROR_STRIDE_TOO_SMALL, c"SMR_ERROR_STRIDE_TOO_SMALL"),
    (SMR_ERROR_FRAME_TOO_SHORT, c"SMR_ERROR_FRAME_TOO_SHORT"),
    (SMR_ERROR_FRAME_TOO_LARGE, c"SMR_ERROR_FRAME_TOO_LARGE"),
    (SMR_ERROR_FRAME_OVERLAPS_TRACKER, c"SMR_ERROR_FRAME_OVERLAPS_TRACKER"),
    (SMR_ERROR_OUTSIDE_FRAME, c"SMR_ERROR_OUTSIDE_FRAME"),
    (SMR_ERROR_BOX_EMPTY, c"SMR_ERROR_BOX_EMPTY"),
    (SMR_ERROR_BOX_OUTSIDE_FRAME, c"SMR_ERROR_BOX_OUTSIDE_FRAME"),
    (SMR_ERROR_BOX_TOO_LARGE, c"SMR_ERROR_BOX_TOO_LARGE"),
    (SMR_ERROR_BOX_NOT_IN_MEMORY, c"SMR_ERROR_BOX_NOT_IN_MEMORY"),
    (SMR_ERROR_WINDOW_TOO_LARGE, c"SMR_ERROR_WINDOW_TOO_LARGE"),
    (SMR_ERROR_NOT_LOCKED, c"SMR_ERROR_NOT_LOCKED"),
    (SMR_ERROR_FRAME_SIZE_CHANGED, c"SMR_ERROR_FRAME_SIZE_CHANGED"),
    (SMR_ERROR_WINDOW_NOT_IN_MEMORY, c"SMR_ERROR_WINDOW_NOT_IN_MEMORY"),
    (SMR_ERROR_NOT_BEGUN, c"SMR_ERROR_NOT_BEGUN"),
    (SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY, c"SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY"),
    (SMR_ERROR_BUFFER_TOO_SMALL, c"SMR_ERROR_BUFFER_TOO_SMALL"),
];

/// The name of a status as it is written here, for logs.
///
/// @param status  Any number.
/// @return        A string that is always there, never NULL; "SMR_ERROR_UNKNOWN" for a number that is no status.
#[unsafe(no_mangle)]
pub extern "C" fn smr_status_name(status: i32) -> *const c_char {
    // A plain number, not the enum: C may pass anything, and a Rust enum may not hold anything.
    let known = NAMES.iter().find(|(known, _)| *known as i32 == status);
    known.map_or(c"SMR_ERROR_UNKNOWN", |(_, name)| name).as_ptr()
}

/// What an exported function returns.
pub(crate) fn status_of(result: Result<(), smr_status>) -> smr_status {
    result.err().unwrap_or(SMR_OK)
}

impl From<TableError> for smr_status {
    fn from(error: TableError) -> Self {
        match error {
            TableError::ScaleOutOfRange => SMR_ERROR_SCALE_OUT_OF_RANGE,
        }
    }
}

impl From<ConfigError> for smr_status {
    fn from(error: ConfigError) -> Self {
        match error {
            ConfigError::ZeroDenominator => SMR_ERROR_ZERO_DENOMINATOR,
            ConfigError::NothingCounts => SMR_ERROR_NOTHING_COUNTS,
            ConfigError::LimitBelowWindow => SMR_ERROR_LIMIT_BELOW_WINDOW,
        }
    }
}

impl From<ImageError> for smr_status {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::Empty => SMR_ERROR_FRAME_EMPTY,
            ImageError::StrideTooSmall => SMR_ERROR_STRIDE_TOO_SMALL,
            ImageError::SliceTooShort => SMR_ERROR_FRAME_TOO_SHORT,
        }
    }
}

impl From<FrameError> for smr_status {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::OutsideFrame => SMR_ERROR_OUTSIDE_FRAME,
        }
    }
}

impl From<LockError> for smr_status {
    fn from(error: LockError) -> Self {
        match error {
            LockError::BoxEmpty => SMR_ERROR_BOX_EMPTY,
            LockError::BoxOutsideFrame => SMR_ERROR_BOX_OUTSIDE_FRAME,
            LockError::BoxTooLarge => SMR_ERROR_BOX_TOO_LARGE,
            LockError::BoxNotInMemory => SMR_ERROR_BOX_NOT_IN_MEMORY,
            LockError::WindowTooLarge => SMR_ERROR_WINDOW_TOO_LARGE,
        }
    }
}

impl From<UpdateError> for smr_status {
    fn from(error: UpdateError) -> Self {
        match error {
            UpdateError::NotLocked => SMR_ERROR_NOT_LOCKED,
            UpdateError::FrameSizeChanged => SMR_ERROR_FRAME_SIZE_CHANGED,
            UpdateError::WindowNotInMemory => SMR_ERROR_WINDOW_NOT_IN_MEMORY,
            UpdateError::NotBegun => SMR_ERROR_NOT_BEGUN,
        }
    }
}

impl From<robust::LockError> for smr_status {
    fn from(error: robust::LockError) -> Self {
        match error {
            robust::LockError::BoxEmpty => SMR_ERROR_BOX_EMPTY,
            robust::LockError::BoxOutsideFrame => SMR_ERROR_BOX_OUTSIDE_FRAME,
            robust::LockError::SurroundingsNotInMemory => SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY,
        }
    }
}

impl From<robust::UpdateError> for smr_status {
    fn from(error: robust::UpdateError) -> Self {
        match error {
            robust::UpdateError::NotLocked => SMR_ERROR_NOT_LOCKED,
            robust::UpdateError::FrameSizeChanged => SMR_ERROR_FRAME_SIZE_CHANGED,
            robust::UpdateError::WindowNotInMemory => SMR_ERROR_WINDOW_NOT_IN_MEMORY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn every_status_has_its_own_name_and_number() {
        // A variant is declared with its number on a line of its own: what the source declares is what is named.
        let declared =
            include_str!("status.rs").lines().filter(|line| line.starts_with("    SMR_") && line.contains(" = "));
        assert_eq!(declared.count(), NAMES.len());
        for (number, (status, name)) in (0..).zip(NAMES) {
            assert_eq!(status as i32, number);
            assert_eq!(format!("{status:?}").as_bytes(), name.to_bytes());
            // SAFETY: a static string, as its documentation says.
            assert_eq!(unsafe { CStr::from_ptr(smr_status_name(number)) }, name);
        }
        for unknown in [-1, 26, i32::MIN, i32::MAX] {
            // SAFETY: as above.
            assert_eq!(unsafe { CStr::from_ptr(smr_status_name(unknown)) }, c"SMR_ERROR_UNKNOWN");
        }
    }
}
