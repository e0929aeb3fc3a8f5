//! Sums of products by AVX2: the plain loops, compiled with its instructions, which compute eight products each.

use crate::kernels::layout::{Layout, Packed};
use crate::kernels::plain::products as plain;
use core::ops::Range;

pub(crate) use plain::{GATHER_PIECES, TAKES_ROWS_OF_CELLS};

/// See [`plain::responses`].
#[target_feature(enable = "avx2")]
pub(crate) fn responses<const N: usize>(
    pieces: Range<usize>,
    _: &mut Packed,
    _: &mut [i32],
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    plain::responses_inline(pieces, cells, layout, weights, out);
}

/// See [`plain::gather`].
#[target_feature(enable = "avx2")]
pub(crate) fn gather<const N: usize>(
    pieces: Range<usize>,
    _: &mut Packed,
    _: &mut [i32],
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    plain::gather_inline(pieces, cells, layout, errors, sums);
}
