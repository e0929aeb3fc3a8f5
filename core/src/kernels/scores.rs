//! What every instruction set computes of two pictures.

use crate::image::Image;

/// What a backend computes; the function of the same name in `plain/scores.rs` says what.
pub(crate) trait Scores {
    /// Apart from `score_at_least`, so that a program which asks for no floor links no bound.
    #[inline(always)]
    fn score(&self, patch: Image<'_>, template: Image<'_>) -> u32 {
        self.score_at_least(patch, template, 0).unwrap_or(0)
    }

    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32>;

    /// This one need not be as exact: what it gives may be more, never less.
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32>;

    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32;

    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]);
}
