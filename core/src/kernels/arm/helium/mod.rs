//! Helium, the vectors of Armv8.1-M (Cortex-M52, M55, M85): 16 pixels in a vector, by assembly.

mod bounds;
#[cfg(feature = "refiner")]
pub(crate) mod dense;
pub(crate) mod gradients;
pub(crate) mod levels;
pub(crate) mod products;
pub(crate) mod scores;
pub(crate) mod weights;

use crate::kernels::rows::Rows;

const LANES: usize = 16;

/// Byte offsets of a channel in eight neighbouring cells.
static CELLS: [u16; 8] = [0, 10, 20, 30, 40, 50, 60, 70];

/// Bytes from the end of a row's last vector of `lanes` pixels to the next row, in the patch and in the template.
#[inline(always)]
fn strides(pair: &Rows, lanes: usize) -> [usize; 2] {
    let read = pair.width.next_multiple_of(lanes);
    [pair.patch_stride, pair.template_stride].map(|stride| stride.wrapping_sub(read))
}
