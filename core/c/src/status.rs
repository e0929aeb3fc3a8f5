//! The number, name and text of every status, and the version of the header and of the library.

use core::ffi::{CStr, c_char};
use smr_core::readout::ReadoutError;
use smr_core::{ConfigError, FrameError, ImageError, LockError, RestoreError, SaveError, UpdateError};

/// Defines the enum and the table of names and texts.
macro_rules! statuses {
    ($($(#[doc = $text:literal])+ $name:ident = $number:literal,)+) => {
        /// The result of a call.
        #[repr(i32)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum smr_status {
            $($(#[doc = $text])+ $name = $number,)+
        }

        /// All statuses with their zero-terminated names and texts. A test writes the header's list from this table.
        pub const STATUSES: &[(smr_status, &str, &str)] =
            &[$((smr_status::$name, concat!(stringify!($name), "\0"), concat!($($text, "\n"),+)),)+];

        /// The names by number, in a table without the texts, so that a program does not link the texts.
        const NAMES: &[&str] = &[$(concat!(stringify!($name), "\0")),+];

        pub(crate) use smr_status::*;
    };
}

statuses! {
    /// The call succeeded.
    SMR_OK = 0,
    /// A pointer is NULL.
    SMR_ERROR_NULL = 1,
    /// A pointer is not aligned for its type.
    SMR_ERROR_MISALIGNED = 2,
    /// The storage is smaller than #smr_target_size.
    SMR_ERROR_STORAGE_TOO_SMALL = 3,
    /// The workspace is smaller than #smr_workspace_size.
    SMR_ERROR_WORKSPACE_TOO_SMALL = 4,
    /// Storage and workspace overlap.
    SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE = 5,
    /// The tracker was not made by #smr_init, it or its workspace was moved or overwritten since, or the configuration
    /// was not filled by one of the calls smr_config_...
    SMR_ERROR_NOT_INITIALISED = 6,
    /// The call or the saved target belongs to the robust tracker but this is the paper's, or the reverse; or the saved
    /// target is one of the other size (#smr_config_small).
    SMR_ERROR_OTHER_METHOD = 7,
    /// No setting of this tracker has this name.
    SMR_ERROR_SETTING_UNKNOWN = 8,
    /// The number of values is wrong for the setting.
    SMR_ERROR_SETTING_COUNT = 9,
    /// `window_limit` is smaller than `window`.
    SMR_ERROR_LIMIT_BELOW_WINDOW = 10,
    /// A setting is outside its range, which is stated beside its field.
    SMR_ERROR_CONFIG_OUT_OF_RANGE = 11,
    /// Width or height of a part of the frame is 0.
    SMR_ERROR_FRAME_EMPTY = 12,
    /// The stride is smaller than the width.
    SMR_ERROR_STRIDE_TOO_SMALL = 13,
    /// `size` is less than (height - 1) * stride + width bytes.
    SMR_ERROR_FRAME_TOO_SHORT = 14,
    /// `size` is larger than any object can be (PTRDIFF_MAX).
    SMR_ERROR_MEMORY_TOO_LARGE = 15,
    /// A call's pixels or bytes overlap the tracker's storage or workspace, or a line overlaps its readout's pixels.
    SMR_ERROR_OVERLAPS_TRACKER = 16,
    /// A part of the frame reaches beyond the frame's edge.
    SMR_ERROR_OUTSIDE_FRAME = 17,
    /// The box has no pixels.
    SMR_ERROR_BOX_EMPTY = 18,
    /// The box reaches beyond the frame's edge.
    SMR_ERROR_BOX_OUTSIDE_FRAME = 19,
    /// The box has more than #SMR_PIXELS pixels. The robust tracker takes a box of any size.
    SMR_ERROR_BOX_TOO_LARGE = 20,
    /// The search window could grow to more than #SMR_SPAN offsets on an axis. Never from the robust tracker.
    SMR_ERROR_WINDOW_TOO_LARGE = 21,
    /// The parts in memory do not cover #smr_lock_window.
    SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY = 22,
    /// There is no target yet: call #smr_lock first.
    SMR_ERROR_NOT_LOCKED = 23,
    /// The frame's size differs from that at #smr_lock.
    SMR_ERROR_FRAME_SIZE_CHANGED = 24,
    /// The parts in memory do not cover #smr_windows.
    SMR_ERROR_WINDOW_NOT_IN_MEMORY = 25,
    /// Work remains: call #smr_update_step or #smr_lock_step again. Not an error.
    SMR_UNDER_WAY = 26,
    /// The memory for the result is too small.
    SMR_ERROR_BUFFER_TOO_SMALL = 27,
    /// The bytes are not a saved target.
    SMR_ERROR_NOT_SAVED = 28,
    /// The target was saved by another version of the library.
    SMR_ERROR_OTHER_VERSION = 29,
    /// The saved target ends too early.
    SMR_ERROR_TRUNCATED = 30,
    /// The bytes have changed since they were saved: the checksum is wrong.
    SMR_ERROR_DAMAGED = 31,
    /// The target was saved with another configuration, so answers would differ: #smr_other_setting names the setting.
    SMR_ERROR_OTHER_CONFIG = 32,
    /// The saved target is too large for this tracker.
    SMR_ERROR_SAVED_TOO_LARGE = 33,
    /// An error for which this interface has no number yet.
    SMR_ERROR_UNKNOWN = 34,
    /// The pixel format is NULL, or the frame is to be shrunk by another number than 1 to 4.
    SMR_ERROR_FORMAT_UNKNOWN = 35,
    /// The line arrived already, or a later line did.
    SMR_ERROR_LINE_OUT_OF_ORDER = 36,
    /// The line has fewer bytes than its format needs.
    SMR_ERROR_LINE_TOO_SHORT = 37,
    /// The sensor has no such line.
    SMR_ERROR_LINE_OUTSIDE_FRAME = 38,
    /// A line of a window is missing.
    SMR_ERROR_LINE_MISSING = 39,
    /// The configuration enables the refiner, but the library lacks it: core/c/install.sh --refiner builds it in.
    SMR_ERROR_REFINER_NOT_BUILT_IN = 40,
    /// `uncertain_below` is smaller than `lost_below`.
    SMR_ERROR_UNCERTAIN_BELOW_LOST = 41,
}

/// The name of a status, for logs: "SMR_OK" and so on.
///
/// @param status  Any number.
/// @return        A static string, never NULL; "SMR_ERROR_UNKNOWN" for a number that is no status.
#[unsafe(no_mangle)]
pub extern "C" fn smr_status_name(status: i32) -> *const c_char {
    // `status` is an integer, because C can pass any number, and a Rust enum must hold one of its variants.
    let known = usize::try_from(status).ok().and_then(|number| NAMES.get(number));
    known.map_or(c"SMR_ERROR_UNKNOWN".as_ptr(), |name| name.as_ptr().cast())
}

pub(crate) fn status_of(result: Result<(), smr_status>) -> smr_status {
    result.err().unwrap_or(SMR_OK)
}

macro_rules! statuses_of_errors {
    ($($error:ident { $($reason:ident => $status:ident),+ $(, ..$rest:tt)? })+) => {
        $(impl From<$error> for smr_status {
            fn from(error: $error) -> Self {
                match error {
                    $($error::$reason { .. } => $status,)+
                    $($rest => SMR_ERROR_UNKNOWN,)?
                }
            }
        })+
    };
}

statuses_of_errors! {
    ImageError {
        Empty => SMR_ERROR_FRAME_EMPTY,
        StrideTooSmall => SMR_ERROR_STRIDE_TOO_SMALL,
        SliceTooShort => SMR_ERROR_FRAME_TOO_SHORT, .._
    }
    FrameError { OutsideFrame => SMR_ERROR_OUTSIDE_FRAME, .._ }
    ReadoutError {
        WindowOutsideFrame => SMR_ERROR_OUTSIDE_FRAME,
        BufferTooSmall => SMR_ERROR_BUFFER_TOO_SMALL,
        LineOutOfOrder => SMR_ERROR_LINE_OUT_OF_ORDER,
        LineTooShort => SMR_ERROR_LINE_TOO_SHORT,
        LineOutsideFrame => SMR_ERROR_LINE_OUTSIDE_FRAME,
        LineMissing => SMR_ERROR_LINE_MISSING, .._
    }
    ConfigError {
        UnknownSetting => SMR_ERROR_SETTING_UNKNOWN,
        WrongCount => SMR_ERROR_SETTING_COUNT,
        LimitBelowWindow => SMR_ERROR_LIMIT_BELOW_WINDOW,
        UncertainBelowLost => SMR_ERROR_UNCERTAIN_BELOW_LOST,
        WindowTooLarge => SMR_ERROR_WINDOW_TOO_LARGE,
        OutOfRange => SMR_ERROR_CONFIG_OUT_OF_RANGE,
        RefinerNotBuiltIn => SMR_ERROR_REFINER_NOT_BUILT_IN, .._
    }
    LockError {
        BoxEmpty => SMR_ERROR_BOX_EMPTY,
        BoxOutsideFrame => SMR_ERROR_BOX_OUTSIDE_FRAME,
        BoxTooLarge => SMR_ERROR_BOX_TOO_LARGE,
        WindowTooLarge => SMR_ERROR_WINDOW_TOO_LARGE,
        LockWindowNotInMemory => SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY, .._
    }
    UpdateError {
        NotLocked => SMR_ERROR_NOT_LOCKED,
        FrameSizeChanged => SMR_ERROR_FRAME_SIZE_CHANGED,
        WindowNotInMemory => SMR_ERROR_WINDOW_NOT_IN_MEMORY, .._
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

/// The version of this header, major.minor.patch. A program can compare it with #smr_version.
pub const SMR_VERSION_MAJOR: u32 = 0;
/// See #SMR_VERSION_MAJOR.
pub const SMR_VERSION_MINOR: u32 = 1;
/// See #SMR_VERSION_MAJOR.
pub const SMR_VERSION_PATCH: u32 = 0;

/// The version of the linked library, as "major.minor.patch".
///
/// @return  A static string, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn smr_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };
    VERSION.as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn every_number_has_its_name() {
        for (number, (status, name, _)) in (0..).zip(STATUSES) {
            assert_eq!(*status as i32, number);
            // SAFETY: it returns a static string.
            let said = unsafe { CStr::from_ptr(smr_status_name(number)) };
            assert_eq!(said.to_bytes_with_nul(), name.as_bytes());
        }
        for unknown in [-1, 42, i32::MIN, i32::MAX] {
            // SAFETY: it returns a static string.
            assert_eq!(unsafe { CStr::from_ptr(smr_status_name(unknown)) }, c"SMR_ERROR_UNKNOWN");
        }
    }
    #[test]
    fn the_version_is_the_packages() {
        let version = format!("{SMR_VERSION_MAJOR}.{SMR_VERSION_MINOR}.{SMR_VERSION_PATCH}");
        assert_eq!(version, env!("CARGO_PKG_VERSION"));
        // SAFETY: it returns a static string.
        assert_eq!(unsafe { CStr::from_ptr(smr_version()) }.to_bytes(), version.as_bytes());
    }
}
