//! Upper bounds of scores by Helium, to exclude offsets: from the points (255 - difference) at four neighbouring
//! offsets, or from the count of template pixels outside their ranges for a group of 4x4 offsets. A range holds the 4x4
//! pixels that a template pixel meets at these offsets, widened by threshold - 1 on both sides, and is stored as lower
//! end and length. A pixel outside its range differs by the threshold or more at all 16 offsets.

use super::super::points::{OFFSETS, Points};
use super::{LANES, strides};
use crate::kernels::rows::Rows;
use core::arch::asm;

/// Adds the points of the pixels at `$from` to `$sum`: 255 - difference, or 0 from the threshold on.
macro_rules! points {
    ($from:literal, $sum:literal) => {
        concat!(
            concat!("vldrb.u8 q1, ", $from, "\n"),
            "vabd.u8 q1, q0, q1\n",
            "vpt.u8 cs, q2, q1\n",
            concat!("vabavt.u8 ", $sum, ", q1, q3\n"), // 255 less the difference
        )
    };
}

/// Implements `Loops::POINT_MARGINS`.
///
/// # Safety
/// `pair.width` pixels, at least one, can be read in each of the `pair.height` rows (at least one) of the template,
/// and three more in each row of the patch.
#[inline(never)]
pub(super) unsafe fn point_margins(pair: &Rows, points: &Points, needed: u32, wanted: u8) -> [i32; OFFSETS] {
    let [f_stride, g_stride] = strides(pair, LANES);
    let mut margins = Points::initial_margins(pair, needed, wanted);
    let [a, b, c, d] = &mut margins;
    // SAFETY: only the `width` pixels of a row are read, in the patch up to three columns further. Nothing is written.
    unsafe {
        asm!(
            "vdup.8 q2, lr",
            "vmov.i8 q3, #255",
            "2:",
            "dlstp.8 lr, {width}",
            "3:",
            "vldrb.u8 q0, [{g}], #16",
            points!("[{f}, #1]", "r2"),
            points!("[{f}, #2]", "r4"),
            points!("[{f}, #3]", "r12"),
            points!("[{f}], #16", "r0"),
            "letp lr, 3b",
            "sub r0, r0, {full}",
            "sub r2, r2, {full}",
            "sub r4, r4, {full}",
            "sub r12, r12, {full}",
            "and lr, r0, r2",
            "and lr, lr, r4",
            "ands lr, lr, r12",
            "bmi 4f", // no offset is left
            "add {f}, {f}, {f_stride}",
            "add {g}, {g}, {g_stride}",
            "subs {rows}, {rows}, #1",
            "bne 2b",
            "4:",
            f = inout(reg) pair.patch => _,
            g = inout(reg) pair.template => _,
            f_stride = in(reg) f_stride,
            g_stride = in(reg) g_stride,
            rows = inout(reg) pair.height => _,
            width = in(reg) pair.width,
            full = in(reg) Points::of_row(pair),
            inout("r0") *a,
            inout("r2") *b,
            inout("r4") *c,
            inout("r12") *d,
            inout("lr") u32::from(points.largest) => _,
            out("q0") _, out("q1") _, out("q2") _, out("q3") _,
            options(readonly, nostack),
        );
    }
    margins
}

/// Implements `Loops::OUTSIDE_RANGES`.
///
/// # Safety
/// `pair.width` bytes, at least one, can be read in each of the `pair.height` rows (at least one) at `pair.patch` and
/// at `pair.high`, both `pair.patch_stride` apart, and of the template.
#[inline(never)]
pub(super) unsafe fn outside_ranges(pair: &Rows, allowed: u32) -> u32 {
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
