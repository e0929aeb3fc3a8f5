//! Gradients of a cell by the DSP extension, which Helium's processors have, too: `smusd` says in one instruction how far a gradient is
//! beyond a direction. The plain loop is in `robust/features.rs`.

use core::arch::asm;
use core::mem::MaybeUninit;

/// Cosine, and 16 bits higher sine, as `smusd` has them.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // both are numbers of 16 bits
pub(crate) const fn pair((cos, sin): (i32, i32)) -> u32 {
    cos as u16 as u32 | (sin as u16 as u32) << 16
}

/// What the pixels of the cell at the column `at` add to each sector between two of the directions: to its first direction, and 16
/// bits higher to its second one. Those of the mirrored sectors are the numbers from 8 on. `None` if the cell is not on the lines.
#[inline(always)]
pub(crate) fn sectors<const COLUMNS: usize>(
    lines: &[[u8; COLUMNS]; 6],
    at: usize,
    directions: &[u32; 6],
) -> Option<[u32; 14]> {
    if at + 6 > COLUMNS {
        return None;
    }
    let mut sectors = MaybeUninit::<[u32; 14]>::uninit();
    // SAFETY: of six lines, COLUMNS bytes apart, six pixels are read, which are there. All of `sectors` is written. r6 and r7, which may
    // not be named, are kept on the stack.
    unsafe {
        asm!(
            "push {{r6, r7}}",
            "movs r6, #0",
            "strd r6, r6, [r0]",
            "strd r6, r6, [r0, #8]",
            "strd r6, r6, [r0, #16]",
            "strd r6, r6, [r0, #24]",
            "strd r6, r6, [r0, #32]",
            "strd r6, r6, [r0, #40]",
            "strd r6, r6, [r0, #48]",
            "ldm.w r2, {{r2, r3, r4, r5, r8, r9}}",
            "mov lr, #4",
            "1:",
            "add r10, r1, #4",
            "2:",
            "ldrb r12, [r1, #1]!",
            "ldrb r6, [r1, #{left}]",
            "ldrb r7, [r1, #{right}]",
            "ldrb r11, [r1, #{below}]",
            "sub r7, r7, r6",
            "subs r11, r11, r12",
            "mul r12, r7, r11",
            "it mi",
            "rsbmi r11, r11, #0",
            "cmp r7, #0",
            "it mi",
            "rsbmi r7, r7, #0",
            "pkhbt r7, r11, r7, lsl #16",
            // Where x * y is less than 0, the gradient is mirrored.
            "lsrs r12, r12, #31",
            "add r12, r0, r12, lsl #5",
            // r11 is how far it is beyond the sector's second direction, r6 beyond its first one.
            "smusd r6, r7, r4",
            "cmp r6, #0",
            "blt 4f",
            "smusd r11, r7, r5",
            "cmp r11, #0",
            "bge 3f",
            "adds r12, #8",
            "b 6f",
            "3:",
            "mov r6, r11",
            "smusd r11, r7, r8",
            "cmp r11, #0",
            "itt lt",
            "addlt r12, #12",
            "blt 6f",
            "mov r6, r11",
            "smusd r11, r7, r9",
            "adds r12, #16",
            "b 6f",
            "4:",
            "mov r11, r6",
            "smusd r6, r7, r3",
            "cmp r6, #0",
            "itt ge",
            "addge r12, #4",
            "bge 6f",
            "mov r11, r6",
            "smusd r6, r7, r2",
            "6:",
            "ldr r7, [r12]",
            "rsbs r11, r11, #0",
            "lsrs r6, r6, #6",
            "add r7, r7, r11, lsr #6",
            "add r7, r7, r6, lsl #16",
            "str r7, [r12]",
            "cmp r1, r10",
            "bne 2b",
            "add r1, r1, #{next}",
            "subs lr, lr, #1",
            "bne 1b",
            "pop {{r6, r7}}",
            in("r0") sectors.as_mut_ptr(),
            inout("r1") lines.as_ptr().cast::<u8>().wrapping_add(at) => _,
            inout("r2") directions.as_ptr() => _,
            out("r3") _,
            out("r4") _,
            out("r5") _,
            out("r8") _,
            out("r9") _,
            out("r10") _,
            out("r11") _,
            out("r12") _,
            out("lr") _,
            left = const COLUMNS - 1,
            right = const COLUMNS + 1,
            below = const 2 * COLUMNS,
            next = const COLUMNS - 4,
        );
        Some(sectors.assume_init())
    }
}
