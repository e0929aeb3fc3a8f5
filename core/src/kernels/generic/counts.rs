//! Loops that count pixels, and so exclude offsets before their scores are computed.

use super::ranges::half;
use super::row_loops::{ANY, ROWS_A_LOOK, whole};
use super::vector::{Neighbours, Vector};
use crate::kernels::rows::Rows;
use crate::kernels::scores::ONE;

/// Upper bound of a score: 65535 for each pixel inside its range (as [`widen`](super::ranges::widen) encodes it). `None` once too many pixels
/// are outside to reach `floor`.
///
/// # Safety
/// The processor has the instruction set of the vector. `rows.width` bytes can be read in each row of the patch, of its
/// upper bound (`rows.high`) and of the template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
pub(crate) unsafe fn inside_at_least<V: Vector, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    floor: u32,
) -> Option<u32> {
    // SAFETY: the processor has the instruction set, and y is below the height, so the row has its `width` pixels.
    unsafe {
        let end = V::end::<WHOLE>(rows.width);
        let pixels = rows.pixels_after(0);
        let allowed = pixels.checked_sub(Rows::pixels_of(floor))?;
        let mut count = Count { bytes: V::splat(0), flushed: 0 };
        let mut y = 0;
        while y + ROWS_A_LOOK <= rows.height {
            for row in y..y + ROWS_A_LOOK {
                count_outside::<V, WHOLE, END>(rows, row, end, &mut count);
            }
            count.flush();
            if count.flushed > allowed {
                return None;
            }
            y += ROWS_A_LOOK;
        }
        while y < rows.height {
            count_outside::<V, WHOLE, END>(rows, y, end, &mut count);
            y += 1;
        }
        count.flush();
        if count.flushed > allowed { None } else { Some((pixels - count.flushed) * u32::from(ONE)) }
    }
}

/// Counts the pixels of row `y` that are outside their ranges. `end` is the mask [`Vector::end`] of the row.
///
/// # Safety
/// `y` is below `rows.height`. `rows.width` bytes can be read in this row of the patch, of its upper bound
/// (`rows.high`) and of the template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
unsafe fn count_outside<V: Vector, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    y: usize,
    end: V,
    count: &mut Count<V>,
) {
    // SAFETY: `end` exists, so the processor has the instruction set. No vector ends beyond the `width` of the row.
    unsafe {
        let ((low, g), span) = (rows.row(y), rows.high_row(y));
        let mut at = 0;
        while at < whole::<V, WHOLE>(rows.width) {
            let above = V::minus(V::load(g.wrapping_add(at)), V::load(low.wrapping_add(at)));
            count.add(V::is_above(above, V::load(span.wrapping_add(at))));
            at += V::LANES;
            if WHOLE == ANY && at.is_multiple_of(Count::<V>::MAX * V::LANES) {
                count.flush();
            }
        }
        if END {
            let low = V::load_end::<WHOLE>(low, rows.width);
            let span = V::load_end::<WHOLE>(span, rows.width);
            let above = V::minus(V::load_end::<WHOLE>(g, rows.width), low);
            count.add(V::keep(V::is_above(above, span), end));
        }
        if WHOLE == ANY {
            count.flush();
        }
    }
}

/// Bit mask of four neighbouring offsets: a bit is set if the score at its offset may reach `floor`. Counts the pixels
/// beyond the threshold at each offset. Each vector of the template is loaded and converted to ranges once.
///
/// # Safety
/// The processor has the instruction set of the vector. `rows.width` pixels can be read in each row of the template,
/// and three more in each row of the patch. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
pub(crate) unsafe fn candidates<V: Neighbours, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    last: u8,
    floor: u32,
) -> u8 {
    // SAFETY: the processor has the instruction set, and y is below the height, so the row has its `width` pixels.
    unsafe {
        let (end, last) = (V::end::<WHOLE>(rows.width), V::splat(last));
        let Some(allowed) = rows.pixels_after(0).checked_sub(Rows::pixels_of(floor)) else { return 0 };
        let mut counts = [Count { bytes: V::splat(0), flushed: 0 }; 4];
        let mut y = 0;
        while y < rows.height {
            let until = rows.height.min(y + ROWS_A_LOOK);
            while y < until {
                count_of_four::<V, WHOLE, END>(rows, y, end, last, &mut counts);
                y += 1;
            }
            if within(&mut counts, allowed) == 0 {
                return 0;
            }
        }
        within(&mut counts, allowed)
    }
}

/// Counts the pixels of row `y` that are beyond the threshold, at each of four offsets. `end` is the mask
/// [`Vector::end`] of the row.
///
/// # Safety
/// `y` is below `rows.height`. `rows.width` pixels can be read in this row of the template, and three more in that of
/// the patch. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
#[inline(always)]
unsafe fn count_of_four<V: Neighbours, const WHOLE: usize, const END: bool>(
    rows: &Rows,
    y: usize,
    end: V,
    last: V,
    counts: &mut [Count<V>; 4],
) {
    // SAFETY: `end` exists, so the processor has the instruction set. No vector ends beyond the `width` of the row, or
    // in the patch three columns further.
    unsafe {
        let (f, g) = rows.row(y);
        let mut at = 0;
        while at < whole::<V, WHOLE>(rows.width) {
            let (highest, span) = around(V::load(g.wrapping_add(at)), last);
            for (column, count) in counts.iter_mut().enumerate() {
                let below = V::minus(highest, V::load(f.wrapping_add(at + column)));
                count.add(V::is_above(below, span));
            }
            at += V::LANES;
            if WHOLE == ANY && at.is_multiple_of(Count::<V>::MAX * V::LANES) {
                flush_all(counts);
            }
        }
        if END {
            let (highest, span) = around(V::load_end::<WHOLE>(g, rows.width), last);
            for (column, count) in counts.iter_mut().enumerate() {
                let f = V::load_end::<WHOLE>(f.wrapping_add(column), rows.width);
                count.add(V::keep(V::is_above(V::minus(highest, f), span), end));
            }
        }
        if WHOLE == ANY {
            flush_all(counts);
        }
    }
}

/// Encodes the range of all pixels f within the threshold of `g`: f is inside if the first result minus f, as a signed
/// byte, is at most the second result.
#[inline(always)]
fn around<V: Neighbours>(g: V, last: V) -> (V, V) {
    let highest = V::minus(V::raised(g, last), half(g));
    (highest, V::minus(highest, V::saturating_sub(g, last)))
}

#[inline(always)]
fn flush_all<V: Vector>(counts: &mut [Count<V>; 4]) {
    for count in counts {
        count.flush();
    }
}

/// One bit for each count, set if the count is at most `allowed`.
#[inline(always)]
fn within<V: Vector>(counts: &mut [Count<V>; 4], allowed: u32) -> u8 {
    flush_all(counts);
    let mut within = 0;
    for (column, count) in counts.iter().enumerate() {
        within |= u8::from(count.flushed <= allowed) << column;
    }
    within
}

/// Number of pixels that passed a comparison.
#[derive(Clone, Copy)]
struct Count<V> {
    /// Count of each lane since the last flush, at most 255.
    bytes: V,
    flushed: u32,
}

impl<V: Vector> Count<V> {
    /// Number of vectors of a row between two flushes: a power of two, below the 255 that a lane can count.
    const MAX: usize = 128;

    /// Adds 1 in each lane that is 255 in `counts`. The other lanes of `counts` are 0.
    #[inline(always)]
    fn add(&mut self, counts: V) {
        self.bytes = V::minus(self.bytes, counts); // 255 is -1
    }

    #[inline(always)]
    fn flush(&mut self) {
        // SAFETY: `bytes` exists, so the processor has the instruction set.
        unsafe {
            self.flushed += V::across(V::add(V::nothing(), self.bytes));
            self.bytes = V::splat(0);
        }
    }
}
