//! The best offset so far, and the least score with which an offset can still change the result.
//!
//! If the runner-up is wanted, the least score is bounded by a floor:
//!
//! 1. If two offsets are more than 2 * neighbourhood apart (in x or in y), no peak has both in its neighbourhood.
//! 2. So for any final peak the runner-up is at least the lower score of such a pair. The floor is the best of these.
//! 3. An offset at or below the floor changes neither the peak nor the runner-up.

use super::runner_up::Maxima;
use super::window::{Peak, Peaks, Wanted, Window};
use core::cmp::Ordering;

pub(super) struct Leaders<const SPAN: usize> {
    best: Option<Peak>,
    second_goal: SecondGoal,
    needed: u32,
    maxima: Maxima<SPAN>,
}

/// The second goal of a search, besides the peak, and the progress towards it: none; to find out whether an offset
/// outside the peak's neighbourhood scores as much as the peak; or to find the runner-up.
#[derive(Clone, Copy)]
enum SecondGoal {
    Nothing,
    Equals(Equals),
    RunnerUp { neighbourhood: u16, floor: u32 },
}

/// The bounding box of the offsets with the peak's score. Each side touches such an offset, so the box suffices to
/// decide whether one of the offsets lies outside the peak's neighbourhood.
#[derive(Clone, Copy)]
struct Equals {
    neighbourhood: u16,
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
}

impl Equals {
    const fn of(neighbourhood: u16, peak: &Peak) -> Self {
        Self { neighbourhood, left: peak.x, right: peak.x, top: peak.y, bottom: peak.y }
    }

    fn add(&mut self, other: &Peak) {
        (self.left, self.right) = (self.left.min(other.x), self.right.max(other.x));
        (self.top, self.bottom) = (self.top.min(other.y), self.bottom.max(other.y));
    }

    /// True if two offsets with the peak's score are more than 2 * neighbourhood apart (in x or in y). Then one of the
    /// two is outside the peak's neighbourhood, whichever offset is the peak.
    fn are_apart(&self) -> bool {
        self.right.abs_diff(self.left).max(self.bottom.abs_diff(self.top)) > 2 * u32::from(self.neighbourhood)
    }

    fn are_outside(&self, peak: &Peak) -> bool {
        let columns = peak.x.abs_diff(self.left).max(self.right.abs_diff(peak.x));
        let rows = peak.y.abs_diff(self.top).max(self.bottom.abs_diff(peak.y));
        columns.max(rows) > self.neighbourhood.into()
    }
}

impl<const SPAN: usize> Leaders<SPAN> {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self { best: None, second_goal: SecondGoal::Nothing, needed: 0, maxima: Maxima::new() }
    }

    #[cfg_attr(smr_small, inline(never))]
    pub(super) fn reset(&mut self, window: &Window, wanted: Wanted) {
        (self.best, self.needed) = (None, 0);
        self.second_goal = match wanted {
            Wanted::Peak => SecondGoal::Nothing,
            Wanted::Equals(radius) => SecondGoal::Equals(Equals::of(radius, &Peak { x: 0, y: 0, score: 0 })),
            Wanted::RunnerUp(neighbourhood) => SecondGoal::RunnerUp { neighbourhood, floor: 0 },
        };
        self.maxima.reset(window);
    }

    pub(super) const fn best(&self) -> Option<Peak> {
        self.best
    }

    /// The least score with which an offset can still change the result.
    pub(super) const fn needed(&self) -> u32 {
        self.needed
    }

    /// The least score with which the offset at (`x`, `y`) can still change the result. It is one more than
    /// [`Self::needed`] if the offset loses a tie with the peak and cannot become the runner-up.
    pub(super) fn needed_at(&self, window: &Window, x: i32, y: i32) -> u32 {
        let needed = self.needed();
        let loses_tie = self.best.is_some_and(|best| {
            let is_decided = match &self.second_goal {
                SecondGoal::Nothing => true,
                SecondGoal::Equals(equals) => equals.are_apart(),
                SecondGoal::RunnerUp { floor, .. } => *floor >= best.score,
            };
            is_decided && best.score == needed && best.beats(&Peak { x, y, score: needed }, window)
        });
        needed.saturating_add(u32::from(loses_tie))
    }

    pub(super) fn note(&mut self, window: &Window, candidate: Peak) {
        match (&mut self.second_goal, &self.best) {
            (SecondGoal::Nothing, _) => {}
            (SecondGoal::Equals(equals), best) => {
                match best.map_or(Ordering::Greater, |best| candidate.score.cmp(&best.score)) {
                    Ordering::Less => {}
                    Ordering::Equal => equals.add(&candidate),
                    Ordering::Greater => *equals = Equals::of(equals.neighbourhood, &candidate),
                }
            }
            (SecondGoal::RunnerUp { neighbourhood, floor }, best) => {
                if let Some(best) = best
                    && candidate.is_further_than(2 * u32::from(*neighbourhood), best)
                {
                    *floor = candidate.score.min(best.score).max(*floor);
                }
                self.maxima.note(window, &candidate);
            }
        }
        if self.best.is_none_or(|best| candidate.beats(&best, window)) {
            self.best = Some(candidate);
        }
        self.set_needed();
    }

    fn set_needed(&mut self) {
        let best = self.best.map_or(0, |best| best.score);
        self.needed = match self.second_goal {
            SecondGoal::RunnerUp { floor, .. } => best.min(floor.saturating_add(1)),
            _ => best,
        };
    }

    /// Raises the floor to the best score that two distant offsets both reach. (`note` tries only pairs with the peak.)
    pub(super) fn raise_floor(&mut self) {
        if let SecondGoal::RunnerUp { neighbourhood, floor } = &mut self.second_goal {
            *floor = self.maxima.both_reach(2 * usize::from(*neighbourhood)).max(*floor);
            self.set_needed();
        }
    }

    pub(super) const fn looks_for_runner_up(&self) -> bool {
        matches!(self.second_goal, SecondGoal::RunnerUp { .. })
    }

    pub(super) fn peaks(&self, window: &Window) -> Option<Peaks> {
        let peak = self.best?;
        let runner_up = match &self.second_goal {
            SecondGoal::Nothing => None,
            SecondGoal::Equals(equals) => (peak.score > 0 && equals.are_outside(&peak)).then_some(peak.score),
            SecondGoal::RunnerUp { neighbourhood, .. } => Some(self.maxima.outside(window, &peak, *neighbourhood)),
        };
        Some(Peaks { peak, runner_up })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rect;
    use crate::track::paper::search::Radius;

    /// If the floor is 1 below the peak's score, an offset of equal score that loses the tie is the runner-up.
    #[test]
    fn a_runner_up_may_score_as_much_as_the_peak() {
        let window = Window::new(Rect::new(20, 20, 4, 4), Radius { x: 10, y: 10 }, Rect::new(0, 0, 60, 60), 0);
        let mut leaders = Leaders::<21>::new();
        leaders.reset(&window, Wanted::RunnerUp(2));
        leaders.note(&window, Peak { x: 20, y: 20, score: 4 });
        leaders.note(&window, Peak { x: 30, y: 20, score: 3 });
        assert_eq!(leaders.needed_at(&window, 10, 20), 4);
        leaders.note(&window, Peak { x: 10, y: 20, score: 4 });
        assert_eq!(leaders.peaks(&window).and_then(|peaks| peaks.runner_up), Some(4));
        // The runner-up equals the peak, so only a larger score changes the result.
        assert_eq!(leaders.needed_at(&window, 10, 25), 5);
    }
}
