//! How much a robust tracker holds, and the storage which that takes.

use super::tracker::smr_robust_tracker;

/// `SMR_ROBUST_PIXELS` of the header.
pub(super) const PIXELS: usize = 1024;

/// `SMR_ROBUST_WINDOW` of the header.
pub(super) const WINDOW: usize = 12288;

/// `SMR_ROBUST_TRACKER_SIZE` of the header: two bytes a pixel of the window, nine a pixel of the template, 1940 for what the
/// search keeps of its offsets, and what the fixed fields take with some to spare.
pub const ROBUST_STORAGE_SIZE: usize = 2 * WINDOW + 9 * PIXELS + 1940 + size_of::<[usize; 32]>() + 148;

/// `SMR_ROBUST_TRACKER_ALIGN` of the header.
pub const ROBUST_STORAGE_ALIGN: usize = 8;

// The header promises both to C, on every target; and it shall not promise much more than is used.
const _: () = assert!(align_of::<smr_robust_tracker>() <= ROBUST_STORAGE_ALIGN);
const _: () = assert!(ROBUST_STORAGE_SIZE.is_multiple_of(ROBUST_STORAGE_ALIGN));
const _: () = assert!(size_of::<smr_robust_tracker>() <= ROBUST_STORAGE_SIZE);
const _: () = assert!(ROBUST_STORAGE_SIZE - size_of::<smr_robust_tracker>() <= 64);
