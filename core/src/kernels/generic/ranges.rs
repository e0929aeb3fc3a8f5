//! Ranges of pixels: the lowest and the highest of 4x4 blocks, widened by the threshold.

use super::vector::{Neighbours, Vector};
use crate::image::Image;
use crate::kernels::scores::RowsOfRanges;

/// Lowest and highest pixel of 4x4 blocks. Returns false, and does nothing, if there are fewer blocks than lanes.
///
/// # Safety
/// The processor has the instruction set of the vector.
#[inline(always)]
pub(crate) unsafe fn spread<V: Neighbours>(rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) -> bool {
    let columns = rows.iter().map(|row| row.len().saturating_sub(3)).min().unwrap_or(0).min(low.len()).min(high.len());
    let Some(last) = columns.checked_sub(V::LANES) else { return false };
    let rows = rows.each_ref().map(|row| row.as_ptr());
    let (low, high) = (low.as_mut_ptr(), high.as_mut_ptr());
    let mut at = 0;
    // SAFETY: the processor has the instruction set. Every row has `columns` bytes and three more, `low` and `high`
    // have `columns`; at + LANES is less than `columns`, last + LANES equals it.
    unsafe {
        while at < last {
            let (lowest, highest) = column_ranges::<V>(&rows, at);
            let lowest = V::min(lowest, V::shift_down::<1>(lowest));
            let highest = V::max(highest, V::shift_down::<1>(highest));
            V::store(V::min(lowest, V::shift_down::<2>(lowest)), low.wrapping_add(at));
            V::store(V::max(highest, V::shift_down::<2>(highest)), high.wrapping_add(at));
            // The last three lanes are incomplete. The next round computes them again.
            at += V::LANES - 3;
        }
        // The last vector overlaps the one before. To complete all lanes, loads at four columns replace shifts.
        let (mut lowest, mut highest) = (V::splat(u8::MAX), V::splat(0));
        for column in 0..4 {
            let ranges = column_ranges::<V>(&rows, last + column);
            (lowest, highest) = (V::min(lowest, ranges.0), V::max(highest, ranges.1));
        }
        V::store(lowest, low.wrapping_add(last));
        V::store(highest, high.wrapping_add(last));
    }
    true
}

/// Half the number of byte values. Subtracting it from bytes, modulo 256, gives signed numbers in the same order.
const HALF: u8 = 128;

#[inline(always)]
pub(crate) fn half<V: Vector>(_: V) -> V {
    // SAFETY: the argument exists, so the processor has the instruction set.
    unsafe { V::splat(HALF) }
}

/// Widens ranges by `last` and encodes them for [`inside_at_least`](super::inside_at_least): g is inside if low - last <= g <= high + last,
/// that is, if g - (low - last), modulo 256, is at most (high + last) - (low - last). Vectors compare signed numbers,
/// so both sides have [`HALF`] subtracted: the results are low - last - HALF, and high + last minus the first result.
#[inline(always)]
pub(super) fn widen<V: Neighbours>(low: V, high: V, last: V) -> (V, V) {
    let low_less_half = V::minus(V::saturating_sub(low, last), half(low));
    (low_less_half, V::minus(V::raised(high, last), low_less_half))
}

#[inline(always)]
pub(crate) fn widen_all(low: &mut [u8], high: &mut [u8], last: u8) {
    for (low, high) in low.iter_mut().zip(high) {
        let (least, most) = (low.saturating_sub(last), high.saturating_add(last));
        *low = least.wrapping_sub(HALF);
        *high = most.wrapping_sub(*low);
    }
}

/// Computes rows of pixel ranges, as [`widen`] encodes them. Returns false, and does nothing, if a row has fewer ranges
/// than a vector has lanes, or if `to` is too small. Reads strips as wide as a vector, each from top to bottom. The
/// minima and maxima of each pair of rows serve two ranges.
///
/// # Safety
/// The processor has the instruction set of the vector.
#[inline(always)]
pub(crate) unsafe fn ranges_of_rows<V: Neighbours>(
    pixels: Image<'_>,
    step: usize,
    last: u8,
    to: &mut RowsOfRanges<'_>,
) -> bool {
    let (columns, height) = (usize::from(pixels.width()).saturating_sub(3), usize::from(pixels.height()));
    let Some(last_strip) = columns.checked_sub(V::LANES) else { return false };
    let rows = height.saturating_sub(3).div_ceil(step.max(1));
    let needed = rows.saturating_sub(1).saturating_mul(to.stride).saturating_add(columns);
    if columns > to.stride || rows == 0 || needed > to.low.len().min(to.high.len()) {
        return false;
    }
    let (pixels, stride) = pixels.parts();
    let mut at = 0;
    loop {
        let (low, high) = (to.low.as_mut_ptr().wrapping_add(at), to.high.as_mut_ptr().wrapping_add(at));
        let mut row = pixels.as_ptr().wrapping_add(at);
        let mut place = 0;
        // SAFETY: the processor has the instruction set. Every row has `columns` pixels and three more, at + LANES is
        // at most `columns`. The last store ends with the ranges of row `rows` - 1 of `to`, whose `needed` bytes exist.
        unsafe {
            let last = V::splat(last);
            let (mut before, mut pairs) = (fours::<V>(row), [(V::splat(0), V::splat(0)); 2]);
            for y in 1..height {
                row = row.wrapping_add(stride);
                let present = fours::<V>(row);
                let pair = (V::min(before.0, present.0), V::max(before.1, present.1));
                if y >= 3 && (step == 1 || (y - 3).is_multiple_of(step)) {
                    let lowest = V::min(pairs[1].0, pair.0);
                    let highest = V::max(pairs[1].1, pair.1);
                    let (lowest, span) = widen(lowest, highest, last);
                    V::store(lowest, low.wrapping_add(place));
                    V::store(span, high.wrapping_add(place));
                    place += to.stride;
                }
                (before, pairs) = (present, [pair, pairs[0]]);
            }
        }
        if at == last_strip {
            return true;
        }
        // The last strip overlaps the strip before it, and stores the same values there again.
        at = last_strip.min(at + V::LANES);
    }
}

/// For each pixel of a vector, the minimum and the maximum of that pixel and the next three.
///
/// # Safety
/// The processor has the instruction set of the vector. A vector and three more pixels can be read at `row`.
#[inline(always)]
unsafe fn fours<V: Neighbours>(row: *const u8) -> (V, V) {
    // SAFETY: the processor has the instruction set. No load ends beyond the three pixels after the vector.
    unsafe { column_ranges(&[row, row.wrapping_add(1), row.wrapping_add(2), row.wrapping_add(3)], 0) }
}

/// The lowest and the highest pixel of four rows in each column from `at` on.
///
/// # Safety
/// The processor has the instruction set of the vector. A vector can be read in each of the rows, from `at` on.
#[inline(always)]
unsafe fn column_ranges<V: Neighbours>(rows: &[*const u8; 4], at: usize) -> (V, V) {
    let [a, b, c, d] = *rows;
    // SAFETY: the processor has the instruction set, and each of the rows has a vector from `at` on.
    let ([a, b], [c, d]) = unsafe {
        let load = [V::load(a.wrapping_add(at)), V::load(b.wrapping_add(at))];
        (load, [V::load(c.wrapping_add(at)), V::load(d.wrapping_add(at))])
    };
    (V::min(V::min(a, b), V::min(c, d)), V::max(V::max(a, b), V::max(c, d)))
}
