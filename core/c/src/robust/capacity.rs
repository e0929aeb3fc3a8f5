//! The storage that a robust tracker takes.

use super::tracker::smr_robust_tracker;

/// `SMR_ROBUST_TRACKER_SIZE` of the header: what its scratch memory, its filter and its templates take, and some to spare.
pub const ROBUST_STORAGE_SIZE: usize = 46592 + size_of::<[usize; 22]>();

/// `SMR_ROBUST_TRACKER_ALIGN` of the header.
pub const ROBUST_STORAGE_ALIGN: usize = 8;

// The header promises both to C, on every target; and it shall not promise much more than is used.
const _: () = assert!(align_of::<smr_robust_tracker>() <= ROBUST_STORAGE_ALIGN);
const _: () = assert!(ROBUST_STORAGE_SIZE.is_multiple_of(ROBUST_STORAGE_ALIGN));
const _: () = assert!(size_of::<smr_robust_tracker>() <= ROBUST_STORAGE_SIZE);
const _: () = assert!(ROBUST_STORAGE_SIZE - size_of::<smr_robust_tracker>() <= 64);
