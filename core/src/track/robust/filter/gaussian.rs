//! Gaussians: the label, which is the wanted response around the target, and the mask that weights the filter's cells
//! in learning. Each is a product of two Gaussians, one on each axis. Distances are in units of 1/256 cell.
//!
//! ```text
//! exp(-(d / sigma)^2 / 2) in units of 1/16384, from the table of exp(-x / 255), x = 255 / 2 * (d / sigma)^2
//! ```

use super::super::features::Grid;
use crate::kernels::rolled;
use crate::similarity::PAPER;

/// The squared width of the Gaussian label, as a fraction: (standard deviation / root of the target's area)^2 = 0.1^2.
const LABEL_WIDTH: [u32; 2] = [1, 100];
/// The standard deviation of the mask that weights the filter's cells in learning, per pixel of the template's side, in
/// units of 1/256 cell. On each axis, 32 makes the standard deviation half of the side, as a cell is 4 pixels wide.
const MASK_WIDTH: u32 = 32;

/// exp(-256 / 255) in units of 1/65536: a step of 256 in x multiplies the Gaussian by it. The table ends at x = 255.
const LOWER: u32 = 24_015;

#[derive(Clone, Copy)]
pub(crate) struct Gaussian {
    /// 255 / sigma^2, in units of 2^-24: x is this factor times d^2 / 2.
    factor: u32,
}

impl Gaussian {
    /// The Gaussian of the label on each axis. Sigma is a tenth of the root of the target's area.
    pub(crate) fn label(grid: &Grid) -> Self {
        // A pixel of the grid is 64 units of distance, so sigma^2 = 64^2 * 0.1^2 * pixels.
        let [width, of] = LABEL_WIDTH;
        Self::new(grid.pixels() * 4096 * width / of)
    }

    /// The Gaussians of the mask on the horizontal and the vertical axis. Sigma is half of the target's side.
    pub(crate) fn mask(grid: &Grid) -> [Self; 2] {
        [grid.columns, grid.rows].map(|side| Self::new((MASK_WIDTH * u32::from(side)).pow(2)))
    }

    fn new(squared_sigma: u32) -> Self {
        Self { factor: (255 << 24) / squared_sigma.max(1) }
    }

    /// The Gaussian, in units of 1/16384. `distance` is less than 256 cells, in units of 1/256 cell.
    #[inline(never)]
    #[allow(clippy::cast_possible_truncation)] // keeps the lower eight bits
    pub(crate) fn at(self, distance: i32) -> i32 {
        let x = (u64::from(distance.unsigned_abs().pow(2)) * u64::from(self.factor)) >> 25;
        let x = u32::try_from(x).unwrap_or(u32::MAX);
        let mut value = u32::from(PAPER.similarity(x as u8));
        for _ in rolled(0..(x >> 8).min(16)) {
            value = (value * LOWER) >> 16;
        }
        (value + 2).cast_signed() >> 2
    }

    /// The Gaussian around the target at an offset of the search, on one axis. `target` is the target's distance from
    /// the window's middle, in units of 1/256 cell.
    pub(super) fn at_offset(self, offset: usize, target: i32, reach: u16) -> i32 {
        self.at(256 * (i32::try_from(offset).unwrap_or(0) - i32::from(reach)) - target)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::constants::ONE;
    use super::*;
    use crate::image::Rect;

    #[test]
    fn a_gaussian_is_near_the_exponential() {
        let gaussian = Gaussian::new(100 * 100);
        for distance in 0..=(1 << 16) - 1 {
            let exact = 16384.0 * (-(f64::from(distance) / 100.0).powi(2) / 2.0).exp();
            assert!((f64::from(gaussian.at(distance)) - exact).abs() < 66.0, "{distance}");
            assert_eq!(gaussian.at(-distance), gaussian.at(distance));
        }
    }

    #[test]
    fn the_label_of_ten_by_ten_cells_has_a_sigma_of_one_cell() {
        let label = Gaussian::label(&Grid::new(Rect::new(0, 0, 40, 40)));
        assert_eq!([label.at(0), label.at(256), label.at(-256), label.at(5 * 256)], [ONE, 9957, 9957, 0]);
    }
}
