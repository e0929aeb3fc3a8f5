//! Two bounds that exclude offsets without computing their scores, by the DSP extension. The first is the sum of points
//! (255 - difference) at each of four neighbouring offsets. The second is the number of template pixels outside their
//! ranges, which differ by the threshold or more at all offsets of a 4x4 group.
//!
//! Both take seven instructions for four pixels. The score itself takes 17: two loads, three for the difference, four
//! to extract bytes, four table loads and four additions.
//!
//! | points of an offset | what |
//! |---|---|
//! | `ldr` | the pixels f; the pixels g of the template are loaded once for all four offsets |
//! | `uqsub8`, `uqsub8`, `orr` | d = the absolute difference of f and g |
//! | `usub8`, `sel` | 255 instead of d if d is not below the threshold |
//! | `usada8` | adds the distances to 255: the points |
//!
//! | pixels outside the ranges of a group | what |
//! |---|---|
//! | three `ldr` | g; the lower ends and the lengths of the ranges, which are widened by threshold - 1 on both sides |
//! | `usub8` | the distance above the lower end, modulo 256 |
//! | `usub8` | sets a flag where that is at most the length |
//! | `sel`, `usada8` | adds one for each pixel outside |

use super::super::points::{OFFSETS, Points};
use super::words::{LANES, WordRow, entry_offset, in_lanes, words};
use crate::kernels::rows::Rows;
use core::arch::asm;

/// Constants that a loop reads from memory. The assembly depends on their offsets.
#[repr(C)]
struct Memory {
    row: WordRow,
    words: usize,
    /// Different in each loop. In [`point_margins`]: the maximum points of a row, 255 for each pixel. In
    /// [`outside_ranges`]: the [`entry_offset`], which the assembly replaces by the address where the loop is entered.
    own: usize,
}

/// Adds the points of the four patch pixels at `$from` to `$sum`: 255 - difference, or 0 from the threshold on.
macro_rules! points {
    ($from:literal, $sum:literal $(, $without:literal)?) => {
        concat!(
            concat!("ldr {x}, ", $from, "\n"),
            "uqsub8 {y}, {x}, {w}\n",
            "uqsub8 {x}, {w}, {x}\n",
            "orr {x}, {x}, {y}\n",
            $(concat!("orr {x}, {x}, ", $without, "\n"),)?
            "usub8 {y}, {largest}, {x}\n",
            "sel {x}, {x}, {most}\n",
            concat!("usada8 ", $sum, ", {x}, {most}, ", $sum, "\n"),
        )
    };
}

/// Adds the points (255 - difference) of the next four columns at four neighbouring offsets.
macro_rules! points_of_word {
    () => {
        concat!(
            "ldr {w}, [{g}], #4\n",
            points!("[{f}], #4", "{a}"),
            points!("[{f}, #-3]", "{b}"),
            points!("[{f}, #-2]", "{c}"),
            points!("[{f}, #-1]", "{d}"),
        )
    };
}

/// Implements `Loops::POINT_MARGINS`.
///
/// # Safety
/// `pair.width` pixels, at least four, can be read in each of the `pair.height` rows (at least one) of the template,
/// and three more in each row of the patch.
#[inline(never)]
pub(super) unsafe fn point_margins(pair: &Rows, points: &Points, needed: u32, wanted: u8) -> [i32; OFFSETS] {
    // Here `skipped_bits` is a mask: 255 in those bytes of the last word that the whole words already cover.
    let mut row = WordRow::of(pair);
    row.skipped_bits = u32::MAX >> (8 * (pair.width % LANES));
    let memory = Memory { row, words: words(pair), own: Points::of_row(pair) as usize };
    let mut margins = Points::initial_margins(pair, needed, wanted);
    let [a, b, c, d] = &mut margins;
    // SAFETY: only words within a row are read, in the patch up to three columns further. Only the stack is written.
    unsafe {
        asm!(
            "push {{{x}}}",
            "2:",
            "ldr {end}, [{x}, #8]",
            "cmp {end}, #0",
            "beq 3f",
            "ldr {w}, [{g}, {end}]",
            "add {f}, {f}, {end}",
            "ldr {end}, [{x}, #12]",
            points!("[{f}]", "{a}", "{end}"),
            points!("[{f}, #1]", "{b}", "{end}"),
            points!("[{f}, #2]", "{c}", "{end}"),
            points!("[{f}, #3]", "{d}", "{end}"),
            "ldr {x}, [sp]",
            "ldr {end}, [{x}, #8]",
            "sub {f}, {f}, {end}",
            "3:",
            "ldr {end}, [{x}, #20]",
            "tst {end}, #4",
            "add {end}, {end}, {g}",
            "bne 7f", // an odd number of words: starts in the middle of a round
            "4:",
            points_of_word!(),
            "7:",
            points_of_word!(),
            "cmp {g}, {end}",
            "bne 4b",
            "ldr {x}, [sp]",
            "ldr {w}, [{x}, #16]",
            "ldr {y}, [{x}, #24]",
            "sub {a}, {a}, {y}",
            "sub {b}, {b}, {y}",
            "sub {c}, {c}, {y}",
            "sub {d}, {d}, {y}",
            "and {y}, {a}, {b}",
            "and {y}, {y}, {c}",
            "ands {y}, {y}, {d}",
            "bmi 5f", // no offset is left
            "ldrd {y}, {end}, [{x}]",
            "add {f}, {f}, {y}",
            "add {g}, {g}, {end}",
            "cmp {g}, {w}",
            "bne 2b",
            "5:",
            "add sp, sp, #4",
            x = inout(reg) &raw const memory => _,
            y = out(reg) _,
            f = inout(reg) pair.patch => _,
            g = inout(reg) pair.template => _,
            w = out(reg) _, end = out(reg) _,
            largest = in(reg) in_lanes(points.largest),
            most = in(reg) in_lanes(Points::MAX),
            a = inout(reg) *a,
            b = inout(reg) *b,
            c = inout(reg) *c,
            d = inout(reg) *d,
        );
    }
    margins
}

/// Bytes of code for one word in [`outside_ranges`].
const CODE_OF_A_WORD: usize = 28;

/// Counts the pixels in `{g}` outside the ranges with the lower ends `{l}` and the lengths `{s}`.
macro_rules! outside {
    () => {
        "usub8 {l}, {g}, {l}\nusub8 {l}, {s}, {l}\nsel {l}, {zero}, {one}\nusada8 {misses}, {l}, {zero}, {misses}\n"
    };
}

macro_rules! outside_word {
    () => {
        concat!("ldr.w {g}, [{template}], #4\n", "ldr.w {l}, [{low}], #4\n", "ldr.w {s}, [{span}], #4\n", outside!(),)
    };
}

/// Implements `Loops::OUTSIDE_RANGES`.
///
/// # Safety
/// `pair.width` bytes, at least four, can be read in each of the `pair.height` rows (at least one) at `pair.patch` and
/// at `pair.high`, both `pair.patch_stride` apart, and of the template.
#[inline(never)]
pub(super) unsafe fn outside_ranges(pair: &Rows, allowed: u32) -> u32 {
    let mut memory = Memory { row: WordRow::of(pair), words: words(pair), own: entry_offset(pair, CODE_OF_A_WORD) };
    // The count starts at -`allowed` - 1 and reaches 0 once more than `allowed` pixels are outside their ranges. It
    // fits in an `i32`, because a template has at most 65537 pixels.
    let start = !allowed.cast_signed();
    let mut sum = start;
    // SAFETY: only words within a row are read. Nothing but `memory` is written.
    unsafe {
        asm!(
            "adr.w {l}, 4f",
            "ldr {s}, [{row}, #24]",
            "add {l}, {l}, {s}",
            "orr {l}, {l}, #1", // Thumb
            "str {l}, [{row}, #24]",
            "2:",
            "ldrd {end}, {one}, [{row}, #8]",
            "cmp {end}, #0",
            "beq 3f",
            "ldr {g}, [{template}, {end}]",
            "ldr {l}, [{low}, {end}]",
            "ldr {s}, [{span}, {end}]",
            "lsr {g}, {g}, {one}", // zeroes shifted in everywhere: within the range
            "lsr {l}, {l}, {one}",
            "lsr {s}, {s}, {one}",
            "mov {one}, #0x01010101",
            outside!(),
            "3:",
            "mov {one}, #0x01010101",
            "ldr {end}, [{row}, #20]",
            "add {end}, {end}, {template}",
            "ldr.w pc, [{row}, #24]",
            ".p2align 2", // adr can point to 4 only if it is aligned
            "4:",
            outside_word!(),
            outside_word!(),
            outside_word!(),
            outside_word!(),
            "cmp {template}, {end}",
            "bne 4b",
            "cmp {misses}, #0",
            "bpl 5f",
            "ldrd {l}, {s}, [{row}]",
            "add {low}, {low}, {l}",
            "add {span}, {span}, {l}",
            "add {template}, {template}, {s}",
            "ldr {s}, [{row}, #16]",
            "cmp {template}, {s}",
            "bne 2b",
            "5:",
            low = inout(reg) pair.patch => _,
            span = inout(reg) pair.high => _,
            template = inout(reg) pair.template => _,
            l = out(reg) _, s = out(reg) _, g = out(reg) _, end = out(reg) _, one = out(reg) _,
            zero = in(reg) 0,
            misses = inout(reg) sum,
            row = in(reg) &raw mut memory,
            options(nostack),
        );
    }
    sum.wrapping_sub(start).cast_unsigned()
}
