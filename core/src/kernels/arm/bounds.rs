//! The bounds of scores on Arm's microcontrollers. `candidates.rs` and `groups.rs` of each instruction set compute two
//! of them. The third one bounds the score of every patch between two pictures: a full score less the least loss of its
//! pixels.
//!
//! A pixel that counts and differs by d loses at least c * d of its 65535 (c: [`CutTable::chord`]). A pixel that does
//! not count loses all. So the bound needs two sums of bytes: the number of pixels that do not count, and the
//! differences of the others. These instruction sets sum bytes fast, but look up a table pixel by pixel.

use super::points::{OFFSETS, Points};
use crate::image::Image;
use crate::kernels::blocks::Blocks;
use crate::kernels::cut_table::CutTable;
use crate::kernels::effort::Effort;
use crate::kernels::one::ONE;
use crate::kernels::plain::scores::{self as plain, Plain};
use crate::kernels::rows::Rows;

/// A table that these kernels look up pixel by pixel.
pub(crate) struct Lookup<'a> {
    pub(crate) plain: Plain<'a>,
}

/// The limits of a loss. A patch is excluded once its pixels have lost more than `allowed`.
pub(crate) struct Limit {
    /// A pixel counts if its difference is less than this: 1..=255.
    pub(crate) threshold: u8,
    /// The loss of a pixel that counts, for each gray level of difference. A pixel that does not count loses 65535.
    pub(crate) chord: u32,
    pub(crate) allowed: u32,
}

/// A function that computes the least loss of two pictures. Once that is more than allowed, it may stop.
pub(crate) type Loss = fn(&Rows, &Limit) -> u32;

impl<'a> Lookup<'a> {
    #[inline(always)] // see `Scorer::new`
    pub(crate) fn new(table: &'a CutTable) -> Self {
        Self { plain: Plain { table } }
    }

    pub(crate) fn entries(&self) -> *const u16 {
        self.plain.table.entries().as_ptr()
    }

    /// The largest difference of a pixel that counts.
    pub(crate) fn margin(&self) -> u8 {
        u8::try_from(self.plain.table.threshold().saturating_sub(1)).unwrap_or(u8::MAX)
    }

    /// An upper bound of the score of a group, if it is at least `floor`. Calls `misses`, which counts the
    /// pixels that cannot count, only if there are at least `NARROWEST` columns.
    #[inline(always)]
    pub(crate) fn bound<const NARROWEST: usize>(
        &self,
        blocks: &Blocks<'_>,
        template: Image<'_>,
        floor: u32,
        misses: unsafe fn(&Rows, u32) -> u32,
    ) -> Option<u32> {
        let Some(rows) = Rows::of_blocks(blocks, template) else { return Some(plain::most(template, template)) };
        let full = rows.full_after(0);
        let allowed = rows.pixels_after(0).checked_sub(Rows::pixels_of(floor))?;
        let some_count = (1..256).contains(&self.plain.table.threshold());
        if !some_count || rows.width < NARROWEST {
            return Some(full);
        }
        // SAFETY: there are enough columns, and both halves of the ranges have the same stride.
        let misses = unsafe { misses(&rows, allowed) };
        (misses <= allowed).then(|| full.wrapping_sub(misses.wrapping_mul(u32::from(ONE))))
    }

    /// The offsets among the `wanted` of four that may score at least `floor`; all of them if the bound is not worth
    /// its time. It calls `spare` only if there are at least `NARROWEST` columns.
    #[inline(always)]
    pub(crate) fn candidates<const NARROWEST: usize>(
        &self,
        rows: &Rows,
        (floor, wanted): (u32, u8),
        effort: &Effort,
        spare: unsafe fn(&Rows, &Points, u32, u8) -> [i32; OFFSETS],
    ) -> u8 {
        let points = self.plain.table.points();
        let needed = points.needed(floor, rows.pixels_after(0), self.plain.table.chord());
        if needed == 0 || rows.width < NARROWEST || !effort.is_worth_it() {
            return wanted;
        }
        // SAFETY: there are enough columns. The patch of `Scores::candidates` has three more than the template.
        let spare = unsafe { spare(rows, points, needed, wanted) };
        let candidates = spare.iter().rev().fold(0, |mask, spare| mask << 1 | u8::from(*spare >= 0));
        effort.note(candidates != wanted);
        candidates
    }

    /// An upper bound of the score of `rows`, if it is at least `floor`. It calls `loss` only if there are at least
    /// `NARROWEST` columns.
    #[inline(always)] // into the one function of a backend that calls it
    pub(crate) fn most<const NARROWEST: usize>(&self, rows: &Rows, floor: u32, loss: Loss) -> Option<u32> {
        let full = rows.full_after(0);
        let allowed = full.checked_sub(floor)?;
        let threshold = u8::try_from(self.plain.table.threshold()).unwrap_or(0);
        // No bound is computed for rows too narrow for the loop, or if all pixels count or none does.
        if threshold == 0 || rows.width < NARROWEST || rows.patch_stride != rows.high_stride {
            return Some(full);
        }
        let loss = loss(rows, &Limit { threshold, chord: self.plain.table.chord(), allowed });
        full.checked_sub(loss).filter(|&most| most >= floor)
    }
}

/// The number of 4x4 blocks, one for each column, in the four rows and with room in `low` and `high`.
#[inline]
pub(crate) fn blocks(rows: &[&[u8]; 4], low: &[u8], high: &[u8]) -> usize {
    rows.iter().fold(low.len().min(high.len()), |blocks, row| blocks.min(row.len().saturating_sub(3)))
}
