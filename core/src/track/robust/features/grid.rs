//! The target's grid: the step at which the frame is resampled, and the shapes of template and filter on it.
//!
//! ```text
//! step = sqrt(area / 1600) pixels of the frame, at least half a pixel
//! ```
//!
//! A target of any size has about 1600 pixels on its grid, so its size hardly changes the cost.

use super::super::constants::{
    CELL, CHANNELS, COVER, LEAST_SIDE, LEAST_STEP, MOST_CELLS, MOST_PIXELS, MOST_SIDE, PIXEL_BITS,
};
use crate::image::Rect;
use crate::kernels::rolled;
use crate::track::update::units;

/// The shapes of the template and of the filter, and the grid's step at scale 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Grid {
    /// Columns of the template, in pixels of the grid.
    pub columns: u16,
    /// Rows of the template, in pixels of the grid.
    pub rows: u16,
    /// Columns of the filter, in cells of 4x4 pixels of the grid. It covers 1.4 times the target.
    pub across: u16,
    /// Rows of the filter, in cells.
    pub down: u16,
    /// Frame pixels from one pixel of the grid to the next at scale 1, in units of 1/4096.
    pub step: u32,
}

impl Grid {
    /// The grid for a box of this size.
    ///
    /// Sides are rounded. The longer one is cut until template and filter have room, so only the middle of a very long
    /// box is used.
    ///
    /// ```
    /// use smr_core::{Rect, robust::Grid};
    /// let grid = Grid::new(Rect::new(0, 0, 80, 80));
    /// assert_eq!((grid.columns, grid.rows, grid.step), (40, 40, 2 * 4096));
    /// assert_eq!((grid.across, grid.down), (14, 14));
    /// ```
    #[must_use]
    pub fn new(target: Rect) -> Self {
        let step = step(target.area());
        let (across, down) = fitting([target.width, target.height].map(|size| cells(size, step)), MOST_CELLS);
        let (columns, rows) =
            fitting([pairs(target.width, across, step), pairs(target.height, down, step)], MOST_PIXELS / 4);
        Self { columns: 2 * columns, rows: 2 * rows, across, down, step }
    }

    pub(crate) fn pixels(&self) -> u32 {
        u32::from(self.columns) * u32::from(self.rows)
    }

    pub(crate) fn weights(&self) -> usize {
        usize::from(self.across) * usize::from(self.down) * CHANNELS
    }

    /// Work of one unit for each weight.
    pub(crate) fn work_on_weights(&self) -> u32 {
        units(self.weights())
    }

    /// The step at `scale`, in units of 1/4096 pixel.
    #[inline(never)]
    pub(crate) fn step_at(&self, scale: u32) -> i64 {
        ((i64::from(self.step) * i64::from(scale)) >> 16).max(1)
    }
}

/// The largest grid for a filter of a given number of cells, and the reach of its search. The most work of a stage
/// depends on them.
#[derive(Clone, Copy)]
pub(crate) struct Extent {
    pub(crate) across: u32,
    pub(crate) down: u32,
    /// The reach of the search, in cells.
    pub(crate) reach: u32,
}

#[allow(clippy::cast_possible_truncation)] // 10 channels, 1600 pixels
impl Extent {
    /// This filter with another reach.
    pub(crate) const fn with_reach(self, reach: u16) -> Self {
        Self { reach: reach as u32, ..self }
    }

    pub(crate) const fn weights(self) -> u32 {
        self.across * self.down * CHANNELS as u32
    }

    pub(crate) const fn pixels(self) -> u32 {
        let all = self.across * self.down * CELL as u32 * CELL as u32;
        if all < MOST_PIXELS as u32 { all } else { MOST_PIXELS as u32 }
    }

    /// Offsets of the search on each axis.
    pub(crate) const fn span(self) -> u32 {
        2 * self.reach + 1
    }

    pub(crate) const fn offsets(self) -> u32 {
        self.span() * self.span()
    }
}

/// The step for a box of this area: the square root, rounded down, of area / `MOST_PIXELS`, bit by bit. It is below
/// 2^23.
fn step(area: u32) -> u32 {
    let square = u64::from(area) << (2 * PIXEL_BITS);
    let mut root = 0;
    for bit in rolled((0..23).rev()) {
        let larger = root | 1 << bit;
        if u64::from(larger) * u64::from(larger) * MOST_PIXELS as u64 <= square {
            root = larger;
        }
    }
    root.max(LEAST_STEP)
}

/// Cells of the filter on a side of the target with `size` pixels. Nothing overflows: 7 * 65535 * 2^12 is below 2^31,
/// and so are 20 steps.
#[inline(never)]
fn cells(size: u16, step: u32) -> u16 {
    let [cover, of] = COVER;
    let size = u32::from(size) << PIXEL_BITS;
    let cells = (cover * size + of / 2 * step) / (of * step).max(1);
    u16::try_from(cells).unwrap_or(MOST_SIDE).clamp(LEAST_SIDE, MOST_SIDE)
}

/// Pairs of pixels on a side of the template. With an even number of pixels the template and the window have the same
/// middle.
#[inline(never)]
fn pairs(size: u16, cells: u16, step: u32) -> u16 {
    let pairs = ((u32::from(size) << PIXEL_BITS) + step) / (2 * step).max(1);
    u16::try_from(pairs).unwrap_or(u16::MAX).min(cells * CELL / 2).max(2)
}

/// Cuts the longer side until the product of both is at most `most`.
#[inline(never)]
fn fitting([mut across, mut down]: [u16; 2], most: usize) -> (u16, u16) {
    for () in rolled(core::iter::repeat(())) {
        if usize::from(across) * usize::from(down) <= most {
            break;
        }
        *(if across > down { &mut across } else { &mut down }) -= 1;
    }
    (across, down)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_rounded_down() {
        let wanted = |area: u32| ((u64::from(area) << 24) / 1600).isqrt().max(2048);
        let ends = (0..32).flat_map(|places| [1 << places, (1 << places) + 1, u32::MAX >> places]);
        let squares = (1..=65535).step_by(7).map(|side: u32| side * side);
        for area in (0..3000).chain(ends).chain(squares.flat_map(|square| [square - 1, square, square + 1])) {
            assert_eq!(u64::from(step(area)), wanted(area), "{area}");
        }
    }
}
