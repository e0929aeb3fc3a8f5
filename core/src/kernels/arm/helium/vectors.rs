//! Vectors of 16 pixels, in which Helium computes.

use crate::kernels::rows::Rows;

/// Pixels in a vector.
pub(super) const LANES: usize = 16;

/// Bytes from the end of the last vector of a row to the next row, in the patch and in the template. A vector has
/// `lanes` pixels.
#[inline(always)]
pub(super) fn strides(pair: &Rows, lanes: usize) -> [usize; 2] {
    let read = pair.width.next_multiple_of(lanes);
    [pair.patch_stride, pair.template_stride].map(|stride| stride.wrapping_sub(read))
}
