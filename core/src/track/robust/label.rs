//! Bells: the label, what the filter should answer at an offset, around the target's place; and how much cells learn, around the
//! target's middle.

use super::features::root;
use super::grid::Grid;

/// 1.0, as labels and responses have it.
pub(super) const ONE: i32 = 1 << 14;
/// Entries of the table for each standard deviation.
const FINE: u16 = 32;
/// Five standard deviations; beyond, the label is 0.
const ENTRIES: usize = 5 * FINE as usize;

/// exp(-t^2 / 2) in units of 1/16384, t in units of 1/32.
const BELL: [u16; ENTRIES] = bell();

/// How wide the bell is.
#[derive(Clone, Copy)]
pub(super) struct Bell {
    /// Steps of the table for 1/256 cell, in units of 2^-20.
    narrow: i64,
}

impl Bell {
    /// The standard deviation is a tenth of the root of the target's area, in cells.
    pub(super) fn of(grid: &Grid) -> Self {
        // In 1/256 cell: 0.1 * sqrt(pixels / 16) * 256 = 6.4 * sqrt(pixels).
        Self::of_width(root(grid.pixels() * 4096 / 100).max(1).into())
    }

    /// One for each axis: the standard deviation is half of the target's side.
    pub(super) fn halves(grid: &Grid) -> [Self; 2] {
        // In 1/256 cell: 256 / 4 / 2 = 32 for each pixel.
        [grid.columns, grid.rows].map(|side| Self::of_width(32 * u64::from(side).max(1)))
    }

    fn of_width(sigma: u64) -> Self {
        Self { narrow: (i64::from(FINE) << 20) / i64::try_from(sigma).unwrap_or(1) }
    }

    #[inline(never)] // one copy in flash
    /// At so much from the middle, in units of 1/256 cell.
    pub(super) fn at(self, distance: i32) -> i32 {
        let entry = (i64::from(distance.unsigned_abs()) * self.narrow) >> 20;
        usize::try_from(entry).ok().and_then(|entry| BELL.get(entry)).map_or(0, |&part| part.into())
    }

    /// At an offset of a search of so much reach, on one axis, of a target so far from its middle; the label is the product of both
    /// axes' parts.
    pub(super) fn at_offset(self, offset: usize, target: i32, reach: u16) -> i32 {
        self.at(256 * (i32::try_from(offset).unwrap_or(0) - i32::from(reach)) - target)
    }
}

#[allow(clippy::indexing_slicing, clippy::cast_possible_truncation)] // t < ENTRIES; every entry is at most 2^14
const fn bell() -> [u16; ENTRIES] {
    const ONE: u128 = 1 << 60;
    /// exp(-1/2048), by the first terms of its series.
    const Q: u128 = ONE - (1 << 49) + (1 << 37) - (1 << 26) / 3;
    // q^(t^2), from one to the next by q^(2t + 1).
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
    use super::*;
    use crate::image::Rect;

    #[test]
    fn every_entry_is_the_rounded_exponential() {
        for (t, &entry) in BELL.iter().enumerate() {
            let exact = 16384.0 * (-(t as f64 / 32.0).powi(2) / 2.0).exp();
            assert_eq!(f64::from(entry), exact.round(), "{t}");
        }
    }

    #[test]
    fn a_target_of_ten_by_ten_cells_has_a_bell_of_one_cell() {
        let bell = Bell::of(&Grid::new(Rect::new(0, 0, 40, 40)));
        assert_eq!([bell.at(0), bell.at(256), bell.at(-256), bell.at(5 * 256)], [ONE, 9937, 9937, 0]);
    }
}
