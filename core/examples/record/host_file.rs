//! A file on the debugger's host. Unlike the type in the crate `semihosting`, it has no assertions, so it cannot panic.

#![allow(unsafe_code)] // semihosting calls take addresses

use core::ffi::CStr;
use semihosting::fd::RawFd;
use semihosting::sys::arm_compat::OpenMode;
use semihosting::sys::arm_compat::syscall::{OperationNumber, ParamRegR, ParamRegW, syscall, syscall_readonly};

/// An open file. The host closes it when the firmware ends.
pub struct HostFile(RawFd);

impl HostFile {
    /// Opens a file for reading; `None` if there is none.
    pub fn open(path: &CStr) -> Option<Self> {
        Self::with_mode(path, OpenMode::RDONLY_BINARY)
    }

    /// Creates an empty file for writing; `None` if that fails.
    pub fn create(path: &CStr) -> Option<Self> {
        Self::with_mode(path, OpenMode::WRONLY_TRUNC_BINARY)
    }

    fn with_mode(path: &CStr, mode: OpenMode) -> Option<Self> {
        let length = path.count_bytes();
        let block = [ParamRegR::c_str(path), ParamRegR::usize(mode as usize), ParamRegR::usize(length)];
        // SAFETY: SYS_OPEN takes a zero-terminated string, its length and a mode, and keeps no pointer.
        unsafe { syscall_readonly(OperationNumber::SYS_OPEN, ParamRegR::block(&block)) }.raw_fd().map(Self)
    }

    /// Reads `bytes` from offset `start` on; `None` if the file is too short.
    pub fn read(&mut self, start: u64, bytes: &mut [u8]) -> Option<()> {
        let place = [ParamRegR::raw_fd(self.0), ParamRegR::usize(usize::try_from(start).ok()?)];
        // SAFETY: SYS_SEEK takes a file and a position.
        let failed = unsafe { syscall_readonly(OperationNumber::SYS_SEEK, ParamRegR::block(&place)) }.usize();
        let length = bytes.len();
        let mut block = [ParamRegW::raw_fd(self.0), ParamRegW::buf(bytes), ParamRegW::usize(length)];
        // SAFETY: SYS_READ takes a file, memory that is borrowed mutably, and its length.
        let missing = unsafe { syscall(OperationNumber::SYS_READ, ParamRegW::block(&mut block)) }.usize();
        (failed == 0 && missing == 0).then_some(())
    }

    pub fn write(&mut self, bytes: &[u8]) -> Option<()> {
        let block = [ParamRegR::raw_fd(self.0), ParamRegR::buf(bytes), ParamRegR::usize(bytes.len())];
        // SAFETY: SYS_WRITE takes a file, memory to read from, and its length.
        let missing = unsafe { syscall_readonly(OperationNumber::SYS_WRITE, ParamRegR::block(&block)) }.usize();
        (missing == 0).then_some(())
    }
}
