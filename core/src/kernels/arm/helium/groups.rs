//! Bounds a group of offsets by Helium: counts the pixels of the template that cannot count at any offset of the group.
//!
//! A pixel counts only if it lies within the range of its block, widened by threshold - 1 on both sides. The ranges are
//! stored as that test needs them: the lower end, and the length.

use super::{LANES, strides};
use crate::kernels::rows::Rows;
use core::arch::asm;

/// See [`Loops::MISSES`](super::super::scores::Loops::MISSES).
///
/// # Safety
/// Patch and upper bound have the same stride.
#[inline(never)]
pub(super) unsafe fn misses(pair: &Rows, allowed: u32) -> u32 {
    let [low_stride, g_stride] = strides(pair, LANES);
    let misses: u32;
    // SAFETY: only the `width` pixels of a row are read. Nothing is written.
    unsafe {
        asm!(
            "vmov.i8 q3, #1",
            "2:",
            "dlstp.8 lr, {width}",
            "3:",
            "vldrb.u8 q0, [{low}], #16",
            "vldrb.u8 q1, [{g}], #16",
            "vsub.i8 q0, q1, q0",
            "vldrb.u8 q2, [{span}], #16",
            "vpt.u8 hi, q0, q2",
            "vaddvat.u8 r2, q3",
            "letp lr, 3b",
            "cmp r2, {allowed}",
            "bhi 4f",
            "add {low}, {low}, {low_stride}",
            "add {span}, {span}, {low_stride}",
            "add {g}, {g}, {g_stride}",
            "subs {rows}, {rows}, #1",
            "bne 2b",
            "4:",
            low = inout(reg) pair.patch => _,
            span = inout(reg) pair.high => _,
            g = inout(reg) pair.template => _,
            low_stride = in(reg) low_stride,
            g_stride = in(reg) g_stride,
            rows = inout(reg) pair.height => _,
            width = in(reg) pair.width,
            allowed = in(reg) allowed,
            inout("r2") 0 => misses,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _,
            options(readonly, nostack),
        );
    }
    misses
}
