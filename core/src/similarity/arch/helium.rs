//! The kernels by Helium, the vectors of Armv8.1-M (Cortex-M52, M55, M85): 16 pixels in a register.
//!
//! - `vabav` adds the absolute differences of two registers to a third.
//! - `vpt` compares, and lets the instructions after it work where it holds, or where it does not.
//! - In a loop from `dlstp` to `letp`, which counts pixels down in `lr`, the last round works in as many lanes as there are
//!   pixels left: nothing else is read or written.
//!
//! `asm!`, as there are no intrinsics. For `means` the compiler makes the same of the plain loop by itself.

use super::super::Table;
use super::Kernels;
use super::filter::{Filter, Limit};
use super::rows::Pair;
use crate::image::Image;
use core::arch::asm;

/// Pixels in a register.
const LANES: usize = 16;

pub(super) struct Helium(Filter);

impl Helium {
    pub(super) fn new(table: &'static Table, threshold: u16) -> Self {
        Self(Filter::new(table, threshold))
    }
}

impl Kernels for Helium {
    #[inline(never)]
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        self.0.score_at_least::<1>(patch, template, floor, exceeds)
    }

    #[inline(never)]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let pair = Pair::new(patch, template);
        let mut sum = 0;
        // How far a row's loop goes: whole registers.
        let advance = pair.width.next_multiple_of(LANES);
        // SAFETY: of every row, the pixels up to `width` are read, of which there is at least one; nothing is written.
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
                f = inout(reg) pair.patch.first => _,
                g = inout(reg) pair.template.first => _,
                f_stride = in(reg) pair.patch.stride.wrapping_sub(advance),
                g_stride = in(reg) pair.template.stride.wrapping_sub(advance),
                rows = inout(reg) pair.height => _,
                width = in(reg) pair.width,
                enough = in(reg) enough,
                sum = inout(reg) sum,
                out("lr") _,
                out("q0") _,
                out("q1") _,
                options(readonly, nostack),
            );
        }
        sum
    }
}

/// True if the pictures lose more than is allowed: certainly from some row on.
fn exceeds(pair: &Pair, limit: &Limit) -> bool {
    let advance = pair.width.next_multiple_of(LANES);
    let left: usize;
    // SAFETY: as in `distance`.
    unsafe {
        asm!(
            "vdup.8 q2, lr",
            "vmov.i8 q3, #1",
            "2:",
            "dlstp.8 lr, {width}",
            "3:",
            "vldrb.u8 q0, [{f}], #16",
            "vldrb.u8 q1, [{g}], #16",
            "vabd.u8 q0, q0, q1",
            "vpte.u8 cs, q0, q2",
            "vaddvat.u8 r2, q3", // where the threshold is reached, pixels
            "vaddvae.u8 r4, q0", // elsewhere differences
            "letp lr, 3b",
            "rsb lr, r2, r2, lsl #16", // * 65535
            "mla lr, r4, {chord}, lr",
            "cmp lr, {allowed}",
            "bhi 4f",
            "add {f}, {f}, {f_stride}",
            "add {g}, {g}, {g_stride}",
            "subs {rows}, {rows}, #1",
            "bne 2b",
            "4:",
            f = inout(reg) pair.patch.first => _,
            g = inout(reg) pair.template.first => _,
            f_stride = in(reg) pair.patch.stride.wrapping_sub(advance),
            g_stride = in(reg) pair.template.stride.wrapping_sub(advance),
            rows = inout(reg) pair.height => left,
            width = in(reg) pair.width,
            chord = in(reg) limit.chord,
            allowed = in(reg) limit.allowed,
            inout("r2") 0 => _,
            inout("r4") 0 => _,
            inout("lr") u32::from(limit.threshold) => _,
            out("q0") _,
            out("q1") _,
            out("q2") _,
            out("q3") _,
            options(readonly, nostack),
        );
    }
    left > 0
}
