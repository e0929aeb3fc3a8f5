//! Cells of gradient orientations (HOG, Dalal and Triggs): the sums of a row of cells, and their features as bytes.

use super::backend::native;
use super::cells::{CELL, CHANNELS, SIDE};

/// Computes the sums of a row of cells, and the energy of each cell: the sum of the squares of its nine gradient sums.
/// Rows and lines have room for a multiple of eight cells.
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

/// Computes the features of a row of cells: each gradient sum times the inverse norm of its cell, and the mean gray
/// level less 128.
#[inline(always)]
pub(crate) fn scale<const ROW: usize>(sums: &[[u16; ROW]], inverses: &[u32; ROW], out: &mut [[i8; CHANNELS]]) {
    debug_assert!(sums.len() == CHANNELS && out.len() <= ROW);
    native::gradients::scale(sums, inverses, out);
}
