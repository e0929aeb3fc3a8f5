//! The sweep: a target that is lost, or doubtful, is looked for all over the frame, one window in each frame, so that none
//! costs much more than another. This file says which window; how it is looked at stands in `correlation.rs`.

use super::SPAN;
use super::grid::{Lattice, PIXEL};
use crate::image::Rect;

/// The windows that cover a frame, and which is next.
#[derive(Clone, Copy)]
pub(super) struct Sweep {
    next: u32,
}

impl Sweep {
    pub(super) const fn new() -> Self {
        Self { next: 0 }
    }

    pub(super) fn advance(&mut self) {
        self.next = self.next.wrapping_add(1);
    }

    /// The window that is next, on a frame with these bounds: `window` with its centre moved.
    ///
    /// Windows lie side by side, row by row, as many as it takes for their offsets to cover the frame.
    pub(super) fn place(self, window: Lattice, bounds: Rect) -> Lattice {
        let reach = i64::try_from(SPAN).unwrap_or(1) * window.step;
        let count = |size: u16| ((i64::from(size) * PIXEL + reach - 1) / reach.max(1)).max(1);
        let (columns, rows) = (count(bounds.width), count(bounds.height));
        let number = i64::from(self.next) % (columns * rows).max(1);
        let centre = |number: i64, count: i64, size: u16| {
            ((2 * number + 1) * i64::from(size) * PIXEL / (2 * count.max(1)) - PIXEL / 2).max(0)
        };
        let x = centre(number % columns.max(1), columns, bounds.width);
        Lattice { x, y: centre(number / columns.max(1), rows, bounds.height), ..window }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn windows_cover_the_frame_and_begin_again() {
        let window = Lattice { x: 0, y: 0, step: PIXEL, columns: 96, rows: 96 };
        let mut sweep = Sweep::new();
        let mut centres = Vec::new();
        for _ in 0..20 {
            let at = sweep.place(window, Rect::new(0, 0, 320, 240));
            centres.push((at.x / PIXEL, at.y / PIXEL));
            sweep.advance();
        }
        assert_eq!(centres[..3], [(31, 29), (95, 29), (159, 29)]);
        assert_eq!(centres[19], (287, 209));
        let again = sweep.place(window, Rect::new(0, 0, 320, 240));
        assert_eq!((again.x / PIXEL, again.y / PIXEL), centres[0]);
    }
}
