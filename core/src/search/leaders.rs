//! Who leads: the peak so far, and the score below which an offset changes nothing.
//!
//! Where the runner-up is wanted too, an offset may be left out only if another peak could not make it the runner-up:
//!
//! 1. Of two offsets more than twice the neighbourhood apart (in x or in y), no peak has both in its neighbourhood.
//! 2. So wherever the peak ends, the runner-up is at least the smaller score of any such pair: the floor.
//! 3. A score at or below the floor is neither above the peak nor above the runner-up, which the pair's scores or larger
//!    ones decide; and those have been noted.

use super::{Found, Maxima, Peak, Window};

pub(super) struct Leaders<const SPAN: usize> {
    best: Option<Peak>,
    /// `None` if only the peak is wanted.
    runner_up: Option<Apart>,
    maxima: Maxima<SPAN>,
}

/// How far the runner-up is from the peak, and what is known of it.
#[derive(Clone, Copy)]
struct Apart {
    neighbourhood: u16,
    floor: u32,
}

impl<const SPAN: usize> Leaders<SPAN> {
    pub(super) const fn new() -> Self {
        Self { best: None, runner_up: None, maxima: Maxima::new() }
    }

    /// Forgets everything. With a neighbourhood, the runner-up outside it is looked for, too.
    pub(super) fn reset(&mut self, window: &Window, neighbourhood: Option<u16>) {
        self.best = None;
        self.runner_up = neighbourhood.map(|neighbourhood| Apart { neighbourhood, floor: 0 });
        self.maxima.reset(window);
    }

    pub(super) const fn best(&self) -> Option<Peak> {
        self.best
    }

    /// The least score with which some offset could still change the result.
    pub(super) fn needed(&self) -> u32 {
        let best = self.best.map_or(0, |best| best.score);
        self.runner_up.map_or(best, |runner_up| best.min(runner_up.floor.saturating_add(1)))
    }

    /// The least score with which the offset at (`x`, `y`) could.
    pub(super) fn needed_at(&self, window: &Window, x: i32, y: i32) -> u32 {
        let needed = self.needed();
        // As good as the peak is not enough for who loses the tie.
        let ties = self.best.is_some_and(|best| {
            best.score == needed && window.rank(&Peak { x, y, score: needed }) < window.rank(&best)
        });
        needed.saturating_add(u32::from(ties))
    }

    /// Takes note of a score.
    pub(super) fn note(&mut self, window: &Window, candidate: Peak) {
        if let (Some(runner_up), Some(best)) = (&mut self.runner_up, &self.best)
            && candidate.is_further_than(2 * u32::from(runner_up.neighbourhood), best)
        {
            runner_up.floor = runner_up.floor.max(candidate.score.min(best.score));
        }
        if self.runner_up.is_some() {
            self.maxima.note(window, &candidate);
        }
        if self.best.is_none_or(|best| window.rank(&candidate) > window.rank(&best)) {
            self.best = Some(candidate);
        }
    }

    /// Looks for pairs among all that has been noted; `note` sees only those with the peak.
    pub(super) fn look_for_pairs(&mut self) {
        if let Some(runner_up) = &mut self.runner_up {
            let distance = 2 * usize::from(runner_up.neighbourhood);
            runner_up.floor = runner_up.floor.max(self.maxima.both_reach(distance));
        }
    }

    pub(super) const fn looks_for_runner_up(&self) -> bool {
        self.runner_up.is_some()
    }

    pub(super) fn found(&self, window: &Window) -> Option<Found> {
        let peak = self.best?;
        let runner_up = self.runner_up.map(|runner_up| self.maxima.outside(window, &peak, runner_up.neighbourhood));
        Some(Found { peak, runner_up })
    }
}

impl Peak {
    /// More than `distance` pixels away in x or in y.
    fn is_further_than(&self, distance: u32, other: &Self) -> bool {
        self.x.abs_diff(other.x).max(self.y.abs_diff(other.y)) > distance
    }
}
