//! Weights of a filter by the DSP extension: `smmla` adds the upper half of a 32x32-bit product.

use crate::kernels::plain::weights as plain;
use core::arch::asm;

pub(crate) fn largest(weights: &[i32], factor: i64, sums: &[i32], left: u32) -> u32 {
    let count = weights.len().min(sums.len());
    let mut largest = 0;
    if count == 0 {
        return largest;
    }
    let [lower, upper] = halves(factor);
    // SAFETY: each slice has `count` numbers.
    unsafe {
        asm!(
            "2:",
            "ldr {weight}, [{weights}], #4",
            "ldr {sum}, [{sums}], #4",
            "lsls {sum}, {left}",
            "smmla {number}, {weight}, {lower}, {sum}",
            "mla {number}, {weight}, {upper}, {number}",
            "cmp {number}, #0",
            "bge 3f",
            "rsbs {sum}, {sum}, #0",
            "smmls {number}, {weight}, {lower}, {sum}",
            "mls {number}, {weight}, {upper}, {number}",
            "3:",
            "cmp {largest}, {number}",
            "it lo",
            "movlo {largest}, {number}",
            "subs {count}, #1",
            "bne 2b",
            weights = inout(reg) weights.as_ptr() => _,
            sums = inout(reg) sums.as_ptr() => _,
            count = inout(reg) count => _,
            lower = in(reg) lower,
            upper = in(reg) upper,
            left = in(reg) left,
            largest = inout(reg) largest,
            weight = out(reg) _, sum = out(reg) _, number = out(reg) _,
            options(readonly, nostack),
        );
    }
    largest
}

pub(crate) fn code(weights: &[i32], factor: i64, sums: &[i32], left: u32, shift: u32, out: &mut [i16]) {
    let count = weights.len().min(sums.len()).min(out.len());
    if count == 0 {
        return;
    }
    let [lower, upper] = halves(factor);
    // SAFETY: each slice has `count` numbers.
    unsafe {
        asm!(
            "2:",
            "ldr {weight}, [{weights}], #4",
            "ldr {number}, [{sums}], #4",
            "lsls {number}, {left}",
            "smmla {number}, {weight}, {lower}, {number}",
            "mla {number}, {weight}, {upper}, {number}",
            // Rounds by the last bit shifted out.
            "asrs {number}, {first}",
            "add {number}, {number}, {last}",
            "asrs {number}, {last}",
            "strh {number}, [{out}], #2",
            "subs {count}, #1",
            "bne 2b",
            weights = inout(reg) weights.as_ptr() => _,
            sums = inout(reg) sums.as_ptr() => _,
            out = inout(reg) out.as_mut_ptr() => _,
            count = inout(reg) count => _,
            lower = in(reg) lower,
            upper = in(reg) upper,
            left = in(reg) left,
            first = in(reg) shift.saturating_sub(1),
            last = in(reg) shift.min(1),
            weight = out(reg) _, number = out(reg) _,
            options(nostack),
        );
    }
}

/// Subtracts `slope * length / 2^back`, rounded, from each weight, unless the difference overflows an `i32`. The
/// assembly scales `length` so that it can divide by 2^32. If `back` is more than 32, or the change of a weight may not
/// fit in an `i32`, the plain loop runs.
pub(crate) fn step(weights: &mut [i32], slopes: &[i16], length: i64, back: u32) {
    let count = weights.len().min(slopes.len());
    if count == 0 || back > 32 || length.unsigned_abs() >> (15 + back) != 0 {
        return plain::step(weights, slopes, length, back);
    }
    let [lower, upper] = halves(length << (32 - back));
    // SAFETY: each slice has `count` numbers.
    unsafe {
        asm!(
            "2:",
            "ldrsh {slope}, [{slopes}], #2",
            "smull {low}, {high}, {slope}, {lower}",
            "mla {high}, {slope}, {upper}, {high}",
            "ldr {weight}, [{weights}], #4",
            "adds {low}, {low}, {low}",
            "adc {high}, {high}, #0",
            "subs {weight}, {weight}, {high}",
            "it vc",
            "strvc {weight}, [{weights}, #-4]",
            "subs {count}, #1",
            "bne 2b",
            weights = inout(reg) weights.as_mut_ptr() => _,
            slopes = inout(reg) slopes.as_ptr() => _,
            count = inout(reg) count => _,
            lower = in(reg) lower,
            upper = in(reg) upper,
            slope = out(reg) _, weight = out(reg) _, low = out(reg) _, high = out(reg) _,
            options(nostack),
        );
    }
}

/// The two halves of `number = lower + upper * 2^32`. The lower half is signed.
#[allow(clippy::cast_possible_truncation)] // the two halves
fn halves(number: i64) -> [i32; 2] {
    let lower = number as i32;
    [lower, (number.wrapping_sub(lower.into()) >> 32) as i32]
}
