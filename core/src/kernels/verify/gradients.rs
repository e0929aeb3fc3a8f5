//! Compares cells of gradient orientations.

use crate::kernels::cells::{CELL, CHANNELS, SIDE};
use crate::kernels::plain::gradients as plain;

/// Checks the sums of a row of cells and their energies.
#[track_caller]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &[[u16; ROW]],
    energies: &[u32; ROW],
    across: usize,
) {
    for (number, &energy) in energies.iter().enumerate().take(across) {
        let wanted = plain::cell(lines, number * usize::from(CELL));
        assert_eq!(energy, wanted.energy(), "energy of cell {number}, given and expected");
        let are_equal = sums.iter().zip(wanted.0).all(|(row, wanted)| row.get(number) == Some(&wanted));
        assert!(are_equal, "sums of cell {number}");
    }
}

/// Checks the features of a row of cells.
#[track_caller]
pub(crate) fn scale<const ROW: usize>(out: &[[i8; CHANNELS]], sums: &[[u16; ROW]], inverses: &[u32; ROW]) {
    let mut wanted = [[0; CHANNELS]; ROW];
    plain::scale(sums, inverses, &mut wanted);
    assert!(out.iter().zip(&wanted).all(|(given, wanted)| given == wanted), "features, given and expected");
}
