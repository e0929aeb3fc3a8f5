//! Gray levels of a row by the DSP extension: summed and replaced four pixels at a time, sampled column by column.

use super::words::{LANES, in_lanes};
use crate::kernels::plain::levels::MixedRow;
use crate::kernels::unrolling::rolled;
use core::arch::asm;

/// See `plain::deviation`.
#[inline(always)]
pub(crate) fn deviation(pixels: &[u8], level: u8) -> [u32; 2] {
    let words = pixels.chunks_exact(LANES);
    let (mut deviation, mut clipped) = (0, 0);
    for &pixel in rolled(words.remainder().iter()) {
        deviation += u32::from(pixel.abs_diff(level));
        clipped += u32::from(matches!(pixel, 0 | u8::MAX));
    }
    for word in words.filter_map(|word| word.first_chunk()) {
        // SAFETY: works on registers only. A pixel is 0 or 255 exactly if pixel + 1, modulo 256, is less than 2.
        unsafe {
            asm!(
                "usada8 {deviation}, {word}, {level}, {deviation}",
                "uadd8 {word}, {word}, {one}",
                "usub8 {word}, {word}, {two}",
                "sel {word}, {zero}, {one}",
                "usada8 {clipped}, {word}, {zero}, {clipped}",
                deviation = inout(reg) deviation,
                clipped = inout(reg) clipped,
                word = inout(reg) u32::from_ne_bytes(*word) => _,
                level = in(reg) in_lanes(level),
                zero = in(reg) 0,
                one = in(reg) in_lanes(1),
                two = in(reg) in_lanes(2),
                options(pure, nomem, nostack),
            );
        }
    }
    [deviation, clipped]
}

/// See `plain::replace`.
#[inline(always)]
pub(crate) fn replace(old: &mut [u8], new: &[u8], largest: u8) -> u8 {
    let (mut old, new) = (old.chunks_exact_mut(LANES), new.chunks_exact(LANES));
    let rest = new.remainder();
    let mut most = u32::from(largest);
    for (old, new) in old.by_ref().zip(new) {
        let Some((old, &new)) = old.first_chunk_mut().zip(new.first_chunk()) else { continue };
        // SAFETY: works on registers only. max(m, d) = m + max(d - m, 0) in each lane.
        unsafe {
            asm!(
                "uqsub8 {more}, {old}, {new}",
                "uqsub8 {old}, {new}, {old}",
                "orr {old}, {old}, {more}",
                "uqsub8 {old}, {old}, {most}",
                "uadd8 {most}, {most}, {old}",
                more = out(reg) _,
                old = inout(reg) u32::from_ne_bytes(*old) => _,
                new = in(reg) u32::from_ne_bytes(new),
                most = inout(reg) most,
                options(pure, nomem, nostack),
            );
        }
        *old = new;
    }
    let [a, b, c, d] = most.to_ne_bytes();
    let mut largest = a.max(b).max(c.max(d));
    for (old, &new) in rolled(old.into_remainder().iter_mut().zip(rest)) {
        largest = largest.max(old.abs_diff(new));
        *old = new;
    }
    largest
}

/// Computes one column.
macro_rules! column {
    () => {
        concat!(
            "ldrh {pair}, [{from}], #2\n",
            "ldr {part}, [{parts}], #4\n",
            "ldr {pair}, [{row}, {pair}]\n",
            "smlad {pair}, {pair}, {part}, {half}\n",
            "lsrs {pair}, {pair}, #16\n",
            "strb {pair}, [{out}], #1\n",
        )
    };
}

/// See `plain::mix`. `smlad` mixes two numbers in one instruction. It takes signed numbers, so 2^15 is subtracted from
/// the numbers of a row.
///
/// # Safety
/// Each number in `from` is less than twice [`PLACES`](crate::kernels::plain::levels::PLACES).
#[inline(always)]
pub(crate) unsafe fn mix(from: &[u16], parts: &[[u16; 2]], row: &MixedRow, out: &mut [u8]) {
    let count = out.len().min(from.len()).min(parts.len());
    if count == 0 {
        return;
    }
    // SAFETY: each slice has `count` numbers. Each number in `from` is the place of a pair in the row, which need not
    // be aligned.
    unsafe {
        asm!(
            "tst {count}, #1",
            "beq 2f",
            column!(),
            "subs {count}, #1",
            "beq 3f",
            "2:",
            column!(),
            column!(),
            "subs {count}, #2",
            "bne 2b",
            "3:",
            from = inout(reg) from.as_ptr() => _,
            parts = inout(reg) parts.as_ptr() => _,
            out = inout(reg) out.as_mut_ptr() => _,
            count = inout(reg) count => _,
            row = in(reg) row.as_ptr(),
            half = in(reg) (1 << 23) + (1 << 15),
            pair = out(reg) _, part = out(reg) _,
            options(nostack),
        );
    }
}
