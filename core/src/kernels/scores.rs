//! The kernels of SMR in a backend: scores, distances, and bounds that exclude offsets.

use crate::image::Image;

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

    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32;

    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]);
}
