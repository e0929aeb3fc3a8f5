//! What is remembered of a target beside its filter and its templates: place, size, velocity, and what is believed of it.

use super::exact::MARGIN;
use super::features::CELL;
use super::grid::{Grid, Lattice, PIXEL, SCALE};
use super::sweep::Sweep;
use super::trust::Trust;
use crate::image::{FineRect, Rect};
use crate::track::Quality;

/// A target's middle and size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) x: i64,
    pub(super) y: i64,
    pub(super) scale: u32,
}

impl Place {
    /// The middle of a box.
    pub(super) fn of(target: Rect) -> Self {
        let middle = |from: i32, size: u16| (2 * i64::from(from) + i64::from(size) - 1) * PIXEL / 2;
        Self { x: middle(target.x, target.width), y: middle(target.y, target.height), scale: SCALE }
    }

    /// Moved by units of 1/64 pixel of the grid.
    pub(super) fn moved(self, grid: &Grid, (right, down): (i32, i32)) -> Self {
        let moved = |from: i64, by: i32| from + ((i64::from(by) * grid.step_at(self.scale)) >> 6);
        Self { x: moved(self.x, right), y: moved(self.y, down), ..self }
    }

    /// Moved into a frame.
    #[inline(never)] // one copy in flash
    pub(super) fn inside(self, bounds: Rect) -> Self {
        let end = |size: u16| i64::from(size.saturating_sub(1)) * PIXEL;
        Self { x: self.x.clamp(0, end(bounds.width)), y: self.y.clamp(0, end(bounds.height)), ..self }
    }

    /// The search window up to `reach` cells around, with the pixel on each side that gradients need.
    pub(super) fn window(self, grid: &Grid, reach: u16) -> Lattice {
        let side = |cells: u16| (cells + 2 * reach) * CELL + 2;
        self.lattice(grid, side(grid.across), side(grid.down))
    }

    /// The template, and `MARGIN` pixels on each side.
    pub(super) fn view(self, grid: &Grid) -> Lattice {
        self.lattice(grid, grid.columns + 2 * MARGIN, grid.rows + 2 * MARGIN)
    }

    #[inline(never)] // one copy in flash
    fn lattice(self, grid: &Grid, columns: u16, rows: u16) -> Lattice {
        Lattice { x: self.x, y: self.y, step: grid.step_at(self.scale), columns, rows }
    }
}

/// What is remembered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Track {
    pub(super) bounds: Rect,
    pub(super) grid: Grid,
    /// Of the box that was locked on.
    pub(super) width: u16,
    pub(super) height: u16,
    pub(super) place: Place,
    /// How far it moves from frame to frame: the mean of the last move and of what was said before.
    pub(super) right: i64,
    pub(super) down: i64,
    /// The scale when the target was last tracked.
    pub(super) believed: u32,
    pub(super) trust: Trust,
    pub(super) sweep: Sweep,
    /// Of the target that was locked on.
    pub(super) quality: Quality,
}

impl Track {
    pub(super) fn new(bounds: Rect, target: Rect) -> Self {
        Self {
            bounds,
            grid: Grid::new(target),
            width: target.width,
            height: target.height,
            place: Place::of(target),
            right: 0,
            down: 0,
            believed: SCALE,
            trust: Trust::new(),
            sweep: Sweep::new(),
            quality: Quality::NONE,
        }
    }

    /// Where it is expected in the next frame: half of the velocity further, where that is asked for.
    pub(super) fn expected(&self, velocity: bool) -> Place {
        let Place { x, y, scale } = self.place;
        let further = |from: i64, by: i64| if velocity { from + (by >> 1) } else { from };
        Place { x: further(x, self.right), y: further(y, self.down), scale }.inside(self.bounds)
    }

    /// It is followed to `place`.
    pub(super) fn follow(&mut self, place: Place) {
        self.right = (place.x - self.place.x + self.right) >> 1;
        self.down = (place.y - self.place.y + self.down) >> 1;
        self.place = place;
    }

    /// Nothing is seen of it: it stays, and is expected to go on half as fast.
    pub(super) fn hold(&mut self) {
        self.follow(self.place);
    }

    /// The picture has moved, by units of 1/256 pixel; the target is expected in the frame. Its own velocity stays.
    pub(super) fn moved(&mut self, right: i32, down: i32) {
        let Place { x, y, scale } = self.place;
        self.place = Place { x: x + (i64::from(right) << 4), y: y + (i64::from(down) << 4), scale }.inside(self.bounds);
    }

    /// It is found again at `place`.
    pub(super) fn find(&mut self, place: Place) {
        (self.right, self.down, self.place) = (0, 0, place);
    }

    /// Its size is right.
    pub(super) fn believe(&mut self) {
        self.believed = self.place.scale;
    }

    /// Where it is looked for next if it is lost, at the scale that was last believed.
    #[inline(never)] // one copy in flash
    pub(super) fn sweep(&self, reach: u16) -> Place {
        let across = i64::from(2 * reach * CELL) * self.grid.step_at(self.believed);
        let (x, y) = self.sweep.place(across, self.bounds);
        Place { x, y, scale: self.believed }
    }

    /// That place was looked at.
    pub(super) fn swept(&mut self) {
        self.sweep.advance();
    }

    /// The target's box.
    pub(super) fn bbox(&self) -> FineRect {
        let size = |size: u16| {
            u32::try_from((u64::from(size) * u64::from(self.place.scale) + (1 << 7)) >> 8).unwrap_or(u32::MAX)
        };
        let (width, height) = (size(self.width), size(self.height));
        let corner = |middle: i64, size: u32| {
            let corner = ((middle + PIXEL / 2) >> 4) - i64::from(size / 2);
            i32::try_from(corner).unwrap_or(0)
        };
        FineRect { x: corner(self.place.x, width), y: corner(self.place.y, height), width, height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_velocity_is_expected() {
        let mut track = Track::new(Rect::new(0, 0, 100, 80), Rect::new(20, 20, 11, 11));
        let at = |x: i64| Place { x: x * PIXEL, y: 25 * PIXEL, scale: SCALE };
        assert_eq!(track.place, at(25));
        track.follow(at(33));
        assert_eq!(track.expected(true), at(35));
        assert_eq!(track.expected(false), at(33));
        track.follow(at(97));
        assert_eq!(track.expected(true), at(99), "no further than the frame");
        track.find(at(40));
        assert_eq!(track.expected(true), at(40));
    }

    #[test]
    fn a_box_grows_around_its_middle() {
        let mut track = Track::new(Rect::new(0, 0, 100, 80), Rect::new(20, 30, 10, 20));
        assert_eq!(track.bbox().whole(), Rect::new(20, 30, 10, 20));
        track.place.scale = 2 * SCALE;
        assert_eq!(track.bbox().whole(), Rect::new(15, 20, 20, 40));
    }
}
