//! Columns of a resampled row by the DSP extension: `smlad` mixes two numbers in one instruction. It takes signed
//! numbers, so 2^15 is subtracted from the numbers of a row. The plain loop is in `plain/bilinear.rs`.

use crate::kernels::plain::bilinear::MixedRow;
use core::arch::asm;

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
