//! A file of the debugger's host. `semihosting` has one too, but it asserts; this one cannot panic.

#![allow(unsafe_code)] // calls to the debugger's host take addresses

use core::ffi::CStr;
use semihosting::fd::RawFd;
use semihosting::sys::arm_compat::OpenMode;
use semihosting::sys::arm_compat::syscall::{OperationNumber, ParamRegR, ParamRegW, syscall, syscall_readonly};

/// Stays open: whatever ends the firmware closes it.
pub struct HostFile(RawFd);

impl HostFile {
    /// To be read; `None` if it is not there.
    pub fn open(path: &CStr) -> Option<Self> {
        Self::with_mode(path, OpenMode::RDONLY_BINARY)
    }

    /// Empty, to be written; `None` if it cannot be.
    pub fn create(path: &CStr) -> Option<Self> {
        Self::with_mode(path, OpenMode::WRONLY_TRUNC_BINARY)
    }

    fn with_mode(path: &CStr, mode: OpenMode) -> Option<Self> {
        let length = path.count_bytes();
        let block = [ParamRegR::c_str(path), ParamRegR::usize(mode as usize), ParamRegR::usize(length)];
        // SAFETY: SYS_OPEN takes a string that ends with a zero, its length and a mode, and keeps none of them.
        unsafe { syscall_readonly(OperationNumber::SYS_OPEN, ParamRegR::block(&block)) }.raw_fd().map(Self)
    }

    /// Fills `bytes` from position `start` on; `None` if the file has not as many.
    pub fn read(&mut self, start: u64, bytes: &mut [u8]) -> Option<()> {
        let place = [ParamRegR::raw_fd(self.0), ParamRegR::usize(usize::try_from(start).ok()?)];
        // SAFETY: SYS_SEEK takes a file and a position.
        let failed = unsafe { syscall_readonly(OperationNumber::SYS_SEEK, ParamRegR::block(&place)) }.usize();
        let length = bytes.len();
        let mut block = [ParamRegW::raw_fd(self.0), ParamRegW::buf(bytes), ParamRegW::usize(length)];
        // SAFETY: SYS_READ takes a file, memory that is borrowed for it alone, and its length.
        let missing = unsafe { syscall(OperationNumber::SYS_READ, ParamRegW::block(&mut block)) }.usize();
        (failed == 0 && missing == 0).then_some(())
    }

    /// Writes `bytes` at the end.
    pub fn write(&mut self, bytes: &[u8]) -> Option<()> {
        let block = [ParamRegR::raw_fd(self.0), ParamRegR::buf(bytes), ParamRegR::usize(bytes.len())];
        // SAFETY: SYS_WRITE takes a file, memory to read from, and its length.
        let missing = unsafe { syscall_readonly(OperationNumber::SYS_WRITE, ParamRegR::block(&block)) }.usize();
        (missing == 0).then_some(())
    }
}
