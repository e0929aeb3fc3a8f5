//! Gradients of a cell by the DSP extension. `smusd` computes cos * |y| - sin * |x|: how far a gradient lies beyond a
//! direction.

use crate::kernels::layout::{CELL, CHANNELS, SIDE};
use crate::kernels::plain::gradients::DIRECTIONS;
use core::arch::asm;
use core::mem::MaybeUninit;

/// Packs cosine in the low 16 bits and sine in the high 16 bits, as `smusd` multiplies them.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // both fit in 16 bits
const fn pair(cos: i32, sin: i32) -> u32 {
    cos as u16 as u32 | (sin as u16 as u32) << 16
}

/// Directions for the assembly. Word 0: direction 0. Words 1 to 5: directions 1 to 5, negated. Words 6 to 9: directions
/// 1 to 4. A gradient lies in sector n if its angle is larger than those of n of the directions 1 to 4.
static TABLE: [u32; 10] = {
    let [first, (a, b), (c, d), (e, f), (g, h), (i, j)] = DIRECTIONS;
    let [k, l, m] = [pair(first.0, first.1), pair(-a, -b), pair(-c, -d)];
    [k, l, m, pair(-e, -f), pair(-g, -h), pair(-i, -j), pair(a, b), pair(c, d), pair(e, f), pair(g, h)]
};

/// Loads channel sums to the given registers and stores features: min(sum * inverse norm / 2^16, 127).
macro_rules! features {
    ($($sum:literal)*) => {
        concat!(
            $("ldrh ", $sum, ", [{from}], #{row}\n",)*
            $("smulwb ", $sum, ", {inverse}, ", $sum, "\n",)*
            $("usat ", $sum, ", #7, ", $sum, "\nstrb ", $sum, ", [{out}], #1\n",)*
        )
    };
}

/// Adds the gradient of a pixel to its sector; r11 becomes the sector's index minus 4. `$pixel` holds |y| in the low
/// and |x| in the high 16 bits. If x and y differ in sign, the top bit of byte `$byte` of r8 is set, which selects the
/// mirrored sector.
macro_rules! add {
    ($pixel:literal, $byte:literal) => {
        concat!(
            concat!("smusd r11, ", $pixel, ", r2\n"),
            concat!("smusd r9, ", $pixel, ", r3\n"),
            concat!("smusd lr, ", $pixel, ", r4\n"),
            "asrs r11, r11, #31\n",
            "add r11, r11, r9, asr #31\n",
            concat!("smusd r9, ", $pixel, ", r5\n"),
            "add r11, r11, lr, asr #31\n",
            "add r11, r11, r9, asr #31\n",
            concat!("uxtab r9, r0, r8, ror #8 * ", $byte, "\n"),
            "ldr lr, [r9, r11, lsl #2]\n",
            concat!("add lr, ", $pixel, "\n"),
            "str lr, [r9, r11, lsl #2]\n",
        )
    };
}

/// Computes the features of a row of cells as the plain loop does. Writes nothing if `sums` has fewer than ten channels
/// or `out` is longer than `ROW`.
#[inline(always)]
pub(crate) fn features<const ROW: usize>(sums: &[[u16; ROW]], inverses: &[u32; ROW], out: &mut [[i8; CHANNELS]]) {
    const { assert!(2 * ROW < 256) };
    if sums.len() < CHANNELS || out.is_empty() || out.len() > ROW {
        return;
    }
    // SAFETY: ten sums and an inverse are read for each cell in `out`, ten features written. No 16x32-bit product
    // overflows.
    unsafe {
        asm!(
            "2:",
            "ldr {inverse}, [{inverses}], #4",
            "mov {from}, {sums}",
            "adds {sums}, {sums}, #2",
            "movs {left}, #3",
            "3:",
            features!("{a}" "{b}" "{c}"),
            "subs {left}, {left}, #1",
            "bne 3b",
            "ldrh {a}, [{from}]",
            "lsrs {a}, {a}, #4",
            "eor {a}, {a}, #128",
            "strb {a}, [{out}], #1",
            "subs {count}, {count}, #1",
            "bne 2b",
            sums = inout(reg) sums.as_ptr() => _,
            inverses = inout(reg) inverses.as_ptr() => _,
            out = inout(reg) out.as_mut_ptr() => _,
            count = inout(reg) out.len() => _,
            inverse = out(reg) _, from = out(reg) _, left = out(reg) _, a = out(reg) _, b = out(reg) _, c = out(reg) _,
            row = const 2 * ROW,
            options(nostack),
        );
    }
}

/// Computes a channel sum from two or three sectors. The number after each sector is the index in `TABLE` of the
/// direction to multiply it by. Stores 1/64 of the sum, adds the square of 1/256 of it to r10, and moves r3 by r8 bytes
/// to the next channel.
macro_rules! sum {
    ($first:literal $at:literal, $second:literal $to:literal $(, $third:literal $by:literal)?) => {
        concat!(
            concat!("ldr r7, [r2, #4 * ", $at, "]\nldr r12, [r2, #4 * ", $to, "]\n"),
            concat!("smusd r6, ", $first, ", r7\n", $("ldr r7, [r2, #4 * ", $by, "]\n",)? "smlsd r6, ", $second, ", r12, r6\n"),
            $(concat!("smlsd r6, ", $third, ", r7, r6\n"),)?
            "lsrs r6, r6, #6\nstrh r6, [r3]\nadd r3, r8\nlsrs r6, r6, #2\nmla r10, r6, r6, r10\n",
        )
    };
}

/// Computes channel sums and energies as the plain loop does; nothing if `sums` has fewer than ten channels. A gradient
/// along an axis may be added to a sector or to its mirror image, because the votes are the same.
#[inline(never)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    const { assert!(COLUMNS >= 4 * ROW + 2 && COLUMNS < 256 && 2 * ROW < 256) };
    // Words 0 to 4: the sectors. Word 5: the end address of the pixels. Words 32 to 36: the mirrored sectors. They
    // begin at byte 128, so that the sign byte of a gradient (128 if x and y differ in sign, else 0) selects them.
    let mut memory = MaybeUninit::<[u32; 37]>::uninit();
    let mut pixels = lines.as_ptr().cast::<u8>().wrapping_add(COLUMNS);
    let mut to = sums.as_mut_ptr().cast::<u16>().wrapping_add(ROW);
    for energy in energies.iter_mut().take(if sums.len() < CHANNELS { 0 } else { across }) {
        // SAFETY: six pixels of each of six lines are read, and a sum of each of ten channels is written. Each line has
        // room for `ROW` cells and their neighbours, and `energies` has no more entries. Words need not be aligned. What
        // is read of `memory` has been written. r6 and r7, which `asm!` may not name, are saved on the stack.
        unsafe {
            asm!(
                "push {{r2, r3, r6, r7}}",
                "movs r6, #0",
                "ldr r4, [r1, #1]\nldr r5, [r1, #1 + {columns}]",
                "ldr r7, [r1, #1 + 2 * {columns}]\nldr r8, [r1, #1 + 3 * {columns}]",
                "usad8 r4, r4, r6\nusada8 r4, r5, r6, r4\nusada8 r4, r7, r6, r4\nusada8 r4, r8, r6, r4",
                "strh r4, [r3, #8 * {row}]",
                "adds r2, #4 * 6",
                "ldm r2, {{r2, r3, r4, r5}}",
                "add r7, r1, #4 * {columns}",
                "strd r6, r6, [r0]\nstrd r6, r6, [r0, #8]\nstrd r6, r7, [r0, #16]",
                "strd r6, r6, [r0, #128]\nstrd r6, r6, [r0, #136]\nstr r6, [r0, #144]",
                // Now r0 points to sector 4.
                "adds r0, #16",
                "2:",
                "ldr r6, [r1]",
                "ldr r7, [r1, #2]",
                // Absolute horizontal differences at four pixels. The top bit of each byte of r8 is the sign of x.
                "usub8 r12, r6, r7\nuhsub8 r8, r7, r6\nusub8 r7, r7, r6\nsel r7, r7, r12",
                "ldr r6, [r1, #1 - {columns}]",
                "ldr r12, [r1, #1 + {columns}]",
                "add r1, r1, #{columns}",
                "usub8 r9, r6, r12\nuhsub8 lr, r12, r6\nusub8 r6, r12, r6\nsel r6, r6, r9",
                "eor r8, r8, lr",
                "and r8, r8, #0x80808080",
                // The first and the third pixel. The second and the fourth follow below.
                "uxtb16 r9, r6\nuxtb16 r10, r7",
                "pkhbt r12, r9, r10, lsl #16\npkhtb r10, r10, r9, asr #16",
                add!("r12", 0),
                add!("r10", 2),
                "uxtb16 r9, r6, ror #8\nuxtb16 r10, r7, ror #8",
                "pkhbt r12, r9, r10, lsl #16\npkhtb r10, r10, r9, asr #16",
                add!("r12", 1),
                "ldr r12, [r0, #4]",
                add!("r10", 3),
                "cmp r1, r12",
                "bne 2b",
                // Computes channel sums 1 to 4 from the sectors, then 8 to 5 from the mirrored ones. r9 becomes sum 0.
                "ldrd r2, r3, [sp]",
                "add r1, r0, #128",
                "mov r8, #{row}",
                "mov r9, #0\nmov r10, #0",
                "3:",
                "ldrd r4, r5, [r0, #-16]\nldrd r11, lr, [r0, #-8]",
                "ldr r6, [r2, #4]\nsmlsd r9, r4, r6, r9",
                sum!("r4" 0, "r5" 2),
                sum!("r5" 6, "r11" 3),
                sum!("r11" 7, "lr" 4),
                "ldr r4, [r0]\nldr r5, [r1]",
                sum!("lr" 8, "r4" 5, "r5" 9),
                "add r3, r3, r8, lsl #1\nadd r3, r8",
                "mov r4, r0\nmov r0, r1\nmov r1, r4",
                "rsbs r8, r8, #0",
                "bmi 3b",
                "lsrs r6, r9, #6\nstrh r6, [r3, #-{row}]\nlsrs r6, r6, #2\nmla r10, r6, r6, r10",
                "add sp, #8\npop {{r6, r7}}",
                inout("r0") memory.as_mut_ptr() => _,
                inout("r1") pixels => _,
                inout("r2") TABLE.as_ptr() => _,
                inout("r3") to => _,
                out("r4") _, out("r5") _, out("r8") _, out("r9") _, lateout("r10") *energy, out("r11") _, out("r12") _,
                out("lr") _,
                columns = const COLUMNS,
                row = const 2 * ROW,
            );
        }
        (pixels, to) = (pixels.wrapping_add(CELL.into()), to.wrapping_add(1));
    }
}
