//! Memory for tests of kernels: reading or writing a byte before or after a slice ends the test.
//!
//! On Unix the slice touches a page that may not be accessed. Elsewhere, and under Miri, which checks every access
//! itself, the slice is a separate allocation.

/// The end of a slice that touches the forbidden page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Before,
    After,
}

#[cfg(all(unix, not(miri)))]
mod memory {
    use super::Side;
    use core::{ptr, slice};

    /// Pages that may be accessed, between two that may not.
    pub(in super::super) struct Guarded {
        first: *mut u8,
        page: usize,
        room: usize,
    }

    impl Guarded {
        pub(in super::super) fn with_room(bytes: usize) -> Self {
            // SAFETY: these calls touch nothing but the new mapping, whose inner pages alone are made accessible.
            unsafe {
                let page = usize::try_from(libc::sysconf(libc::_SC_PAGESIZE)).expect("pages have a size");
                let room = bytes.next_multiple_of(page).max(page);
                let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
                let all = libc::mmap(ptr::null_mut(), room + 2 * page, libc::PROT_NONE, flags, -1, 0);
                assert_ne!(all, libc::MAP_FAILED);
                let first = all.cast::<u8>().add(page);
                assert_eq!(libc::mprotect(first.cast(), room, libc::PROT_READ | libc::PROT_WRITE), 0);
                Self { first, page, room }
            }
        }

        /// `length` bytes that begin or end at a forbidden page.
        pub(in super::super) fn slice(&mut self, length: usize, side: Side) -> &mut [u8] {
            assert!(length <= self.room);
            let start = if side == Side::Before { 0 } else { self.room - length };
            // SAFETY: start + length is at most `room`; the bytes are initialised (zero), and borrowed as this is.
            unsafe { slice::from_raw_parts_mut(self.first.add(start), length) }
        }
    }

    impl Drop for Guarded {
        fn drop(&mut self) {
            // SAFETY: the mapping is unchanged, and nothing borrows it any more.
            unsafe { libc::munmap(self.first.sub(self.page).cast(), self.room + 2 * self.page) };
        }
    }
}

#[cfg(not(all(unix, not(miri))))]
mod memory {
    use super::Side;
    use std::vec::Vec;

    pub(in super::super) struct Guarded(Vec<u8>);

    impl Guarded {
        pub(in super::super) fn with_room(_: usize) -> Self {
            Self(Vec::new())
        }

        pub(in super::super) fn slice(&mut self, length: usize, _: Side) -> &mut [u8] {
            self.0 = std::vec![0; length];
            &mut self.0
        }
    }
}

pub(super) use memory::Guarded;

impl Guarded {
    /// A copy of `bytes` whose end `side` touches a forbidden page.
    pub(super) fn copy(&mut self, bytes: &[u8], side: Side) -> &[u8] {
        let slice = self.slice(bytes.len(), side);
        slice.copy_from_slice(bytes);
        slice
    }

    /// The same for numbers with a sign.
    pub(super) fn copy_signed(&mut self, numbers: &[i8], side: Side) -> &[i8] {
        let slice = self.slice(numbers.len(), side);
        slice.iter_mut().zip(numbers).for_each(|(to, number)| *to = number.cast_unsigned());
        // SAFETY: an i8 is as large and as aligned as a u8, and all values are valid.
        unsafe { core::slice::from_raw_parts(slice.as_ptr().cast(), slice.len()) }
    }
}
