//! Plain loops on a filter's weights: scaling, quantisation to 16 bits, gradient descent step.

use super::super::unrolling::rolled_if_rare;

/// The largest absolute value of [`number`] over all weights. If [`number`] is negative, its quotient is rounded up.
#[inline(always)]
pub(crate) fn largest(weights: &[i32], factor: i64, sums: &[i32], left: u32) -> u32 {
    let size = |(&weight, &sum): (&i32, &i32)| match number(weight, factor, sum << left) {
        number @ 0.. => number.unsigned_abs(),
        _ => number(weight, -factor, (sum << left).wrapping_neg()).cast_unsigned(),
    };
    rolled_if_rare(weights.iter().zip(sums)).map(size).max().unwrap_or(0)
}

/// Quantises each [`number`]: divides by `2^shift` and rounds. The caller chooses `shift` so that 16 bits suffice.
#[inline(always)]
pub(crate) fn coded(weights: &[i32], factor: i64, sums: &[i32], left: u32, shift: u32) -> impl Iterator<Item = i16> {
    // Rounds by the last bit shifted out, because adding half of the divisor could overflow.
    let (first, last) = (shift.saturating_sub(1), shift.min(1));
    let shifted = move |number: i32| ((number >> first) + last.cast_signed()) >> last;
    rolled_if_rare(weights.iter().zip(sums))
        .map(move |(&weight, &sum)| low(shifted(number(weight, factor, sum << left))))
}

#[inline(always)]
pub(crate) fn code(weights: &[i32], factor: i64, sums: &[i32], left: u32, shift: u32, out: &mut [i16]) {
    out.iter_mut().zip(coded(weights, factor, sums, left, shift)).for_each(|(out, coded)| *out = coded);
}

/// `weight * factor / 2^32 + sum`; the quotient is rounded down.
#[inline(always)]
#[allow(clippy::cast_possible_truncation)] // the caller guarantees that the result fits
fn number(weight: i32, factor: i64, sum: i32) -> i32 {
    // Avoids a 64-bit product, which is slow on a processor without an instruction for it.
    if factor == 0 {
        return sum;
    }
    let short = (factor >> 16) as i32;
    if i64::from(short) << 16 == factor && short.unsigned_abs() < 1 << 15 {
        return ((weight >> 16) * short + (((weight & 0xFFFF) * short) >> 16)).wrapping_add(sum);
    }
    ((i64::from(weight).wrapping_mul(factor) >> 32) as i32).wrapping_add(sum)
}

/// Subtracts `slope * length / 2^back`, rounded, from each weight. A weight that would overflow an `i32` stays.
#[inline(always)]
pub(crate) fn step(weights: &mut [i32], slopes: &[i16], length: i64, back: u32) {
    rolled_if_rare(weights.iter_mut().zip(slopes))
        .for_each(|(weight, &slope)| *weight = stepped(*weight, slope, length, back));
}

#[inline(always)]
fn stepped(weight: i32, slope: i16, length: i64, back: u32) -> i32 {
    let change = (i64::from(slope) * length + (1 << back >> 1)) >> back;
    i32::try_from(i64::from(weight) - change).unwrap_or(weight)
}

#[allow(clippy::cast_possible_truncation)]
fn low(number: i32) -> i16 {
    number as i16
}
