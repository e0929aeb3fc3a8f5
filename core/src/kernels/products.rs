//! Sums of products by a backend: filter responses, the gradient of the filter's error, and layers of a small network.
//!
//! The DSP extension multiplies two pairs of numbers in an instruction, Helium and SIMD128 eight or more. Other
//! processors share loads among several offsets. There, and with the DSP extension, responses and gradients need a
//! fifth fewer multiplications (`three_sums.rs`). The plain loops are compiled with the instructions of AVX2. SSSE3 and
//! NEON use the plain loops, and SIMD128 the plain loop of layers; the compiler vectorizes them.

use super::backend::{Backend, by_backend};
use super::layout::{Layout, Packed};
#[cfg(feature = "refiner")]
use super::plain::dense as plain;
use core::ops::Range;

/// Filter responses and gradients by a backend. All backends return the same integers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Products(Backend);

impl Products {
    /// Selects `backend`, or the plain loops if the machine does not support it.
    pub(crate) fn new(backend: Backend) -> Self {
        Self(backend.or_scalar())
    }

    /// Number of pieces of work of [`Products::responses`]. A piece takes up to 34 multiplications for each weight.
    pub(crate) fn pieces(self, layout: Layout, weights: usize) -> usize {
        if self.takes_rows_of_cells() { layout.rows(weights).div_ceil(2) } else { layout.span }
    }

    /// Number of multiplications in a piece of [`Products::responses`].
    #[cfg_attr(smr_small, inline(never))]
    pub(crate) fn work(self, piece: usize, layout: Layout, weights: usize) -> usize {
        if self.takes_rows_of_cells() {
            (2 * piece..2 * piece + 2).map(|row| layout.work_on(row, weights)).sum()
        } else {
            layout.span * weights
        }
    }

    /// True if pieces of work are pairs of rows of cells, false if they are rows of offsets.
    fn takes_rows_of_cells(self) -> bool {
        by_backend!(self.0, set => set::products::TAKES_ROWS_OF_CELLS)
    }

    /// Number of multiplications in a piece of [`Products::gather`].
    pub(crate) fn gather_work(self, piece: usize, layout: Layout, weights: usize) -> usize {
        by_backend!(self.0, set => match set::products::GATHER_PIECES {
            Some(pieces) => layout.span * layout.span * weights / pieces,
            None => self.work(piece, layout, weights),
        })
    }

    pub(crate) fn gather_pieces(self, layout: Layout, weights: usize) -> usize {
        by_backend!(self.0, set => set::products::GATHER_PIECES.unwrap_or_else(|| self.pieces(layout, weights)))
    }

    /// Computes the filter responses of some pieces of work, as [`plain::responses`](super::plain::products::responses)
    /// specifies. Pieces must follow in order, with `room` and `spare` (scratch memory) unchanged in between. If
    /// `spare` is shorter than the weights, a slower loop may run.
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
        #[allow(unused_unsafe)] // most sets need no check
        // SAFETY: `new` has checked that the machine has the instruction set.
        unsafe {
            by_backend!(self.0, set => set::products::responses(pieces, room, spare, cells, layout, weights, out));
        }
    }

    /// Adds the gradient of the filter's error, as [`plain::gather`](super::plain::products::gather) specifies. Pieces
    /// and memory: see [`Products::responses`]. Full speed requires a `spare` of seven more elements than filter cells.
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
        #[allow(unused_unsafe)]
        // SAFETY: `new` has checked that the machine has the instruction set.
        unsafe {
            by_backend!(self.0, set => set::products::gather(pieces, room, spare, cells, layout, errors, sums));
        }
    }
}

/// Bytes of scratch memory for [`Dense::outputs`] at full speed: the DSP extension unpacks two patches of up to 216
/// inputs each to 16-bit numbers, aligned to 4 bytes. With less memory it computes one patch at a time.
#[cfg(feature = "refiner")]
pub(crate) const SPARE: usize = 4 * 216 + 3;

/// Layers of a small network by a backend. All backends return the same integers.
#[cfg(feature = "refiner")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dense(Backend);

#[cfg(feature = "refiner")]
impl Dense {
    pub(crate) fn new(backend: Backend) -> Self {
        Self(backend.or_scalar())
    }

    /// Computes the outputs of a layer, as [`plain::outputs`] specifies. A patch is `layer.inputs` numbers in
    /// `patches`, and its outputs follow each other in `out`. `spare` is scratch memory of [`SPARE`] bytes.
    #[inline(never)]
    pub(crate) fn outputs(self, layer: plain::Layer<'_>, patches: &[i8], spare: &mut [i8], out: &mut [i8]) {
        #[allow(unused_unsafe)] // most sets need no check
        // SAFETY: `new` has checked that the machine has the instruction set.
        unsafe {
            by_backend!(self.0, set => set::dense::outputs(layer, patches, spare, out));
        }
    }

    /// The sum of each output for one patch, before the shift. Always uses the plain loop, because only the small last
    /// layer needs these sums.
    pub(crate) fn sums<const N: usize>(layer: plain::Layer<'_>, patch: &[i8]) -> [i32; N] {
        core::array::from_fn(|output| plain::sum(layer, output, patch))
    }
}
