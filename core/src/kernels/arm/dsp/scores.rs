//! Scores by the DSP extension of Armv7E-M (Cortex-M4, M7) and Armv8-M (M33, M35P): four pixels in a register.
//!
//! - `usada8` adds the four absolute differences of two registers to a third.
//! - `uqsub8` is a saturating subtraction: by how much one pixel exceeds another.
//! - `usub8` compares, and `sel` then selects the larger or the smaller of each two pixels.
//!
//! The intrinsics need an unstable compiler, so these are `asm!`: whole loops, because the compiler would spill
//! registers between pieces. Words are loaded from any address. That works in Normal memory, unless firmware sets
//! `UNALIGN_TRP`, and faults in Device memory: see [`Backend`](crate::similarity::Backend).

use super::super::points::{OFFSETS, Points};
use super::super::scores::{Loops, blocks};
use super::bounds;
use super::words::{LANES, WordRow, in_lanes, words};
use crate::kernels::plain::scores as plain;
use crate::kernels::rows::Rows;
use core::arch::asm;

/// Columns that `distance` processes at a time, by an unrolled loop.
const STRIP: usize = 16 * LANES;

pub(crate) struct Dsp;

impl Loops for Dsp {
    const NARROWEST: usize = LANES;
    const REACHABLE: unsafe fn(&Rows, *const u16, u32) -> u32 = reachable;
    const DISTANCE: unsafe fn(&Rows, u32) -> u32 = distance;
    const OUTSIDE_RANGES: unsafe fn(&Rows, u32) -> u32 = bounds::outside_ranges;
    const POINT_MARGINS: unsafe fn(&Rows, &Points, u32, u8) -> [i32; OFFSETS] = bounds::point_margins;
    const RANGES: fn(&[&[u8]; 4], u8, &mut [u8], &mut [u8]) = ranges;
}

/// Computes the lower ends and lengths of the pixel ranges of 4x4 blocks, widened by `margin` on both sides. Does
/// nothing for fewer than four blocks: only templates of fewer than four columns have so few, and no bound is computed
/// for those.
fn ranges(rows: &[&[u8]; 4], margin: u8, low: &mut [u8], span: &mut [u8]) {
    let blocks = blocks(rows, low, span);
    if blocks < LANES {
        return;
    }
    let [a, b, c, d] = rows.each_ref().map(|row| row.as_ptr());
    let from = Spread { rows: [a, b, c, d], margin: in_lanes(margin), last: blocks - LANES };
    // SAFETY: the rows have the pixels of these blocks, and `low` and `span` have room for them.
    unsafe { spread(&from, low.as_mut_ptr(), span.as_mut_ptr()) }
}

/// Adds to `{reachable}` the similarities of the four pairs of pixels in `{w}` and `r2`.
macro_rules! similarities {
    () => {
        concat!(
            "uqsub8 r3, {w}, r2\n",
            "uqsub8 {w}, r2, {w}\n",
            "orr {w}, {w}, r3\n",
            "uxtb r2, {w}\n",
            "ubfx r3, {w}, #8, #8\n",
            "ldrh r2, [{entries}, r2, lsl #1]\n",
            "ldrh r3, [{entries}, r3, lsl #1]\n",
            "add {reachable}, {reachable}, r2\n",
            "add {reachable}, {reachable}, r3\n",
            "ubfx r2, {w}, #16, #8\n",
            "lsr r3, {w}, #24\n",
            "ldrh r2, [{entries}, r2, lsl #1]\n",
            "ldrh r3, [{entries}, r3, lsl #1]\n",
            "add {reachable}, {reachable}, r2\n",
            "add {reachable}, {reachable}, r3\n",
        )
    };
}

/// Implements [`Loops::REACHABLE`]. The first of the `entries` is that of equal pixels.
///
/// # Safety
/// `pair.width` pixels, at least four, can be read in each of the `pair.height` rows (at least one) of both
/// pictures, and 256 numbers at `entries`.
#[inline(always)]
unsafe fn reachable(pair: &Rows, entries: *const u16, floor: u32) -> u32 {
    let mut reachable = pair.full_after(0);
    let row = WordRow::of(pair);
    // SAFETY: only words within a row and entries up to 255 are read. Nothing is written.
    unsafe {
        asm!(
            "2:",
            "add {end}, {f}, {words}",
            "ldrd r2, r3, [{row}, #8]",
            "cbz r2, 3f",
            "ldr {w}, [{f}, r2]",
            "ldr r2, [{g}, r2]",
            "lsr {w}, {w}, r3",
            "lsr r2, r2, r3", // shifts in zeroes on both sides: these pixels are equal
            "b 4f",
            "3:",
            "sub r2, {end}, {f}",
            "tst r2, #4",
            "beq 5f",
            "ldr {w}, [{f}], #4", // takes one word, so that pairs are left
            "ldr r2, [{g}], #4",
            "4:",
            similarities!(),
            "b 3b",
            "5:",
            "cmp {f}, {end}",
            "beq 7f",
            "6:",
            "ldr {w}, [{f}], #4",
            "ldr r2, [{g}], #4",
            similarities!(),
            "ldr {w}, [{f}], #4",
            "ldr r2, [{g}], #4",
            similarities!(),
            "cmp {f}, {end}",
            "bne 6b",
            "7:",
            "sub {reachable}, {reachable}, {full}",
            "cmp {reachable}, {floor}",
            "blo 8f",
            "ldrd r2, r3, [{row}]",
            "add {f}, {f}, r2",
            "add {g}, {g}, r3",
            "ldr r2, [{row}, #16]",
            "cmp {g}, r2",
            "bne 2b",
            "8:",
            f = inout(reg) pair.patch => _,
            g = inout(reg) pair.template => _,
            w = out(reg) _,
            out("r2") _, out("r3") _,
            end = out(reg) _,
            words = in(reg) words(pair),
            row = in(reg) &raw const row,
            entries = in(reg) entries,
            // The largest possible score of a row. The zeroes shifted into its last word count as equal pixels.
            full = in(reg) plain::full(pair.width.next_multiple_of(LANES)),
            floor = in(reg) floor,
            reachable = inout(reg) reachable,
            options(readonly, nostack),
        );
    }
    reachable
}

/// Implements [`Loops::DISTANCE`].
///
/// # Safety
/// `pair.width` pixels, at least four, can be read in each of the `pair.height` rows (at least one) of both
/// pictures.
#[inline(always)]
unsafe fn distance(pair: &Rows, enough: u32) -> u32 {
    // `sum` starts at -`enough` - 1 and reaches 0 once the distance exceeds `enough`. The limit prevents an overflow.
    let start = !enough.min(1 << 30).cast_signed();
    let mut sum = start;
    let mut column = 0;
    while column < pair.width && sum < 0 {
        let width = STRIP.min(pair.width - column);
        // SAFETY: the strip ends within the `pair.width` columns. The first one has at least four columns, later ones
        // lie behind it.
        unsafe { sum = strip(pair, column, width, sum) };
        column += STRIP;
    }
    sum.wrapping_sub(start).cast_unsigned()
}

/// Assembly of the unrolled loop. No `.irp`, because the compiler estimates jump distances by the number of lines.
macro_rules! distance_of_words {
    ($($offset:literal)*) => {
        concat!($(
            concat!("ldr.n r2, [r0, #", $offset, "]\n"),
            concat!("ldr.n r3, [r1, #", $offset, "]\n"),
            "usada8 {sum}, r2, r3, {sum}\n",
        )*)
    };
}

/// Adds to `sum` the differences in `width` (1..=`STRIP`) columns from `column`, row by row, while `sum` is negative.
///
/// # Safety
/// `column + width` is at least four and at most `pair.width`. `pair.width` pixels can be read in each of the
/// `pair.height` rows (at least one) of both pictures.
#[inline(always)]
unsafe fn strip(pair: &Rows, column: usize, width: usize, mut sum: i32) -> i32 {
    let left = width % LANES;
    // Offset of the word whose upper part holds the columns after the last whole word; 0 if there are none.
    let last = if left == 0 { 0 } else { width.wrapping_sub(LANES) };
    // SAFETY: only words within the `width` columns of a row are read. Nothing is written.
    unsafe {
        asm!(
            "adr.w {words}, 4f",
            "sub {words}, {words}, r2, lsl #3", // each word has eight bytes of code
            "2:",
            "cbz r5, 3f",
            "ldr.n r2, [r0, r5]",
            "ldr.n r3, [r1, r5]",
            "lsr r2, r2, {none}",
            "lsr r3, r3, {none}",
            "usada8 {sum}, r2, r3, {sum}",
            "3:",
            "mov pc, {words}",
            ".p2align 2", // adr can point to 4 only if it is aligned
            distance_of_words!(60 56 52 48 44 40 36 32 28 24 20 16 12 8 4 0),
            "4:",
            "add r0, r0, {f_stride}",
            "add r1, r1, {g_stride}",
            "adds {rows}, {rows}, #1",
            "tst {rows}, {sum}", // negative while both are
            "bmi.w 2b",
            words = out(reg) _,
            inout("r0") pair.patch.wrapping_add(column) => _,
            inout("r1") pair.template.wrapping_add(column) => _,
            inout("r2") width / LANES => _,
            out("r3") _,
            in("r5") last,
            none = in(reg) 8 * (LANES - left),
            f_stride = in(reg) pair.patch_stride,
            g_stride = in(reg) pair.template_stride,
            rows = inout(reg) pair.height.wrapping_neg() => _,
            sum = inout(reg) sum,
            options(readonly, nostack),
        );
    }
    sum
}

/// Selects the smaller (`least`) or larger (`most`) pixel in each lane of `$x` and `$y`. Overwrites `$free`.
macro_rules! of_two {
    (least, $to:literal, $x:literal, $y:literal, $free:literal) => {
        concat!("usub8 ", $free, ", ", $x, ", ", $y, "\nsel ", $to, ", ", $y, ", ", $x)
    };
    (most, $to:literal, $x:literal, $y:literal, $free:literal) => {
        concat!("usub8 ", $free, ", ", $x, ", ", $y, "\nsel ", $to, ", ", $x, ", ", $y)
    };
}

/// Selects the smallest and the largest pixel of four rows in each of four columns from `at` on.
macro_rules! of_four_rows {
    ($low:literal, $high:literal) => {
        concat!(
            "ldrd {e}, {f}, [{rows}]\n",
            "ldr {e}, [{e}, {at}]\n",
            "ldr {f}, [{f}, {at}]\n",
            concat!("usub8 ", $low, ", {e}, {f}\nsel ", $low, ", {f}, {e}\nsel ", $high, ", {e}, {f}\n"),
            "ldrd {e}, {f}, [{rows}, #8]\n",
            "ldr {e}, [{e}, {at}]\n",
            "ldr {f}, [{f}, {at}]\n",
            "usub8 {g}, {e}, {f}\nsel {g}, {f}, {e}\nsel {e}, {e}, {f}\n",
            of_two!(least, $low, $low, "{g}", "{f}"),
            "\n",
            of_two!(most, $high, $high, "{e}", "{f}"),
        )
    };
}

/// For each of four columns, the minimum or maximum of it and the next three. `$next` holds the next four columns.
macro_rules! of_four_columns {
    ($what:ident, $first:literal, $next:literal) => {
        concat!(
            concat!("lsr {e}, ", $first, ", #8\n"),
            concat!("orr {e}, {e}, ", $next, ", lsl #24\n"),
            of_two!($what, "{e}", "{e}", $first, "{f}"),
            concat!("\nlsr {f}, ", $first, ", #16\n"),
            concat!("orr {f}, {f}, ", $next, ", lsl #16\n"),
            of_two!($what, "{e}", "{e}", "{f}", "{g}"),
            concat!("\nlsr {f}, ", $first, ", #24\n"),
            concat!("orr {f}, {f}, ", $next, ", lsl #8\n"),
            of_two!($what, "{e}", "{e}", "{f}", "{g}"),
        )
    };
}

/// Constants that [`spread`] reads. The assembly depends on their offsets.
#[repr(C)]
struct Spread {
    rows: [*const u8; 4],
    /// Margin on both sides of each range, in each lane.
    margin: u32,
    /// Index of the first of the last four blocks.
    last: usize,
}

/// Computes ranges with a margin: low = max(smallest pixel - margin, 0), span = min(largest pixel + margin, 255) - low.
///
/// # Safety
/// `last + 7` bytes can be read at each of the rows, and `last + 4` bytes written at `low` and `span`.
#[inline(always)]
unsafe fn spread(from: &Spread, low: *mut u8, span: *mut u8) {
    // SAFETY: a round takes four blocks and reads words at `at` and at `at + 4`. The last round takes the last four
    // blocks, reads its second word at `last + 3`, the last word of a row, and drops the first byte of that.
    unsafe {
        asm!(
            "1:",
            of_four_rows!("{a}", "{b}"),
            "2:",
            "add {at}, {at}, #4",
            "sub {at}, {at}, {again}, lsr #3",
            of_four_rows!("{c}", "{d}"),
            "add {at}, {at}, {again}, lsr #3",
            "lsr {c}, {c}, {again}",
            "lsr {d}, {d}, {again}",
            of_four_columns!(least, "{a}", "{c}"),
            "ldr {f}, [{rows}, #16]",
            "uqsub8 {e}, {e}, {f}",
            "str {e}, [{low}, {at}]",
            "mov {a}, {c}",
            of_four_columns!(most, "{b}", "{d}"),
            "ldr {f}, [{rows}, #16]",
            "uqadd8 {e}, {e}, {f}",
            "ldr {f}, [{low}, {at}]",
            "usub8 {e}, {e}, {f}",
            "str {e}, [{span}, {at}]",
            "mov {b}, {d}",
            "ldr {f}, [{rows}, #20]",
            "cmp {at}, {f}",
            "blo 2b",
            "cmp {again}, #0",
            "mov {again}, #8", // the bits of a byte
            "mov {at}, {f}",
            "beq 1b",
            a = out(reg) _, b = out(reg) _, c = out(reg) _, d = out(reg) _, e = out(reg) _, f = out(reg) _,
            g = out(reg) _,
            rows = in(reg) from,
            // Both pointers start one word lower, because the loop advances `at` by a word before it stores.
            low = in(reg) low.wrapping_sub(LANES),
            span = in(reg) span.wrapping_sub(LANES),
            at = inout(reg) 0 => _,
            again = inout(reg) if from.last == 0 { 8 } else { 0 } => _,
            options(nostack),
        );
    }
}
