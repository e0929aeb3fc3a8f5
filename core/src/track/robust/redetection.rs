//! Redetection: while the target is lost, a second window is searched in each frame. In turn these windows sweep the whole frame.
//!
//! The windows cover the frame side by side, row by row. Each is searched and verified like the first window, so redetection adds the same
//! cost to every frame.

use super::constants::PIXEL;
use crate::image::Rect;

/// The next window.
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

    /// The middle of the next window. Neighbouring windows are at most `side` apart, in units of positions.
    pub(super) fn middle(self, side: i64, bounds: Rect) -> (i64, i64) {
        let count = |size: u16| ((i64::from(size) * PIXEL + side - 1) / side.max(1)).max(1);
        let (columns, rows) = (count(bounds.width), count(bounds.height));
        let number = i64::from(self.next) % (columns * rows).max(1);
        let centre = |number: i64, count: i64, size: u16| {
            ((2 * number + 1) * i64::from(size) * PIXEL / (2 * count.max(1)) - PIXEL / 2).max(0)
        };
        (centre(number % columns.max(1), columns, bounds.width), centre(number / columns.max(1), rows, bounds.height))
    }
}
