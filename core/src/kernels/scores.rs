//! The kernels of SMR in a backend: scores, distances, and bounds that exclude offsets.

use crate::image::Image;

/// All of four offsets: see [`Scores::candidates`].
pub(crate) const ALL_FOUR: u8 = 0b1111;

/// The kernels of SMR. The function of the same name in `plain/scores.rs` specifies each.
pub(crate) trait Scores {
    /// A separate method, so that a program that never uses a floor does not link the bounds.
    #[inline(always)]
    fn score(&self, patch: Image<'_>, template: Image<'_>) -> u32 {
        self.score_at_least(patch, template, 0).unwrap_or(0)
    }

    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32>;

    /// May return more than the plain loop, never less.
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32>;

    /// Which of four offsets may score at least `floor`: bit i is clear only if the one i columns to the right cannot. The patch has three more
    /// columns than the template. Backends without a fast way let all four through.
    #[inline(always)]
    fn candidates(&self, _patch: Image<'_>, _template: Image<'_>, _floor: u32) -> u8 {
        ALL_FOUR
    }

    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32;

    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]);

    /// The ranges of [`Scores::spread`] in a form of the backend's own, which only [`Scores::most_within`] reads.
    #[inline(always)]
    fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        self.spread(rows, low, high);
    }

    /// [`Scores::score_between_at_least`] for ranges of [`Scores::ranges`].
    #[inline(always)]
    fn most_within(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        self.score_between_at_least(low, high, template, floor)
    }
}
