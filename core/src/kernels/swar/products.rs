//! Filter responses and gradients for processors without DSP or SIMD.
//!
//! Both kernels slide rows of factors along rows of numbers. Up to nine neighbouring sums share the load of a factor.
//! The numbers of a channel are stored side by side, so that neighbouring sums have neighbouring numbers. Both compute
//! three sums of products instead of four (`three_sums.rs`): numbers are differences of two rows of cells, and some
//! factors are sums of two factors.
//!
//! Armv6-M has no signed load with a constant offset. So there each number is stored with 256 added, and 256 times the
//! sum of its factors is subtracted. Sums may wrap before the subtraction.

use crate::kernels::layout::{CHANNELS, Layout, PACKED, Packed};
use crate::kernels::plain::products as plain;
use crate::kernels::three_sums::{BOTH, PairedSizes, Rows, SUMS, Slide};
#[cfg(not(all(smr_swar, target_arch = "arm")))]
use crate::kernels::unrolling::in_order;
use crate::kernels::unrolling::rolled;
use core::ops::Range;

pub(crate) const TAKES_ROWS_OF_CELLS: bool = true;
pub(crate) const GATHER_PIECES: Option<usize> = Some(STEP);

const STEP: usize = CHANNELS;

/// Added to each stored feature or difference of features, so that none is negative on Armv6-M.
const NUMBER_BIAS: i32 = if cfg!(all(smr_swar, target_arch = "arm")) { 256 } else { 0 };

/// Computes filter responses, as [`plain::responses`] specifies. Pieces of work are pairs of rows of cells.
pub(crate) fn responses<const N: usize>(
    pieces: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    let Layout { row, stride, span, .. } = layout;
    let down = layout.checked_height(cells.len(), weights.len()).unwrap_or(0);
    let (pairs, across) = (PairedSizes::new(down, span), row / STEP);
    let width = across + span.saturating_sub(1);
    let has_room = STEP * width <= PACKED / 2 && pairs.both() * N <= PACKED / 4;
    let fits = down > 0 && span <= N && has_room;
    let (totals, spare) = spare.split_at_mut_checked(pairs.rows_of_factors()).unwrap_or_default();
    let factors = numbers_in(spare).get_mut(..totals.len() * row);
    let (true, Some(factors)) = (fits && !totals.is_empty(), factors) else {
        return plain::responses(layout.all_rows_in_first_piece(pieces), room, &mut [], cells, layout, weights, out);
    };
    if pieces.start == 0 {
        let ((of_cells, _), mut factors) = (weights.as_chunks::<STEP>(), &mut *factors);
        for (number, total) in totals.iter_mut().enumerate() {
            let of = |row: usize| of_cells.get(row * across..(row + 1) * across).unwrap_or_default();
            let (first, second) = pairs.factors(number);
            *total = 0;
            for channel in 0..STEP {
                let of = |row| of(row).iter().map(|cell| cell.get(channel).copied().unwrap_or(0));
                let Some(to) = factors.split_off_mut(..across) else { return };
                rolled(to.iter_mut().zip(of(first))).for_each(|(to, from)| *to = from);
                if let Some(second) = second {
                    rolled(to.iter_mut().zip(of(second))).for_each(|(to, from)| *to += from);
                }
                *total += sum(to);
            }
        }
    }
    let (numbers, both) = room.words().split_at_mut(PACKED / 4);
    let both = both.as_chunks_mut().0.get_mut(..pairs.both()).unwrap_or_default();
    let (numbers, factors) = (numbers.as_mut_ptr().cast(), factors.as_ptr());
    let mut rows = Differences { cells: cells.as_ptr(), stride, numbers, width, factors, totals, across };
    pairs.responses(pieces, &mut rows, both, out);
}

/// Row of cells, or difference of two rows, channel by channel. `Layout::checked_height` ensures that all rows exist.
struct Differences<'a> {
    cells: *const i8,
    stride: usize,
    numbers: *mut i16,
    width: usize,
    factors: *const i16,
    /// Sums of the factors, one for each row of factors.
    totals: &'a [i32],
    /// Width of the filter in cells.
    across: usize,
}

impl Rows for Differences<'_> {
    #[inline(always)]
    fn take(&mut self, first: usize, second: Option<usize>) {
        let Self { cells, stride, mut numbers, width, .. } = *self;
        for channel in 0..STEP {
            let of = |row: usize| cells.wrapping_add(row * stride + channel);
            // SAFETY: `checked_height` found `width` cells in these rows, and `numbers` has room for `width` per
            // channel.
            unsafe { subtract(numbers, width, of(first), second.map(of)) };
            numbers = numbers.wrapping_add(width);
        }
    }

    #[inline(always)]
    fn add(&mut self, number: usize, sums: &mut [i32]) {
        let Self { numbers, width, factors, totals, across, .. } = *self;
        let slide =
            Slide { factors: factors.wrapping_add(number * STEP * across), count: across, numbers, width, rows: STEP };
        // SAFETY: there are `STEP` rows of `across` factors from here on, and at every offset they lie on the numbers.
        unsafe { slide.add(totals.get(number).copied().unwrap_or(0), sums) };
    }
}

/// Writes one channel of `width` cells: `first`, minus `second` if there is one, plus [`NUMBER_BIAS`].
///
/// # Safety
/// At `first` and at `second`, a byte can be read in each of `width` cells, `STEP` bytes apart. `width` numbers can be
/// written at `to`, which is aligned.
#[inline(never)]
unsafe fn subtract(mut to: *mut i16, width: usize, mut first: *const i8, second: Option<*const i8>) {
    // Two loops, because one for both cases would need too many registers.
    if let Some(mut second) = second {
        for _ in rolled(0..width) {
            // SAFETY: a round for each of the `width` cells and numbers.
            unsafe { *to = low(i32::from(*first) - i32::from(*second) + NUMBER_BIAS) };
            (to, first, second) = (to.wrapping_add(1), first.wrapping_add(STEP), second.wrapping_add(STEP));
        }
    } else {
        for _ in rolled(0..width) {
            // SAFETY: a round for each of the `width` cells and numbers.
            unsafe { *to = low(i32::from(*first) + NUMBER_BIAS) };
            (to, first) = (to.wrapping_add(1), first.wrapping_add(STEP));
        }
    }
}

#[allow(clippy::cast_possible_truncation)] // as named
fn low(number: i32) -> i16 {
    number as i16
}

fn sum(factors: &[i16]) -> i32 {
    rolled(factors.iter()).map(|&factor| i32::from(factor)).sum()
}

fn numbers_in(words: &mut [i32]) -> &mut [i16] {
    // SAFETY: a word may hold any two numbers.
    unsafe { words.align_to_mut().1 }
}

/// Adds the gradient of the filter's error, as [`plain::gather`] specifies. Pieces of work are channels.
pub(crate) fn gather<const N: usize>(
    pieces: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    let Layout { row, stride, span, .. } = layout;
    let down = layout.checked_height(cells.len(), sums.len()).unwrap_or(0);
    // Errors take the role of factors, and rows of the filter take the role of offsets.
    let (pairs, across) = (PairedSizes::new(span, down), row / STEP);
    let width = across + span.saturating_sub(1);
    let rows = |sum| pairs.rows_of(sum) + pairs.offsets_of(sum) - 1;
    let (of_row, numbers) = room.words().split_at_mut_checked(across).unwrap_or_default();
    let has_room = down > 1 && rows(BOTH) * width <= 2 * numbers.len() && span > 1 && span <= N && errors.len() >= span;
    let factors = numbers_in(spare).get_mut(..pairs.rows_of_factors() * span);
    let (true, Some(factors)) = (has_room, factors) else {
        return plain::gather(layout.all_rows_in_first_piece(pieces), room, spare, cells, layout, errors, sums);
    };
    if pieces.start == 0 {
        let mut factors = &mut *factors;
        for number in 0..pairs.rows_of_factors() {
            let (first, second) = pairs.factors(number);
            let Some(to) = factors.split_off_mut(..span) else { return };
            for (x, to) in rolled(to.iter_mut().enumerate()) {
                let of = |row: usize| errors.get(row).and_then(|errors| errors.get(x)).copied().unwrap_or(0);
                *to = of(first) + second.map_or(0, of);
            }
        }
    }
    let (numbers, (of_cells, _)) = (numbers.as_mut_ptr().cast::<i16>(), sums.as_chunks_mut::<STEP>());
    for channel in pieces.start..pieces.end.min(STEP) {
        let mut factors = &*factors;
        for sum_of in 0..SUMS {
            for at in 0..rows(sum_of) {
                let of =
                    |row: usize| (row < down + span - 1).then(|| cells.as_ptr().wrapping_add(row * stride + channel));
                let (first, second) = (of(2 * at + sum_of), of(2 * at + 1).filter(|_| sum_of != BOTH));
                // Below the last row of cells the numbers are 0: a row minus itself.
                let all = cells.as_ptr();
                let (first, second) = first.map_or((all, Some(all)), |first| (first, second));
                // SAFETY: `checked_height` found `width` cells in these rows, and `has_room` room for `rows(sum_of)`
                // rows.
                unsafe { subtract(numbers.wrapping_add(at * width), width, first, second) };
            }
            let (now, later) = factors.split_at_checked(pairs.rows_of(sum_of) * span).unwrap_or_default();
            let total = sum(now);
            for at in 0..pairs.offsets_of(sum_of) {
                let numbers = numbers.wrapping_add(at * width);
                let slide = Slide { factors: now.as_ptr(), count: span, numbers, width, rows: pairs.rows_of(sum_of) };
                rolled(of_row.iter_mut()).for_each(|sum| *sum = 0);
                // SAFETY: each row has `span` factors, and `width` numbers under them at all `across` offsets. No size
                // is 0.
                unsafe { slide.add(total, of_row) };
                // Partial sum `both` belongs to two rows of the filter, `upper` and `lower` to one each.
                let first = 2 * at + sum_of / 2;
                for at in first..first + 1 + usize::from(sum_of == BOTH) {
                    let of_cells = of_cells.get_mut(at * across..).unwrap_or_default();
                    for (cell, sum) in rolled(of_cells.iter_mut().zip(&*of_row)) {
                        if let Some(to) = cell.get_mut(channel) {
                            *to = to.wrapping_add(*sum);
                        }
                    }
                }
            }
            factors = later;
        }
    }
}

impl Slide<i16> {
    /// Adds to `sums[i]`, for each of the `rows`, the dot product of its factors and its numbers from `i` on, without
    /// `NUMBER_BIAS`. `total` is the sum of the factors of all rows.
    ///
    /// # Safety
    /// `rows` rows of `count` factors can be read at `factors`, one after the other. Of as many rows at `numbers`,
    /// `width` apart, `count + sums.len() - 1` numbers can be read. `width` is at least `count`. `count` and `rows` are
    /// not 0.
    #[inline(never)]
    unsafe fn add(mut self, total: i32, sums: &mut [i32]) {
        if NUMBER_BIAS != 0 {
            rolled(sums.iter_mut()).for_each(|sum| *sum = sum.wrapping_sub(NUMBER_BIAS * total));
        }
        let (mut to, mut left) = (sums.as_mut_ptr(), sums.len());
        while left > 0 {
            // SAFETY: no function takes more than the `left` sums, whose numbers lie in the rows.
            let done = unsafe {
                match left {
                    1 | 2 => self.one(to),
                    3 | 6 => self.three(to),
                    4 | 5 | 7 => self.four(to),
                    8 | 11 | 14..=16 => self.eight(to),
                    _ => self.nine(to),
                }
            };
            (to, left) = (to.wrapping_add(done), left - done);
            self.numbers = self.numbers.wrapping_add(done);
        }
    }
}

/// Defines a function that adds products to n neighbouring sums. On Armv6-M, r4 to r12 hold the sums, r3 a product.
#[cfg(all(smr_swar, target_arch = "arm"))]
macro_rules! slide {
    ($name:ident $n:literal: $($sum:literal $at:literal)*) => {
        impl Slide<i16> {
            /// # Safety
            /// `rows` rows of `count` factors can be read at `factors`, one after the other. Of as many rows at
            /// `numbers`, `width` apart, `count + n - 1` numbers can be read. `width` is at least `count`. Neither `count`
            /// nor `rows` is zero. n sums can be read and written at `sums`. All addresses are aligned.
            #[inline(never)]
            unsafe fn $name(&self, sums: *mut i32) -> usize {
                let Self { factors, count, numbers, width, rows } = *self;
                // SAFETY: the factors, and n - 1 more numbers than factors of each row, are read. Only the sums and the
                // stack are written. The stack keeps r6, r7 and r11, which `asm!` may not name, and row data.
                unsafe {
                    core::arch::asm!(
                        "push {{r2, r3, r4, r5, r6, r7}}",
                        "mov r3, r11",
                        "push {{r3}}",
                        "mov r3, r5",
                        $(concat!("ldr r2, [r3, #4 * ", $at, "]\n", "mov ", $sum, ", r2"),)*
                        "2:",
                        "ldr r3, [sp, #4]",
                        "adds r3, r0, r3",
                        "mov lr, r3",
                        "3:",
                        "ldrsh r2, [r1, r0]",
                        $(concat!("ldrh r3, [r0, #2 * ", $at, "]\n", "muls r3, r2, r3\n", "add ", $sum, ", r3"),)*
                        "adds r0, #2",
                        "cmp r0, lr",
                        "bne 3b",
                        "ldr r3, [sp, #8]",
                        "adds r0, r0, r3",
                        "subs r1, r1, r3",
                        "ldr r3, [sp, #12]",
                        "subs r3, #1",
                        "str r3, [sp, #12]",
                        "bne 2b",
                        "ldr r3, [sp, #16]",
                        $(concat!("mov r2, ", $sum, "\n", "str r2, [r3, #4 * ", $at, "]"),)*
                        "pop {{r2}}",
                        "mov r11, r2",
                        "add sp, #16",
                        "pop {{r6, r7}}",
                        inout("r0") numbers => _,
                        // Bytes from a number to its factor.
                        inout("r1") factors.addr().wrapping_sub(numbers.addr()) => _,
                        inout("r2") 2 * count => _,
                        inout("r3") 2 * (width - count) => _,
                        inout("r4") rows => _,
                        inout("r5") sums => _,
                        out("r8") _, out("r9") _, out("r10") _, out("r12") _, out("lr") _,
                    );
                }
                $n
            }
        }
    };
}

/// Defines a function that adds products to n neighbouring sums. Each number is loaded once for up to four factors.
#[cfg(not(all(smr_swar, target_arch = "arm")))]
macro_rules! slide {
    ($name:ident $n:literal: $($sum:literal $at:literal)*) => {
        impl Slide<i16> {
            /// # Safety
            /// `rows` rows of `count` factors can be read at `factors`, one after the other. Of as many rows at
            /// `numbers`, `width` apart, `count + n - 1` numbers can be read. `width` is at least `count`. n sums can
            /// be read and written at `to`. All addresses are aligned.
            #[inline(never)]
            unsafe fn $name(&self, to: *mut i32) -> usize {
                let Self { mut factors, count, mut numbers, width, rows } = *self;
                // SAFETY: `count` factors and the numbers under them are read, and n sums.
                unsafe {
                    let mut sums: [i32; $n] = to.cast::<[i32; $n]>().read();
                    for _ in rolled(0..rows) {
                        let mut left = count;
                        while left >= 4 {
                            let [a, b, c, d] = [0, 1, 2, 3].map(|at| i32::from(*factors.add(at)));
                            let [first, second, third] = [0, 1, 2].map(|at| i32::from(*numbers.add(at)));
                            $(
                                let fourth = i32::from(*numbers.add(3 + $at));
                                let sum = sums[$at].wrapping_add(a.wrapping_mul(first)).wrapping_add(b.wrapping_mul(second));
                                sums[$at] = in_order(sum.wrapping_add(c.wrapping_mul(third)).wrapping_add(d.wrapping_mul(fourth)));
                                let [first, second, third] = [second, third, fourth];
                            )*
                            let _ = [first, second, third];
                            (factors, numbers, left) = (factors.add(4), numbers.add(4), left - 4);
                        }
                        for _ in rolled(0..left) {
                            let factor = i32::from(*factors);
                            $(sums[$at] = in_order(sums[$at].wrapping_add(factor.wrapping_mul(i32::from(*numbers.add($at)))));)*
                            (factors, numbers) = (factors.add(1), numbers.add(1));
                        }
                        numbers = numbers.wrapping_add(width - count);
                    }
                    to.cast::<[i32; $n]>().write(sums);
                }
                $n
            }
        }
    };
}

slide!(one 1: "r4" 0);
slide!(three 3: "r4" 0 "r5" 1 "r6" 2);
slide!(four 4: "r4" 0 "r5" 1 "r6" 2 "r7" 3);
slide!(eight 8: "r4" 0 "r5" 1 "r6" 2 "r7" 3 "r8" 4 "r9" 5 "r10" 6 "r11" 7);
slide!(nine 9: "r4" 0 "r5" 1 "r6" 2 "r7" 3 "r8" 4 "r9" 5 "r10" 6 "r11" 7 "r12" 8);
