//! Sums of products by the DSP extension: `smlad` adds two products of 16-bit numbers.
//!
//! Both loops slide a row of factors along a row of numbers. Up to five neighbouring sums share each factor. The numbers under it pass from
//! the register of one sum to that of the next, so each number is loaded once for all of them. A factor is a pair of 16-bit numbers:
//!
//! - Responses: two channels of a cell. Features are unpacked to 16 bits, row by row.
//! - Gradient: the errors at an offset and at the one below it. The features of two rows of cells are unpacked as pairs.

use crate::kernels::layout::{Layout, PACKED, Packed};
use crate::kernels::plain::products as plain;
use crate::kernels::unrolling::rolled;
use core::arch::asm;
use core::ops::Range;
use core::ptr;

/// Bytes from an offset to the next one: the features of a cell.
const STEP: usize = 10;
/// The most offsets on an axis for which `gather` works here.
const SPAN: usize = 17;

/// See [`plain::responses`]. A part is two rows of cells.
pub(crate) fn responses<const N: usize>(
    parts: Range<usize>,
    room: &mut Packed,
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    let Layout { row, stride, step, span } = layout;
    let used = row + span.saturating_sub(1) * step;
    let whole = step == STEP && row > 0 && row.is_multiple_of(STEP) && weights.len().is_multiple_of(row);
    let down = weights.len().checked_div(row).unwrap_or(0);
    let rows = layout.rows(weights.len());
    let needed = rows.saturating_sub(1) * stride + used;
    if !whole || down == 0 || span == 0 || span > N || out.len() < span || used > PACKED || cells.len() < needed {
        return plain::responses(whole_of(parts, span), cells, layout, weights, out);
    }
    if parts.start == 0 {
        out.iter_mut().take(span).for_each(|out| out.fill(0));
    }
    for number in 2 * parts.start..rows.min(2 * parts.end) {
        let from = cells.get(number * stride..).unwrap_or_default();
        let (pairs, _) = from.as_chunks::<2>();
        let (wide, _) = room.as_chunks_mut();
        for (wide, &[first, second]) in rolled(wide.iter_mut().zip(pairs).take(used / 2)) {
            *wide = pair(first.into(), second.into());
        }
        // For each row of weights that meets this row of cells at some offset.
        for (y, weights) in weights.chunks_exact(row.max(1)).enumerate() {
            let Some(out) = number.checked_sub(y).filter(|&y| y < span).and_then(|y| out.get_mut(y)) else { continue };
            let (mut at, cells) = (0, row / STEP);
            while at < span {
                let block = Block {
                    filter: weights.as_ptr().cast(),
                    under: room.as_ptr().cast::<u8>().wrapping_add(at * 2 * STEP),
                    sums: out.as_mut_ptr().wrapping_add(at),
                    count: cells,
                    filters: STEP / 2,
                };
                // SAFETY: the filter has `cells` cells of weights. For n sums, `under` is followed by `cells + n - 1` cells, and `at + n` is at
                // most `span`.
                at += unsafe { block.of_at_most::<{ 2 * STEP }, { 2 * STEP }, 1>(span - at) };
            }
        }
    }
}

/// See [`plain::gather`]. A part is two rows of cells.
pub(crate) fn gather<const N: usize>(
    parts: Range<usize>,
    room: &mut Packed,
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    let Layout { row, stride, step, span } = layout;
    let used = row + span.saturating_sub(1) * step;
    let whole = step == STEP && row > 0 && row.is_multiple_of(STEP) && sums.len().is_multiple_of(row);
    let down = sums.len().checked_div(row).unwrap_or(0);
    let rows = layout.rows(sums.len());
    let needed = rows.saturating_sub(1) * stride + used;
    let fits = span > 0 && span <= N.min(SPAN) && errors.len() >= span && 2 * used <= PACKED;
    if !whole || !fits || down == 0 || cells.len() < needed {
        return plain::gather(whole_of(parts, span), cells, layout, errors, sums);
    }
    for number in (2 * parts.start..rows.min(2 * parts.end)).step_by(2) {
        let upper = cells.get(number * stride..number * stride + used).unwrap_or_default();
        // The row below the last one may hold anything: no error is multiplied with it.
        let lower = cells.get((number + 1) * stride..).and_then(|lower| lower.get(..used)).unwrap_or(upper);
        let (pairs, _) = room.as_chunks_mut();
        for ((both, &upper), &lower) in rolled(pairs.iter_mut().zip(upper).zip(lower)) {
            *both = pair(upper.into(), lower.into());
        }
        for (y, sums) in sums.chunks_exact_mut(row.max(1)).enumerate() {
            // The errors at the offsets where this row of sums meets the two rows of cells.
            let of = |number: usize| number.checked_sub(y).filter(|&y| y < span).and_then(|y| errors.get(y));
            let (first, second) = (of(number), of(number + 1));
            if first.is_none() && second.is_none() {
                continue;
            }
            let mut filter = [[0; 2]; SPAN];
            let error =
                |errors: Option<&[i16; N]>, x: usize| errors.and_then(|errors| errors.get(x)).copied().unwrap_or(0);
            for (x, filter) in rolled(filter.iter_mut().enumerate().take(span)) {
                *filter = pair(error(first, x), error(second, x));
            }
            let across = row / STEP;
            for channel in 0..STEP {
                let mut at = 0;
                while at < across {
                    let block = Block {
                        filter: filter.as_ptr().cast(),
                        under: room.as_ptr().cast::<[u16; 2]>().wrapping_add(at * STEP + channel).cast(),
                        sums: sums.as_mut_ptr().wrapping_add(at * STEP + channel),
                        count: span,
                        filters: 1,
                    };
                    // SAFETY: the filter has `span` errors. For n sums, `under` is followed by `span + n - 1` cells, and `at + n` is at most
                    // `across`.
                    at += unsafe { block.of_at_most::<4, { 4 * STEP }, STEP>(across - at) };
                }
            }
        }
    }
}

/// Two numbers as `smlad` takes them.
fn pair(low: i16, high: i16) -> [u16; 2] {
    [low.cast_unsigned(), high.cast_unsigned()]
}

/// The parts of the plain loop that replace these parts: all for the first one, none for the others.
fn whole_of(parts: Range<usize>, span: usize) -> Range<usize> {
    if parts.start == 0 { 0..span } else { 0..0 }
}

/// Neighbouring sums, and what is added to them. Filter i of `filters` has `count` factors, which begin 4 * i bytes after `filter`; the
/// numbers under them at the first sum begin 4 * i bytes after `under`.
#[derive(Clone, Copy)]
struct Block {
    filter: *const u8,
    under: *const u8,
    sums: *mut i32,
    count: usize,
    filters: usize, // not a constant: the compiler would unroll the loop
}

impl Block {
    /// Computes some of the `left` remaining sums and returns how many. There is no function for three: it would take 0.5 KB of flash and
    /// hardly ever run.
    ///
    /// # Safety
    /// As [`Block::slide5`], for the returned number of sums.
    #[inline(always)]
    unsafe fn of_at_most<const F: usize, const U: usize, const S: usize>(self, left: usize) -> usize {
        // SAFETY: as the caller guarantees.
        unsafe {
            match left {
                0 => 0,
                1 => self.slide1::<F, U, S>(),
                2 | 3 => self.slide2::<F, U, S>(),
                4 | 6 | 8 | 12 | 16 => self.slide4::<F, U, S>(),
                _ => self.slide5::<F, U, S>(),
            }
        }
    }
}

/// One factor: loads it and the next number under it, and adds its products to all sums.
macro_rules! turn {
    ([$($sum:literal)*] [$($under:literal)*] $new:literal) => {
        concat!(
            "ldr r6, [r12], #{f}\n",
            "ldr ", $new, ", [lr], #{u}\n",
            $("smlad ", $sum, ", ", $under, ", r6, ", $sum, "\n",)*
        )
    };
}

/// A function for n sums. The loop is unrolled n times, with the registers of the numbers rotated: no number moves.
macro_rules! slide {
    ($name:ident, $n:literal, [$($sum:ident $sum_in:tt)*], [$($first:ident $first_in:tt)*]:
        $($sums:tt $window:tt $new:tt;)*) => {
        impl Block {
            /// Adds to each of n sums the products of the filter and the numbers under it, and returns n. Sums are `S` numbers apart, factors
            /// `F` bytes, numbers `U` bytes.
            ///
            /// # Safety
            /// `count` factors can be read at `filter`, `count + n - 1` numbers at `under`, and n sums written at `sums`. Only `sums` must
            /// be aligned.
            #[inline(never)]
            unsafe fn $name<const F: usize, const U: usize, const S: usize>(&self) -> usize {
                let mut sums = self.sums;
                // SAFETY: there are n sums.
                $(let mut $sum = unsafe { next::<S>(&mut sums).read() };)*
                for pair in 0..self.filters {
                    #[allow(unused_mut)] // for one sum nothing is loaded ahead
                    let mut cells = self.under.wrapping_add(4 * pair);
                    // SAFETY: `count + n - 1` numbers can be read.
                    $(let $first = unsafe { load::<U>(&mut cells) };)*
                    // SAFETY: `count` factors and as many more numbers are read. r6 and r7, which `asm!` may not name, are saved on the
                    // stack. r11 passes `count`.
                    unsafe {
                        asm!(
                            "push {{r6, r7}}",
                            concat!("subs r7, r11, #", $n),
                            "bmi 3f",
                            "2:",
                            $(turn!($sums $window $new),)*
                            concat!("subs r7, #", $n),
                            "bpl 2b",
                            "3:",
                            concat!("adds r7, #", $n),
                            $(
                                "beq 4f",
                                turn!($sums $window $new),
                                "subs r7, #1",
                            )*
                            "4:",
                            "pop {{r6, r7}}",
                            $(inout($sum_in) $sum,)*
                            $(inout($first_in) $first => _,)*
                            inout("r11") self.count => _,
                            inout("r12") self.filter.wrapping_add(4 * pair) => _,
                            inout("lr") cells => _,
                            f = const F,
                            u = const U,
                        );
                    }
                }
                let mut sums = self.sums;
                // SAFETY: as above.
                $(unsafe { next::<S>(&mut sums).write($sum) };)*
                $n
            }
        }
    };
}

slide!(slide1, 1, [a "r0"], []:
    ["r0"] ["r11"] "r11";);
slide!(slide2, 2, [a "r0" b "r1"], [f "r5"]:
    ["r0" "r1"] ["r5" "r11"] "r11";
    ["r0" "r1"] ["r11" "r5"] "r5";);
slide!(slide4, 4, [a "r0" b "r1" c "r2" d "r3"], [f "r5" g "r8" h "r9"]:
    ["r0" "r1" "r2" "r3"] ["r5" "r8" "r9" "r11"] "r11";
    ["r0" "r1" "r2" "r3"] ["r8" "r9" "r11" "r5"] "r5";
    ["r0" "r1" "r2" "r3"] ["r9" "r11" "r5" "r8"] "r8";
    ["r0" "r1" "r2" "r3"] ["r11" "r5" "r8" "r9"] "r9";);
slide!(slide5, 5, [a "r0" b "r1" c "r2" d "r3" e "r4"], [f "r5" g "r8" h "r9" i "r10"]:
    ["r0" "r1" "r2" "r3" "r4"] ["r5" "r8" "r9" "r10" "r11"] "r11";
    ["r0" "r1" "r2" "r3" "r4"] ["r8" "r9" "r10" "r11" "r5"] "r5";
    ["r0" "r1" "r2" "r3" "r4"] ["r9" "r10" "r11" "r5" "r8"] "r8";
    ["r0" "r1" "r2" "r3" "r4"] ["r10" "r11" "r5" "r8" "r9"] "r9";
    ["r0" "r1" "r2" "r3" "r4"] ["r11" "r5" "r8" "r9" "r10"] "r10";);

/// The address of this number; moves `at` on by `STEP` numbers.
#[inline(always)]
fn next<const STEP: usize>(at: &mut *mut i32) -> *mut i32 {
    let this = *at;
    *at = at.wrapping_add(STEP);
    this
}

/// Loads a pair; moves `at` on by `STEP` bytes.
///
/// # Safety
/// Four bytes can be read at `at`.
#[inline(always)]
unsafe fn load<const STEP: usize>(at: &mut *const u8) -> u32 {
    // SAFETY: as the caller guarantees. The pair need not be aligned.
    let pair = unsafe { ptr::read_unaligned(at.cast::<u32>()) };
    *at = at.wrapping_add(STEP);
    pair
}
