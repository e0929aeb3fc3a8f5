//! Loops that add over all pixels: the score, and the sum of absolute differences.

use super::lookup::LookUp;
use super::row_loops::{ROWS_A_LOOK, whole};
use super::vector::Vector;
use crate::kernels::rows::Rows;

struct Sums<V: Vector> {
    low: V::Total,
    high: V::Total,
}

/// The score if it is at least `floor`, else `None`: see the pseudo-code of the folder.
///
/// # Safety
/// The processor has the instruction set of the vector. `rows.width` pixels can be read in each row of the patch and
/// the template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
pub(crate) unsafe fn sum_at_least<L: LookUp, const WHOLE: usize, const END: bool>(
    table: &L,
    rows: &Rows,
    floor: u32,
) -> Option<u32> {
    // SAFETY: the processor has the instruction set, and y is below the height, so the row has its `width` pixels.
    unsafe {
        let end = L::Vector::end::<WHOLE>(rows.width);
        // Two sets of totals, so that the additions of a row need not wait for those of the row before.
        let nothing = L::Vector::nothing();
        let mut even = Sums::<L::Vector> { low: nothing, high: nothing };
        let mut odd = Sums { low: nothing, high: nothing };
        let mut y = 0;
        while y < rows.height {
            add_row::<L, WHOLE, END>(table, rows, y, end, &mut even);
            if y + 1 < rows.height {
                add_row::<L, WHOLE, END>(table, rows, y + 1, end, &mut odd);
                let left = rows.full_after(y + 2);
                if left < floor && y % ROWS_A_LOOK == ROWS_A_LOOK - 2 && score(&even, &odd) + left < floor {
                    return None;
                }
            }
            y += 2;
        }
        Some(score(&even, &odd)).filter(|&score| score >= floor)
    }
}

/// Adds the table entries of row `y`. `end` is the mask [`Vector::end`] of the row.
///
/// # Safety
/// `y` is below `rows.height`. `rows.width` pixels can be read in this row of the patch and the template.
/// `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
unsafe fn add_row<L: LookUp, const WHOLE: usize, const END: bool>(
    table: &L,
    rows: &Rows,
    y: usize,
    end: L::Vector,
    sums: &mut Sums<L::Vector>,
) {
    // SAFETY: `end` exists, so the processor has the instruction set. No vector ends beyond the `width` of the row.
    unsafe {
        let (f, g) = rows.row(y);
        let mut at = 0;
        while at < whole::<L::Vector, WHOLE>(rows.width) {
            let (f, g) = (L::Vector::load(f.wrapping_add(at)), L::Vector::load(g.wrapping_add(at)));
            let (low, high) = table.look_up(L::Vector::difference(f, g));
            sums.low = L::Vector::add(sums.low, low);
            sums.high = L::Vector::add(sums.high, high);
            at += L::Vector::LANES;
        }
        if END {
            let f = L::Vector::load_end::<WHOLE>(f, rows.width);
            let g = L::Vector::load_end::<WHOLE>(g, rows.width);
            let (low, high) = table.look_up(L::Vector::difference(f, g));
            sums.low = L::Vector::add(sums.low, L::Vector::keep(low, end));
            sums.high = L::Vector::add(sums.high, L::Vector::keep(high, end));
        }
    }
}

/// The score: the total of low bytes plus 256 times the total of high bytes. It fits in a `u32` for every template.
#[inline(always)]
fn score<V: Vector>(even: &Sums<V>, odd: &Sums<V>) -> u32 {
    V::across(V::plus(V::plus(even.low, odd.low), V::times_256(V::plus(even.high, odd.high))))
}

/// The sum of absolute differences. Stops once it exceeds `enough`.
///
/// # Safety
/// The processor has the instruction set of the vector. `rows.width` pixels can be read in each row of the patch and
/// the template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
pub(crate) unsafe fn distance<V: Vector, const WHOLE: usize, const END: bool>(rows: &Rows, enough: u32) -> u32 {
    // SAFETY: the processor has the instruction set, and y is below the height, so the row has its `width` pixels.
    unsafe {
        let (end, mut sum) = (V::end::<WHOLE>(rows.width), V::nothing());
        let mut y = 0;
        while y + ROWS_A_LOOK <= rows.height {
            for row in y..y + ROWS_A_LOOK {
                sum = add_row_distance::<V, WHOLE, END>(rows, row, end, sum);
            }
            if V::across(sum) > enough {
                return V::across(sum);
            }
            y += ROWS_A_LOOK;
        }
        while y < rows.height {
            sum = add_row_distance::<V, WHOLE, END>(rows, y, end, sum);
            y += 1;
        }
        V::across(sum)
    }
}

/// Adds the absolute differences in row `y` to `sum`. `end` is the mask [`Vector::end`] of the row.
///
/// # Safety
/// `y` is below `rows.height`. `rows.width` pixels can be read in this row of the patch and the template.
/// `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
unsafe fn add_row_distance<V: Vector, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    y: usize,
    end: V,
    mut sum: V::Total,
) -> V::Total {
    // SAFETY: `end` exists, so the processor has the instruction set. No vector ends beyond the `width` of the row.
    unsafe {
        let (f, g) = rows.row(y);
        let mut at = 0;
        while at < whole::<V, WHOLE>(rows.width) {
            sum = V::add_distance(sum, V::load(f.wrapping_add(at)), V::load(g.wrapping_add(at)));
            at += V::LANES;
        }
        if END {
            let f = V::keep(V::load_end::<WHOLE>(f, rows.width), end);
            let g = V::keep(V::load_end::<WHOLE>(g, rows.width), end);
            sum = V::add_distance(sum, f, g);
        }
        sum
    }
}
