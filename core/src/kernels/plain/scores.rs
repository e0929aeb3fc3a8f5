//! Plain loops that specify scores (steps 2 to 4 of the method), and the distances and bounds by which the search
//! excludes offsets. Every backend returns the same scores and distances.

use super::super::cut_table::CutTable;
use super::super::scores::{Blocks, ONE, Scores};
use super::super::unrolling::rolled_if_rare;
use crate::image::Image;

#[derive(Clone, Copy)]
pub(crate) struct Plain<'a> {
    pub(crate) table: &'a CutTable,
}

impl Scores for Plain<'_> {
    #[cfg_attr(smr_swar, inline(never))]
    #[cfg_attr(not(smr_swar), inline)]
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        score_at_least(patch, template, self.table, floor)
    }

    #[inline]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        distance(patch, template, enough)
    }

    #[inline(always)]
    fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        spread(rows, low, high);
    }

    #[inline(always)]
    fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let Some((low, high)) = blocks.pictures(template) else { return Some(most(template, template)) };
        score_between_at_least(low, high, template, self.table, floor)
    }
}

/// The score (the sum of the similarities of all pairs of pixels) if it is at least `floor`; `None` as soon as the
/// remaining pixels cannot reach it. Exact for up to [`MAX_PIXELS`](super::super::scores::MAX_PIXELS) pixels.
#[must_use]
pub(crate) fn score_at_least(patch: Image<'_>, template: Image<'_>, table: &CutTable, floor: u32) -> Option<u32> {
    if cfg!(any(smr_dsp, smr_helium)) {
        // Hardly ever runs on this target, so it shares code with the bound, which is the score if `low` equals `high`.
        return score_between_at_least(patch, patch, template, table, floor);
    }
    let mut reachable = most(patch, template);
    for y in 0..patch.height().min(template.height()) {
        let (f, g) = (patch.row(y), template.row(y));
        reachable -= full(f.len().min(g.len())) - row_score(f, g, table);
        if reachable < floor {
            return None;
        }
    }
    Some(reachable)
}

/// The largest possible score: that of a patch equal to the template.
pub(crate) fn most(patch: Image<'_>, template: Image<'_>) -> u32 {
    full(pixels(patch, template))
}

/// The number of pixels in the common top left part of two pictures.
#[inline]
pub(crate) fn pixels(patch: Image<'_>, template: Image<'_>) -> usize {
    usize::from(patch.width().min(template.width())) * usize::from(patch.height().min(template.height()))
}

/// The score of `pixels` equal pixels, exact for up to [`MAX_PIXELS`](super::super::scores::MAX_PIXELS) of them.
pub(crate) fn full(pixels: usize) -> u32 {
    u32::try_from(pixels).unwrap_or(u32::MAX).saturating_mul(u32::from(ONE))
}

fn row_score(patch: &[u8], template: &[u8], table: &CutTable) -> u32 {
    rolled_if_rare(patch.iter().zip(template)).map(|(&f, &g)| pixel(f, g, table)).sum()
}

#[inline]
fn pixel(f: u8, g: u8, table: &CutTable) -> u32 {
    u32::from(table.similarity(f.abs_diff(g)))
}

/// The sum of absolute differences (SAD). Once it exceeds `enough`, the remaining rows may be skipped: the result is
/// then more than `enough` and at most the SAD.
#[must_use]
#[inline(never)]
pub(crate) fn distance(patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
    let mut sum = 0;
    for y in 0..patch.height().min(template.height()) {
        let pixels = patch.row(y).iter().zip(template.row(y));
        sum += rolled_if_rare(pixels).map(|(&f, &g)| u32::from(f.abs_diff(g))).sum::<u32>();
        if sum > enough {
            break;
        }
    }
    sum
}

/// Upper bound of the score of every patch whose pixels lie between those of `low` and `high`. `None` as soon as the
/// bound falls below `floor`.
///
/// No pixel of `low` is above that of `high`. The difference of a pixel is its distance to the range between them: no
/// patch in the range is closer. If `low` equals `high`, the bound is the score.
#[must_use]
#[cfg_attr(any(smr_dsp, smr_helium), inline(never))]
pub(crate) fn score_between_at_least(
    low: Image<'_>,
    high: Image<'_>,
    template: Image<'_>,
    table: &CutTable,
    floor: u32,
) -> Option<u32> {
    let mut reachable = most(low, template);
    for y in 0..low.height().min(template.height()) {
        let (low, high, g) = (low.row(y), high.row(y), template.row(y));
        for ((&low, &high), &g) in rolled_if_rare(low.iter().zip(high).zip(g)) {
            reachable -= u32::from(ONE) - pixel(g.min(high).max(low), g, table);
        }
        if reachable < floor {
            return None;
        }
    }
    Some(reachable)
}

/// Computes the lowest and the highest pixel of each 4x4 block. Block `i` begins in column `i`, so the rows have three
/// more pixels than `low` and `high`.
#[inline(never)]
pub(crate) fn spread(rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
    for (column, (to_low, to_high)) in low.iter_mut().zip(high).enumerate() {
        let (mut low, mut high) = (u8::MAX, 0);
        for row in rolled_if_rare(rows.iter()) {
            let Some(pixels) = row.get(column..).and_then(|row| row.first_chunk::<4>()) else { return };
            for &pixel in rolled_if_rare(pixels.iter()) {
                (low, high) = (pixel.min(low), pixel.max(high));
            }
        }
        (*to_low, *to_high) = (low, high);
    }
}
