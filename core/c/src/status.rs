//! Every way a call can end: number, name and text, each written once.

use core::ffi::c_char;
use smr_core::similarity::TableError;
use smr_core::{ConfigError, FrameError, ImageError, LockError, RestoreError, SaveError, UpdateError};

/// Makes the enum, the table of its names, and what the header says of each.
macro_rules! statuses {
    ($($(#[doc = $text:literal])+ $name:ident = $number:literal,)+) => {
        /// How a call ended; in the header with its texts.
        #[repr(i32)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum smr_status {
            $($(#[doc = $text])+ $name = $number,)+
        }

        /// Number, name with a zero at its end, and text: the header's part of it is written from this list by a test.
        pub const STATUSES: &[(smr_status, &str, &str)] =
            &[$((smr_status::$name, concat!(stringify!($name), "\0"), concat!($($text, "\n"),+)),)+];

        pub(crate) use smr_status::*;
    };
}

statuses! {
    /// Done.
    SMR_OK = 0,
    /// A pointer is NULL.
    SMR_ERROR_NULL = 1,
    /// A pointer is not aligned for what it points to.
    SMR_ERROR_MISALIGNED = 2,
    /// The storage is smaller than #smr_target_size.
    SMR_ERROR_STORAGE_TOO_SMALL = 3,
    /// The workspace is smaller than #smr_workspace_size.
    SMR_ERROR_WORKSPACE_TOO_SMALL = 4,
    /// Storage and workspace share memory.
    SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE = 5,
    /// The tracker was not made by #smr_init, or was moved or overwritten since, or its workspace was; the configuration was not
    /// made by one of the calls smr_config_...; or the table was not made by #smr_table_init.
    SMR_ERROR_NOT_INITIALISED = 6,
    /// The other method's tracker is asked, or the target was saved by one.
    SMR_ERROR_OTHER_METHOD = 7,
    /// The scale of a table is not in 1..4096.
    SMR_ERROR_SCALE_OUT_OF_RANGE = 8,
    /// A fraction of the configuration has a denominator of 0.
    SMR_ERROR_ZERO_DENOMINATOR = 9,
    /// `k` or `first_threshold` is 0: no pixel would ever count.
    SMR_ERROR_NOTHING_COUNTS = 10,
    /// `window_limit` is smaller than `window`.
    SMR_ERROR_LIMIT_BELOW_WINDOW = 11,
    /// A number of the configuration lies outside the range that is stated beside it.
    SMR_ERROR_CONFIG_OUT_OF_RANGE = 12,
    /// Width or height of a part of the frame is 0.
    SMR_ERROR_FRAME_EMPTY = 13,
    /// The stride is smaller than the width.
    SMR_ERROR_STRIDE_TOO_SMALL = 14,
    /// `size` ends before the last pixel of the last row.
    SMR_ERROR_FRAME_TOO_SHORT = 15,
    /// `size` is more than any object can have (PTRDIFF_MAX).
    SMR_ERROR_MEMORY_TOO_LARGE = 16,
    /// The pixels, or the bytes, lie in the tracker's own storage, or in its workspace.
    SMR_ERROR_OVERLAPS_TRACKER = 17,
    /// A part in memory reaches beyond the edge of the frame.
    SMR_ERROR_OUTSIDE_FRAME = 18,
    /// The box has no pixels.
    SMR_ERROR_BOX_EMPTY = 19,
    /// A part of the box lies outside the frame.
    SMR_ERROR_BOX_OUTSIDE_FRAME = 20,
    /// The box has more than #SMR_PIXELS pixels. The robust tracker has room for every box.
    SMR_ERROR_BOX_TOO_LARGE = 21,
    /// The window could grow to more than #SMR_SPAN offsets on an axis. The robust tracker always has room.
    SMR_ERROR_WINDOW_TOO_LARGE = 22,
    /// What is in memory does not cover #smr_lock_window.
    SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY = 23,
    /// There is no target yet: #smr_lock comes first.
    SMR_ERROR_NOT_LOCKED = 24,
    /// The frame is not of the size of the one that was locked on, or by which the lock was begun.
    SMR_ERROR_FRAME_SIZE_CHANGED = 25,
    /// What is in memory does not cover #smr_window, or #smr_sweep_window where there is one.
    SMR_ERROR_WINDOW_NOT_IN_MEMORY = 26,
    /// No update, or no lock, of this tracker is under way in its workspace: none was begun, it was finished, the tracker has changed
    /// since, or another one has used the workspace. #smr_begin or #smr_begin_lock comes first.
    SMR_ERROR_NOT_BEGUN = 27,
    /// The memory is too small for what goes there.
    SMR_ERROR_BUFFER_TOO_SMALL = 28,
    /// These are not the bytes of a saved target.
    SMR_ERROR_NOT_SAVED = 29,
    /// The target was saved by another version of the library.
    SMR_ERROR_OTHER_VERSION = 30,
    /// The saved target ends too early.
    SMR_ERROR_TRUNCATED = 31,
    /// The saved target has changed since it was written: its checksum is wrong.
    SMR_ERROR_DAMAGED = 32,
    /// The target was saved with another configuration: answers would differ.
    SMR_ERROR_OTHER_CONFIG = 33,
    /// The saved target is too large for this tracker.
    SMR_ERROR_SAVED_TOO_LARGE = 34,
    /// A reason that has no number yet.
    SMR_ERROR_UNKNOWN = 35,
}

/// The name of a status as it is written here, for logs.
///
/// @param status  Any number.
/// @return        A string that is always there, never NULL; "SMR_ERROR_UNKNOWN" for a number that is no status.
#[unsafe(no_mangle)]
pub extern "C" fn smr_status_name(status: i32) -> *const c_char {
    // A plain number, not the enum: C may pass anything, and a Rust enum may not hold anything.
    let known = STATUSES.iter().find(|(known, ..)| *known as i32 == status);
    known.map_or(c"SMR_ERROR_UNKNOWN".as_ptr(), |(_, name, _)| name.as_ptr().cast())
}

/// What an exported function returns.
pub(crate) fn status_of(result: Result<(), smr_status>) -> smr_status {
    result.err().unwrap_or(SMR_OK)
}

/// What an error of smr-core is called here.
macro_rules! called {
    ($($error:ident { $($reason:ident => $status:ident),+ $(, ..$rest:tt)? })+) => {
        $(impl From<$error> for smr_status {
            fn from(error: $error) -> Self {
                match error {
                    $($error::$reason => $status,)+
                    $($rest => SMR_ERROR_UNKNOWN,)?
                }
            }
        })+
    };
}

called! {
    TableError { ScaleOutOfRange => SMR_ERROR_SCALE_OUT_OF_RANGE }
    ImageError {
        Empty => SMR_ERROR_FRAME_EMPTY,
        StrideTooSmall => SMR_ERROR_STRIDE_TOO_SMALL,
        SliceTooShort => SMR_ERROR_FRAME_TOO_SHORT, .._
    }
    FrameError { OutsideFrame => SMR_ERROR_OUTSIDE_FRAME, .._ }
    ConfigError {
        ZeroDenominator => SMR_ERROR_ZERO_DENOMINATOR,
        NothingCounts => SMR_ERROR_NOTHING_COUNTS,
        LimitBelowWindow => SMR_ERROR_LIMIT_BELOW_WINDOW,
        OutOfRange => SMR_ERROR_CONFIG_OUT_OF_RANGE, .._
    }
    LockError {
        BoxEmpty => SMR_ERROR_BOX_EMPTY,
        BoxOutsideFrame => SMR_ERROR_BOX_OUTSIDE_FRAME,
        BoxTooLarge => SMR_ERROR_BOX_TOO_LARGE,
        WindowTooLarge => SMR_ERROR_WINDOW_TOO_LARGE,
        LockWindowNotInMemory => SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY,
        FrameSizeChanged => SMR_ERROR_FRAME_SIZE_CHANGED,
        NotBegun => SMR_ERROR_NOT_BEGUN, .._
    }
    UpdateError {
        NotLocked => SMR_ERROR_NOT_LOCKED,
        FrameSizeChanged => SMR_ERROR_FRAME_SIZE_CHANGED,
        WindowNotInMemory => SMR_ERROR_WINDOW_NOT_IN_MEMORY,
        NotBegun => SMR_ERROR_NOT_BEGUN, .._
    }
    SaveError {
        NotLocked => SMR_ERROR_NOT_LOCKED,
        BufferTooSmall => SMR_ERROR_BUFFER_TOO_SMALL, .._
    }
    RestoreError {
        NotSaved => SMR_ERROR_NOT_SAVED,
        OtherVersion => SMR_ERROR_OTHER_VERSION,
        Truncated => SMR_ERROR_TRUNCATED,
        Damaged => SMR_ERROR_DAMAGED,
        OtherTracker => SMR_ERROR_OTHER_METHOD,
        OtherConfig => SMR_ERROR_OTHER_CONFIG,
        TooLarge => SMR_ERROR_SAVED_TOO_LARGE, .._
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ffi::CStr;

    #[test]
    fn every_number_has_its_name() {
        for (number, (status, name, _)) in (0..).zip(STATUSES) {
            assert_eq!(*status as i32, number);
            // SAFETY: a static string, as its documentation says.
            let said = unsafe { CStr::from_ptr(smr_status_name(number)) };
            assert_eq!(said.to_bytes_with_nul(), name.as_bytes());
        }
        for unknown in [-1, 36, i32::MIN, i32::MAX] {
            // SAFETY: as above.
            assert_eq!(unsafe { CStr::from_ptr(smr_status_name(unknown)) }, c"SMR_ERROR_UNKNOWN");
        }
    }
}
