//! Redetection: each update searches a few windows for a lost target. Over several frames, they cover the picture.
//!
//! The windows cover the picture side by side, row by row. A frame searches and verifies the next `Config::sweep`
//! windows, until one shows the target, but none beyond the end of a row, so that they lie in one rectangle.

use super::super::arithmetic::quotient;
use super::super::constants::{PIXEL, PIXEL_BITS};
use crate::image::Rect;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sweep {
    pub(crate) next: u32,
}

impl Sweep {
    pub(crate) const fn new() -> Self {
        Self { next: 0 }
    }

    pub(crate) fn move_on(&mut self) {
        self.next = self.next.wrapping_add(1);
    }

    /// The next window's middle, in units of 1/4096 pixel, and true if the window ends a row of windows. The middles of
    /// neighbouring windows are at most `side` / 4096 pixels apart.
    pub(crate) fn middle(self, side: u32, bounds: Rect) -> ((i64, i64), bool) {
        let (columns, rows) = (count(bounds.width, side), count(bounds.height, side));
        let number = self.next % (columns * rows).max(1);
        let (column, row) = (number % columns, number / columns);
        ((centre(column, columns, bounds.width), centre(row, rows, bounds.height)), column + 1 == columns)
    }
}

/// The number of windows on an axis. `side` is at least 2 * 4 * 4 * 409 = 13,088: twice the least reach (4 cells of 4
/// samples), at the least step of 409/4096 pixel. So the product of the counts on both axes is below 2^32.
fn count(size: u16, side: u32) -> u32 {
    (u32::from(size) << PIXEL_BITS).div_ceil(side.max(1)).max(1)
}

/// The middle of window `number` on an axis, in units of 1/4096 pixel.
#[inline(never)]
fn centre(number: u32, count: u32, size: u16) -> i64 {
    let middle = quotient((2 * i64::from(number) + 1) * i64::from(size) * PIXEL, 2 * i64::from(count));
    (middle - PIXEL / 2).max(0)
}
