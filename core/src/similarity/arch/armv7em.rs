//! The kernels by the DSP extension of Armv7E-M (Cortex-M4, M7) and Armv8-M (M33, M35P): four pixels in a register.
//!
//! - `usada8` adds the four absolute differences of two registers to a third.
//! - `uhadd8` halves four sums, rounding down: `means` is three rounds of it.
//! - `uqsub8` subtracts and stops at zero: what is left of a threshold after a difference.
//!
//! `asm!`, as the intrinsics need an unstable compiler; whole loops of it, as these have to do without what a compiler
//! spills for want of registers. Rows begin at any address: these processors load words from there, unless firmware has
//! set `UNALIGN_TRP`, which compilers for them do not allow for either.

use super::super::{Table, scalar};
use super::Kernels;
use super::filter::{Filter, Limit};
use super::rows::Pair;
use crate::image::Image;
use core::arch::asm;

/// Pixels in a register.
const LANES: usize = 4;

/// The columns that `distance` goes down at a time: the words for which its loop is unrolled.
const STRIP: usize = 32 * LANES;

/// The columns that the filter goes down at a time, and the bytes of its code for a word.
const FILTER_STRIP: usize = 16 * LANES;
const FILTER_WORD: usize = 32;

/// Distances of that many pixels are below 2^30.
const MAX_PIXELS: usize = 1 << 22;

pub(super) struct Dsp(Filter);

impl Dsp {
    pub(super) fn new(table: &'static Table, threshold: u16) -> Self {
        Self(Filter::new(table, threshold))
    }
}

impl Kernels for Dsp {
    #[inline(never)]
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        self.0.score_at_least::<LANES>(patch, template, floor, exceeds)
    }

    #[inline(never)]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let pair = Pair::new(patch, template);
        if pair.width < LANES || pair.width * pair.height > MAX_PIXELS {
            return few_or_many(patch, template, enough);
        }
        // Below zero as long as it is not more than enough; and all differences can be added without overflow.
        let start = !enough.min(1 << 30).cast_signed();
        let mut sum = start;
        let mut column = 0;
        while column < pair.width && sum < 0 {
            let width = STRIP.min(pair.width - column);
            // SAFETY: the strip is a part of the pair, which has at least four columns.
            unsafe { sum = strip(&pair, column, width, sum) };
            column += STRIP;
        }
        sum.wrapping_sub(start).cast_unsigned()
    }

    #[inline(never)]
    fn means(&self, rows: &[&[u8]; 8], means: &mut [u8]) {
        let columns = rows.iter().fold(means.len(), |columns, row| columns.min(row.len()));
        if columns < LANES {
            return scalar::means(rows, means);
        }
        let addresses = rows.each_ref().map(|row| row.as_ptr());
        // SAFETY: all eight rows, and what is written, have that many columns: at least four.
        unsafe { means_at(&addresses, means.as_mut_ptr(), columns) }
    }
}

/// Apart, so that what it needs does not burden the usual case.
#[cold]
#[inline(never)]
fn few_or_many(patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
    scalar::distance(patch, template, enough)
}

/// Adds the differences in `width` (1..=`STRIP`) columns from `column` on to `sum`, until that is not negative any more.
///
/// # Safety
/// The pair has these columns, and at least four.
#[inline(always)]
unsafe fn strip(pair: &Pair, column: usize, width: usize, mut sum: i32) -> i32 {
    let left = width % LANES;
    // The last columns are the upper part of the last word, which begins in the columns before. 0 if there are none.
    let last = if left == 0 { 0 } else { width.wrapping_sub(LANES) };
    // SAFETY: of each row, whole words and the last word of `width` are read; nothing is written.
    unsafe {
        asm!(
            "adr.w {words}, 4f",
            "sub {words}, {words}, r2, lsl #3", // eight bytes of code for each word
            "2:",
            "cbz r5, 3f",
            "ldr.n r2, [r0, r5]",
            "ldr.n r3, [r1, r5]",
            "lsr r2, r2, {none}",
            "lsr r3, r3, {none}",
            "usada8 {sum}, r2, r3, {sum}",
            "3:",
            "mov pc, {words}",
            ".p2align 2", // so that 4 is where adr can point to
            ".irp offset,124,120,116,112,108,104,100,96,92,88,84,80,76,72,68,64,60,56,52,48,44,40,36,32,28,24,20,16,12,8,4,0",
            "ldr.n r2, [r0, #\\offset]",
            "ldr.n r3, [r1, #\\offset]",
            "usada8 {sum}, r2, r3, {sum}",
            ".endr",
            "4:",
            "add r0, r0, {f_stride}",
            "add r1, r1, {g_stride}",
            "adds {rows}, {rows}, #1",
            "tst {rows}, {sum}", // negative if both are
            "bmi.w 2b",
            words = out(reg) _,
            inout("r0") pair.patch.first.wrapping_add(column) => _,
            inout("r1") pair.template.first.wrapping_add(column) => _,
            inout("r2") width / LANES => _,
            out("r3") _,
            in("r5") last,
            none = in(reg) 8 * (LANES - left),
            f_stride = in(reg) pair.patch.stride,
            g_stride = in(reg) pair.template.stride,
            rows = inout(reg) pair.height.wrapping_neg() => _,
            sum = inout(reg) sum,
            options(readonly, nostack),
        );
    }
    sum
}

/// # Safety
/// At all `rows` and at `means` there are `columns` bytes, at least four.
#[inline(always)]
unsafe fn means_at(rows: &[*const u8; 8], means: *mut u8, columns: usize) {
    // SAFETY: four columns at a time, from the last ones down; the first four may be some of those before again.
    unsafe {
        asm!(
            "2:",
            "ldrd {a}, {b}, [{rows}]",
            "ldr {a}, [{a}, {at}]",
            "ldr {b}, [{b}, {at}]",
            "ldrd {c}, {d}, [{rows}, #8]",
            "ldr {c}, [{c}, {at}]",
            "ldr {d}, [{d}, {at}]",
            "uhadd8 {a}, {a}, {b}",
            "uhadd8 {c}, {c}, {d}",
            "uhadd8 {a}, {a}, {c}",
            "ldrd {b}, {c}, [{rows}, #16]",
            "ldr {b}, [{b}, {at}]",
            "ldr {c}, [{c}, {at}]",
            "ldrd {d}, {e}, [{rows}, #24]",
            "ldr {d}, [{d}, {at}]",
            "ldr {e}, [{e}, {at}]",
            "uhadd8 {b}, {b}, {c}",
            "uhadd8 {d}, {d}, {e}",
            "uhadd8 {b}, {b}, {d}",
            "uhadd8 {a}, {a}, {b}",
            "str {a}, [{means}, {at}]",
            "subs {at}, {at}, #4",
            "bpl 2b",
            "adds {at}, {at}, #4", // of the columns before, there are that many left
            "it ne",
            "movne {at}, #0",
            "bne 2b",
            a = out(reg) _,
            b = out(reg) _,
            c = out(reg) _,
            d = out(reg) _,
            e = out(reg) _,
            rows = in(reg) rows,
            means = in(reg) means,
            at = inout(reg) columns - LANES => _,
            options(nostack),
        );
    }
}

/// True if the pictures, which have at least four columns, lose more than is allowed: certainly from some row on.
fn exceeds(pair: &Pair, limit: &Limit) -> bool {
    let mut clipped = Clipped::default();
    let mut column = 0;
    while column < pair.width {
        let width = FILTER_STRIP.min(pair.width - column);
        // SAFETY: the strip is a part of the pair, which has at least four columns.
        if unsafe { clipped.add(pair, column, width, limit) } {
            return true;
        }
        column += FILTER_STRIP;
    }
    false
}

/// Sums of min(difference, threshold), and of min(difference, threshold - 1): these differ by 1 for every pixel that does
/// not count.
#[derive(Default)]
struct Clipped {
    by_threshold: u32,
    by_one_less: u32,
}

/// What a round of the loop over rows needs, apart from what is always in registers.
#[repr(C)]
struct Round {
    f_stride: usize,
    g_stride: usize,
    for_each_that_does_not_count: u32,
    for_each_level: u32,
    allowed: u32,
    rows: usize,
    none: usize,
    words: usize,
}

impl Clipped {
    /// Adds `width` (1..=`FILTER_STRIP`) columns from `column` on, until more is lost than is allowed: then it says true.
    ///
    /// What `uqsub8` leaves of the threshold after a difference is as far from the threshold as the difference, and no
    /// farther than 0: that is what `usada8` adds. With M and M' the two sums, M - M' pixels do not count, and M less
    /// (M - M') * threshold is the sum of the differences of the others.
    ///
    /// # Safety
    /// The pair has these columns, and at least four.
    #[inline(always)]
    unsafe fn add(&mut self, pair: &Pair, column: usize, width: usize, limit: &Limit) -> bool {
        let in_lanes = |byte: u8| u32::from_ne_bytes([byte; LANES]);
        let left = width % LANES;
        let mut round = Round {
            f_stride: pair.patch.stride,
            g_stride: pair.template.stride,
            for_each_that_does_not_count: u32::from(Table::ONE)
                .wrapping_sub(limit.chord.wrapping_mul(u32::from(limit.threshold))),
            for_each_level: limit.chord,
            allowed: limit.allowed,
            rows: pair.height,
            none: 8 * (LANES - left),
            words: width / LANES * FILTER_WORD,
        };
        // SAFETY: of each row, whole words and the last word of `width` are read; nothing but `round` is written.
        unsafe {
            asm!(
                "adr.w r2, 4f",
                "ldr r3, [{round}, #28]",
                "sub r2, r2, r3",
                "orr r2, r2, #1", // Thumb
                "str r2, [{round}, #28]",
                "2:",
                "cbz r5, 3f",
                "ldr r2, [r0, r5]",
                "ldr r3, [r1, r5]",
                "ldr {d}, [{round}, #24]",
                "lsr r2, r2, {d}",
                "lsr r3, r3, {d}",
                "uqsub8 {d}, r2, r3",
                "uqsub8 r2, r3, r2",
                "orr r2, r2, {d}",
                "uqsub8 {d}, {threshold}, r2",
                "uqsub8 r2, {one_less}, r2",
                "usada8 {sum}, {threshold}, {d}, {sum}",
                "usada8 {less}, {one_less}, r2, {less}",
                "3:",
                "ldr.w pc, [{round}, #28]",
                ".p2align 2", // so that 4 is where adr can point to
                ".irp offset,60,56,52,48,44,40,36,32,28,24,20,16,12,8,4,0",
                "ldr.n r2, [r0, #\\offset]",
                "ldr.n r3, [r1, #\\offset]",
                "uqsub8 {d}, r2, r3",
                "uqsub8 r2, r3, r2",
                "orr.w r2, r2, {d}",
                "uqsub8 {d}, {threshold}, r2",
                "uqsub8 r2, {one_less}, r2",
                "usada8 {sum}, {threshold}, {d}, {sum}",
                "usada8 {less}, {one_less}, r2, {less}",
                ".endr",
                "4:",
                "ldrd r2, r3, [{round}]",
                "add r0, r0, r2",
                "add r1, r1, r3",
                "sub {d}, {sum}, {less}",
                "ldrd r2, r3, [{round}, #8]",
                "mul r2, r2, {d}",
                "mla r2, r3, {sum}, r2",
                "ldrd r3, {d}, [{round}, #16]",
                "cmp r2, r3",
                "bhi 5f",
                "subs {d}, {d}, #1",
                "str {d}, [{round}, #20]",
                "bne.w 2b",
                "5:",
                inout("r0") pair.patch.first.wrapping_add(column) => _,
                inout("r1") pair.template.first.wrapping_add(column) => _,
                out("r2") _,
                out("r3") _,
                // The last columns are the upper part of the last word, which begins in the columns before.
                in("r5") if left == 0 { 0 } else { width.wrapping_sub(LANES) },
                d = out(reg) _,
                threshold = in(reg) in_lanes(limit.threshold),
                one_less = in(reg) in_lanes(limit.threshold - 1),
                sum = inout(reg) self.by_threshold,
                less = inout(reg) self.by_one_less,
                round = in(reg) &raw mut round,
                options(nostack),
            );
        }
        round.rows > 0
    }
}
