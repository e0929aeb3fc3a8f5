//! A layer of a small network by AVX2: the plain loop, compiled with its instructions.

use crate::kernels::plain::dense as plain;

/// See [`plain::outputs`].
#[target_feature(enable = "avx2")]
pub(crate) fn outputs(layer: plain::Layer<'_>, patches: &[i8], _: &mut [i8], out: &mut [i8]) {
    plain::outputs_inline(layer, patches, out);
}
