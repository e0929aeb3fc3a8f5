//! Keeps the part of the frame that a cropped video shows on its target, without trembling.

use smr_recordings::BoundingBox;

/// Side of the part, in longer sides of the first box.
const AROUND: f64 = 3.0;
/// Most by which the target may be off the middle, in longer sides of the first box: the tracker's jitter is less, and a
/// target that moves slowly does not carry it into the picture.
const SLACK: f64 = 0.02;
/// Frames in which the part moves to a target that was lost and is found elsewhere.
const GLIDE: u32 = 10;

/// A square around a target, computed from the frames so far.
pub struct Steady {
    middle: (f64, f64),
    /// Longer side of the first box.
    unit: f64,
    /// From the target to the middle when it was found, and the frames since then; `None` while it is lost.
    found: Option<((f64, f64), u32)>,
}

impl Steady {
    pub fn new(first: &BoundingBox) -> Self {
        let unit = first.width.max(first.height);
        Self { middle: first.centre(), unit, found: Some(((0.0, 0.0), GLIDE)) }
    }

    /// Returns the side of the square in pixels.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
    pub fn side(&self) -> u32 {
        (self.unit * AROUND).ceil() as u32
    }

    /// Returns the middle of the square in the next frame, in which the target has the box `seen`, if it is not lost.
    pub fn next(&mut self, seen: Option<&BoundingBox>) -> (f64, f64) {
        let Some((x, y)) = seen.map(BoundingBox::centre) else {
            self.found = None;
            return self.middle;
        };
        let (off, frames) = self.found.unwrap_or(((self.middle.0 - x, self.middle.1 - y), 0));
        self.found = Some((off, GLIDE.min(frames + 1)));
        let left = 1.0 - f64::from(frames) / f64::from(GLIDE);
        // It starts and ends slowly.
        let left = left * left * (3.0 - 2.0 * left);
        let way = (x + off.0 * left - self.middle.0, y + off.1 * left - self.middle.1);
        let length = way.0.hypot(way.1);
        if length > 0.0 {
            // What is left of the way is always shorter than the slack, and most of a short way is left.
            let part = length / (length + SLACK * self.unit);
            self.middle = (self.middle.0 + way.0 * part, self.middle.1 + way.1 * part);
        }
        self.middle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around((x, y): (f64, f64)) -> BoundingBox {
        BoundingBox { x: x - 25.0, y: y - 10.0, width: 50.0, height: 20.0 }
    }

    fn far((x, y): (f64, f64), (left, top): (f64, f64)) -> f64 {
        (x - left).hypot(y - top)
    }

    #[test]
    fn the_target_stays_in_the_middle_and_jitter_is_lost() {
        let mut steady = Steady::new(&around((100.0, 80.0)));
        assert_eq!(steady.side(), 150);
        // However fast it moves.
        for speed in [0.0, 0.5, 3.0, 40.0, -20.0] {
            for frame in 0..30 {
                let at = (100.0 + speed * f64::from(frame), 80.0 - speed * f64::from(frame));
                let middle = steady.next(Some(&around(at)));
                assert!(far(middle, at) <= SLACK * 50.0, "{speed} {frame} {middle:?} {at:?}");
            }
        }
        let mut steady = Steady::new(&around((100.0, 80.0)));
        let jitter = [0.2, -0.3, 0.1, -0.2, 0.4, -0.1, -0.3, 0.2];
        let middles = jitter.map(|off| steady.next(Some(&around((100.0 + off, 80.0)))).0);
        let trembling = |places: &[f64]| places.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>();
        assert!(trembling(&middles) < trembling(&jitter) / 3.0, "{middles:?}");
    }

    #[test]
    fn a_target_that_is_found_elsewhere_is_reached_without_a_jump() {
        let mut steady = Steady::new(&around((100.0, 80.0)));
        steady.next(Some(&around((100.0, 80.0))));
        assert_eq!([None, None].map(|lost| steady.next(lost)), [(100.0, 80.0); 2]);
        let (mut before, mut widest) = ((100.0, 80.0), 0.0_f64);
        for frame in 0..=GLIDE {
            let at = (400.0 + f64::from(frame), 80.0);
            let middle = steady.next(Some(&around(at)));
            widest = widest.max(far(middle, before));
            before = middle;
        }
        assert!(widest < 60.0, "{widest} pixels in a frame, of 300");
        assert!(far(before, (400.0 + f64::from(GLIDE), 80.0)) < 1.0, "{before:?}");
        // Lost again on the way, it stays where it is.
        steady.next(None);
        for _ in 0..5 {
            before = steady.next(Some(&around((100.0, 80.0))));
        }
        assert_eq!(steady.next(None), before);
    }
}
