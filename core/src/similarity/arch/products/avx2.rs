//! Sums of products by AVX2: the plain loops, of which the compiler makes eight products an instruction where it may.

use crate::similarity::products::{self, Layout};

/// See [`products::responses`].
#[target_feature(enable = "avx2")]
pub(super) fn responses<const N: usize>(cells: &[i8], layout: Layout, weights: &[i16], out: &mut [[i32; N]]) {
    products::responses(cells, layout, weights, out);
}

/// See [`products::gather`].
#[target_feature(enable = "avx2")]
pub(super) fn gather<const N: usize>(cells: &[i8], layout: Layout, errors: &[[i16; N]], sums: &mut [i32]) {
    products::gather(cells, layout, errors, sums);
}
