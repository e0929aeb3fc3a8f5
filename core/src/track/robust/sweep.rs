//! The sweep: a target that is lost, or doubtful, is looked for all over the frame, one window in each frame, so that none
//! costs much more than another. This file says which window; how it is looked at stands in `correlation.rs`.

use super::grid::PIXEL;
use crate::image::Rect;

/// The windows that cover a frame, and which is next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sweep {
    pub(super) next: u32,
}

impl Sweep {
    pub(super) const fn new() -> Self {
        Self { next: 0 }
    }

    pub(super) fn advance(&mut self) {
        self.next = self.next.wrapping_add(1);
    }

    /// The middle of the window that is next, on a frame with these bounds.
    ///
    /// Windows lie side by side, row by row, as many as it takes for offsets of so much `reach` to cover the frame.
    pub(super) fn place(self, reach: i64, bounds: Rect) -> (i64, i64) {
        let count = |size: u16| ((i64::from(size) * PIXEL + reach - 1) / reach.max(1)).max(1);
        let (columns, rows) = (count(bounds.width), count(bounds.height));
        let number = i64::from(self.next) % (columns * rows).max(1);
        let centre = |number: i64, count: i64, size: u16| {
            ((2 * number + 1) * i64::from(size) * PIXEL / (2 * count.max(1)) - PIXEL / 2).max(0)
        };
        (centre(number % columns.max(1), columns, bounds.width), centre(number / columns.max(1), rows, bounds.height))
    }
}
