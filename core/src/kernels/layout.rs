//! How the weights of a filter lie on the bytes of cells, and the scratch memory of sums of products.

/// Numbers that a backend may put together before it multiplies: for the bytes in a row of 48 cells two each.
pub(crate) const ROOM: usize = 960;
pub(crate) type Room = [u16; ROOM];

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
