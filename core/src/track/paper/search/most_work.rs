//! Upper bound of the comparisons of a search, even if no offset can be excluded. Counted as in `scan.rs`.

use super::exclusion::{Ranges, SIDE};
use super::scan::{MAX_STEPS, SAD_STEP, first_step_of};

/// The sizes that determine the work of a search.
pub(crate) struct Extent {
    /// The number of offsets of the window on each axis.
    pub(crate) window: (usize, usize),
    /// Pixels of the template on each axis.
    pub(crate) template: (u16, u16),
    pub(crate) pruning: bool,
}

impl Extent {
    fn offsets(&self) -> u64 {
        wide(self.window.0) * wide(self.window.1)
    }

    fn pixels(&self) -> u64 {
        u64::from(self.template.0) * u64::from(self.template.1)
    }

    fn maxima_count(&self) -> u64 {
        wide(self.window.0) + wide(self.window.1)
    }

    /// The largest number of comparisons of the descent: its SADs, and the scores at its start and at its end.
    fn descent(&self) -> u64 {
        let step = first_step_of(self.window);
        if !self.pruning {
            return 0;
        }
        if step == 0 {
            return self.pixels();
        }
        let sad = u64::from(self.template.0) * u64::from(self.template.1.div_ceil(SAD_STEP));
        2 * self.pixels() + sad * (1 + 8 * u64::from(step.ilog2() + 1).min(wide(MAX_STEPS)))
    }

    /// Upper bound of the comparisons for the peak: scoring every offset and bounding every group of the window once.
    fn peak<const PIXELS: usize, const SPAN: usize>(&self) -> u64 {
        let groups = if self.pruning { Ranges::<PIXELS, SPAN>::most(self.window, self.template) } else { 0 };
        self.offsets() * self.pixels() + groups
    }

    /// Upper bound of the comparisons for the runner-up: scoring nine scouts and then the whole window; reading the
    /// maxima once at the start, once at the end, and to raise the floor (at most 1/32 of the scoring and bounding).
    fn runner_up<const PIXELS: usize, const SPAN: usize>(&self) -> u64 {
        let scouts = if self.offsets() >= 288 { 9 * self.pixels() } else { 0 };
        let all = scouts + self.peak::<PIXELS, SPAN>();
        all + if self.pruning { all / 32 } else { 0 } + 2 * self.maxima_count()
    }

    /// Upper bound of a search's comparisons, with or without the runner-up. `again` adds a second search for it.
    pub(crate) fn most<const PIXELS: usize, const SPAN: usize>(&self, runner_up: bool, again: bool) -> u64 {
        let first = match (runner_up, self.pruning) {
            (true, true) => self.runner_up::<PIXELS, SPAN>(),
            // Every offset is scored; the maxima are read at the end.
            (true, false) => self.peak::<PIXELS, SPAN>() + self.maxima_count(),
            (false, _) => self.peak::<PIXELS, SPAN>(),
        };
        self.descent() + first + if again { self.runner_up::<PIXELS, SPAN>() } else { 0 }
    }

    /// Upper bound of the comparisons by which a step exceeds its grant: one offset, group or row of ranges, whichever
    /// takes the most, plus 1 for each of 7 * `SPAN` words of working memory read.
    pub(crate) fn most_beyond_a_step<const SPAN: usize>(&self) -> u32 {
        let row = 2 * (wide(self.window.0) + u64::from(self.template.0)).saturating_sub(wide(SIDE));
        let most = self.pixels().max(row) + 7 * wide(SPAN);
        u32::try_from(most).unwrap_or(u32::MAX)
    }
}

fn wide(count: usize) -> u64 {
    u64::try_from(count).unwrap_or(u64::MAX)
}
