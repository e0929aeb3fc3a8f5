//! Gaussians: the label, which is the wanted response around the target, and the mask of learning over the filter's
//! cells.
//!
//! ```text
//! exp(-(d / sigma)^2 / 2) in units of 1/16384, from a table of 32 entries per sigma; 0 from 5 sigma on
//! ```
//!
//! In two dimensions it is the product of the Gaussians of both axes. Distances are in units of 1/256 cell.

use super::super::arithmetic::root;
use super::super::constants::{LABEL_WIDTH, LEARNED_WIDTH};
use super::super::features::Grid;

/// Entries of the table for each sigma.
const FINE: u16 = 32;
const ENTRIES: usize = 5 * FINE as usize;

/// exp(-t^2 / 2) in units of 1/16384, t in units of 1/32.
const TABLE: [u16; ENTRIES] = table();

/// A Gaussian on one axis.
#[derive(Clone, Copy)]
pub(crate) struct Gaussian {
    /// Entries of the table for each 1/256 cell. Unit: 2^-20.
    entries: i64,
}

impl Gaussian {
    /// The label's Gaussian: sigma is a tenth of the root of the target's area.
    pub(crate) fn label(grid: &Grid) -> Self {
        // A pixel of the grid is 64 units, so sigma^2 = 64^2 * 0.1^2 * pixels.
        let [width, of] = LABEL_WIDTH;
        Self::new(root(grid.pixels() * 4096 * width / of).max(1).into())
    }

    /// The mask's Gaussians across and down: sigma is half of the target's side.
    pub(crate) fn mask(grid: &Grid) -> [Self; 2] {
        [grid.columns, grid.rows].map(|side| Self::new(LEARNED_WIDTH * u64::from(side).max(1)))
    }

    fn new(sigma: u64) -> Self {
        Self { entries: (i64::from(FINE) << 20) / i64::try_from(sigma).unwrap_or(1) }
    }

    /// The Gaussian at a distance from its middle, in units of 1/16384. The distance is in units of 1/256 cell.
    #[inline(never)]
    pub(crate) fn at(self, distance: i32) -> i32 {
        let entry = (i64::from(distance.unsigned_abs()) * self.entries) >> 20;
        usize::try_from(entry).ok().and_then(|entry| TABLE.get(entry)).map_or(0, |&value| value.into())
    }

    /// The value at an offset on one axis of a search. `target` is the target's distance from the middle, in units of
    /// 1/256 cell.
    pub(super) fn at_offset(self, offset: usize, target: i32, reach: u16) -> i32 {
        self.at(256 * (i32::try_from(offset).unwrap_or(0) - i32::from(reach)) - target)
    }
}

#[allow(clippy::indexing_slicing, clippy::cast_possible_truncation)] // t < ENTRIES; every entry is at most 2^14
const fn table() -> [u16; ENTRIES] {
    const ONE: u128 = 1 << 60;
    /// q = exp(-1/2048), by the first terms of its series.
    const Q: u128 = ONE - (1 << 49) + (1 << 37) - (1 << 26) / 3;
    // The entries are q^(t^2); q^(2t + 1) leads from one to the next.
    let mut entries = [0; ENTRIES];
    let (mut value, mut odd) = (ONE, Q);
    let mut t = 0;
    while t < ENTRIES {
        entries[t] = ((value + (1 << 45)) >> 46) as u16;
        value = (value * odd) >> 60;
        odd = (odd * ((Q * Q) >> 60)) >> 60;
        t += 1;
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::super::super::constants::ONE;
    use super::*;
    use crate::image::Rect;

    #[test]
    fn every_entry_is_the_rounded_exponential() {
        for (t, &entry) in TABLE.iter().enumerate() {
            let exact = 16384.0 * (-(t as f64 / 32.0).powi(2) / 2.0).exp();
            assert_eq!(f64::from(entry), exact.round(), "{t}");
        }
    }

    #[test]
    fn the_label_of_ten_by_ten_cells_has_a_sigma_of_one_cell() {
        let label = Gaussian::label(&Grid::new(Rect::new(0, 0, 40, 40)));
        assert_eq!([label.at(0), label.at(256), label.at(-256), label.at(5 * 256)], [ONE, 9937, 9937, 0]);
    }
}
