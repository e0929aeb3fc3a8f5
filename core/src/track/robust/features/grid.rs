//! The target's grid: the step at which the frame is resampled, and the shapes of template and filter on the grid. A
//! target of 400 or more frame pixels has about 1600 pixels on its grid (1296 in the small size), so its size hardly
//! changes the cost.
//!
//! ```text
//! step = sqrt(area / 1600 or 1296) pixels of the frame, at least half a pixel
//! ```

use super::super::constants::{CELL, CHANNELS, Limits, MAX_SIDE, PIXEL_BITS};
use crate::image::Rect;
use crate::kernels::rolled;
use crate::track::update::units;

/// The minimum side of the correlation filter, in cells.
const MIN_SIDE: u16 = 4;
/// The filter's side in cells for each grid pixel of the target's side: 7/20. As a cell has 4x4 grid pixels, the
/// filter's side is 1.4 times the target's.
const COVER: [u32; 2] = [7, 20];
/// The smallest step of the target's grid, in units of 1/4096 pixel: half a pixel, which enlarges a target twofold.
const MIN_STEP: u32 = 2048;

/// The grid to which a target is resampled: shapes of the template and of the filter, and the step at scale 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Grid {
    /// Columns of the template, in pixels of the grid.
    pub columns: u16,
    /// Rows of the template, in pixels of the grid.
    pub rows: u16,
    /// Columns of the filter, in cells of 4x4 pixels of the grid: 1.4 times the target's width.
    pub across: u16,
    /// Rows of the filter, in cells of 4x4 pixels of the grid.
    pub down: u16,
    /// Frame pixels between neighbouring pixels of the grid at scale 1, in units of 1/4096.
    pub step: u32,
}

impl Grid {
    /// The grid for a box of this size in a tracker of the [`Standard`](super::super::Standard) size. The sides of
    /// template and filter are rounded. The template has at most 1600 pixels, the filter at most 200 cells, so both
    /// cover only the middle of a very long box.
    ///
    /// ```
    /// use smr_core::{Rect, robust::Grid};
    /// let grid = Grid::new(Rect::new(0, 0, 80, 80));
    /// assert_eq!((grid.columns, grid.rows, grid.step), (40, 40, 2 * 4096));
    /// assert_eq!((grid.across, grid.down), (14, 14));
    /// ```
    #[must_use]
    pub fn new(target: Rect) -> Self {
        Self::within(Limits::STANDARD, target)
    }

    #[inline(never)]
    pub(crate) fn within(limits: Limits, target: Rect) -> Self {
        let step = step(target.area(), limits.pixels);
        let (across, down) = fitting([target.width, target.height].map(|size| cells(size, step)), limits.cells);
        let (columns, rows) =
            fitting([pairs(target.width, across, step), pairs(target.height, down, step)], limits.pixels / 4);
        Self { columns: 2 * columns, rows: 2 * rows, across, down, step }
    }

    pub(crate) fn pixels(&self) -> u32 {
        u32::from(self.columns) * u32::from(self.rows)
    }

    pub(crate) fn weights(&self) -> usize {
        usize::from(self.across) * usize::from(self.down) * CHANNELS
    }

    /// The count of the filter's weights, which is the work if each weight costs one unit.
    pub(crate) fn work_on_weights(&self) -> u32 {
        units(self.weights())
    }

    /// The grid's step at `scale`, in units of 1/4096 pixel of the frame.
    #[inline(never)]
    pub(crate) fn step_at(&self, scale: u32) -> i64 {
        ((i64::from(self.step) * i64::from(scale)) >> 16).max(1)
    }
}

/// The size of a filter, in cells, and the radius of its search window. Upper bounds of work are computed from them.
#[derive(Clone, Copy)]
pub(crate) struct Extent {
    pub(crate) across: u32,
    pub(crate) down: u32,
    /// The radius of the search window, in cells.
    pub(crate) reach: u32,
    /// Pixels of the largest template.
    pub(crate) most_pixels: u32,
}

#[allow(clippy::cast_possible_truncation)] // a constant: 10 channels
impl Extent {
    pub(crate) const fn with_reach(self, reach: u16) -> Self {
        Self { reach: reach as u32, ..self }
    }

    pub(crate) const fn weights(self) -> u32 {
        self.across * self.down * CHANNELS as u32
    }

    pub(crate) const fn pixels(self) -> u32 {
        let all = self.across * self.down * CELL as u32 * CELL as u32;
        if all < self.most_pixels { all } else { self.most_pixels }
    }

    pub(crate) const fn span(self) -> u32 {
        2 * self.reach + 1
    }

    pub(crate) const fn offsets(self) -> u32 {
        self.span() * self.span()
    }
}

/// The grid's step for a box, in units of 1/4096 pixel: the root of area / `pixels`, rounded down, but at least
/// `MIN_STEP`. It is below 2^23, because `pixels` is at least 1024.
fn step(area: u32, pixels: u16) -> u32 {
    let square = u64::from(area) << (2 * PIXEL_BITS);
    let mut root = 0;
    for bit in rolled((0..23).rev()) {
        let larger = root | 1 << bit;
        if u64::from(larger) * u64::from(larger) * u64::from(pixels) <= square {
            root = larger;
        }
    }
    root.max(MIN_STEP)
}

/// Cells of the filter for a box side of `size` pixels. No overflow: 7 * 65535 * 2^12 and 20 * `step` are below 2^31.
#[inline(never)]
fn cells(size: u16, step: u32) -> u16 {
    let [cover, of] = COVER;
    let size = u32::from(size) << PIXEL_BITS;
    let cells = (cover * size + of / 2 * step) / (of * step).max(1);
    u16::try_from(cells).unwrap_or(MAX_SIDE).clamp(MIN_SIDE, MAX_SIDE)
}

/// Pairs of template pixels on an axis. An even number of pixels gives template and search window the same middle.
#[inline(never)]
fn pairs(size: u16, cells: u16, step: u32) -> u16 {
    let pairs = ((u32::from(size) << PIXEL_BITS) + step) / (2 * step).max(1);
    u16::try_from(pairs).unwrap_or(u16::MAX).min(cells * CELL / 2).max(2)
}

/// Shortens the longer side until the product of the sides is at most `most`.
#[inline(never)]
fn fitting([mut across, mut down]: [u16; 2], most: u16) -> (u16, u16) {
    for () in rolled(core::iter::repeat(())) {
        if u32::from(across) * u32::from(down) <= u32::from(most) {
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
        let wanted = |area: u32, pixels: u16| ((u64::from(area) << 24) / u64::from(pixels)).isqrt().max(2048);
        let ends = (0..32).flat_map(|places| [1 << places, (1 << places) + 1, u32::MAX >> places]);
        let squares = (1..=65535).step_by(7).map(|side: u32| side * side);
        for area in (0..3000).chain(ends).chain(squares.flat_map(|square| [square - 1, square, square + 1])) {
            for Limits { pixels, .. } in [Limits::STANDARD, Limits::SMALL] {
                assert_eq!(u64::from(step(area, pixels)), wanted(area, pixels), "{area} {pixels}");
            }
        }
    }
}
