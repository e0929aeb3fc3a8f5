//! Sums of products, the responses of a filter and the gradient of its error: chooses the loops of a backend.
//!
//! The DSP extension multiplies two pairs of numbers in an instruction, Helium and SIMD128 eight. Without them several
//! offsets share loads. In that case and with the DSP extension, responses take a fifth fewer products
//! (`three_sums.rs`). For AVX2 the plain loops are compiled with its instructions. SSE2 and NEON use them as they are;
//! the compiler vectorizes them.

#[cfg(smr_dsp)]
use super::arm::dsp::products as dsp;
#[cfg(smr_helium)]
use super::arm::helium::products as helium;
use super::backend::Backend;
use super::layout::{Layout, Packed};
use super::plain::products as plain;
#[cfg(not(any(smr_dsp, smr_helium)))]
use super::swar::products as swar;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
use super::wasm32::simd128::products as simd128;
#[cfg(target_arch = "x86_64")]
use super::x86::avx2::products as avx2;
use core::ops::Range;

/// Sums of products by a backend. All backends give the same integers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Products(Backend);

impl Products {
    /// The sums by `backend`, or by the plain loops if the machine does not have it.
    pub(crate) fn new(backend: Backend) -> Self {
        Self(if backend.is_available() { backend } else { Backend::Scalar })
    }

    /// The number of parts of [`Products::responses`]. Each backend has its own parts. A part has at most 34 products
    /// for each weight.
    pub(crate) fn parts(self, layout: Layout, weights: usize) -> usize {
        if self.takes_rows_of_cells() { layout.rows(weights).div_ceil(2) } else { layout.span }
    }

    /// Products in part `part` of the responses.
    #[cfg_attr(smr_small, inline(never))]
    pub(crate) fn work(self, part: usize, layout: Layout, weights: usize) -> usize {
        if self.takes_rows_of_cells() {
            (2 * part..2 * part + 2).map(|row| layout.work_on(row, weights)).sum()
        } else {
            layout.span * weights
        }
    }

    /// True if a part of the responses is two rows of cells. Else it is a row of offsets.
    fn takes_rows_of_cells(self) -> bool {
        match self.0 {
            #[cfg(smr_dsp)]
            Backend::Dsp => true,
            #[cfg(not(any(smr_dsp, smr_helium)))]
            Backend::Swar => true,
            _ => false,
        }
    }

    /// Products in part `part` of [`Products::gather`].
    pub(crate) fn gather_work(self, part: usize, layout: Layout, weights: usize) -> usize {
        match self.0 {
            #[cfg(smr_dsp)]
            Backend::Dsp => layout.span * layout.span * weights / dsp::GATHER_PARTS,
            #[cfg(smr_helium)]
            Backend::Helium => layout.span * layout.span * weights / helium::GATHER_PARTS,
            _ => self.work(part, layout, weights),
        }
    }

    /// The number of parts of [`Products::gather`].
    pub(crate) fn gather_parts(self, layout: Layout, weights: usize) -> usize {
        match self.0 {
            #[cfg(smr_dsp)]
            Backend::Dsp => dsp::GATHER_PARTS,
            #[cfg(smr_helium)]
            Backend::Helium => helium::GATHER_PARTS,
            _ => self.parts(layout, weights),
        }
    }

    /// Computes the parts `parts` of [`plain::responses`]. The caller asks for them in order. `room` and `spare` are
    /// scratch memory, which the caller leaves as it is from one part to the next. `spare` should be as long as the
    /// weights: with less, a slower loop may run.
    #[inline(never)] // one copy in flash for each span
    #[cfg_attr(smr_helium, allow(unused))]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn responses<const N: usize>(
        self,
        parts: Range<usize>,
        room: &mut Packed,
        spare: &mut [i32],
        cells: &[i8],
        layout: Layout,
        weights: &[i16],
        out: &mut [[i32; N]],
    ) {
        #[cfg(any(test, feature = "verify"))]
        let last = parts.end >= self.parts(layout, weights.len());
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `new` has checked that the machine has AVX2.
            Backend::Avx2 => unsafe { avx2::responses(parts, cells, layout, weights, out) },
            #[cfg(smr_dsp)]
            Backend::Dsp => dsp::responses(parts, room, spare, cells, layout, weights, out),
            #[cfg(smr_helium)]
            Backend::Helium => helium::responses(parts, cells, layout, weights, out),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Backend::Simd128 => simd128::responses(parts, cells, layout, weights, out),
            #[cfg(not(any(smr_dsp, smr_helium)))]
            Backend::Swar => swar::responses(parts, room, spare, cells, layout, weights, out),
            _ => plain::responses(parts, cells, layout, weights, out),
        }
        #[cfg(any(test, feature = "verify"))]
        if last {
            let mut expected = [[0; N]; N];
            plain::responses(0..layout.span, cells, layout, weights, &mut expected);
            for (given, expected) in out.iter().zip(&expected).take(layout.span) {
                let row = ..layout.span.min(N);
                assert_eq!(given.get(row), expected.get(row), "responses, given and expected");
            }
        }
    }

    /// Computes the parts `parts` of [`plain::gather`]. The caller asks for them in order. `room` and `spare` are
    /// scratch memory, which the caller leaves as it is from one part to the next. `spare` should have a number for
    /// each cell of the filter and seven more: with less, a slower loop may run.
    #[inline(never)]
    #[cfg_attr(not(any(smr_dsp, smr_helium)), allow(unused))]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn gather<const N: usize>(
        self,
        parts: Range<usize>,
        room: &mut Packed,
        spare: &mut [i32],
        cells: &[i8],
        layout: Layout,
        errors: &[[i16; N]],
        sums: &mut [i32],
    ) {
        // Backends have different parts, so only a call for all parts can be compared.
        #[cfg(any(test, feature = "verify"))]
        let whole = parts == (0..self.gather_parts(layout, sums.len()));
        #[cfg(any(test, feature = "verify"))]
        let mut expected: heapless::Vec<i32, 4096> = sums.iter().copied().collect();
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `new` has checked that the machine has AVX2.
            Backend::Avx2 => unsafe { avx2::gather(parts, cells, layout, errors, sums) },
            #[cfg(smr_dsp)]
            Backend::Dsp => dsp::gather(parts, room, spare, cells, layout, errors, sums),
            #[cfg(smr_helium)]
            Backend::Helium => helium::gather(parts, room, spare, cells, layout, errors, sums),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Backend::Simd128 => simd128::gather(parts, cells, layout, errors, sums),
            #[cfg(not(any(smr_dsp, smr_helium)))]
            Backend::Swar => swar::gather(parts, room, cells, layout, errors, sums),
            _ => plain::gather(parts, cells, layout, errors, sums),
        }
        #[cfg(any(test, feature = "verify"))]
        if whole {
            plain::gather(0..layout.span, cells, layout, errors, &mut expected);
            assert_eq!(sums, &*expected, "gathered errors, given and expected");
        }
    }
}
