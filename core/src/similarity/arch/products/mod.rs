//! Sums of products, faster: the loops of `similarity/products.rs`, which specify them.
//!
//! | file | backends |
//! |---|---|
//! | `avx2.rs` | AVX2 and AVX-512: the plain loops, compiled for AVX2 |
//! | `dsp.rs` | the DSP extension: two products an instruction |
//! | (`similarity/products.rs`) | all others: compilers make SSE2, NEON and Helium of the plain loops |

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(smr_dsp)]
mod dsp;
#[cfg(test)]
mod tests;

use super::Backend;
use crate::similarity::products::{Layout, gather, responses};

/// How sums of products are computed. All ways give the same integers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Products(Backend);

impl Products {
    /// By `backend`; by the plain loops where the machine does not have it.
    pub(crate) fn new(backend: Backend) -> Self {
        Self(if backend.is_available() { backend } else { Backend::Scalar })
    }

    /// See [`responses`].
    #[inline(never)] // one copy in flash for each span
    pub(crate) fn responses<const N: usize>(
        self,
        cells: &[i8],
        layout: Layout,
        weights: &[i16],
        out: &mut [[i32; N]],
    ) {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `new` has seen that the machine has it; one that has AVX-512 has AVX2.
            Backend::Avx2 | Backend::Avx512 => unsafe { avx2::responses(cells, layout, weights, out) },
            #[cfg(smr_dsp)]
            Backend::Dsp => dsp::responses(cells, layout, weights, out),
            _ => responses(cells, layout, weights, out),
        }
        #[cfg(feature = "verify")]
        {
            let mut expected = [[0; N]; N];
            responses(cells, layout, weights, &mut expected);
            for (given, expected) in out.iter().zip(&expected).take(layout.span) {
                let row = ..layout.span.min(N);
                assert_eq!(given.get(row), expected.get(row), "responses, given and expected");
            }
        }
    }

    /// See [`gather`].
    #[inline(never)] // one copy in flash
    pub(crate) fn gather<const N: usize>(
        self,
        cells: &[i8],
        layout: Layout,
        errors: &[[i16; N]],
        sums: &mut [i32],
    ) {
        #[cfg(feature = "verify")]
        let mut expected: heapless::Vec<i32, 4096> = sums.iter().copied().collect();
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `new` has seen that the machine has it; one that has AVX-512 has AVX2.
            Backend::Avx2 | Backend::Avx512 => unsafe { avx2::gather(cells, layout, errors, sums) },
            #[cfg(smr_dsp)]
            Backend::Dsp => dsp::gather(cells, layout, errors, sums),
            _ => gather(cells, layout, errors, sums),
        }
        #[cfg(feature = "verify")]
        {
            gather(cells, layout, errors, &mut expected);
            assert_eq!(sums, &*expected, "gathered errors, given and expected");
        }
    }
}
