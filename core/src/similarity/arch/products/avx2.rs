//! Sums of products by AVX2: the plain loops, of which the compiler makes eight products an instruction where it may.

use crate::similarity::products::{self, Layout};
use core::ops::Range;

/// See [`products::responses`].
#[target_feature(enable = "avx2")]
pub(super) fn responses<const N: usize>(
    parts: Range<usize>,
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    products::responses(parts, cells, layout, weights, out);
}

/// See [`products::gather`].
#[target_feature(enable = "avx2")]
pub(super) fn gather<const N: usize>(
    parts: Range<usize>,
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    products::gather(parts, cells, layout, errors, sums);
}
