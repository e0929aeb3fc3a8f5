//! Sums of products by the DSP extension: `smlad` adds two products of 16 bits.
//!
//! A row of the filter that slides along a row of numbers is all there is to it: offsets side by side share each weight, and
//! what lies under it slides from one offset's register to the next one's, so that each number is loaded once for all of them.
//!
//! - Responses: bytes become numbers of 16 bits, row by row; a pair is two channels of a cell.
//! - Gathering: errors are the filter, and a pair is a byte and the one below it, of two rows that were put together.

use crate::similarity::products::{self, Layout};
use core::arch::asm;
use core::ptr;

/// Bytes from an offset to the next one: those of a cell.
const STEP: usize = 10;
/// The most bytes in a row of cells that are slid along here: 48 cells.
const ROW: usize = 48 * STEP;
/// The most offsets on an axis for which errors are gathered here.
const SPAN: usize = 13;

/// See [`products::responses`].
pub(super) fn responses<const N: usize>(cells: &[i8], layout: Layout, weights: &[i16], out: &mut [[i32; N]]) {
    let Layout { row, stride, step, span } = layout;
    let used = row + span.saturating_sub(1) * step;
    let whole = step == STEP && row > 0 && row.is_multiple_of(STEP) && weights.len().is_multiple_of(row);
    let down = weights.len().checked_div(row).unwrap_or(0);
    let rows = down + span.saturating_sub(1);
    let needed = rows.saturating_sub(1) * stride + used;
    if !whole || down == 0 || span == 0 || span > N || out.len() < span || used > ROW || cells.len() < needed {
        return products::responses(cells, layout, weights, out);
    }
    out.iter_mut().take(span).for_each(|out| out.fill(0));
    let mut wide = [0i16; ROW];
    for number in 0..rows {
        let from = cells.get(number * stride..).unwrap_or_default();
        wide.iter_mut().zip(from).take(used).for_each(|(wide, &cell)| *wide = cell.into());
        // The rows of weights that lie on this row of cells at some offset.
        for (y, weights) in weights.chunks_exact(row.max(1)).enumerate() {
            let Some(out) = number.checked_sub(y).filter(|&y| y < span).and_then(|y| out.get_mut(y)) else { continue };
            let (mut at, cells) = (0, row / STEP);
            while at < span {
                let block = Block {
                    filter: weights.as_ptr().cast(),
                    under: wide.as_ptr().cast::<u8>().wrapping_add(at * 2 * STEP),
                    sums: out.as_mut_ptr().wrapping_add(at),
                    count: cells,
                };
                // SAFETY: the filter has `cells` cells of weights; `under` is followed by as many and the block's offsets less
                // one; of `out`, `at` and the block's offsets are at most `span`.
                at += unsafe { block.of_at_most::<5, { 2 * STEP }, { 2 * STEP }, 1>(span - at) };
            }
        }
    }
}

/// See [`products::gather`].
pub(super) fn gather<const N: usize>(cells: &[i8], layout: Layout, errors: &[[i16; N]], sums: &mut [i32]) {
    let Layout { row, stride, step, span } = layout;
    let used = row + span.saturating_sub(1) * step;
    let whole = step == STEP && row > 0 && row.is_multiple_of(STEP) && sums.len().is_multiple_of(row);
    let down = sums.len().checked_div(row).unwrap_or(0);
    let rows = down + span.saturating_sub(1);
    let needed = rows.saturating_sub(1) * stride + used;
    let room = span > 0 && span <= N.min(SPAN) && errors.len() >= span && used <= ROW;
    if !whole || !room || down == 0 || cells.len() < needed {
        return products::gather(cells, layout, errors, sums);
    }
    let pair = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
    let mut both = [0u32; ROW];
    for number in (0..rows).step_by(2) {
        let upper = cells.get(number * stride..number * stride + used).unwrap_or_default();
        // What lies below the last row meets no error.
        let lower = cells.get((number + 1) * stride..).and_then(|lower| lower.get(..used)).unwrap_or(upper);
        for ((both, &upper), &lower) in both.iter_mut().zip(upper).zip(lower) {
            *both = pair(i16::from(upper).cast_unsigned(), i16::from(lower).cast_unsigned());
        }
        for (y, sums) in sums.chunks_exact_mut(row.max(1)).enumerate() {
            // The errors at the offsets where this row of sums lies on the two rows of cells.
            let of = |number: usize| number.checked_sub(y).filter(|&y| y < span).and_then(|y| errors.get(y));
            let (first, second) = (of(number), of(number + 1));
            if first.is_none() && second.is_none() {
                continue;
            }
            let mut filter = [0u32; SPAN];
            let error = |errors: Option<&[i16; N]>, x: usize| {
                errors.and_then(|errors| errors.get(x)).map_or(0, |error| error.cast_unsigned())
            };
            for (x, filter) in filter.iter_mut().enumerate().take(span) {
                *filter = pair(error(first, x), error(second, x));
            }
            let across = row / STEP;
            for channel in 0..STEP {
                let mut at = 0;
                while at < across {
                    let block = Block {
                        filter: filter.as_ptr().cast(),
                        under: both.as_ptr().wrapping_add(at * STEP + channel).cast(),
                        sums: sums.as_mut_ptr().wrapping_add(at * STEP + channel),
                        count: span,
                    };
                    // SAFETY: the filter has `span` errors; `under` is followed by as many cells and the block's less one; of
                    // the row of sums, `at` and the block's cells are at most all.
                    at += unsafe { block.of_at_most::<1, 4, { 4 * STEP }, STEP>(across - at) };
                }
            }
        }
    }
}

/// Sums side by side, and what is added to them: a filter of `count` pairs, and what lies under it at the first of them.
#[derive(Clone, Copy)]
struct Block {
    filter: *const u8,
    under: *const u8,
    sums: *mut i32,
    count: usize,
}

impl Block {
    /// Five sums, or what is left of them where there are fewer than five; says how many.
    ///
    /// # Safety
    /// As [`Block::slide`] for as many.
    #[inline(always)]
    unsafe fn of_at_most<const PAIRS: usize, const F: usize, const U: usize, const S: usize>(
        self,
        left: usize,
    ) -> usize {
        // SAFETY: the caller has seen to it.
        unsafe {
            match left {
                0 => 0,
                1 => self.slide::<1, PAIRS, F, U, S>(),
                2 => self.slide::<2, PAIRS, F, U, S>(),
                3 => self.slide::<3, PAIRS, F, U, S>(),
                4 | 7 | 8 => self.slide::<4, PAIRS, F, U, S>(),
                _ => self.slide::<5, PAIRS, F, U, S>(),
            }
        }
    }

    /// Adds to `N` sums, which are `S` numbers apart: to each the products of the filter and what lies under it; `U` bytes on,
    /// that of the next sum lies. Pairs of the filter are `F` bytes apart, and `PAIRS` such filters follow each other. Returns `N`.
    ///
    /// # Safety
    /// `filter` can be read so often, `under` for N - 1 more, and `sums` can be written to; only `sums` must be aligned.
    #[inline(never)]
    unsafe fn slide<const N: usize, const PAIRS: usize, const F: usize, const U: usize, const S: usize>(self) -> usize {
        let Self { filter, under, sums, count } = self;
        let mut sum = [0; N];
        for (at, sum) in sum.iter_mut().enumerate() {
            // SAFETY: there are N sums, so far apart.
            *sum = unsafe { sums.wrapping_add(at * S).read() };
        }
        for pair in 0..PAIRS {
            let (mut filter, mut under) = (filter.wrapping_add(4 * pair), under.wrapping_add(4 * pair));
            let mut window = [0; N];
            for slot in window.iter_mut().take(N - 1) {
                // SAFETY: N - 1 more than `count` can be read.
                *slot = unsafe { load::<U>(&mut under) };
            }
            let mut left = count;
            'all: loop {
                // Each round leaves the window as it was, turned once around.
                for turn in 0..N {
                    if left == 0 {
                        break 'all;
                    }
                    left -= 1;
                    // SAFETY: this is done `count` times.
                    let weight = unsafe { load::<F>(&mut filter) };
                    // SAFETY: as above.
                    window[(turn + N - 1) % N] = unsafe { load::<U>(&mut under) };
                    for (at, sum) in sum.iter_mut().enumerate() {
                        *sum = smlad(window[(turn + at) % N], weight, *sum);
                    }
                }
            }
        }
        for (at, sum) in sum.into_iter().enumerate() {
            // SAFETY: as above.
            unsafe { sums.wrapping_add(at * S).write(sum) };
        }
        N
    }
}

/// A pair, and on by so many bytes.
///
/// # Safety
/// It can be read.
#[inline(always)]
unsafe fn load<const STEP: usize>(at: &mut *const u8) -> u32 {
    // SAFETY: the caller has seen to it; it need not be aligned.
    let pair = unsafe { ptr::read_unaligned(at.cast::<u32>()) };
    *at = at.wrapping_add(STEP);
    pair
}

/// `sum` and the products of both halves.
#[inline(always)]
fn smlad(a: u32, b: u32, sum: i32) -> i32 {
    let result;
    // SAFETY: it only computes; the flag of overflow is not said to be kept.
    unsafe {
        asm!("smlad {sum}, {a}, {b}, {sum}", a = in(reg) a, b = in(reg) b, sum = inout(reg) sum => result,
            options(pure, nomem, nostack));
    }
    result
}
