//! Cells of gradient orientations (HOG, Dalal and Triggs): the sums of a row of cells, and their features as bytes.

#[cfg(smr_dsp)]
use super::arm::dsp::gradients::{self as dsp, cell};
#[cfg(smr_helium)]
pub(crate) use super::arm::helium::gradients::{gradients, scale};
#[cfg(not(smr_helium))]
use super::cells::{CELL, SIDE};
#[cfg(not(any(smr_dsp, smr_helium)))]
use super::plain::gradients::cell;
#[cfg(not(any(smr_dsp, smr_helium)))]
pub(crate) use super::plain::gradients::scale;
#[cfg(smr_dsp)]
pub(crate) use dsp::scale;

/// Computes the sums of a row of cells, and the energy of each cell: the sum of the squares of its nine gradient sums.
#[cfg(not(smr_helium))]
#[inline(never)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    for (number, energy) in energies.iter_mut().enumerate().take(across) {
        let cell = cell(lines, number * usize::from(CELL));
        *energy = cell.energy();
        for (row, sum) in sums.iter_mut().zip(cell.0) {
            if let Some(of_cell) = row.get_mut(number) {
                *of_cell = sum;
            }
        }
    }
}
