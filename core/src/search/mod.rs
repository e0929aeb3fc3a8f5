//! Which offsets are scored, and what they say: the **peak** and the **runner-up**.
//!
//! The tie rule: of equal scores the offset closest to the window's centre wins (by x^2 + y^2), of equally close ones
//! the upper, then the left one. A target without texture therefore stays where it was.

mod maxima;
mod window;

pub(crate) use maxima::Maxima;
pub use window::Window;

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

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found {
    /// The offset with the largest score.
    pub peak: Peak,
    /// The largest score outside the peak's neighbourhood; 0 if the window does not reach beyond it.
    pub runner_up: u32,
}

/// Scores every offset of `window` with `score` and keeps the peak and the runner-up (step 4 of the method).
///
/// `maxima` has room for the window (the caller has checked). `None` if `score` has no answer for an offset.
pub(crate) fn exhaustive<const SPAN: usize>(
    window: &Window,
    neighbourhood: u16,
    maxima: &mut Maxima<SPAN>,
    mut score: impl FnMut(i32, i32) -> Option<u32>,
) -> Option<Found> {
    maxima.reset(window);
    let mut best: Option<Peak> = None;
    for (row, y) in window.ys().enumerate() {
        for (column, x) in window.xs().enumerate() {
            let candidate = Peak { x, y, score: score(x, y)? };
            maxima.note(column, row, candidate.score);
            if best.is_none_or(|best| window.rank(&candidate) > window.rank(&best)) {
                best = Some(candidate);
            }
        }
    }
    let peak = best?;
    Some(Found { peak, runner_up: maxima.outside(window, &peak, neighbourhood) })
}

impl Window {
    /// What makes one offset better than another: its score, then the tie rule.
    fn rank(&self, candidate: &Peak) -> (u32, Reverse<(u64, i32, i32)>) {
        let dx = u64::from(candidate.x.abs_diff(self.centre_x));
        let dy = u64::from(candidate.y.abs_diff(self.centre_y));
        (candidate.score, Reverse((dx * dx + dy * dy, candidate.y, candidate.x)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Radius, Rect};
    use proptest::prelude::*;

    fn window(x: i32, y: i32, radius_x: u16, radius_y: u16) -> Window {
        Window::new(Rect::new(x, y, 4, 4), Radius { x: radius_x, y: radius_y }, Rect::new(0, 0, 24, 24), 2)
    }

    #[test]
    fn among_equals_the_closest_wins_then_the_upper_then_the_left_one() {
        let window = window(10, 10, 5, 5);
        let mut maxima = Maxima::<11>::new();
        let mut peak_of = |equals: &[(i32, i32)]| {
            let score = |x, y| Some(u32::from(equals.contains(&(x, y))));
            let peak = exhaustive(&window, 8, &mut maxima, score).unwrap().peak;
            (peak.x, peak.y)
        };
        assert_eq!(peak_of(&[(8, 10), (10, 11), (15, 15)]), (10, 11));
        assert_eq!(peak_of(&[(10, 11), (11, 10), (9, 10), (10, 9)]), (10, 9));
        assert_eq!(peak_of(&[(11, 10), (9, 10)]), (9, 10));
        assert_eq!(peak_of(&[]), (10, 10));
    }

    #[test]
    fn an_offset_without_a_score_is_no_answer() {
        let mut maxima = Maxima::<11>::new();
        let found = exhaustive(&window(10, 10, 5, 5), 8, &mut maxima, |x, _| (x < 12).then_some(1));
        assert_eq!(found, None);
    }

    proptest! {
        #[test]
        fn peak_and_runner_up_are_those_of_the_whole_map(
            (x, y) in (-2i32..=22, -2i32..=22),
            (radius_x, radius_y, neighbourhood) in (0u16..12, 0u16..12, 0u16..6),
            seed in any::<u32>(),
        ) {
            // Few different scores, so that ties abound.
            let score_of = |x: i32, y: i32| {
                ((x + 40) as u32).wrapping_mul(2_654_435_761).wrapping_add((y + 40) as u32 ^ seed).wrapping_mul(40_503) >> 29
            };
            let window = window(x, y, radius_x, radius_y);
            let mut maxima = Maxima::<25>::new();
            let found = exhaustive(&window, neighbourhood, &mut maxima, |x, y| Some(score_of(x, y))).unwrap();
            let all = || window.ys().flat_map(|y| window.xs().map(move |x| (x, y)));

            let best = all().map(|(x, y)| score_of(x, y)).max().unwrap();
            prop_assert_eq!(found.peak.score, best);
            prop_assert_eq!(score_of(found.peak.x, found.peak.y), best);
            let distance = |x: i32, y: i32| (x - window.centre_x).pow(2) + (y - window.centre_y).pow(2);
            let closest = all().filter(|&(x, y)| score_of(x, y) == best).map(|(x, y)| distance(x, y)).min();
            prop_assert_eq!(Some(distance(found.peak.x, found.peak.y)), closest);

            let near = i32::from(neighbourhood);
            let far = all().filter(|(x, y)| (x - found.peak.x).abs().max((y - found.peak.y).abs()) > near);
            prop_assert_eq!(found.runner_up, far.map(|(x, y)| score_of(x, y)).max().unwrap_or(0));
        }
    }
}
