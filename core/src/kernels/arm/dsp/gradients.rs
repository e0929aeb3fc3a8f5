//! Gradients of a cell by the DSP extension: differences of four pixels at a time, and `smusd` says in one instruction how far a gradient
//! is beyond a direction. The plain loop is in `plain/gradients.rs`.

use crate::kernels::cells::SIDE;
use crate::kernels::plain::gradients::{self as plain, DIRECTIONS, Sums, Votes};
use core::arch::asm;
use core::mem::MaybeUninit;

/// Cosine, and 16 bits higher sine, as `smusd` has them.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // both are numbers of 16 bits
const fn pair(cos: i32, sin: i32) -> u32 {
    cos as u16 as u32 | (sin as u16 as u32) << 16
}

/// Directions as the loop has them.
#[repr(C)]
struct Directions {
    /// Of the sectors 0 to 4: the first direction, and the opposite of the second one.
    sectors: [[u32; 2]; 5],
    /// The second to the fifth direction, of which the number that a gradient is beyond is its sector.
    between: [u32; 4],
}

impl Directions {
    const fn new([a, b, c, d, e, f]: [(i32, i32); 6]) -> Self {
        const fn sector(first: (i32, i32), second: (i32, i32)) -> [u32; 2] {
            [pair(first.0, first.1), pair(-second.0, -second.1)]
        }
        let sectors = [sector(a, b), sector(b, c), sector(c, d), sector(d, e), sector(e, f)];
        Self { sectors, between: [pair(b.0, b.1), pair(c.0, c.1), pair(d.0, d.1), pair(e.0, e.1)] }
    }
}

/// What the loop works on. The assembler knows where its fields are.
#[repr(C)]
struct Desk {
    /// Of the sectors 0 to 4 what the first direction gets, and 16 bits higher what the second one does.
    sectors: [u32; 5],
    /// Where the pixels end.
    end: u32,
    directions: [[u32; 2]; 5],
    unused: [u32; 16],
    /// Of those that mirror the sectors: 128 bytes on, the highest bit of a byte.
    mirrored: [u32; 5],
}

/// A pixel, of which the register holds up, and 16 bits higher right, and byte `byte` of r8 in its highest bit whether it is mirrored. r11
/// is the number of its sector less 4.
macro_rules! vote {
    ($pixel:literal, $byte:literal) => {
        concat!(
            "smusd r11, ",
            $pixel,
            ", r2\n",
            "smusd r9, ",
            $pixel,
            ", r3\n",
            "smusd lr, ",
            $pixel,
            ", r4\n",
            "asr r11, r11, #31\n",
            "add r11, r11, r9, asr #31\n",
            "smusd r9, ",
            $pixel,
            ", r5\n",
            "add r11, r11, lr, asr #31\n",
            "add r11, r11, r9, asr #31\n",
            "add lr, r0, r11, lsl #3\n",
            "ldrd r9, lr, [lr, #40]\n",
            "smusd r9, ",
            $pixel,
            ", r9\n",
            "smusd lr, ",
            $pixel,
            ", lr\n",
            "lsr lr, lr, #6\n",
            "pkhbt lr, lr, r9, lsl #10\n",
            "uxtab r9, r0, r8, ror #8 * ",
            $byte,
            "\n",
            "ldr ",
            $pixel,
            ", [r9, r11, lsl #2]\n",
            "add ",
            $pixel,
            ", ",
            $pixel,
            ", lr\n",
            "str ",
            $pixel,
            ", [r9, r11, lsl #2]\n",
        )
    };
}

/// The sums of a cell, of its pixels and their neighbours.
#[inline(always)] // into its one caller
pub(crate) fn cell<const COLUMNS: usize>(lines: &[[u8; COLUMNS]; SIDE], at: usize) -> Sums {
    static SECTORS: Directions = Directions::new(DIRECTIONS);
    let sums = Votes(sectors(lines, at, &SECTORS)).sums(plain::gray(lines, at));
    #[cfg(feature = "verify")]
    assert_eq!(sums.0, plain::cell(lines, at).0, "sums of a cell, given and expected");
    sums
}

/// What the pixels of the cell at the column `at` add to each sector between two of the directions: to its first direction, and 16
/// bits higher to its second one. Then those of the mirrored sectors; a gradient along an axis, which is split alike either way, may be
/// there. Zeroes if the cell is not on the lines.
#[inline(always)]
fn sectors<const COLUMNS: usize>(lines: &[[u8; COLUMNS]; 6], at: usize, directions: &Directions) -> [[u32; 5]; 2] {
    const { assert!(COLUMNS > 8 && COLUMNS < 256) };
    if at + 6 > COLUMNS {
        return [[0; 5]; 2];
    }
    let mut desk = MaybeUninit::<Desk>::uninit();
    // SAFETY: of six lines, COLUMNS bytes apart, six pixels are read, which are there: words of four, which need not be aligned, from
    // the first and the third column of the inner lines and from the second one of those above and below. Of the desk all is written
    // but what is unused. r6 and r7, which may not be named, are kept on the stack.
    unsafe {
        asm!(
            "push {{r6, r7}}",
            "add r12, r0, #24",
            "ldm r2!, {{r3, r4, r5, r6, r7, r8, r9, r10, r11, lr}}",
            "stm r12, {{r3, r4, r5, r6, r7, r8, r9, r10, r11, lr}}",
            "ldm r2, {{r2, r3, r4, r5}}",
            "movs r6, #0",
            "strd r6, r6, [r0]",
            "strd r6, r6, [r0, #8]",
            "add r7, r1, #4 * {columns}",
            "strd r6, r7, [r0, #16]",
            "strd r6, r6, [r0, #128]",
            "strd r6, r6, [r0, #136]",
            "str r6, [r0, #144]",
            // Where the sector 4 is.
            "adds r0, #16",
            "2:",
            "ldr r6, [r1]",
            "ldr r7, [r1, #2]",
            "usub8 r12, r6, r7",
            "uhsub8 r8, r7, r6", // the highest bit is the sign
            "usub8 r7, r7, r6",
            "sel r7, r7, r12",
            "ldr r6, [r1, #1 - {columns}]",
            "ldr r12, [r1, #1 + {columns}]",
            "usub8 r9, r6, r12",
            "uhsub8 lr, r12, r6",
            "usub8 r6, r12, r6",
            "sel r6, r6, r9",
            "eor r8, r8, lr",
            "and r8, r8, #0x80808080",
            "add r1, r1, #{columns}",
            // The first and the third pixel.
            "uxtb16 r9, r6",
            "uxtb16 r10, r7",
            "pkhbt r12, r9, r10, lsl #16",
            "pkhtb r10, r10, r9, asr #16",
            vote!("r12", 0),
            vote!("r10", 2),
            "uxtb16 r9, r6, ror #8",
            "uxtb16 r10, r7, ror #8",
            "pkhbt r12, r9, r10, lsl #16",
            "pkhtb r10, r10, r9, asr #16",
            vote!("r12", 1),
            vote!("r10", 3),
            "ldr r12, [r0, #4]",
            "cmp r1, r12",
            "bne 2b",
            "pop {{r6, r7}}",
            inout("r0") desk.as_mut_ptr() => _,
            inout("r1") lines.as_ptr().cast::<u8>().wrapping_add(COLUMNS + at) => _,
            inout("r2") directions => _,
            out("r3") _,
            out("r4") _,
            out("r5") _,
            out("r8") _,
            out("r9") _,
            out("r10") _,
            out("r11") _,
            out("r12") _,
            out("lr") _,
            columns = const COLUMNS,
        );
        let desk = desk.as_ptr();
        [(&raw const (*desk).sectors).read(), (&raw const (*desk).mirrored).read()]
    }
}
