//! Excludes offsets that cannot reach a score, by the DSP extension: counts the points of four neighbouring offsets at
//! a time.
//!
//! Four pixels of an offset take seven instructions:
//!
//! | instructions | what |
//! |---|---|
//! | `ldr` | the pixels f; the pixels g of the template are loaded once for all four offsets |
//! | `uqsub8`, `uqsub8`, `orr` | d = the absolute difference of f and g |
//! | `usub8`, `sel` | 255 instead of d if the pixel does not count |
//! | `usada8` | adds the distances to 255: the points |
//!
//! The score itself takes 17: two loads, three for the difference, four bytes taken out of it, four loads from the
//! table and four additions.

use super::super::points::{OFFSETS, Points};
use super::words::{LANES, Row, in_lanes, words};
use crate::kernels::rows::Rows;
use core::arch::asm;

/// The numbers that the loop reads from memory. The assembly knows their offsets.
#[repr(C)]
struct Memory {
    row: Row,
    /// Bytes in the whole words of a row.
    words: usize,
    /// The points of a row of equal pixels.
    full: u32,
}

/// Adds the points of the four columns at `from` to `sum`.
macro_rules! add {
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

/// See [`Loops::SPARE`](super::super::scores::Loops::SPARE).
///
/// # Safety
/// The template has at least four columns, the patch as many and three more.
#[inline(never)]
pub(super) unsafe fn spare(pair: &Rows, points: &Points, needed: u32, wanted: u8) -> [i32; OFFSETS] {
    // Instead of a number of bits: 255 in each byte of the last word that belongs to an earlier column, so that the
    // column does not get points again.
    let mut row = Row::of(pair);
    row.none = u32::MAX >> (8 * (pair.width % LANES));
    let memory = Memory { row, words: words(pair), full: Points::of_row(pair) };
    let mut spare = Points::spare(pair, needed, wanted);
    let [a, b, c, d] = &mut spare;
    // SAFETY: only words within a row are read, in the patch up to three columns further. The stack pointer is restored
    // at the end; only the stack is written.
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
            add!("[{f}]", "{a}", "{end}"),
            add!("[{f}, #1]", "{b}", "{end}"),
            add!("[{f}, #2]", "{c}", "{end}"),
            add!("[{f}, #3]", "{d}", "{end}"),
            "ldr {x}, [sp]",
            "ldr {end}, [{x}, #8]",
            "sub {f}, {f}, {end}",
            "3:",
            "ldr {end}, [{x}, #20]",
            "tst {end}, #4",
            "add {end}, {end}, {g}",
            "bne 7f", // an odd number of words: starts in the middle of a round
            "4:",
            "ldr {w}, [{g}], #4",
            add!("[{f}], #4", "{a}"),
            add!("[{f}, #-3]", "{b}"),
            add!("[{f}, #-2]", "{c}"),
            add!("[{f}, #-1]", "{d}"),
            "7:",
            "ldr {w}, [{g}], #4",
            add!("[{f}], #4", "{a}"),
            add!("[{f}, #-3]", "{b}"),
            add!("[{f}, #-2]", "{c}"),
            add!("[{f}, #-1]", "{d}"),
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
            most = in(reg) in_lanes(Points::MOST),
            a = inout(reg) *a,
            b = inout(reg) *b,
            c = inout(reg) *c,
            d = inout(reg) *d,
        );
    }
    spare
}
