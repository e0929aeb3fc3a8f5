//! Scores, the plain loops: the specification of a score (steps 2 to 4 of the method), and of the distances and bounds
//! by which the search excludes offsets. Every backend gives the same scores and distances.

use super::super::blocks::Blocks;
use super::super::cut_table::CutTable;
use super::super::one::ONE;
use super::super::scores::Scores;
#[cfg(any(smr_swar, test, feature = "unstable"))]
use super::super::unrolling::rolled;
use super::super::unrolling::rolled_if_spare;
use crate::image::Image;
#[cfg(any(smr_swar, test, feature = "unstable"))]
use crate::image::Rect;

/// The plain loops as a backend.
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
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        score_between_at_least(low, high, template, self.table, floor)
    }

    #[inline]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        distance(patch, template, enough)
    }

    #[inline]
    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        spread(rows, low, high);
    }

    #[inline(always)]
    fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        self.spread(rows, low, high);
    }

    #[inline(always)]
    fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let Some((low, high)) = blocks.pictures(template) else { return Some(most(template, template)) };
        self.score_between_at_least(low, high, template, floor)
    }
}

/// The sum of the similarities of all pairs of pixels.
///
/// If the sizes of `patch` and `template` differ, their common top left part is compared. The sum is exact for up to
/// [`MAX_PIXELS`](super::super::one::MAX_PIXELS) pixels.
#[cfg(any(test, feature = "unstable"))]
#[must_use]
pub(crate) fn score(patch: Image<'_>, template: Image<'_>, table: &CutTable) -> u32 {
    patch.rows().zip(template.rows()).map(|(f, g)| row_score(f, g, table)).sum()
}

/// The score if it is at least `floor`. `None` as soon as the remaining pixels cannot reach that.
#[must_use]
pub(crate) fn score_at_least(patch: Image<'_>, template: Image<'_>, table: &CutTable, floor: u32) -> Option<u32> {
    if cfg!(any(smr_dsp, smr_helium)) {
        // On this target the plain loop hardly ever runs, so one loop is enough: if both bounds are the patch, the
        // bound of the score is the score.
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

/// The score of a patch that equals the template.
pub(crate) fn most(patch: Image<'_>, template: Image<'_>) -> u32 {
    full(pixels(patch, template))
}

/// The number of pixels in the common top left part.
#[inline]
pub(crate) fn pixels(patch: Image<'_>, template: Image<'_>) -> usize {
    usize::from(patch.width().min(template.width())) * usize::from(patch.height().min(template.height()))
}

/// The score of `pixels` equal pixels, exact for up to [`MAX_PIXELS`](super::super::one::MAX_PIXELS) of them.
pub(crate) fn full(pixels: usize) -> u32 {
    u32::try_from(pixels).unwrap_or(u32::MAX).saturating_mul(u32::from(ONE))
}

fn row_score(patch: &[u8], template: &[u8], table: &CutTable) -> u32 {
    rolled_if_spare(patch.iter().zip(template)).map(|(&f, &g)| pixel(f, g, table)).sum()
}

/// The similarity of two pixels; 0 if their difference reaches the threshold.
#[inline]
fn pixel(f: u8, g: u8, table: &CutTable) -> u32 {
    u32::from(table.similarity(f.abs_diff(g)))
}

/// The sum of absolute differences (SAD). Once it exceeds `enough`, the remaining rows may be left out. The result is
/// then more than `enough` and at most the SAD.
#[must_use]
#[inline(never)]
pub(crate) fn distance(patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
    let mut sum = 0;
    for y in 0..patch.height().min(template.height()) {
        let pixels = patch.row(y).iter().zip(template.row(y));
        sum += rolled_if_spare(pixels).map(|(&f, &g)| u32::from(f.abs_diff(g))).sum::<u32>();
        if sum > enough {
            break;
        }
    }
    sum
}

/// An upper bound of the score of every patch between `low` and `high`, if it is at least `floor`. `None` as soon as it
/// cannot reach that.
///
/// No pixel of `low` is above that of `high`. The difference of a pixel is its distance to the range between the two:
/// no patch in the range is closer. If `low` equals `high`, the bound is the score.
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
        for ((&low, &high), &g) in rolled_if_spare(low.iter().zip(high).zip(g)) {
            reachable -= u32::from(ONE) - pixel(g.min(high).max(low), g, table);
        }
        if reachable < floor {
            return None;
        }
    }
    Some(reachable)
}

/// The lowest and the highest pixel of each 4x4 block. The block at index `i` begins in column `i`. The rows have three
/// more pixels than `low` and `high`.
#[inline(never)]
pub(crate) fn spread(rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
    for (column, (to_low, to_high)) in low.iter_mut().zip(high).enumerate() {
        let (mut low, mut high) = (u8::MAX, 0);
        for row in rolled_if_spare(rows.iter()) {
            let Some(pixels) = row.get(column..).and_then(|row| row.first_chunk::<4>()) else { return };
            for &pixel in rolled_if_spare(pixels.iter()) {
                (low, high) = (pixel.min(low), pixel.max(high));
            }
        }
        (*to_low, *to_high) = (low, high);
    }
}

/// The score of the pixels of `template` that lie on the padding, which is all zeroes.
///
/// `seen` is the rectangle that lies on the frame, in coordinates of the template. It is empty if the whole template
/// lies on the padding.
#[cfg(any(smr_swar, test, feature = "unstable"))]
#[must_use]
#[cfg_attr(smr_small, inline(never))] // keeps its registers out of those of its caller
pub(crate) fn score_on_padding(template: Image<'_>, seen: Rect, table: &CutTable) -> u32 {
    let mut sum = 0;
    let width = usize::from(template.width());
    let [left, right] = [seen.x, seen.right()].map(|x| usize::try_from(x).unwrap_or(0));
    for y in 0..template.height() {
        let is_seen = (seen.y..seen.bottom()).contains(&y.into());
        let (left, right) = if is_seen { (left, right) } else { (0, 0) };
        if left > 0 {
            sum += row_on_padding(template.row(y).get(..left).unwrap_or_default(), table);
        }
        if right < width {
            sum += row_on_padding(template.row(y).get(right..).unwrap_or_default(), table);
        }
    }
    sum
}

#[cfg(any(smr_swar, test, feature = "unstable"))]
#[inline(never)]
fn row_on_padding(row: &[u8], table: &CutTable) -> u32 {
    rolled(row.iter()).map(|&g| u32::from(table.of_pixels(0, g))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::check;
    use proptest::prelude::*;
    use std::{vec, vec::Vec};

    fn cut(threshold: u16) -> CutTable {
        check::cut(2, threshold)
    }

    fn similarity(difference: u8) -> u16 {
        cut(256).similarity(difference)
    }

    #[test]
    fn the_largest_template_has_the_largest_sum() {
        // 65537 = MAX_PIXELS is prime: as one row it would be wider than a u16, so 65536 pixels are summed.
        let pixels = vec![7; 256 * 256];
        let image = Image::new(&pixels, 256, 256).unwrap();
        assert_eq!(score(image, image, &cut(1)), 65536 * 65535);
        assert_eq!(score(image, image, &cut(256)), 65536 * 65535);
    }

    fn image(pixels: &[u8], width: u16) -> Image<'_> {
        Image::new(pixels, width, u16::try_from(pixels.len()).unwrap() / width).unwrap()
    }

    #[test]
    fn pixels_count_below_the_threshold() {
        let (patch, template) = ([10, 10, 10, 10], [10, 11, 22, 23]);
        let table = cut(13);
        let p = |d| u32::from(similarity(d));
        assert_eq!(score(image(&patch, 4), image(&template, 4), &table), p(0) + p(1) + p(12));
    }

    #[test]
    fn a_distance_ends_once_it_is_enough() {
        let (patch, template) = ([10, 20, 30, 40], [13, 20, 20, 90]);
        let (patch, template) = (image(&patch, 2), image(&template, 2));
        assert_eq!(distance(patch, template, u32::MAX), 3 + 10 + 50);
        assert_eq!(distance(patch, template, 2), 3);
    }

    #[test]
    fn what_lies_between_two_pictures_differs_by_as_much_as_it_is_outside_them() {
        let (low, high, template) = ([10, 10, 10], [20, 20, 20], [9, 15, 40]);
        let table = cut(13);
        let most = score_between_at_least(image(&low, 3), image(&high, 3), image(&template, 3), &table, 0);
        let p = |d| u32::from(similarity(d));
        assert_eq!(most, Some(p(1) + p(0))); // 40 is 20 above the highest
    }

    #[test]
    fn ranges_are_those_of_blocks() {
        let rows = [[1, 5, 5, 5, 7], [5, 5, 5, 5, 5], [5, 5, 5, 5, 5], [5, 5, 9, 5, 5]];
        let (mut low, mut high) = ([0; 2], [0; 2]);
        spread(&rows.each_ref().map(|row| &row[..]), &mut low, &mut high);
        assert_eq!((low, high), ([1, 5], [9, 9]));
    }

    #[test]
    fn a_threshold_of_zero_lets_nothing_count() {
        let pixels = [0; 9];
        let image = Image::new(&pixels, 3, 3).unwrap();
        assert_eq!(score(image, image, &cut(0)), 0);
    }

    proptest! {
        #[test]
        fn padding_is_a_patch_of_zeroes(
            (width, height) in (1u16..9, 1u16..9),
            pixels in prop::collection::vec(any::<u8>(), 64),
            (x, y, w, h) in (0i32..9, 0i32..9, 0u16..9, 0u16..9),
            threshold in 0u16..=256,
        ) {
            let template = Image::new(&pixels, width, height).unwrap();
            let seen = Rect::new(0, 0, width, height).intersection(Rect::new(x, y, w, h));
            // The part on the frame matches nothing, so only the padding counts.
            let mut expected = 0u32;
            for (j, row) in (0..).zip(template.rows()) {
                for (i, &g) in (0..).zip(row) {
                    let on_padding = seen.is_empty() || !seen.contains(Rect::new(i, j, 1, 1));
                    if on_padding && u16::from(g) < threshold {
                        expected += u32::from(similarity(g));
                    }
                }
            }
            prop_assert_eq!(score_on_padding(template, seen, &cut(threshold)), expected);
        }

        #[test]
        fn the_stride_does_not_matter(pixels in prop::collection::vec(any::<u8>(), 60), threshold in 0u16..=256) {
            let strided = Image::with_stride(&pixels, 7, 6, 10).unwrap();
            let packed: Vec<u8> = strided.rows().flatten().copied().collect();
            let template: Vec<u8> = pixels.iter().rev().take(42).copied().collect();
            let template = Image::new(&template, 7, 6).unwrap();
            let packed = Image::new(&packed, 7, 6).unwrap();
            prop_assert_eq!(
                score(strided, template, &cut(threshold)),
                score(packed, template, &cut(threshold))
            );
        }
    }
}
