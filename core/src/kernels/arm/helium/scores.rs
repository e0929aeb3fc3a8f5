//! Scores by Helium, the vectors of Armv8.1-M: 16 pixels in a vector, by `asm!`, because there are no intrinsics.
//!
//! - `vldrh` with a vector of offsets loads an entry of the table for each lane.
//! - `vabav` adds the absolute differences of two vectors to a register.
//! - `vpt` compares. The instructions after it work only in the lanes where the comparison holds, or does not hold.
//! - A loop from `dlstp` to `letp` counts pixels down in `lr`. The last round uses one lane for each remaining pixel.

use super::super::points::{OFFSETS, Points};
use super::super::scores::{Loops, blocks};
use super::{LANES, bounds, strides};
use crate::kernels::plain::scores as plain;
use crate::kernels::rows::Rows;
use core::arch::asm;

pub(crate) struct Helium;

impl Loops for Helium {
    const NARROWEST: usize = 1;
    const REACHABLE: unsafe fn(&Rows, *const u16, u32) -> u32 = reachable;
    const DISTANCE: unsafe fn(&Rows, u32) -> u32 = distance;
    const OUTSIDE_RANGES: unsafe fn(&Rows, u32) -> u32 = bounds::outside_ranges;
    const POINT_MARGINS: unsafe fn(&Rows, &Points, u32, u8) -> [i32; OFFSETS] = bounds::point_margins;
    const RANGES: fn(&[&[u8]; 4], u8, &mut [u8], &mut [u8]) = ranges;
}

/// Implements [`Loops::REACHABLE`].
///
/// # Safety
/// `pair.width` pixels, at least one, can be read in each of the `pair.height` rows (at least one) of both
/// pictures, and 256 numbers at `entries`.
#[inline(always)]
unsafe fn reachable(pair: &Rows, entries: *const u16, floor: u32) -> u32 {
    let mut reachable = pair.full_after(0);
    // Half the lanes, because a vector holds only eight 16-bit entries of the table.
    let [f_stride, g_stride] = strides(pair, LANES / 2);
    // SAFETY: only the `width` pixels of a row, at least one, and entries up to 255 are read. Nothing is written.
    unsafe {
        asm!(
            "2:",
            "dlstp.16 lr, {width}",
            "3:",
            "vldrb.u16 q0, [r0], #8",
            "vldrb.u16 q1, [r1], #8",
            "vabd.u16 q0, q0, q1",
            "vldrh.u16 q1, [{entries}, q0, uxtw #1]",
            "vaddva.u16 r2, q1",
            "letp lr, 3b",
            "sub r2, r2, {full}",
            "cmp r2, {floor}",
            "blo 4f",
            "add r0, r0, {f_stride}",
            "add r1, r1, {g_stride}",
            "subs {rows}, {rows}, #1",
            "bne 2b",
            "4:",
            inout("r0") pair.patch => _,
            inout("r1") pair.template => _,
            f_stride = in(reg) f_stride,
            g_stride = in(reg) g_stride,
            rows = inout(reg) pair.height => _,
            width = in(reg) pair.width,
            full = in(reg) plain::full(pair.width),
            floor = in(reg) floor,
            entries = in(reg) entries,
            inout("r2") reachable,
            out("lr") _, out("q0") _, out("q1") _,
            options(readonly, nostack),
        );
    }
    reachable
}

/// Implements [`Loops::DISTANCE`].
///
/// # Safety
/// `pair.width` pixels, at least one, can be read in each of the `pair.height` rows (at least one) of both pictures.
#[inline(always)]
unsafe fn distance(pair: &Rows, enough: u32) -> u32 {
    let mut sum = 0;
    let [f_stride, g_stride] = strides(pair, LANES);
    // SAFETY: only the `width` pixels of a row, at least one, are read. Nothing is written.
    unsafe {
        asm!(
            "2:",
            "dlstp.8 lr, {width}",
            "3:",
            "vldrb.u8 q0, [{f}], #16",
            "vldrb.u8 q1, [{g}], #16",
            "vabav.u8 {sum}, q0, q1",
            "letp lr, 3b",
            "cmp {sum}, {enough}",
            "bhi 4f",
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
            enough = in(reg) enough,
            sum = inout(reg) sum,
            out("lr") _, out("q0") _, out("q1") _,
            options(readonly, nostack),
        );
    }
    sum
}

/// Replaces each lane of `$picked` by the minimum (or maximum) of itself and the three lanes before it. `$ones` carries
/// one lane from a vector to the next, `$twos` carries two.
macro_rules! of_four {
    ($pick:literal, $picked:literal, $ones:literal, $twos:literal) => {
        concat!(
            of_four!(@ $pick, $picked, $ones, "8"),
            of_four!(@ $pick, $picked, $twos, "16"),
        )
    };
    (@ $pick:literal, $picked:literal, $carry:literal, $bits:literal) => {
        concat!(
            concat!("vmov q2, ", $picked, "\n"),
            concat!("vshlc q2, ", $carry, ", #", $bits, "\n"),
            concat!($pick, " ", $picked, ", ", $picked, ", q2\n"),
        )
    };
}

/// Takes the minimum and maximum of the four pixels in each column, then the extremes of four columns: a lane and the
/// three lanes before it. So the block of a lane begins three columns before the lane, and the first three lanes of the
/// first vector are not stored.
fn ranges(rows: &[&[u8]; 4], margin: u8, low: &mut [u8], span: &mut [u8]) {
    let columns = blocks(rows, low, span);
    if columns == 0 {
        return;
    }
    let [a, b, c, d] = rows.each_ref().map(|row| row.as_ptr());
    // SAFETY: `columns + 3` pixels of each row are read, and `columns` of `low` and `span` written, and `blocks` counts
    // no more than they have.
    unsafe {
        asm!(
            "vdup.8 q3, {lanes}",
            "movw {lanes}, #0xfff8",
            "dlstp.8 lr, lr",
            "3:",
            "vldrb.u8 q0, [{a}], #16",
            "vldrb.u8 q2, [{b}], #16",
            "vmax.u8 q1, q0, q2",
            "vmin.u8 q0, q0, q2",
            "vldrb.u8 q2, [{c}], #16",
            "vmax.u8 q1, q1, q2",
            "vmin.u8 q0, q0, q2",
            "vldrb.u8 q2, [{d}], #16",
            "vmax.u8 q1, q1, q2",
            "vmin.u8 q0, q0, q2",
            of_four!("vmin.u8", "q0", "{least}", "{least_of_two}"),
            of_four!("vmax.u8", "q1", "{most}", "{most_of_two}"),
            "vqsub.u8 q0, q0, q3",
            "vqadd.u8 q1, q1, q3",
            "vsub.i8 q1, q1, q0",
            "vmsr p0, {lanes}",
            "vpstt",
            "vstrbt.8 q0, [{low}], #16",
            "vstrbt.8 q1, [{span}], #16",
            "movw {lanes}, #0xffff",
            "letp lr, 3b",
            a = inout(reg) a => _,
            b = inout(reg) b => _,
            c = inout(reg) c => _,
            d = inout(reg) d => _,
            low = inout(reg) low.as_mut_ptr().wrapping_sub(3) => _,
            span = inout(reg) span.as_mut_ptr().wrapping_sub(3) => _,
            lanes = inout(reg) u32::from(margin) => _,
            // Lanes carried between vectors. Any start value is right: lanes computed from it are not stored.
            least = out(reg) _, least_of_two = out(reg) _, most = out(reg) _, most_of_two = out(reg) _,
            inout("lr") columns + 3 => _,
            out("q0") _, out("q1") _, out("q2") _, out("q3") _,
            options(nostack),
        );
    }
}
