//! Columns of a resampled row by Helium: four at a time. The plain loop is in `plain/bilinear.rs`.

use crate::kernels::plain::bilinear::MixedRow;
use core::arch::asm;

/// Computes the gray levels of columns, as `plain::levels` specifies them.
///
/// # Safety
/// Each number in `from` is less than twice [`PLACES`](crate::kernels::plain::bilinear::PLACES).
#[inline(always)]
pub(crate) unsafe fn mix(from: &[u16], parts: &[[u16; 2]], row: &MixedRow, out: &mut [u8]) {
    let count = out.len().min(from.len()).min(parts.len());
    if count == 0 {
        return;
    }
    // SAFETY: each slice has `count` numbers, and the last round uses only the lanes that are left. Each number in
    // `from` is the place of a pair in the row, which need not be aligned. The product is twice the level, less 256,
    // rounded down.
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
            // A load that widens, and a store that narrows, take only r0 to r7.
            inout("r0") from.as_ptr() => _,
            inout("r1") out.as_mut_ptr() => _,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _,
            options(nostack),
        );
    }
}
