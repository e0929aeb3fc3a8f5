//! Weights of a filter by Helium, four at a time. In a loop from `dlstp` to `letp`, the last round uses only as many
//! lanes as there are weights left.

use crate::kernels::plain::weights as plain;
use core::arch::asm;

pub(crate) fn largest(weights: &[i32], factor: i64, sums: &[i32], left: u32) -> u32 {
    let Ok(factor) = i32::try_from(factor) else { return plain::largest(weights, factor, sums, left) };
    let count = weights.len().min(sums.len());
    let mut largest = 0;
    if count == 0 {
        return largest;
    }
    // SAFETY: each slice has `count` numbers, and the last round uses only the lanes that are left.
    unsafe {
        asm!(
            "vdup.32 q4, {factor}",
            "vneg.s32 q5, q4",
            "dlstp.32 lr, {count}",
            "2:",
            "vldrw.u32 q0, [{weights}], #16",
            "vldrw.u32 q1, [{sums}], #16",
            "vshl.s32 q1, {left}",
            "vmulh.s32 q2, q0, q4",
            "vadd.i32 q2, q2, q1",
            "vmulh.s32 q3, q0, q5",
            "vsub.i32 q3, q3, q1",
            "vpt.s32 lt, q2, zr",
            "vorrt q2, q3, q3",
            "vmaxv.u32 {largest}, q2",
            "letp lr, 2b",
            weights = inout(reg) weights.as_ptr() => _,
            sums = inout(reg) sums.as_ptr() => _,
            factor = in(reg) factor,
            left = in(reg) left,
            largest = inout(reg) largest,
            count = in(reg) count,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _, out("q5") _,
            options(readonly, nostack),
        );
    }
    largest
}

pub(crate) fn code(weights: &[i32], factor: i64, sums: &[i32], left: u32, shift: u32, out: &mut [i16]) {
    let Ok(factor) = i32::try_from(factor) else { return plain::code(weights, factor, sums, left, shift, out) };
    let count = weights.len().min(sums.len()).min(out.len());
    if count == 0 {
        return;
    }
    // SAFETY: each slice has `count` numbers, and the last round uses only the lanes that are left.
    unsafe {
        asm!(
            "vdup.32 q2, {factor}",
            "dlstp.32 lr, {count}",
            "2:",
            "vldrw.u32 q0, [{weights}], #16",
            "vldrw.u32 q1, [{sums}], #16",
            "vmulh.s32 q0, q0, q2",
            "vshl.s32 q1, {left}",
            "vadd.i32 q0, q0, q1",
            "vrshl.s32 q0, {right}",
            "vstrh.32 q0, [r0], #8",
            "letp lr, 2b",
            weights = inout(reg) weights.as_ptr() => _,
            sums = inout(reg) sums.as_ptr() => _,
            factor = in(reg) factor,
            left = in(reg) left,
            right = in(reg) shift.wrapping_neg(),
            count = in(reg) count,
            inout("r0") out.as_mut_ptr() => _,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _,
            options(nostack),
        );
    }
}

/// Multiplies each slope by three 16-bit parts of the length in turn, from the lowest on. Each product, shifted right
/// by 16, is added to the next one. Beyond the limits in this list the plain loop runs:
///
/// - The first two products fit in an `i32` for any slope, the third if the length is below 2^47.
/// - The changes fit in an `i32` if the length is below 2^(15 + back).
/// - If `back` is more than 16, rounding adds nothing to the lowest 16 bits.
pub(crate) fn step(weights: &mut [i32], slopes: &[i16], length: i64, back: u32) {
    let count = weights.len().min(slopes.len());
    if count == 0 || !(17..=47).contains(&back) || length.unsigned_abs() >> (15 + back).min(47) != 0 {
        return plain::step(weights, slopes, length, back);
    }
    let half = 1_i64 << (back - 1);
    let piece = |number: i64| u32::try_from(number & 0xFFFF).unwrap_or(0);
    let upper = |number: i64| i32::try_from(number >> 32).unwrap_or(0);
    // SAFETY: each slice has `count` numbers, and the last round uses only the lanes that are left.
    unsafe {
        asm!(
            "dlstp.32 lr, lr",
            "2:",
            "vldrh.s32 q0, [r0], #8",
            "vmul.i32 q1, q0, {first}",
            "vshr.s32 q1, q1, #16",
            "vadd.i32 q1, q1, {half}",
            "vmla.i32 q1, q0, {second}",
            "vshr.s32 q2, q1, #16",
            "vadd.i32 q2, q2, {upper_half}",
            "vmla.i32 q2, q0, {third}",
            "vmovlb.u16 q1, q1",
            "vshl.u32 q1, {right}",
            "vshl.s32 q2, {left}",
            "vadd.i32 q1, q1, q2",
            "vldrw.u32 q0, [{weights}]",
            "vsub.i32 q2, q0, q1",
            "vqsub.s32 q0, q0, q1",
            "vpt.i32 eq, q0, q2",
            "vstrwt.32 q0, [{weights}]",
            "adds {weights}, #16",
            "letp lr, 2b",
            weights = inout(reg) weights.as_mut_ptr() => _,
            first = in(reg) piece(length),
            second = in(reg) piece(length >> 16),
            third = in(reg) upper(length),
            half = in(reg) piece(half >> 16),
            upper_half = in(reg) upper(half),
            // A shift to the left by a negative number is one to the right.
            left = in(reg) 32_u32.wrapping_sub(back),
            right = in(reg) 16_u32.wrapping_sub(back),
            inout("r0") slopes.as_ptr() => _,
            inout("lr") count => _,
            out("q0") _, out("q1") _, out("q2") _,
            options(nostack),
        );
    }
}
