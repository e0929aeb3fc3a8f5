//! Bounds a group of offsets by the DSP extension: counts the pixels of the template that cannot count at any offset of
//! the group.
//!
//! A pixel counts only if it lies within the range of its block, widened by threshold - 1 on both sides. The ranges are
//! stored as that test needs them: the lower end, and the length. Four pixels take seven instructions: three `ldr`,
//! `usub8` (the distance above the lower end, modulo 256), `usub8` (sets a flag where that is at most the length),
//! `sel` and `usada8`, which adds one for each pixel outside.

use super::words::{Row, entry, words};
use crate::kernels::rows::Rows;
use core::arch::asm;

/// The numbers that the loop reads from memory. The assembly knows their offsets.
#[repr(C)]
struct Memory {
    row: Row,
    /// Bytes in the whole words of a row.
    words: usize,
    /// See [`entry`].
    entry: usize,
}

/// Bytes of code for a word.
const WORD: usize = 28;

/// Adds the pixels in `{g}` that are outside the range in `{l}` and `{s}`.
macro_rules! add {
    () => {
        "usub8 {l}, {g}, {l}\nusub8 {l}, {s}, {l}\nsel {l}, {zero}, {one}\nusada8 {misses}, {l}, {zero}, {misses}\n"
    };
}

macro_rules! add_word {
    () => {
        concat!("ldr.w {g}, [{template}], #4\n", "ldr.w {l}, [{low}], #4\n", "ldr.w {s}, [{span}], #4\n", add!(),)
    };
}

/// See [`Loops::MISSES`](super::super::scores::Loops::MISSES).
///
/// # Safety
/// The pictures have at least four columns. Patch and upper bound have the same stride.
#[inline(never)]
pub(super) unsafe fn misses(pair: &Rows, allowed: u32) -> u32 {
    let mut memory = Memory { row: Row::of(pair), words: words(pair), entry: entry(pair, WORD) };
    // Negative until more than `allowed` pixels are outside. There are at most 65537 pixels.
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
            add!(),
            "3:",
            "mov {one}, #0x01010101",
            "ldr {end}, [{row}, #20]",
            "add {end}, {end}, {template}",
            "ldr.w pc, [{row}, #24]",
            ".p2align 2", // adr can point to 4 only if it is aligned
            "4:",
            add_word!(),
            add_word!(),
            add_word!(),
            add_word!(),
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
