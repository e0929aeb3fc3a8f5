//! Sums over the gray levels of a row, and the replacement of a row. They serve the contrast of a patch and the update
//! of a template.

use super::backend::native;
use super::one::MAX_PIXELS;

/// The sum of the differences of `pixels` from `level`, and the number of pixels at 0 or 255. The sum fits for at most
/// 65537 pixels.
#[inline(never)]
pub(crate) fn deviation(pixels: &[u8], level: u8) -> [u32; 2] {
    debug_assert!(pixels.len() <= MAX_PIXELS);
    native::levels::deviation(pixels, level)
}

/// Replaces `old` by `new`, which has the same length. Returns the largest of `largest` and the differences of the
/// pixels.
#[inline(never)] // keeps its registers out of its caller
pub(crate) fn replace(old: &mut [u8], new: &[u8], largest: u8) -> u8 {
    debug_assert_eq!(old.len(), new.len());
    native::levels::replace(old, new, largest)
}
