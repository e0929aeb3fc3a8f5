//! The filter's responses at all offsets of a search window, and the peak of the penalised responses.
//!
//! ```text
//! r(d) = sum over cells c and channels k of  w[c, k] * x[c + d, k]
//! penalised(d) = r(d) * (1 - 0.3 * |d|^2 / reach^2), where r(d) is positive
//! ```
//!
//! | symbol | what | unit | bound |
//! |---|---|---|---|
//! | `d` | offset | cell | `reach` cells on each axis |
//! | `r` | response | 1/16384 of the label | +-2^24 |
//! | peak | place of the largest penalised response | 1/256 cell | |
//!
//! The scale search omits the penalty. A parabola through the peak and its neighbours on each axis refines the place.
//! Of equal responses the middle one wins, otherwise the first in scan order, so in a black frame the place stays.
//! Cost: one product for each weight and offset, by default 289 for each weight.

use super::super::arithmetic::quotient;
use super::super::constants::{CHANNELS, SPAN};
use super::super::features::{Extent, Grid};
use super::correlation::{Coded, FeatureWindow};
use crate::kernels::{Layout, Packed, Products};
use crate::track::update::{Budget, units};

/// The largest penalty of a filter response, in units of 1/256 of the response. The penalty grows with the squared
/// distance from the centre, up to the radius of the search window. Without penalties the success rate R is lower by
/// 0.043 +- 0.016.
const DISTANCE_PENALTY: u32 = 77;

pub(crate) struct Responses {
    pub(crate) rows: [[i32; SPAN]; SPAN],
    /// The count of offsets on each axis of the search.
    pub(crate) span: usize,
}

/// Units of work for each weight that is coded or changed.
pub(crate) const CODED: u32 = 16;

pub(crate) const fn most_work(extent: Extent) -> u32 {
    extent.offsets() * extent.weights()
}

/// Upper bound of the work for an indivisible piece. Some backends compute two rows of offsets in one piece.
pub(crate) const fn most_work_of_a_piece(extent: Extent) -> u32 {
    2 * extent.span() * extent.weights()
}

/// The largest response, after penalties if `peak` applies them, and its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Peak {
    /// Offset from the middle of the window, in units of 1/256 cell.
    pub(crate) x: i32,
    pub(crate) y: i32,
    /// The response at the offset of the peak, in units of 1/16384.
    pub(crate) response: i32,
    /// The response at (`x`, `y`), interpolated by a parabola on each axis, in units of 1/16384.
    pub(crate) height: i32,
}

/// The memory layout for a filter that moves over a window of cells by up to `span / 2` cells to each side.
pub(crate) fn layout(grid: &Grid, span: usize) -> Layout {
    let row = usize::from(grid.across) * CHANNELS;
    Layout { row, stride: row + span.saturating_sub(1) * CHANNELS, step: CHANNELS, span }
}

impl Responses {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { rows: [[0; SPAN]; SPAN], span: 0 }
    }

    /// Sets all responses to 0: those of a filter whose weights are 0.
    pub(crate) fn clear(&mut self, span: usize) {
        *self = Self { span, ..const { Self::new() } };
    }

    /// Computes one piece of the filter's responses, without the penalty for distance. True after the last piece.
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn compute(
        &mut self,
        weights: &Coded,
        products: Products,
        packed: &mut Packed,
        spare: &mut [i32],
        window: FeatureWindow<'_>,
        piece: usize,
        budget: &mut Budget,
    ) -> bool {
        self.span = window.layout.span;
        budget.spend(units(products.work(piece, window.layout, weights.numbers().len())));
        let done = weights.respond(products, packed, spare, window, piece, &mut self.rows);
        if done {
            weights.to_responses(&mut self.rows);
        }
        done
    }

    pub(crate) fn peak(&self, penalty: bool) -> Peak {
        peak(&self.rows, self.span, penalty)
    }
}

/// The peak of the responses at `span` offsets on each axis. `penalty` lowers responses far from the middle.
#[inline(never)]
pub(crate) fn peak(rows: &[[i32; SPAN]], span: usize, penalty: bool) -> Peak {
    let responses = WithPenalty { rows, span, penalty };
    let (mut x, mut y) = (span / 2, span / 2);
    let mut response = responses.at(x, y).unwrap_or(i32::MIN);
    for (down, row) in rows.iter().take(span).enumerate() {
        for (right, &candidate) in row.iter().take(span).enumerate() {
            // Skips the penalty if even the response without it is at most the best one: no penalty raises a response.
            let counted = if candidate > response { responses.with_penalty(right, down, candidate) } else { candidate };
            if counted > response {
                (response, x, y) = (counted, right, down);
            }
        }
    }
    let vertex = |before: Option<i32>, after: Option<i32>| match (before, after) {
        (Some(before), Some(after)) => top(before, response, after),
        _ => (0, 0),
    };
    // For an index that wraps below 0, `at` returns `None`.
    let (right, across) = vertex(responses.at(x.wrapping_sub(1), y), responses.at(x + 1, y));
    let (below, down) = vertex(responses.at(x, y.wrapping_sub(1)), responses.at(x, y + 1));
    let cells = |at: usize| i32::try_from(2 * at + 1).unwrap_or(0) - i32::try_from(span).unwrap_or(0);
    let height = response.saturating_add(across).saturating_add(down);
    Peak { x: 128 * cells(x) + right, y: 128 * cells(y) + below, response, height }
}

struct WithPenalty<'a> {
    rows: &'a [[i32; SPAN]],
    span: usize,
    penalty: bool,
}

impl WithPenalty<'_> {
    /// The response at an offset, with its penalty; `None` outside of the search.
    #[cfg_attr(smr_small, inline(never))]
    fn at(&self, x: usize, y: usize) -> Option<i32> {
        let response = self.rows.get(..self.span)?.get(y)?.get(..self.span)?.get(x)?;
        Some(self.with_penalty(x, y, *response))
    }

    fn with_penalty(&self, x: usize, y: usize, response: i32) -> i32 {
        if self.penalty { penalised(x, y, self.span, response) } else { response }
    }
}

/// The penalised response at an offset. Negative responses have no penalty.
#[inline(never)]
fn penalised(x: usize, y: usize, span: usize, response: i32) -> i32 {
    let reach = u32::try_from(span / 2).unwrap_or(0);
    let away = |at: usize| u32::try_from(at).map_or(0, |at| at.abs_diff(reach).pow(2));
    let edge = (reach * reach).max(1);
    let kept = 256 - DISTANCE_PENALTY * (away(x) + away(y)).min(edge) / edge;
    let less = (i64::from(response.max(0)) * i64::from(kept)) >> 8;
    i32::try_from(less).unwrap_or(0) + response.min(0)
}

/// The top of a parabola through three equidistant responses: its place from the middle one, in units of 1/256 of the
/// distance (-128 to 128), and its height above the middle one. Both are 0 if the parabola has no maximum.
#[inline(never)]
fn top(before: i32, at: i32, after: i32) -> (i32, i32) {
    // Responses are at most 2^24.
    let curvature = before - 2 * at + after;
    if curvature >= 0 {
        return (0, 0);
    }
    let (difference, curvature) = (i64::from(before - after), i64::from(curvature));
    // `difference` is at most 2^25, and its square at most 2^50.
    let top = quotient(difference * 128, curvature).clamp(-128, 128);
    let higher = quotient(difference.pow(2), -8 * curvature);
    (i32::try_from(top).unwrap_or(0), i32::try_from(higher).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_a_parabola() {
        let parabola = |top: i32, x: i32| 1_000_000 - (x * 256 - top).pow(2);
        for at in [-127, -1, 0, 1, 77, 128] {
            let (found, higher) = top(parabola(at, -1), parabola(at, 0), parabola(at, 1));
            assert!((found - at).abs() <= 1, "{at}: {found}");
            assert!((higher - at.pow(2)).abs() <= 1, "{at}: {higher}");
        }
        assert_eq!([top(5, 5, 5), top(9, 5, 9), top(-(1 << 24), 1 << 24, -(1 << 24))], [(0, 0); 3]);
        assert_eq!(top(1 << 24, 1 << 24, -(1 << 24)), (-128, 1 << 22));
    }

    #[test]
    fn a_peak_is_measured_from_the_middle() {
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        responses.rows[3][10] = 900;
        assert_eq!(responses.peak(false), Peak { x: 512, y: -5 * 256, response: 900, height: 900 });
        responses.rows[3][11] = 900;
        assert_eq!(responses.peak(false), Peak { x: 512 + 128, y: -5 * 256, response: 900, height: 1012 });
        responses.span = 3;
        responses.rows[0][0] = 5;
        assert_eq!(responses.peak(false), Peak { x: -256, y: -256, response: 5, height: 5 });
    }

    #[test]
    fn where_all_respond_alike_the_middle_is_the_peak() {
        for response in [-5, 0] {
            let responses = Responses { rows: [[response; SPAN]; SPAN], span: SPAN };
            for penalty in [false, true] {
                assert_eq!(responses.peak(penalty), Peak { x: 0, y: 0, response, height: response });
            }
        }
    }

    #[test]
    fn far_responses_count_less() {
        let less = |x: usize, y: usize| penalised(x, y, SPAN, 1 << 24);
        assert_eq!([less(8, 8), less(0, 0), less(0, 8), less(8, 4)], [1 << 24, 179 << 16, 179 << 16, 237 << 16]);
        assert_eq!(penalised(0, 1, SPAN, -256), -256);
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        (responses.rows[0][0], responses.rows[8][8]) = (1000, 800);
        assert_eq!([responses.peak(false).response, responses.peak(true).response], [1000, 800]);
    }
}
