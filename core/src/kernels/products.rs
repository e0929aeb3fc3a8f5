//! Sums of products: the responses of a filter, the gradient of its error, and the layers of a small network. Chooses the
//! loops of a backend.
//!
//! The DSP extension multiplies two pairs of numbers in an instruction, Helium and SIMD128 eight or more. Without them
//! several offsets share loads. In that case and with the DSP extension, responses and gradients take a fifth fewer
//! products (`three_sums.rs`). For AVX2 the plain loops are compiled with its instructions. SSSE3 and NEON use the
//! plain loops, and SIMD128 the plain loop of layers; the compiler vectorizes them.

use super::backend::{Backend, by_backend};
use super::layout::{Layout, Packed};
#[cfg(feature = "refiner")]
use super::plain::dense as plain;
use core::ops::Range;

/// Sums of products by a backend. All backends give the same integers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Products(Backend);

impl Products {
    /// The sums by `backend`, or by the plain loops if the machine does not have it.
    pub(crate) fn new(backend: Backend) -> Self {
        Self(backend.or_scalar())
    }

    /// The number of pieces of [`Products::responses`]. Each backend has its own pieces. A piece has at most 34 products
    /// for each weight.
    pub(crate) fn pieces(self, layout: Layout, weights: usize) -> usize {
        if self.takes_rows_of_cells() { layout.rows(weights).div_ceil(2) } else { layout.span }
    }

    /// Products in a piece of the responses.
    #[cfg_attr(smr_small, inline(never))]
    pub(crate) fn work(self, piece: usize, layout: Layout, weights: usize) -> usize {
        if self.takes_rows_of_cells() {
            (2 * piece..2 * piece + 2).map(|row| layout.work_on(row, weights)).sum()
        } else {
            layout.span * weights
        }
    }

    /// True if a piece of the responses is two rows of cells. Else it is a row of offsets.
    fn takes_rows_of_cells(self) -> bool {
        by_backend!(self.0, set => set::products::TAKES_ROWS_OF_CELLS)
    }

    /// Products in a piece of [`Products::gather`].
    pub(crate) fn gather_work(self, piece: usize, layout: Layout, weights: usize) -> usize {
        by_backend!(self.0, set => match set::products::GATHER_PIECES {
            Some(pieces) => layout.span * layout.span * weights / pieces,
            None => self.work(piece, layout, weights),
        })
    }

    /// The number of pieces of [`Products::gather`].
    pub(crate) fn gather_pieces(self, layout: Layout, weights: usize) -> usize {
        by_backend!(self.0, set => set::products::GATHER_PIECES.unwrap_or_else(|| self.pieces(layout, weights)))
    }

    /// Computes these pieces of [`plain::responses`](super::plain::products::responses). The caller asks for them
    /// in order. `room` and `spare` are scratch memory, which the caller leaves as it is from one piece to the next.
    /// `spare` should be as long as the weights: with less, a slower loop may run.
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn responses<const N: usize>(
        self,
        pieces: Range<usize>,
        room: &mut Packed,
        spare: &mut [i32],
        cells: &[i8],
        layout: Layout,
        weights: &[i16],
        out: &mut [[i32; N]],
    ) {
        debug_assert!(layout.span <= N);
        // SAFETY: `new` has checked that the machine has the instruction set.
        #[allow(unused_unsafe)] // most sets need no check
        unsafe {
            by_backend!(self.0, set => set::products::responses(pieces, room, spare, cells, layout, weights, out));
        }
    }

    /// Computes these pieces of [`plain::gather`](super::plain::products::gather). The caller asks for them in
    /// order. `room` and `spare` are scratch memory, which the caller leaves as it is from one piece to the next.
    /// `spare` should have a number for each cell of the filter and seven more: with less, a slower loop may run.
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn gather<const N: usize>(
        self,
        pieces: Range<usize>,
        room: &mut Packed,
        spare: &mut [i32],
        cells: &[i8],
        layout: Layout,
        errors: &[[i16; N]],
        sums: &mut [i32],
    ) {
        debug_assert!(layout.span <= N);
        // SAFETY: `new` has checked that the machine has the instruction set.
        #[allow(unused_unsafe)]
        unsafe {
            by_backend!(self.0, set => set::products::gather(pieces, room, spare, cells, layout, errors, sums));
        }
    }
}

/// Bytes of scratch memory with which every backend is fastest: the DSP extension unpacks two patches of up to 216
/// inputs to words. With less memory it takes one patch at a time.
#[cfg(feature = "refiner")]
pub(crate) const SPARE: usize = 4 * 216 + 3;

/// Layers of a small network by a backend. All backends give the same integers.
#[cfg(feature = "refiner")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dense(Backend);

#[cfg(feature = "refiner")]
impl Dense {
    /// The layers by `backend`, or by the plain loop if the machine does not have it.
    pub(crate) fn new(backend: Backend) -> Self {
        Self(backend.or_scalar())
    }

    /// See [`plain::outputs`]. `patches` has `layer.inputs` numbers for each patch, `out` one for each of its outputs.
    /// `spare` is scratch memory: see [`SPARE`].
    #[inline(never)]
    pub(crate) fn outputs(self, layer: plain::Layer<'_>, patches: &[i8], spare: &mut [i8], out: &mut [i8]) {
        // SAFETY: `new` has checked that the machine has the instruction set.
        #[allow(unused_unsafe)] // most sets need no check
        unsafe {
            by_backend!(self.0, set => set::dense::outputs(layer, patches, spare, out));
        }
    }

    /// The sums of one patch, before the shift. It serves the last layer, which is small, and always uses the plain
    /// loop.
    pub(crate) fn sums<const N: usize>(layer: plain::Layer<'_>, patch: &[i8]) -> [i32; N] {
        core::array::from_fn(|output| plain::sum(layer, output, patch))
    }
}
