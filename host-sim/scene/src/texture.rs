//! Periodic textures of random gray levels.

use super::PIXEL;
use super::random::Random;

/// A texture of 256x256 gray levels, indexed by the low bytes of row and column, so it repeats.
pub struct Texture([u8; 1 << 16]);

impl Texture {
    pub(super) const BLANK: Self = Self([0; 1 << 16]);

    /// Averages two interpolated grids of random levels, with points `coarse` and `fine` pixels apart, and scales the
    /// average to the range from `darkest` to `brightest`.
    pub fn new(seed: u64, (coarse, fine): (i32, i32), (darkest, brightest): (i32, i32)) -> Self {
        let mut random = Random(seed);
        let mut grid = || Self(core::array::from_fn(|_| random.next().to_le_bytes()[0]));
        let (first, second) = (grid(), grid());
        let at = |grid: &Self, place: i32, cell| grid.sample((place & 255) * PIXEL / cell, (place >> 8) * PIXEL / cell);
        let mut levels = [0; 1 << 16];
        for (place, level) in (0..).zip(&mut levels) {
            let average = (at(&first, place, coarse) + at(&second, place, fine)) / 2;
            [*level, ..] = (darkest + (((brightest - darkest) * average) >> 16)).to_le_bytes();
        }
        Self(levels)
    }

    /// Interpolates bilinearly at a position in sixteenths of a pixel; returns 256ths of a gray level.
    pub fn sample(&self, x: i32, y: i32) -> i32 {
        let (column, row) = (x.div_euclid(PIXEL), y.div_euclid(PIXEL));
        let (right, low) = (x.rem_euclid(PIXEL), y.rem_euclid(PIXEL));
        let upper = self.at(column, row) * (PIXEL - right) + self.at(column + 1, row) * right;
        let lower = self.at(column, row + 1) * (PIXEL - right) + self.at(column + 1, row + 1) * right;
        upper * (PIXEL - low) + lower * low
    }

    fn at(&self, column: i32, row: i32) -> i32 {
        let (column, row) = (column.to_le_bytes()[0], row.to_le_bytes()[0]);
        i32::from(self.0[usize::from(row) << 8 | usize::from(column)])
    }
}
