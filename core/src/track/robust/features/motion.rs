//! The target's motion: predicts its place in the next frame from its last place and its velocity.
//!
//! ```text
//! expected  = place + velocity / 2
//! velocity' = (velocity + place' - place) / 2
//! ```
//!
//! Positions are in units of 1/4096 pixel. A pixel's position is that of its middle. Scales are in units of 1/65536.
//! Positions lie within the frame, so coordinates are below 2^28.

use super::super::constants::{PIXEL, SCALE};
use super::grid::Grid;
use crate::image::Rect;

/// The middle of a target in the frame (1/4096 pixel), and its scale (1/65536).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) x: i64,
    pub(crate) y: i64,
    pub(crate) scale: u32,
}

impl Place {
    pub(crate) const NONE: Self = Self { x: 0, y: 0, scale: 0 };

    /// The middle of a box, at scale 1.
    #[inline(never)]
    pub(crate) fn of(target: Rect) -> Self {
        let middle = |from: i32, size: u16| (2 * i64::from(from) + i64::from(size) - 1) * PIXEL / 2;
        Self { x: middle(target.x, target.width), y: middle(target.y, target.height), scale: SCALE }
    }

    /// Moves the place right and down, in units of 1/64 pixel of the grid.
    pub(crate) fn moved(self, grid: &Grid, (right, down): (i32, i32)) -> Self {
        let moved = |from: i64, by: i32| from + ((i64::from(by) * grid.step_at(self.scale)) >> 6);
        Self { x: moved(self.x, right), y: moved(self.y, down), ..self }
    }

    #[inline(never)]
    pub(crate) fn inside(self, bounds: Rect) -> Self {
        let end = |size: u16| i64::from(size.saturating_sub(1)) * PIXEL;
        Self { x: self.x.clamp(0, end(bounds.width)), y: self.y.clamp(0, end(bounds.height)), ..self }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Motion {
    pub(crate) place: Place,
    /// Velocity to the right and down, in units of 1/4096 pixel per frame.
    pub(crate) velocity: [i64; 2],
}

impl Motion {
    pub(crate) const fn at(place: Place) -> Self {
        Self { place, velocity: [0; 2] }
    }

    /// Predicts the place in the next frame, clamped to the frame.
    #[inline(never)]
    pub(crate) fn expected(&self, bounds: Rect) -> Place {
        let [right, down] = self.velocity;
        let Place { x, y, scale } = self.place;
        Place { x: x + (right >> 1), y: y + (down >> 1), scale }.inside(bounds)
    }

    /// Moves to the place in this frame, and updates the velocity. `None` keeps the place and halves the velocity.
    pub(crate) fn follow(&mut self, place: Option<Place>) {
        let (place, [right, down]) = (place.unwrap_or(self.place), self.velocity);
        self.velocity = [(place.x - self.place.x + right) >> 1, (place.y - self.place.y + down) >> 1];
        self.place = place;
    }

    /// Moves the place by `right` / 256 and `down` / 256 pixels, when the camera turns. The target's velocity stays.
    pub(crate) fn shift(&mut self, right: i32, down: i32, bounds: Rect) {
        let Place { x, y, scale } = self.place;
        self.place = Place { x: x + (i64::from(right) << 4), y: y + (i64::from(down) << 4), scale }.inside(bounds);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_velocity_is_expected() {
        let bounds = Rect::new(0, 0, 100, 80);
        let mut motion = Motion::at(Place::of(Rect::new(20, 20, 11, 11)));
        let at = |x: i64| Place { x: x * PIXEL, y: 25 * PIXEL, scale: SCALE };
        assert_eq!(motion.place, at(25));
        motion.follow(Some(at(33)));
        assert_eq!(motion.expected(bounds), at(35));
        motion.follow(Some(at(97)));
        assert_eq!(motion.expected(bounds), at(99), "no further than the frame");
        assert_eq!(Motion::at(at(40)).expected(bounds), at(40));
    }
}
