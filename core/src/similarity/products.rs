//! Sums of products: bytes, as the filter sees a picture, times numbers of 16 bits. The plain loops; they specify what a backend
//! computes.

/// Numbers that a backend may put together before it multiplies: for the bytes in a row of 48 cells two each.
pub(crate) const ROOM: usize = 960;
pub(crate) type Room = [u16; ROOM];

use super::arch::rolled_if_spare;
use core::ops::Range;

/// How a filter lies on bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Bytes under a row of the filter.
    pub(crate) row: usize,
    /// Bytes from there to those under its next row; also from an offset to the next one below.
    pub(crate) stride: usize,
    /// Bytes from an offset to the next one to the right.
    pub(crate) step: usize,
    /// Offsets on each axis.
    pub(crate) span: usize,
}

impl Layout {
    /// Rows of cells that a filter of so many weights lies on at one offset or another.
    #[allow(dead_code)] // for backends that go by them
    pub(crate) fn rows(self, weights: usize) -> usize {
        weights.checked_div(self.row).unwrap_or(0) + self.span.saturating_sub(1)
    }

    /// Products of so many weights with the bytes in such a row of cells.
    #[allow(dead_code)] // as above
    pub(crate) fn work_on(self, row: usize, weights: usize) -> usize {
        let down = weights.checked_div(self.row).unwrap_or(0);
        let meets = (row + 1).min(down).min(self.span).min(self.rows(weights).saturating_sub(row));
        meets * self.span * self.row
    }
}

/// `out[y][x]` is the sum over all weights of `weight * byte` at the offset (x, y).
///
/// A part is a row of offsets. No sum may leave an `i32`: at most 2000 weights of at most 8191 reach 2000 * 8191 * 128 < 2^31.
#[inline(always)] // a backend compiles it for its own instruction set
pub(crate) fn responses<const N: usize>(
    parts: Range<usize>,
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    let Layout { row, stride, step, span } = layout;
    for y in parts.start..parts.end.min(span) {
        let Some(out) = out.get_mut(y) else { return };
        for (x, out) in out.iter_mut().take(span).enumerate() {
            let rows = weights.chunks(row.max(1)).zip((y * stride + x * step..).step_by(stride.max(1)));
            *out = rows.map(|(weights, from)| dot(cells.get(from..).unwrap_or_default(), weights)).sum();
        }
    }
}

#[inline(always)]
fn dot(cells: &[i8], weights: &[i16]) -> i32 {
    rolled_if_spare(cells.iter().zip(weights)).map(|(&cell, &weight)| i32::from(cell) * i32::from(weight)).sum()
}

/// The other way round: to each weight's sum the products of all `errors` with the byte that the weight lies on at that offset.
///
/// A part is a row of errors. No sum may leave an `i32`: 17 * 17 errors of at most 16383 reach 289 * 16383 * 128 < 2^31.
#[inline(always)]
pub(crate) fn gather<const N: usize>(
    parts: Range<usize>,
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    let Layout { row, stride, step, span } = layout;
    for y in parts.start..parts.end.min(span) {
        let Some(errors) = errors.get(y) else { return };
        for (sums, from) in sums.chunks_mut(row.max(1)).zip((y * stride..).step_by(stride.max(1))) {
            for (x, &error) in errors.iter().take(span).enumerate() {
                let cells = cells.get(from + x * step..).unwrap_or_default();
                for (sum, &cell) in rolled_if_spare(sums.iter_mut().zip(cells)) {
                    *sum += i32::from(error) * i32::from(cell);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_cells_have_all_products() {
        for (down, span) in [(1, 1), (4, 17), (20, 17), (25, 3), (6, 13)] {
            let layout = Layout { row: 70, stride: 0, step: 10, span };
            let all: usize = (0..layout.rows(70 * down) + 2).map(|row| layout.work_on(row, 70 * down)).sum();
            assert_eq!(all, span * span * 70 * down, "{down} {span}");
        }
    }
}
