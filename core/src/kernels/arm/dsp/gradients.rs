//! Gradients of a cell by the DSP extension. It subtracts four pixels at a time. `smusd` computes in one instruction
//! how far a gradient is beyond a direction. The plain loop is in `plain/gradients.rs`.

use crate::kernels::layout::{CHANNELS, SIDE};
use crate::kernels::plain::gradients::{self as plain, DIRECTIONS, Sectors, Sums};
use core::arch::asm;
use core::mem::MaybeUninit;

/// Cosine in the low 16 bits and sine in the high 16 bits, as `smusd` takes them.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // both fit in 16 bits
const fn pair(cos: i32, sin: i32) -> u32 {
    cos as u16 as u32 | (sin as u16 as u32) << 16
}

/// The second to the fifth direction. A gradient that is beyond n of them lies in sector n.
static BETWEEN: [u32; 4] = {
    let [_, (a, b), (c, d), (e, f), (g, h), _] = DIRECTIONS;
    [pair(a, b), pair(c, d), pair(e, f), pair(g, h)]
};

/// Memory of the assembly, which knows the offsets of the fields.
#[repr(C)]
struct Memory {
    sectors: [u32; 5],
    /// The address where the pixels end.
    end: u32,
    unused: [u32; 26],
    /// The mirrored sectors. They are 128 bytes further on: 128 is the top bit of a byte.
    mirrored: [u32; 5],
}

/// Computes a feature: the sum times the inverse, divided by 2^16, and at most 127.
macro_rules! feature {
    () => {
        concat!(
            "ldrh {feature}, [{sum}], #{row}\n",
            "smulwb {feature}, {inverse}, {feature}\n",
            "usat {feature}, #7, {feature}\n",
            "strb {feature}, [{out}], #1\n",
        )
    };
}

/// Adds the gradient of a pixel. The register `pixel` holds |y| in the low and |x| in the high 16 bits. The top bit of
/// byte `byte` of r8 says whether the gradient is mirrored. r11 becomes the sector minus 4.
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

/// Computes the features of a row of cells, as [`plain::features`] specifies them. Does nothing if there are fewer sums or
/// inverses than cells.
#[inline(always)]
pub(crate) fn features<const ROW: usize>(sums: &[[u16; ROW]], inverses: &[u32; ROW], out: &mut [[i8; CHANNELS]]) {
    const { assert!(2 * ROW < 256) };
    if sums.len() < CHANNELS || out.is_empty() || out.len() > ROW {
        return;
    }
    // SAFETY: ten sums and an inverse are read for each cell in `out`, and ten features written. No product of 16 and
    // 32 bits overflows.
    unsafe {
        asm!(
            "2:",
            "ldr {inverse}, [{inverses}], #4",
            "mov {sum}, {sums}",
            "adds {sums}, {sums}, #2",
            "movs {left}, #3",
            "3:",
            feature!(),
            feature!(),
            feature!(),
            "subs {left}, {left}, #1",
            "bne 3b",
            "ldrh {feature}, [{sum}]",
            "lsrs {feature}, {feature}, #4",
            "eor {feature}, {feature}, #128",
            "strb {feature}, [{out}], #1",
            "subs {count}, {count}, #1",
            "bne 2b",
            sums = inout(reg) sums.as_ptr() => _,
            inverses = inout(reg) inverses.as_ptr() => _,
            out = inout(reg) out.as_mut_ptr() => _,
            count = inout(reg) out.len() => _,
            inverse = out(reg) _, sum = out(reg) _, feature = out(reg) _, left = out(reg) _,
            row = const 2 * ROW,
            options(nostack),
        );
    }
}

/// See [`plain::gradients`].
#[inline(never)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    plain::by_cells(lines, sums, energies, across, cell);
}

/// The sums of a cell. They depend on its pixels and their neighbours.
#[inline(always)]
fn cell<const COLUMNS: usize>(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Sums {
    sectors(lines, at).sums(plain::gray(lines, at), |sum, (cos, sin)| {
        let distance;
        // SAFETY: it reads two registers and writes one.
        unsafe {
            asm!("smusd {}, {}, {}", out(reg) distance, in(reg) sum, in(reg) pair(cos, sin), options(pure, nomem, nostack, preserves_flags));
        }
        distance
    })
}

/// The gradients of the cell that begins at the column `at`, by sector and by mirrored sector. A gradient along an axis
/// may count in a sector or in its mirror image: both give the same votes. All are 0 if the cell reaches beyond the lines.
#[inline(always)]
fn sectors<const COLUMNS: usize>(lines: &[[u8; COLUMNS]; 6], at: usize) -> Sectors {
    const { assert!(COLUMNS > 8 && COLUMNS < 256) };
    if at + 6 > COLUMNS {
        return Sectors([[0; 5]; 2]);
    }
    let mut memory = MaybeUninit::<Memory>::uninit();
    // SAFETY: six pixels of each of six lines are read, and `at + 6 <= COLUMNS`. Words need not be aligned. All fields
    // of `memory` are written except `unused`. r6 and r7, which `asm!` may not name, are saved on the stack.
    unsafe {
        asm!(
            "push {{r6, r7}}",
            "ldm r2, {{r2, r3, r4, r5}}",
            "movs r6, #0",
            "strd r6, r6, [r0]",
            "strd r6, r6, [r0, #8]",
            "add r7, r1, #4 * {columns}",
            "strd r6, r7, [r0, #16]",
            "strd r6, r6, [r0, #128]",
            "strd r6, r6, [r0, #136]",
            "str r6, [r0, #144]",
            // Now r0 points to sector 4.
            "adds r0, #16",
            "2:",
            "ldr r6, [r1]",
            "ldr r7, [r1, #2]",
            "usub8 r12, r6, r7",
            "uhsub8 r8, r7, r6", // the top bit is the sign
            "usub8 r7, r7, r6",
            "sel r7, r7, r12",
            "ldr r6, [r1, #1 - {columns}]",
            "ldr r12, [r1, #1 + {columns}]",
            "add r1, r1, #{columns}",
            "usub8 r9, r6, r12",
            "uhsub8 lr, r12, r6",
            "usub8 r6, r12, r6",
            "sel r6, r6, r9",
            "eor r8, r8, lr",
            "and r8, r8, #0x80808080",
            // The first and the third pixel. The second and the fourth follow below.
            "uxtb16 r9, r6",
            "uxtb16 r10, r7",
            "pkhbt r12, r9, r10, lsl #16",
            "pkhtb r10, r10, r9, asr #16",
            add!("r12", 0),
            add!("r10", 2),
            "uxtb16 r9, r6, ror #8",
            "uxtb16 r10, r7, ror #8",
            "pkhbt r12, r9, r10, lsl #16",
            "pkhtb r10, r10, r9, asr #16",
            add!("r12", 1),
            "ldr r12, [r0, #4]",
            add!("r10", 3),
            "cmp r1, r12",
            "bne 2b",
            "pop {{r6, r7}}",
            inout("r0") memory.as_mut_ptr() => _,
            inout("r1") lines.as_ptr().cast::<u8>().wrapping_add(COLUMNS + at) => _,
            inout("r2") &raw const BETWEEN => _,
            out("r3") _, out("r4") _, out("r5") _, out("r8") _, out("r9") _, out("r10") _, out("r11") _, out("r12") _,
            out("lr") _,
            columns = const COLUMNS,
        );
        let memory = memory.as_ptr();
        Sectors([(&raw const (*memory).sectors).read(), (&raw const (*memory).mirrored).read()])
    }
}
