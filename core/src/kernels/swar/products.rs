//! Sums of products for processors without DSP or SIMD: several offsets at a time, which share the loads of weights and
//! of sums.
//!
//! Armv6-M cannot load a signed number from a place relative to an address. So each row of cells is copied as x + 128,
//! without a sign, and 128 times the sum of the other factors is subtracted. For the differences of cells that
//! responses take (`three_sums.rs`), it is 256 times. Sums may wrap before the subtraction.

use crate::kernels::cells::CHANNELS;
use crate::kernels::layout::{Layout, PACKED, Packed};
use crate::kernels::plain::products as plain;
use crate::kernels::three_sums::{Pairs, Rows};
use crate::kernels::unrolling::{in_order, rolled};
use core::ops::Range;

/// A part of the responses is two rows of cells.
pub(crate) const TAKES_ROWS_OF_CELLS: bool = true;
pub(crate) use plain::GATHER_PARTS;

const STEP: usize = CHANNELS;

/// Offsets that are computed at a time. With more, Armv6-M would not have a register for each sum.
const AT_ONCE: usize = 3;

/// The number added to a cell: it inverts the top bit.
const BIAS: i32 = 128;
const TOP: u8 = 0x80;

/// The number added to a difference of two cells.
const MIDDLE: i32 = 256;

/// Repeats the code for each channel. The compiler does not unroll a loop with assembly, which [`in_order`] contains.
macro_rules! for_each_channel {
    ($channel:ident => $code:block) => {
        for_each_channel! { $channel $code 0 1 2 3 4 5 6 7 8 9 }
    };
    ($channel:ident $code:block $($number:literal)*) => {$({
        const $channel: usize = $number;
        $code
    })*};
}

/// See [`plain::responses`]. A part is two rows of cells. The caller leaves `spare` as it is between parts.
pub(crate) fn responses<const N: usize>(
    parts: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    let Layout { row, stride, step, span } = layout;
    let down = layout.fits(cells.len(), weights.len()).unwrap_or(0);
    let (pairs, width) = (Pairs::new(layout, down), span.saturating_sub(1) * step + row);
    let has_room = size_of::<u16>() * width <= PACKED && pairs.both() * N <= PACKED / 4;
    let fits = down > 0 && span > 1 && span <= N && has_room;
    let (totals, spare) = spare.split_at_mut_checked(pairs.rows_of_factors()).unwrap_or_default();
    // SAFETY: a word may hold any two numbers.
    let spare = unsafe { spare.align_to_mut::<i16>().1 };
    let (true, Some(factors)) = (fits, spare.get_mut(..totals.len() * row)) else {
        return plain::responses(layout.whole(parts), room, &mut [], cells, layout, weights, out);
    };
    if parts.start == 0 {
        let of = |number: usize| weights.get(number * row..(number + 1) * row).unwrap_or_default();
        for (number, (to, total)) in factors.chunks_exact_mut(row.max(1)).zip(&mut *totals).enumerate() {
            let (first, second) = pairs.factors(number);
            let second = second.map(of).unwrap_or_default();
            *total = 0;
            for (at, (to, first)) in rolled(to.iter_mut().zip(of(first)).enumerate()) {
                *to = first + second.get(at).copied().unwrap_or(0);
                *total += MIDDLE * i32::from(*to);
            }
        }
    }
    let (differences, both) = room.words().split_at_mut(PACKED / 4);
    let both = both.as_chunks_mut().0.get_mut(..pairs.both()).unwrap_or_default();
    let mut rows = Differences {
        cells: cells.as_ptr(),
        stride,
        differences: differences.as_mut_ptr().cast(),
        width,
        factors: factors.as_ptr().cast(),
        totals,
        across: row / STEP,
    };
    pairs.responses(parts, &mut rows, both, out);
}

/// A row of cells, or of differences of two rows, each plus [`MIDDLE`]. `fits` has checked that all rows of cells are
/// there.
struct Differences<'a> {
    cells: *const i8,
    stride: usize,
    differences: *mut u16,
    /// Numbers in the row.
    width: usize,
    factors: *const [i16; STEP],
    /// [`MIDDLE`] times the sum of a row of factors, for each row.
    totals: &'a [i32],
    /// Cells in a row of factors.
    across: usize,
}

impl Rows for Differences<'_> {
    #[inline(always)]
    fn take(&mut self, first: usize, second: Option<usize>) {
        let Self { cells, stride, differences, width, .. } = *self;
        let of = |row: usize| cells.wrapping_add(row * stride);
        // SAFETY: the cells have these rows, and there is room for as many numbers.
        unsafe { subtract(differences, width / STEP, of(first), second.map(of)) };
    }

    #[inline(always)]
    fn add(&mut self, number: usize, mut sums: &mut [i32]) {
        let Self { differences, factors, totals, across, .. } = *self;
        let (mut numbers, total) = (differences.cast_const(), totals.get(number).copied().unwrap_or(0));
        // SAFETY: there is a row of factors, and at every offset it lies on the row of differences.
        unsafe {
            let factors = core::slice::from_raw_parts(factors.wrapping_add(number * across), across);
            // Takes three offsets at a time, but two if two or four are left: `responses` has checked that there is not
            // only one.
            while sums.len() > 1 {
                let count = if matches!(sums.len(), 2 | 4) { 2 } else { AT_ONCE };
                let Some((now, later)) = sums.split_at_mut_checked(count) else { return };
                if count == 2 {
                    add_responses::<2>(numbers, factors, total, now);
                } else {
                    add_responses::<AT_ONCE>(numbers, factors, total, now);
                }
                (numbers, sums) = (numbers.wrapping_add(count * STEP), later);
            }
        }
    }
}

/// Computes the numbers of `across` cells from `first`, less those from `second` if there are any, each plus
/// [`MIDDLE`].
///
/// # Safety
/// The numbers of these cells can be read, and as many numbers written.
#[inline(never)]
unsafe fn subtract(mut to: *mut u16, across: usize, mut first: *const i8, second: Option<*const i8>) {
    static ZEROES: [i8; STEP] = [0; STEP];
    let step = if second.is_some() { STEP } else { 0 };
    let mut second = second.unwrap_or(ZEROES.as_ptr());
    for _ in rolled(0..across) {
        for_each_channel!(CHANNEL => {
            // SAFETY: as the caller guarantees.
            unsafe {
                let [first, second] = [first, second].map(|from| i32::from(*from.wrapping_add(CHANNEL)));
                *to.wrapping_add(CHANNEL) = low(in_order(first - second + MIDDLE));
            }
        });
        (to, first, second) = (to.wrapping_add(STEP), first.wrapping_add(STEP), second.wrapping_add(step));
    }
}

/// The lower 16 bits.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // as named
fn low(number: i32) -> u16 {
    number as u16
}

/// Adds the products of a row of factors with the numbers at `COUNT` neighbouring offsets, less `total`.
///
/// # Safety
/// At each offset as many numbers as factors can be read.
#[inline(never)] // so that no other code needs a register
unsafe fn add_responses<const COUNT: usize>(
    mut numbers: *const u16,
    factors: &[[i16; STEP]],
    total: i32,
    out: &mut [i32],
) {
    let mut sums = [0i32; COUNT];
    for factors in rolled(factors.iter()) {
        for_each_channel!(CHANNEL => {
            let factor = i32::from(factors[CHANNEL]);
            for (sum, x) in sums.iter_mut().zip(offsets::<COUNT>()) {
                // SAFETY: as the caller guarantees.
                let number = i32::from(unsafe { *numbers.add(x + CHANNEL) });
                *sum = in_order(sum.wrapping_add(factor.wrapping_mul(number)));
            }
        });
        numbers = numbers.wrapping_add(STEP);
    }
    out.iter_mut().zip(sums).for_each(|(out, sum)| *out = out.wrapping_add(sum).wrapping_sub(total));
}

/// See [`plain::gather`]. A part is two rows of cells.
pub(crate) fn gather<const N: usize>(
    parts: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    let Layout { row, stride, step, span } = layout;
    let width = span.saturating_sub(1) * step + row;
    let has_room = width <= size_of::<Packed>() && span <= N && errors.len() >= span;
    if layout.fits(cells.len(), sums.len()).is_none() || span < 4 || !has_room {
        return plain::gather(layout.whole(parts), room, spare, cells, layout, errors, sums);
    }
    for number in 2 * parts.start..layout.rows(sums.len()).min(2 * parts.end) {
        let Some(of_row) = cells.get(number * stride..number * stride + width) else { return };
        let biased = room.0.as_mut_ptr().cast::<u8>();
        // SAFETY: `fits` has checked that there is room for a row.
        let copy = unsafe { core::slice::from_raw_parts_mut(biased, width) };
        rolled(copy.iter_mut().zip(of_row)).for_each(|(to, from)| *to = from.cast_unsigned() ^ TOP);
        // Visits each row of sums that lies on this row of cells at some offset.
        for (y, sums) in sums.chunks_exact_mut(row.max(1)).enumerate() {
            let Some(errors) = number.checked_sub(y).filter(|&y| y < span).and_then(|y| errors.get(y)?.get(..span))
            else {
                continue;
            };
            let (mut cells, (sums, _)) = (biased.cast_const(), sums.as_chunks_mut::<STEP>());
            let bias = BIAS * rolled(errors.iter()).map(|&error| i32::from(error)).sum::<i32>();
            let mut errors = errors;
            // Takes three errors at a time, but two at the end. Only there the bias is subtracted.
            while let [one, two, later @ ..] = errors {
                // SAFETY: a row of the filter lies on the copied cells at every offset.
                unsafe {
                    match later {
                        [three, rest @ ..] if !matches!(later.len(), 2 | 4) => {
                            gather_at(cells, &[*one, *two, *three], 0, sums);
                            (cells, errors) = (cells.wrapping_add(AT_ONCE * STEP), rest);
                        }
                        _ => {
                            gather_at(cells, &[*one, *two], if later.is_empty() { bias } else { 0 }, sums);
                            (cells, errors) = (cells.wrapping_add(2 * STEP), later);
                        }
                    }
                }
            }
        }
    }
}

/// Adds the products of `COUNT` neighbouring errors with their cells to each sum, and subtracts `bias`.
///
/// # Safety
/// At each offset as many cells as sums can be read.
#[inline(never)]
unsafe fn gather_at<const COUNT: usize>(
    mut cells: *const u8,
    errors: &[i16; COUNT],
    bias: i32,
    sums: &mut [[i32; STEP]],
) {
    let errors = errors.map(i32::from);
    for sums in rolled(sums.iter_mut()) {
        for_each_channel!(CHANNEL => {
            let mut sum = if COUNT < AT_ONCE { sums[CHANNEL].wrapping_sub(bias) } else { sums[CHANNEL] };
            for (x, error) in offsets::<COUNT>().into_iter().zip(errors) {
                // SAFETY: as the caller guarantees.
                let cell = i32::from(unsafe { *cells.add(x + CHANNEL) });
                sum = in_order(sum.wrapping_add(error.wrapping_mul(cell)));
            }
            sums[CHANNEL] = sum;
        });
        cells = cells.wrapping_add(STEP);
    }
}

/// The places of the first cells at neighbouring offsets.
fn offsets<const COUNT: usize>() -> [usize; COUNT] {
    core::array::from_fn(|x| x * STEP)
}
