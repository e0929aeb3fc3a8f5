//! What the backends for Arm's microcontrollers share: the table as they look it up, and a bound of the score that needs none.
//!
//! A pixel that counts and differs by d loses at least c * d of its 65535 ([`CutTable::chord`]), one that does not loses all.
//! How many do not, and the sum of the differences of those that do, are sums of bytes, and that is what these instruction
//! sets are fast at; a table they can only look up pixel by pixel. So a group of offsets is bounded by this alone.

use crate::kernels::cut_table::CutTable;
use crate::kernels::plain::scores::Plain;
use crate::kernels::rows::Rows;

/// What is looked up, pixel by pixel.
pub(crate) struct Lookup<'a> {
    pub(crate) plain: Plain<'a>,
}

/// When pictures are excluded: once their pixels have lost more than `allowed`.
pub(crate) struct Limit {
    /// A pixel counts if it differs by less: 1..=255.
    pub(crate) threshold: u8,
    /// What a pixel that counts loses with each gray level. One that does not count loses 65535.
    pub(crate) chord: u32,
    pub(crate) allowed: u32,
}

/// What two pictures lose at least; once that is more than is allowed, any part of it that is.
pub(crate) type Loss = fn(&Rows, &Limit) -> u32;

impl<'a> Lookup<'a> {
    #[inline(always)] // see `Scorer::new`
    pub(crate) fn new(table: &'a CutTable) -> Self {
        Self { plain: Plain { table } }
    }

    pub(crate) fn entries(&self) -> *const u16 {
        self.plain.table.entries().as_ptr()
    }

    /// The score that `rows` reach at most, if that is at least `floor`. `loss` is asked of pictures of at least
    /// `NARROWEST` columns.
    #[inline(always)] // into the one function of a backend that calls it
    pub(crate) fn most<const NARROWEST: usize>(&self, rows: &Rows, floor: u32, loss: Loss) -> Option<u32> {
        let full = rows.full_after(0);
        let allowed = full.checked_sub(floor)?;
        let threshold = u8::try_from(self.plain.table.threshold()).unwrap_or(0);
        // Of what is too narrow for the loop, and of pixels that all count or none, nothing is known.
        if threshold == 0 || rows.width < NARROWEST || rows.patch_stride != rows.high_stride {
            return Some(full);
        }
        let loss = loss(rows, &Limit { threshold, chord: self.plain.table.chord(), allowed });
        full.checked_sub(loss).filter(|&most| most >= floor)
    }
}

/// How many blocks of 4x4 pixels, side by side, four rows have the pixels and `low` and `high` the room for.
#[inline]
pub(crate) fn blocks(rows: &[&[u8]; 4], low: &[u8], high: &[u8]) -> usize {
    rows.iter().fold(low.len().min(high.len()), |blocks, row| blocks.min(row.len().saturating_sub(3)))
}
