//! Gradients of a cell for Armv6-M, which has too few registers for the compiled loop in `plain/gradients.rs`.

use crate::kernels::layout::SIDE;
use crate::kernels::plain::gradients::{self as plain, DIRECTIONS, Sectors};
use core::arch::asm;

pub(crate) use plain::features;

// The assembly below contains these factors (cosines and sines of the directions) as literals.
const _: () = {
    let [_, one, two, three, four, _] = DIRECTIONS;
    assert!(one.1 == 256 && three.0 == 2 * 187 && three.1 == 8 * 81 && four.0 == 130 && two.0 > two.1);
};

#[inline(never)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    plain::by_cells(lines, sums, energies, across, |lines, at| sectors(lines, at).sums(plain::gray(lines, at)));
}

/// Adds the gradient of a pixel to its sector. r0 points to the left neighbour of pixel 0 of the row, r1 and r2 one
/// line above and below, r12 to sector 0.
macro_rules! add {
    ($at:literal) => {
        concat!(
            concat!("ldrb r3, [r0, #2 + ", $at, "]\n"),
            concat!("ldrb r6, [r0, #", $at, "]\n"),
            "subs r3, r3, r6\n",
            concat!("ldrb r4, [r2, #1 + ", $at, "]\n"),
            concat!("ldrb r6, [r1, #1 + ", $at, "]\n"),
            "subs r4, r4, r6\n",
            // r3 becomes |x|, r4 |y|, r5 a byte offset: -4 (mirrored sectors) if x and y differ in sign, else 0.
            "asrs r5, r3, #31\n",
            "asrs r6, r4, #31\n",
            "eors r3, r5\n",
            "subs r3, r3, r5\n",
            "eors r4, r6\n",
            "subs r4, r4, r6\n",
            "eors r5, r6\n",
            "lsls r5, r5, #2\n",
            "add r5, r12\n",
            beyond!("mov r6, r8", "mov r7, r9\nmuls r7, r3, r7"),
            "bge 4f\n",
            beyond!("mov r6, r10", "lsls r7, r3, #8"),
            "blt 5f\n",
            "adds r5, #8\n",
            "b 5f\n",
            "4:\n",
            "adds r5, #16\n",
            beyond!("movs r6, #187", "movs r7, #81\nmuls r7, r3, r7\nlsls r7, r7, #2"),
            "blt 5f\n",
            "adds r5, #8\n",
            beyond!("movs r6, #130", "mov r7, lr\nmuls r7, r3, r7"),
            "blt 5f\n",
            "adds r5, #8\n",
            "5:\n",
            "lsls r3, r3, #16\n",
            "orrs r3, r4\n",
            "ldr r4, [r5]\n",
            "adds r3, r3, r4\n",
            "str r3, [r5]\n",
        )
    };
}

/// Compares cos * |y| with sin * |x|: is the gradient beyond a direction?
macro_rules! beyond {
    ($cos:literal, $right:literal) => {
        concat!($cos, "\nmuls r6, r4, r6\n", $right, "\ncmp r6, r7\n")
    };
}

/// Sums the gradients of the cell at column `at` in sectors; all are 0 if the cell reaches beyond the lines. A gradient
/// along an axis may be added to a sector or to its mirror image: both give the same votes.
#[inline(always)]
fn sectors<const COLUMNS: usize>(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Sectors {
    const { assert!(COLUMNS < 256) };
    let [_, one, two, _, four, _] = DIRECTIONS;
    // For each sector, the sums of its mirror image (index 0) and of the sector itself (index 1).
    let mut sectors = [[0; 2]; 5];
    if at + SIDE <= COLUMNS {
        let above = lines.as_ptr().cast::<u8>().wrapping_add(at);
        // SAFETY: six pixels of each of six lines are read, and `at + 6 <= COLUMNS`. Of `sectors` five pairs are
        // written. r6 and r7, which `asm!` may not name, are saved on the stack.
        unsafe {
            asm!(
                "push {{r3, r6, r7}}",
                "mov r12, r5",
                "ldm r4, {{r4, r5, r6, r7}}",
                "mov r8, r4",
                "mov r9, r5",
                "mov r10, r6",
                "mov lr, r7",
                "3:",
                add!(0),
                add!(1),
                add!(2),
                add!(3),
                "movs r1, r0",
                "movs r0, r2",
                "adds r2, #{columns}",
                "ldr r3, [sp]",
                "cmp r2, r3",
                "beq 6f",
                "b 3b",
                "6:",
                "pop {{r3, r6, r7}}",
                inout("r0") above.wrapping_add(COLUMNS) => _,
                inout("r1") above => _,
                inout("r2") above.wrapping_add(2 * COLUMNS) => _,
                inout("r3") above.wrapping_add(6 * COLUMNS) => _,
                inout("r4") &[two.0, two.1, one.0, four.1] => _,
                inout("r5") (&raw mut sectors).cast::<u32>().wrapping_add(1) => _,
                out("r8") _, out("r9") _, out("r10") _, out("r12") _, out("lr") _,
                columns = const COLUMNS,
            );
        }
    }
    let [a, b, c, d, e] = sectors;
    Sectors([[a[1], b[1], c[1], d[1], e[1]], [a[0], b[0], c[0], d[0], e[0]]])
}
