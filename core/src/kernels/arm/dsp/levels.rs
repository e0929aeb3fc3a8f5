//! Gray levels of a row by the DSP extension: four pixels or one bilinear sample at a time.

use super::words::{LANES, in_lanes};
use crate::kernels::plain::levels::{MixedRow, SampleWeights};
use crate::kernels::unrolling::rolled;
use core::arch::asm;

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

/// Samples two columns: the weights in the registers become 2^16 times the gray levels.
macro_rules! columns {
    ($first:literal $second:literal) => {
        concat!(
            "ldrh {x}, [{from}], #2\nldrh {y}, [{from}], #2\nldr {x}, [{row}, {x}]\nldr {y}, [{row}, {y}]\n",
            concat!("smlad ", $first, ", {x}, ", $first, ", {half}\nsmlad ", $second, ", {y}, ", $second, ", {half}\n"),
        )
    };
}

/// Samples columns as `plain::levels::mix` does. `smlad` weights and adds two samples in one instruction. It multiplies
/// signed numbers, so `row` stores 256 * level - 2^15.
///
/// # Safety
/// Each number in `from` is even, and less than twice [`LEFT_SAMPLES`](crate::kernels::plain::levels::LEFT_SAMPLES).
#[inline(always)]
pub(crate) unsafe fn mix(from: &[u16], parts: &[SampleWeights], row: &MixedRow, out: &mut [u8]) {
    let count = out.len().min(from.len()).min(parts.len());
    // SAFETY: each slice has `count` numbers. Each number in `from` is the place of a pair, at any alignment. Parts are
    // words.
    unsafe {
        asm!(
            "subs r5, #4",
            "blo 3f",
            "2:",
            "ldm r0!, {{r1, r2, r3, r4}}",
            columns!("r1" "r2"),
            columns!("r3" "r4"),
            "pkhtb r1, r3, r1, asr #16\npkhtb r2, r4, r2, asr #16",
            "orr r1, r1, r2, lsl #8\nstr r1, [{out}], #4",
            "subs r5, #4",
            "bhs 2b",
            "3:",
            "adds r5, #4",
            "beq 5f",
            "4:",
            "ldrh {x}, [{from}], #2\nldm r0!, {{r1}}\nldr {x}, [{row}, {x}]\nsmlad r1, {x}, r1, {half}",
            "lsrs r1, r1, #16\nstrb r1, [{out}], #1",
            "subs r5, #1",
            "bne 4b",
            "5:",
            from = inout(reg) from.as_ptr() => _,
            inout("r0") parts.as_ptr() => _,
            out = inout(reg) out.as_mut_ptr() => _,
            inout("r5") count => _,
            row = in(reg) row.as_ptr(), half = in(reg) (1 << 23) + (1 << 15),
            x = out(reg) _, y = out(reg) _, out("r1") _, out("r2") _, out("r3") _, out("r4") _,
            options(nostack),
        );
    }
}
