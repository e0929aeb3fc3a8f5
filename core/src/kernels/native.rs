//! Kernels selected at compile time, not by a [`Backend`](super::Backend): bilinear sampling of rows, cells of gradient
//! orientations (HOG, Dalal and Triggs), gray levels, and the weights of a filter.

use super::backend::native;
use super::layout::{CELL, CHANNELS, SIDE};
use super::plain::levels::{LEFT_SAMPLES, MixedRow, SampleWeights};
use super::scores::MAX_PIXELS;
use heapless::Vec;

/// Bilinear sampling positions of up to `N` output columns in a row.
pub(crate) struct Interpolation<const N: usize> {
    /// For each column, the byte offset of its left sample in the row.
    from: Vec<u16, N>,
    parts: Vec<SampleWeights, N>,
}

impl<const N: usize> Interpolation<N> {
    /// Number of indices that a left sample can have in a row: 0 to 511.
    pub(crate) const LEFT_SAMPLES: usize = LEFT_SAMPLES as usize;

    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { from: Vec::new(), parts: Vec::new() }
    }

    pub(crate) fn clear(&mut self) {
        self.from.clear();
        self.parts.clear();
    }

    pub(crate) fn count(&self) -> usize {
        self.from.len()
    }

    /// Appends a column sampled at index `place + part / 256`. Does nothing if there are `N` columns already.
    pub(crate) fn push(&mut self, place: u16, part: u8) {
        let _ = self.from.push(2 * (place % LEFT_SAMPLES));
        let _ = self.parts.push(SampleWeights([256 - u16::from(part), part.into()]));
    }

    /// Samples `row` at the columns: writes rounded gray levels, up to the length of `out`.
    #[inline(always)]
    pub(crate) fn mix(&self, row: &MixedRow, out: &mut [u8]) {
        let Self { from, parts } = self;
        #[allow(unused_unsafe)] // the plain loop is safe
        // SAFETY: `push` appends even offsets, below twice `LEFT_SAMPLES`.
        unsafe {
            native::levels::mix(from, parts, row, out);
        }
    }
}

/// Computes the channel sums of a row of cells, and the energy of each cell: the sum of the squares of its nine
/// gradient sums. The slices have room for a multiple of eight cells.
#[inline(always)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    debug_assert!(sums.len() == CHANNELS && across <= ROW && across * usize::from(CELL) + 2 <= COLUMNS);
    native::gradients::gradients(lines, sums, energies, across);
}

/// Computes the features of a row of cells: channel sum times inverse norm, and mean gray level less 128.
#[inline(always)]
pub(crate) fn features<const ROW: usize>(sums: &[[u16; ROW]], inverses: &[u32; ROW], out: &mut [[i8; CHANNELS]]) {
    debug_assert!(sums.len() == CHANNELS && out.len() <= ROW);
    native::gradients::features(sums, inverses, out);
}

#[cfg(not(smr_helium))]
pub(crate) use super::plain::gradients::norms;
#[cfg(smr_helium)]
pub(crate) use native::gradients::norms;

/// For up to 65537 pixels, the sum of absolute differences from `level`, and the number of clipped pixels (0 or 255).
#[inline(never)]
pub(crate) fn deviation(pixels: &[u8], level: u8) -> [u32; 2] {
    debug_assert!(pixels.len() <= MAX_PIXELS);
    native::levels::deviation(pixels, level)
}

/// Copies `new` over `old`, of the same length. Returns the maximum of `largest` and the absolute differences.
#[inline(never)]
pub(crate) fn replace(old: &mut [u8], new: &[u8], largest: u8) -> u8 {
    debug_assert_eq!(old.len(), new.len());
    native::levels::replace(old, new, largest)
}

/// The values `weight * factor / 2^32 + sum * 2^left`, with the quotient rounded down. A value is within +-(2^31 - 1),
/// but either of its two terms may be larger.
#[derive(Clone, Copy)]
pub(crate) struct ScaledSums<'a> {
    pub(crate) weights: &'a [i32],
    pub(crate) factor: i64,
    pub(crate) sums: &'a [i32],
    pub(crate) left: u32,
}

impl<'a> ScaledSums<'a> {
    /// Takes `sums` as the values, without weights. They may include -2^31.
    pub(crate) fn of(sums: &'a [i32]) -> Self {
        Self { weights: sums, factor: 0, sums, left: 0 }
    }

    #[inline(never)]
    pub(crate) fn largest(self) -> u32 {
        let Self { weights, factor, sums, left } = self;
        native::weights::largest(weights, factor, sums, left)
    }

    /// Quantises all values: divides by `2^shift` and rounds. The caller chooses `shift` so that 16 bits suffice.
    #[inline(never)]
    pub(crate) fn code(self, shift: u32, out: &mut [i16]) {
        let Self { weights, factor, sums, left } = self;
        native::weights::code(weights, factor, sums, left, shift, out);
    }
}

/// A gradient descent step: subtracts `slope * length / 2^back`, rounded, from each weight. `back` is 0 to 62, and no
/// product reaches 2^62.
#[derive(Clone, Copy)]
pub(crate) struct GradientStep {
    pub(crate) length: i64,
    pub(crate) back: u32,
}

impl GradientStep {
    /// Updates the weights. A weight that would overflow an `i32` is not changed.
    #[inline(never)]
    pub(crate) fn apply(self, weights: &mut [i32], slopes: &[i16]) {
        let Self { length, back } = self;
        debug_assert!(back <= 62);
        native::weights::step(weights, slopes, length, back);
    }
}
