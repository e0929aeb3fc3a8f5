//! Finds the runner-up from the largest score of each row and of each column of the window.
//!
//! 1. The neighbourhood of the peak is a square. Outside are whole rows (above, below) and columns (left, right).
//! 2. So the largest score outside is exactly the largest of the maxima of those rows and columns.
//! 3. The maxima can be collected before the peak is known. They take width + height words instead of width * height.

use super::window::{Peak, Window};
use crate::kernels::rolled;

/// The largest score of each row and each column of a window of up to `SPAN` x `SPAN` offsets.
pub(super) struct Maxima<const SPAN: usize> {
    columns: AxisMaxima<SPAN>,
    rows: AxisMaxima<SPAN>,
}

struct AxisMaxima<const SPAN: usize> {
    maxima: [u32; SPAN],
    len: usize,
}

impl<const SPAN: usize> AxisMaxima<SPAN> {
    fn reset(&mut self, len: usize) {
        self.len = len;
        rolled(self.maxima.iter_mut().take(len)).for_each(|maximum| *maximum = 0);
    }

    /// The maxima in use. They fit the array, because `lock` refuses a window of more than `SPAN` offsets on an axis.
    fn all(&self) -> &[u32] {
        self.maxima.get(..self.len).unwrap_or_default()
    }
}

impl<const SPAN: usize> Maxima<SPAN> {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self { columns: AxisMaxima { maxima: [0; SPAN], len: 0 }, rows: AxisMaxima { maxima: [0; SPAN], len: 0 } }
    }

    pub(super) fn reset(&mut self, window: &Window) {
        let (columns, rows) = window.size();
        self.columns.reset(columns);
        self.rows.reset(rows);
    }

    pub(super) fn note(&mut self, window: &Window, candidate: &Peak) {
        raise(&mut self.columns.maxima, *window.xs().start(), candidate.x, candidate.score);
        raise(&mut self.rows.maxima, *window.ys().start(), candidate.y, candidate.score);
    }

    /// The largest score that two offsets more than `distance` apart (in x or in y) both reach, computed from the
    /// maxima of rows and of columns; 0 if there is no such pair.
    pub(super) fn both_reach(&self, distance: usize) -> u32 {
        best_pair(self.columns.all(), distance).max(best_pair(self.rows.all(), distance))
    }

    /// The largest score of an offset more than `neighbourhood` pixels from the peak in x or in y; 0 if there is none.
    pub(super) fn outside(&self, window: &Window, peak: &Peak, neighbourhood: u16) -> u32 {
        let columns = largest_away(self.columns.all(), *window.xs().start(), peak.x, neighbourhood);
        let rows = largest_away(self.rows.all(), *window.ys().start(), peak.y, neighbourhood);
        columns.max(rows)
    }
}

#[cfg_attr(smr_small, inline(never))]
fn raise(maxima: &mut [u32], first: i32, at: i32, score: u32) {
    let index = usize::try_from(at.saturating_sub(first)).unwrap_or(usize::MAX);
    if let Some(maximum) = maxima.get_mut(index) {
        *maximum = score.max(*maximum);
    }
}

/// The largest `min(maxima[i], maxima[j])` of all pairs with `j - i > distance`, found in one pass; 0 without a pair.
///
/// Two indices move inwards from the ends. `before` and `behind` are the largest entries passed on each side. A pair
/// that uses the smaller of the two cannot be better than the present pair, so the index on the smaller side moves on.
#[cfg_attr(smr_small, inline(never))]
fn best_pair(maxima: &[u32], distance: usize) -> u32 {
    let at = |index: usize| maxima.get(index).copied().unwrap_or(0);
    let (mut first, mut last) = (0, maxima.len().saturating_sub(1));
    let (mut before, mut behind) = (at(first), at(last));
    let mut both = 0;
    while last.saturating_sub(first) > distance {
        both = before.min(behind).max(both);
        if before <= behind {
            first += 1;
            before = at(first).max(before);
        } else {
            last -= 1;
            behind = at(last).max(behind);
        }
    }
    both
}

/// The largest entry whose index is more than `neighbourhood` from that of the peak; 0 if there is none.
fn largest_away(maxima: &[u32], first: i32, peak: i32, neighbourhood: u16) -> u32 {
    let peak = usize::try_from(peak.saturating_sub(first)).unwrap_or(0);
    let before = maxima.get(..peak.saturating_sub(neighbourhood.into()));
    let behind = maxima.get(peak + usize::from(neighbourhood) + 1..);
    [before, behind].map(|far| largest(far.unwrap_or_default())).into_iter().max().unwrap_or(0)
}

#[inline(never)]
fn largest(maxima: &[u32]) -> u32 {
    rolled(maxima.iter()).copied().max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_pair_is_the_best_of_all_pairs(maxima in prop::collection::vec(0u32..9, 0..24), distance in 0usize..12) {
            let apart = |i: usize| maxima.iter().skip(i + distance + 1).max().copied();
            let best = (0..maxima.len()).filter_map(|i| Some(maxima[i].min(apart(i)?))).max().unwrap_or(0);
            prop_assert_eq!(best_pair(&maxima, distance), best);
        }
    }
}
