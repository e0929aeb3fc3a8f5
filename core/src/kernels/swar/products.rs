//! Sums of products for processors without DSP or SIMD: several offsets at a time, which share the loads of weights and of sums.
//!
//! Armv6-M has no loads of signed bytes from a place relative to an address. So each row of cells is copied as x + 128, without a sign, and
//! 128 times the sum of the other factors is subtracted. Sums may wrap before that.

use crate::kernels::cells::CHANNELS;
use crate::kernels::layout::{Layout, Packed};
use crate::kernels::plain::products as plain;
use crate::kernels::unrolling::{in_order, rolled};
use core::ops::Range;

const STEP: usize = CHANNELS;

/// Offsets at a time: more would not leave a register of Armv6-M for each sum.
const AT_ONCE: usize = 3;

/// What is added to a cell: its top bit is inverted.
const BIAS: i32 = 128;
const TOP: u8 = 0x80;
const TOPS: u32 = 0x8080_8080;

/// Bytes of a word.
const WORD: usize = 4;

/// The code for each channel, one after the other: the compiler does not unroll a loop with assembly, as [`in_order`] has it.
macro_rules! for_each_channel {
    ($channel:ident => $code:block) => {
        for_each_channel! { $channel $code 0 1 2 3 4 5 6 7 8 9 }
    };
    ($channel:ident $code:block $($number:literal)*) => {$({
        const $channel: usize = $number;
        $code
    })*};
}

/// True if the filter of `weights` weights has whole rows of whole cells, and at every offset lies wholly on the `cells` bytes of cells.
fn fits(cells: usize, layout: Layout, weights: usize) -> bool {
    let Layout { row, stride, step, span } = layout;
    let (Some(down), Some(most)) = (weights.checked_div(row), span.checked_sub(1)) else { return false };
    let last_row = (most + down).saturating_sub(1);
    let width = most.checked_mul(step).and_then(|x| x.checked_add(row));
    let end = last_row.checked_mul(stride).zip(width).and_then(|(y, x)| y.checked_add(x));
    let has_room = width.is_some_and(|width| width + WORD <= size_of::<Packed>());
    let is_whole = step == STEP && row.is_multiple_of(STEP) && weights.is_multiple_of(row);
    is_whole && has_room && end.is_some_and(|end| end <= cells)
}

/// See [`plain::responses`].
pub(crate) fn responses<const N: usize>(
    parts: Range<usize>,
    room: &mut Packed,
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    if !fits(cells.len(), layout, weights.len()) || layout.span > N {
        return plain::responses(parts, cells, layout, weights, out);
    }
    let Layout { row, stride, step, span } = layout;
    let width = (span - 1) * step + row;
    for y in parts.start..parts.end.min(span) {
        let Some(out) = out.get_mut(y).and_then(|out| out.get_mut(..span)) else { return };
        out.fill(0);
        let mut sum = 0;
        for (weights, from) in weights.chunks(row.max(1)).zip((y * stride..).step_by(stride.max(1))) {
            let Some(of_row) = cells.get(from..from + width) else { return };
            let (mut cells, weights) = (biased(of_row, room), weights.as_chunks::<STEP>().0);
            let (groups, rest) = out.as_chunks_mut::<AT_ONCE>();
            // SAFETY: a row of the filter lies on the copied cells at every offset.
            unsafe {
                for group in groups {
                    add_responses::<AT_ONCE, false>(cells, weights, group);
                    cells = cells.wrapping_add(AT_ONCE * STEP);
                }
                sum += match rest {
                    [] => add_responses::<0, true>(cells, weights, rest),
                    [_] => add_responses::<1, true>(cells, weights, rest),
                    _ => add_responses::<2, true>(cells, weights, rest),
                };
            }
        }
        out.iter_mut().for_each(|out| *out = out.wrapping_sub(BIAS.wrapping_mul(sum)));
    }
}

/// Adds the responses of a row of weights at `COUNT` neighbouring offsets, and returns the sum of the weights if `TOTAL`.
///
/// # Safety
/// At each offset as many cells as weights can be read.
#[inline(never)] // so that nothing else needs a register
unsafe fn add_responses<const COUNT: usize, const TOTAL: bool>(
    mut cells: *const u8,
    weights: &[[i16; STEP]],
    out: &mut [i32],
) -> i32 {
    let (mut sums, mut total) = ([0i32; COUNT], 0);
    for weights in rolled(weights.iter()) {
        for_each_channel!(CHANNEL => {
            let weight = i32::from(weights[CHANNEL]);
            for (sum, x) in sums.iter_mut().zip(offsets::<COUNT>()) {
                // SAFETY: as the caller guarantees.
                let cell = i32::from(unsafe { *cells.add(x + CHANNEL) });
                *sum = in_order(sum.wrapping_add(weight.wrapping_mul(cell)));
            }
            if TOTAL {
                total = in_order(total + weight);
            }
        });
        cells = cells.wrapping_add(STEP);
    }
    out.iter_mut().zip(sums).for_each(|(out, sum)| *out = out.wrapping_add(sum));
    total
}

/// See [`plain::gather`].
pub(crate) fn gather<const N: usize>(
    parts: Range<usize>,
    room: &mut Packed,
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    if !fits(cells.len(), layout, sums.len()) || layout.span > N {
        return plain::gather(parts, cells, layout, errors, sums);
    }
    let Layout { row, stride, step, span } = layout;
    let width = (span - 1) * step + row;
    for y in parts.start..parts.end.min(span) {
        let Some(errors) = errors.get(y).and_then(|errors| errors.get(..span)) else { return };
        let bias = BIAS * errors.iter().map(|&error| i32::from(error)).sum::<i32>();
        for (sums, from) in sums.chunks_mut(row.max(1)).zip((y * stride..).step_by(stride.max(1))) {
            let Some(of_row) = cells.get(from..from + width) else { return };
            let (mut cells, sums) = (biased(of_row, room), sums.as_chunks_mut::<STEP>().0);
            let (groups, rest) = errors.as_chunks::<AT_ONCE>();
            // SAFETY: a row of the filter lies on the copied cells at every offset.
            unsafe {
                for group in groups {
                    gather_at(cells, group, 0, sums);
                    cells = cells.wrapping_add(AT_ONCE * STEP);
                }
                match rest {
                    [one] => gather_at(cells, &[*one], bias, sums),
                    [one, two] => gather_at(cells, &[*one, *two], bias, sums),
                    _ => gather_at(cells, &[], bias, sums),
                }
            }
        }
    }
}

/// Adds the products of `COUNT` neighbouring errors with their cells to each sum, and subtracts `bias`.
///
/// # Safety
/// At each offset as many cells as sums can be read.
#[inline(never)]
unsafe fn gather_at<const COUNT: usize>(
    mut cells: *const u8,
    errors: &[i16; COUNT],
    bias: i32,
    sums: &mut [[i32; STEP]],
) {
    let errors = errors.map(i32::from);
    for sums in rolled(sums.iter_mut()) {
        for_each_channel!(CHANNEL => {
            let mut sum = if COUNT < AT_ONCE { sums[CHANNEL].wrapping_sub(bias) } else { sums[CHANNEL] };
            for (x, error) in offsets::<COUNT>().into_iter().zip(errors) {
                // SAFETY: as the caller guarantees.
                let cell = i32::from(unsafe { *cells.add(x + CHANNEL) });
                sum = in_order(sum.wrapping_add(error.wrapping_mul(cell)));
            }
            sums[CHANNEL] = sum;
        });
        cells = cells.wrapping_add(STEP);
    }
}

/// The first cells of neighbouring offsets.
fn offsets<const COUNT: usize>() -> [usize; COUNT] {
    core::array::from_fn(|x| x * STEP)
}

/// Copies a row of cells to `room`, each plus 128.
#[inline(never)]
fn biased(row: &[i8], room: &mut Packed) -> *const u8 {
    // SAFETY: a byte may have any value.
    let room = unsafe { room.0.align_to_mut::<u8>().1 };
    // To a place that differs from the row's by whole words, so that both have their words at the same bytes.
    let start = row.as_ptr().addr().wrapping_sub(room.as_ptr().addr()) % WORD;
    let copy = room.get_mut(start..).and_then(|room| room.get_mut(..row.len())).unwrap_or_default();
    let first = copy.as_ptr();
    // SAFETY: a word may have any value.
    let (from, to) = unsafe { (row.align_to::<u32>(), copy.align_to_mut::<u32>()) };
    let ends = rolled(from.0.iter().zip(to.0).chain(from.2.iter().zip(to.2)));
    ends.for_each(|(from, to)| *to = from.cast_unsigned() ^ TOP);
    from.1.iter().zip(to.1).for_each(|(from, to)| *to = from ^ TOPS);
    first
}
