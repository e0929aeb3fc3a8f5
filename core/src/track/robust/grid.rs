//! The target's grid: how finely the frame is resampled, and the shapes of template and filter on it.
//!
//! ```text
//! step = sqrt(area / 1600) pixels of the frame, at least half a pixel
//! ```
//!
//! A target of any size has about 1600 pixels on its grid, so every frame costs about the same.

use super::constants::{CELL, CHANNELS, COVER, LEAST_SIDE, LEAST_STEP, MOST_CELLS, MOST_PIXELS, MOST_SIDE, PIXEL_BITS};
use crate::image::Rect;

/// Shapes of the template and of the filter, and the grid's step at scale 1.
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
    /// Sides are rounded. The longer one is cut until template and filter have room: of a very long box only the middle is used.
    ///
    /// ```
    /// use smr_core::{Rect, robust::Grid};
    /// let grid = Grid::new(Rect::new(0, 0, 80, 80));
    /// assert_eq!((grid.columns, grid.rows, grid.step), (40, 40, 2 * 4096));
    /// assert_eq!((grid.across, grid.down), (14, 14));
    /// ```
    #[must_use]
    pub fn new(target: Rect) -> Self {
        let area = u64::from(target.area()) << (2 * PIXEL_BITS);
        // The upper bound, which is never reached, tells the compiler that nothing below overflows.
        let step = root(area / MOST_PIXELS as u64).clamp(LEAST_STEP, 1 << 32);
        let [part, of] = COVER;
        let cells = |size: u16| {
            let size = u64::from(size) << PIXEL_BITS;
            ((part * size + of / 2 * step) / (of * step)).clamp(LEAST_SIDE, MOST_SIDE.into())
        };
        let (across, down) = fitting(cells(target.width), cells(target.height), MOST_CELLS as u64);
        // Even, so that the template and the window have the same middle.
        let pixels = |size: u16, cells: u16| {
            let side = 2 * (((u64::from(size) << PIXEL_BITS) + step) / (2 * step));
            // Not `clamp`: the compiler would link its panic.
            side.min((cells * CELL).into()).max(4)
        };
        let (columns, rows) =
            fitting(pixels(target.width, across) / 2, pixels(target.height, down) / 2, MOST_PIXELS as u64 / 4);
        Self { columns: 2 * columns, rows: 2 * rows, across, down, step: u32::try_from(step).unwrap_or(u32::MAX) }
    }

    /// Pixels of the template.
    pub(super) fn pixels(&self) -> u32 {
        u32::from(self.columns) * u32::from(self.rows)
    }

    /// Weights of the filter.
    pub(super) fn weights(&self) -> usize {
        usize::from(self.across) * usize::from(self.down) * CHANNELS
    }

    /// The step at `scale`, in units of 1/4096 pixel.
    pub(super) fn step_at(&self, scale: u32) -> i64 {
        ((i64::from(self.step) * i64::from(scale)) >> 16).max(1)
    }
}

/// The square root, rounded down, by Newton's steps from above. `isqrt` would take 0.6 KB of flash, and this runs only once for each lock.
fn root(number: u64) -> u64 {
    let mut root = 1 << 32;
    loop {
        let next = (root + number / root.max(1)) / 2;
        if next >= root {
            return root;
        }
        root = next;
    }
}

/// Two sides; the longer one is cut until their product is at most `most`.
fn fitting(mut across: u64, mut down: u64, most: u64) -> (u16, u16) {
    while across * down > most {
        *(if across > down { &mut across } else { &mut down }) -= 1;
    }
    let small = |side: u64| u16::try_from(side).unwrap_or(u16::MAX);
    (small(across), small(down))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_rounded_down() {
        // The largest area is 65535 * 65535 * 2^24 / 1600, below 2^46.
        for number in (0..3000).chain((0..46).flat_map(|places| [1 << places, (1 << places) + 1, (2 << places) - 1])) {
            assert_eq!(root(number), number.isqrt(), "{number}");
        }
        let squares = (1_u64..1 << 23).step_by(997).map(|side| side * side);
        assert!(squares.clone().all(|square| root(square).pow(2) == square && root(square - 1) == square.isqrt() - 1));
    }
}
