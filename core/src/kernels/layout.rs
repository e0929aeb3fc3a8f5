//! Cell size of the robust tracker's features, sizes of a correlation filter on the cells, and scratch memory.

use core::ops::Range;

/// Side of a feature cell, in pixels of the resampled frame.
pub const CELL: u16 = 4;
/// Feature channels of a cell, one byte each.
pub const CHANNELS: usize = 10;
/// Side of a cell with its border of neighbouring pixels, in pixels.
pub(crate) const SIDE: usize = CELL as usize + 2;
/// Length of [`Packed`]: two 16-bit numbers for each byte of a row of 48 cells.
pub(crate) const PACKED: usize = 960;

/// Scratch memory into which a backend may unpack feature bytes before it multiplies them.
#[repr(align(4))]
pub(crate) struct Packed(pub(crate) [u16; PACKED]);

impl Packed {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self([0; PACKED])
    }

    #[allow(dead_code)] // for backends that multiply pairs
    pub(crate) fn words(&mut self) -> &mut [i32; PACKED / 2] {
        // SAFETY: the memory is aligned for words and as long, and a word may have any value.
        unsafe { &mut *(&raw mut self.0).cast() }
    }
}

/// Sizes of a correlation filter, and of the rows of feature bytes over which it slides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Number of weights in a row of the filter: one for each feature byte under the row.
    pub(crate) row: usize,
    /// Bytes from a row of cells to the next one.
    pub(crate) stride: usize,
    /// Bytes from a filter offset to its right neighbour.
    pub(crate) step: usize,
    /// Number of filter offsets on each axis.
    pub(crate) span: usize,
}

impl Layout {
    /// Returns the height in rows of a filter of `weights` weights. `None` unless its rows consist of whole cells, and
    /// at each offset it lies within the `cells` feature bytes.
    #[cfg_attr(smr_small, inline(never))]
    #[allow(dead_code)] // for backends that do not check each access
    pub(crate) fn checked_height(self, cells: usize, weights: usize) -> Option<usize> {
        let Self { row, stride, step, span } = self;
        let whole = step == CHANNELS && row > 0 && row.is_multiple_of(step) && weights.is_multiple_of(row) && span > 0;
        let down = weights.checked_div(row).filter(|&down| whole && down > 0)?;
        // Checked arithmetic, because backends rely on the result and read the cells without bounds checks.
        let last_row = (down - 1).checked_add(span - 1)?.checked_mul(stride)?;
        let last = last_row.checked_add((span - 1).checked_mul(step)?)?;
        (last.checked_add(row)? <= cells).then_some(down)
    }

    /// Returns all rows of offsets if `pieces` starts at 0, else none. For the plain loop where it replaces a faster
    /// loop whose pieces of work are not rows of offsets.
    #[allow(dead_code)] // for backends whose pieces are not rows of offsets
    pub(crate) fn all_rows_in_first_piece(self, pieces: Range<usize>) -> Range<usize> {
        if pieces.start == 0 { 0..self.span } else { 0..0 }
    }

    /// Number of rows of cells that a filter of `weights` weights covers at all offsets together.
    #[allow(dead_code)] // for backends that go row by row of cells
    pub(crate) fn rows(self, weights: usize) -> usize {
        weights.checked_div(self.row).unwrap_or(0) + self.span.saturating_sub(1)
    }

    /// Number of multiplications of a weight by a feature byte of row `row` of the cells, over all offsets.
    #[allow(dead_code)] // as above
    pub(crate) fn work_on(self, row: usize, weights: usize) -> usize {
        let down = weights.checked_div(self.row).unwrap_or(0);
        let meets = (row + 1).min(down).min(self.span).min(self.rows(weights).saturating_sub(row));
        meets * self.span * self.row
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

    /// A filter of 2x2 cells at 3x3 offsets lies on 4x4 cells.
    #[test]
    fn a_filter_fits_if_it_lies_on_its_cells_at_each_offset() {
        let layout = Layout { row: 2 * CHANNELS, stride: 4 * CHANNELS, step: CHANNELS, span: 3 };
        assert_eq!(layout.checked_height(16 * CHANNELS, 4 * CHANNELS), Some(2));
        assert_eq!(layout.checked_height(16 * CHANNELS - 1, 4 * CHANNELS), None);
        assert_eq!(layout.checked_height(16 * CHANNELS, 4 * CHANNELS - 1), None);
        // With wrapping arithmetic these layouts would seem to fit.
        for huge in [Layout { stride: usize::MAX / 4 + 1, ..layout }, Layout { span: usize::MAX, ..layout }] {
            assert_eq!(huge.checked_height(16 * CHANNELS, 4 * CHANNELS), None);
        }
    }
}
