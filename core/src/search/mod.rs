//! Which offsets are scored, and what they say: the **peak** and the **runner-up**.
//!
//! The tie rule: of equal scores the offset closest to the window's centre wins (by x^2 + y^2), of equally close ones
//! the upper, then the left one. A target without texture therefore stays where it was.

mod bound;
mod leaders;
mod maxima;
mod ranges;
mod scan;
mod window;

pub(crate) use bound::Extent;
pub(crate) use scan::{Scene, Search};
pub use window::{Radius, Window};

use maxima::Maxima;

use core::cmp::Reverse;

/// A position of the template's top left corner in the frame, and its score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Peak {
    /// Left edge of the box, in the frame.
    pub x: i32,
    /// Top edge of the box, in the frame.
    pub y: i32,
    /// The sum of the similarities.
    pub score: u32,
}

/// What a search looks for; the numbers are the peak's neighbourhood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// The peak alone.
    Peak,
    /// The peak, and whether an offset outside its neighbourhood scores as much. Little more work than the peak alone.
    Equals(u16),
    /// The peak and the runner-up.
    RunnerUp(u16),
}

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found {
    /// The offset with the largest score.
    pub peak: Peak,
    /// The largest score outside the peak's neighbourhood; 0 if the window does not reach beyond it. `None` if nothing
    /// depends on it: see [`RunnerUp`](crate::paper::RunnerUp).
    pub runner_up: Option<u32>,
}

impl Window {
    /// What makes one offset better than another: its score, then the tie rule.
    fn rank(&self, candidate: &Peak) -> (u32, Reverse<(u64, i32, i32)>) {
        let dx = u64::from(candidate.x.abs_diff(self.centre().0));
        let dy = u64::from(candidate.y.abs_diff(self.centre().1));
        (candidate.score, Reverse((dx * dx + dy * dy, candidate.y, candidate.x)))
    }
}

#[cfg(test)]
mod tests;
