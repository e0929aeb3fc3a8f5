//! Plain loops of sums of products: the responses of a correlation filter, and the gradient of its error.
//!
//! Weights of the filter and errors of responses are `i16`, features of cells `i8`.

use super::super::layout::{Layout, Packed};
use super::super::unrolling::rolled_if_rare;
use core::ops::Range;

/// Responses: `out[y][x]` is the sum of weight * feature over all weights, with the filter at the offset (x, y).
///
/// A piece of work is a row of offsets. No sum overflows: 2000 weights of at most 8191 reach 2000 * 8191 * 128 < 2^31.
#[inline(always)]
pub(crate) fn responses_inline<const N: usize>(
    pieces: Range<usize>,
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    let Layout { row, stride, step, span } = layout;
    for y in pieces.start..pieces.end.min(span) {
        let Some(out) = out.get_mut(y) else { return };
        for (x, out) in rolled_if_rare(out.iter_mut().take(span).enumerate()) {
            let mut from = y * stride + x * step;
            *out = 0;
            for weights in rolled_if_rare(weights.chunks(row.max(1))) {
                *out += dot(cells.get(from..).unwrap_or_default(), weights);
                from += stride;
            }
        }
    }
}

#[inline(always)]
fn dot(cells: &[i8], weights: &[i16]) -> i32 {
    rolled_if_rare(cells.iter().zip(weights)).map(|(&cell, &weight)| i32::from(cell) * i32::from(weight)).sum()
}

/// Adds the gradient of the error to `sums`: for each weight, error * feature, summed over all offsets (x, y). The
/// error is `errors[y][x]`, the feature the one under the weight with the filter at that offset.
///
/// A piece of work is a row of errors. No sum overflows: 17^2 errors of at most 16383 reach 289 * 16383 * 128 < 2^31.
#[inline(always)]
pub(crate) fn gather_inline<const N: usize>(
    pieces: Range<usize>,
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    let Layout { row, stride, step, span } = layout;
    for y in pieces.start..pieces.end.min(span) {
        let Some(errors) = errors.get(y) else { return };
        let mut from = y * stride;
        for sums in rolled_if_rare(sums.chunks_mut(row.max(1))) {
            for (x, &error) in rolled_if_rare(errors.iter().take(span).enumerate()) {
                let cells = cells.get(from + x * step..).unwrap_or_default();
                for (sum, &cell) in rolled_if_rare(sums.iter_mut().zip(cells)) {
                    *sum += i32::from(error) * i32::from(cell);
                }
            }
            from += stride;
        }
    }
}

/// False: pieces of work are rows of offsets, not pairs of rows of cells.
pub(crate) const TAKES_ROWS_OF_CELLS: bool = false;
/// Number of pieces of work of [`gather`]. `None`: the same number as [`responses`] has.
pub(crate) const GATHER_PIECES: Option<usize> = None;

/// [`responses_inline`] as one copy, which saves flash. Arguments without a name are scratch memory of other backends.
#[inline(never)]
pub(crate) fn responses<const N: usize>(
    pieces: Range<usize>,
    _: &mut Packed,
    _: &mut [i32],
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    responses_inline(pieces, cells, layout, weights, out);
}

#[inline(never)]
pub(crate) fn gather<const N: usize>(
    pieces: Range<usize>,
    _: &mut Packed,
    _: &mut [i32],
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    gather_inline(pieces, cells, layout, errors, sums);
}
