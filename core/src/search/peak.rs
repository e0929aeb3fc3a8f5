//! The goal of a search, its result, and the tie rule.

use super::window::Window;

/// The score of one offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Peak {
    /// Left edge of the box, in pixels of the frame.
    pub x: i32,
    /// Top edge of the box, in pixels of the frame.
    pub y: i32,
    /// The sum of the similarities, each in units of 1/65535.
    pub score: u32,
}

impl Peak {
    /// True if this offset is the peak rather than `other`: by the score, then by the tie rule.
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    pub(super) fn beats(&self, other: &Self, window: &Window) -> bool {
        if self.score == other.score { self.order(window) < other.order(window) } else { self.score > other.score }
    }

    /// The key of the tie rule: of equal scores the offset with the least key is the peak.
    fn order(&self, window: &Window) -> (u64, i32, i32) {
        let (x, y) = window.centre();
        let (dx, dy) = (u64::from(self.x.abs_diff(x)), u64::from(self.y.abs_diff(y)));
        (dx * dx + dy * dy, self.y, self.x)
    }

    /// True if `other` is more than `distance` pixels away in x or in y.
    pub(super) fn is_further_than(&self, distance: u32, other: &Self) -> bool {
        self.x.abs_diff(other.x).max(self.y.abs_diff(other.y)) > distance
    }
}

/// The goal of a search. The number is the radius of the peak's neighbourhood in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// The peak alone.
    Peak,
    /// The peak, and whether an offset outside its neighbourhood has the same score. Costs little more than the peak
    /// alone.
    Equals(u16),
    /// The peak and the runner-up.
    RunnerUp(u16),
}

/// The result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found {
    /// The offset with the largest score.
    pub peak: Peak,
    /// The largest score outside the peak's neighbourhood; 0 if the neighbourhood covers the window. `None` if the
    /// decision did not depend on it: see [`runner_up_always`](crate::paper::Config::runner_up_always).
    pub runner_up: Option<u32>,
}
