//! The version of the header and of the library.

use core::ffi::{CStr, c_char};

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
    fn the_version_is_the_packages() {
        let version = format!("{SMR_VERSION_MAJOR}.{SMR_VERSION_MINOR}.{SMR_VERSION_PATCH}");
        assert_eq!(version, env!("CARGO_PKG_VERSION"));
        // SAFETY: it returns a static string.
        assert_eq!(unsafe { CStr::from_ptr(smr_version()) }.to_bytes(), version.as_bytes());
    }
}
