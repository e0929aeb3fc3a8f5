//! Gray levels of a row by Helium: 16 pixels or four bilinear samples at a time.

use crate::kernels::plain::levels::{MixedRow, SampleWeights};
use core::arch::asm;

#[inline(always)]
pub(crate) fn deviation(pixels: &[u8], level: u8) -> [u32; 2] {
    let (mut deviation, mut clipped) = (0, 0);
    // SAFETY: only `pixels` are read. Nothing is written. A pixel is 0 or 255 if pixel + 1, modulo 256, is 0 or 1.
    unsafe {
        asm!(
            "vdup.8 q1, {level}",
            "vmov.i8 q2, #1",
            "wlstp.8 lr, {count}, 3f",
            "2:",
            "vldrb.u8 q0, [{at}], #16",
            "vabav.u8 {deviation}, q0, q1",
            "vadd.i8 q0, q0, q2",
            "vpt.u8 cs, q2, q0",
            "vaddvat.u8 r2, q2",
            "letp lr, 2b",
            "3:",
            at = inout(reg) pixels.as_ptr() => _,
            count = in(reg) pixels.len(),
            level = in(reg) u32::from(level),
            deviation = inout(reg) deviation,
            inout("r2") clipped, // in an even register, which `vaddva` requires for its sum
            out("lr") _, out("q0") _, out("q1") _, out("q2") _,
            options(readonly, nostack),
        );
    }
    [deviation, clipped]
}

#[inline(always)]
pub(crate) fn replace(old: &mut [u8], new: &[u8], largest: u8) -> u8 {
    let mut largest = u32::from(largest);
    // SAFETY: only the first `count` pixels of each are read, and those of `old` written.
    unsafe {
        asm!(
            "vmov.i8 q2, #0",
            "wlstp.8 lr, {count}, 3f",
            "2:",
            "vldrb.u8 q0, [{new}], #16",
            "vldrb.u8 q1, [{old}]",
            "vstrb.8 q0, [{old}], #16",
            "vabd.u8 q0, q0, q1",
            "vmax.u8 q2, q2, q0",
            "letp lr, 2b",
            "3:",
            "vmaxv.u8 {largest}, q2",
            old = inout(reg) old.as_mut_ptr() => _,
            new = inout(reg) new.as_ptr() => _,
            count = in(reg) old.len().min(new.len()),
            largest = inout(reg) largest,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _,
            options(nostack),
        );
    }
    largest.to_le_bytes()[0]
}

/// # Safety
/// Each number in `from` is even, and less than twice [`LEFT_SAMPLES`](crate::kernels::plain::levels::LEFT_SAMPLES).
#[inline(always)]
pub(crate) unsafe fn mix(from: &[u16], parts: &[SampleWeights], row: &MixedRow, out: &mut [u8]) {
    let count = out.len().min(from.len()).min(parts.len());
    if count == 0 {
        return;
    }
    // SAFETY: each slice has `count` numbers; the last round uses only the lanes left. Each number in `from` is the
    // place of a pair in the row, which need not be aligned. The product is twice the level, less 256, rounded down.
    unsafe {
        asm!(
            "vmov.i16 q3, #256",
            "dlstp.32 lr, {count}",
            "2:",
            "vldrh.u32 q0, [r0], #8",
            "vldrb.u8 q1, [{parts}], #16",
            "vldrw.u32 q2, [{row}, q0]",
            "vqdmladh.s16 q0, q2, q1",
            "vrhadd.s16 q0, q0, q3",
            "vstrb.32 q0, [r1], #4",
            "letp lr, 2b",
            parts = inout(reg) parts.as_ptr() => _,
            count = in(reg) count,
            row = in(reg) row.as_ptr(),
            // The base register of a widening load or a narrowing store must be one of r0 to r7.
            inout("r0") from.as_ptr() => _,
            inout("r1") out.as_mut_ptr() => _,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _,
            options(nostack),
        );
    }
}
