//! Score kernels common to the DSP extension and Helium, which each define their loops over pixels ([`Loops`]).
//!
//! Both sum bytes fast, but look up a table pixel by pixel. So two bounds, which exclude offsets, only sum bytes:
//!
//! - [`Loops::OUTSIDE_RANGES`] counts the pixels beyond the threshold at every offset of a 4x4 group.
//! - [`Loops::POINT_MARGINS`] sums the points of four offsets (`points.rs`).

use super::points::{OFFSETS, Points};
use crate::image::Image;
use crate::kernels::cut_table::CutTable;
use crate::kernels::plain::scores::{self as plain, Plain};
use crate::kernels::rows::Rows;
use crate::kernels::scores::{Blocks, Effort, ONE, Scores};
use core::marker::PhantomData;

/// Loops of an instruction set over the pixels of two pictures with at least `NARROWEST` columns and one row.
pub(crate) trait Loops {
    /// Minimum width of a picture in columns. If it is more than one, the loops fill up the last words of both rows
    /// with zeroes. These pixels have difference 0 and count as [`ONE`] each, so the first table entry must be [`ONE`].
    const NARROWEST: usize;
    /// Maps (rows, 256 table entries, floor) to the score if it is at least `floor`, else to any number below `floor`.
    ///
    /// # Safety
    /// `width` pixels, at least `NARROWEST`, can be read in each row of patch and template, and 256 entries in the
    /// table.
    const REACHABLE: unsafe fn(&Rows, *const u16, u32) -> u32;
    /// Maps (rows, enough) to the sum of absolute differences. The loop may stop once the sum exceeds `enough`.
    ///
    /// # Safety
    /// `width` pixels, at least `NARROWEST`, can be read in each row of patch and template.
    const DISTANCE: unsafe fn(&Rows, u32) -> u32;
    /// Maps (rows, allowed) to the number of template pixels outside their ranges. May stop once it exceeds `allowed`.
    /// `Rows::patch` holds the lower ends of the ranges, `Rows::high` the lengths, with the same stride.
    ///
    /// # Safety
    /// `width` bytes, at least `NARROWEST`, can be read in each row of lower ends, of lengths (with
    /// `Rows::patch_stride`) and of the template.
    const OUTSIDE_RANGES: unsafe fn(&Rows, u32) -> u32;
    /// Maps (rows, constants, needed, wanted) to the points (`points.rs`) of four offsets minus `needed`. A result is
    /// negative only if its offset has fewer points than `needed`, or a 0 bit in `wanted`.
    ///
    /// # Safety
    /// `width` pixels, at least `NARROWEST`, can be read in each row of the template, and three more in each row of the
    /// patch.
    const POINT_MARGINS: unsafe fn(&Rows, &Points, u32, u8) -> [i32; OFFSETS];
    /// Takes (rows, margin, low, lengths). Computes the lower ends and the lengths of the pixel ranges of 4x4 blocks,
    /// widened by `margin` on both sides. Does nothing if there are fewer blocks than `NARROWEST`.
    const RANGES: fn(&[&[u8]; 4], u8, &mut [u8], &mut [u8]);
}

/// The score kernels that run the loops `L`, with a similarity table.
pub(crate) struct Kernels<'a, L> {
    plain: Plain<'a>,
    points: Effort,
    loops: PhantomData<L>,
}

impl<'a, L: Loops> Kernels<'a, L> {
    #[inline(always)]
    pub(crate) fn new(table: &'a CutTable) -> Self {
        Self { plain: Plain { table }, points: Effort::NEW, loops: PhantomData }
    }

    #[inline(always)]
    fn can_take(width: usize) -> bool {
        L::NARROWEST == 1 || width >= L::NARROWEST
    }
}

impl<L: Loops> Scores for Kernels<'_, L> {
    #[inline(never)]
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let (pair, table) = (Rows::of(patch, template), self.plain.table);
        if !Self::can_take(pair.width) || L::NARROWEST > 1 && table.threshold() == 0 {
            return self.plain.score_at_least(patch, template, floor);
        }
        // SAFETY: both pictures are borrowed and have at least `NARROWEST` columns; a table has 256 entries.
        let reachable = unsafe { (L::REACHABLE)(&pair, table.entries().as_ptr(), floor) };
        Some(reachable).filter(|&score| score >= floor)
    }

    /// # Safety
    /// The patch has at least as many rows as the template, and three more columns.
    #[inline(never)]
    unsafe fn candidates(&self, patch: Image<'_>, template: Image<'_>, floor: u32, wanted: u8) -> u8 {
        let (rows, points) = (Rows::of(patch, template), self.plain.table.points());
        let needed = points.needed(floor, rows.pixels_after(0));
        if needed == 0 || !Self::can_take(rows.width) || !self.points.is_worth_it() {
            return wanted;
        }
        // SAFETY: both pictures are borrowed and have at least `NARROWEST` columns, and the patch has three more columns
        // than the template.
        let margins = unsafe { (L::POINT_MARGINS)(&rows, points, needed, wanted) };
        let candidates = margins.iter().rev().fold(0, |mask, margin| mask << 1 | u8::from(*margin >= 0));
        self.points.note(candidates != wanted);
        candidates
    }

    #[inline(never)]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let pair = Rows::of(patch, template);
        if !Self::can_take(pair.width) {
            return narrow_distance(patch, template, enough);
        }
        // SAFETY: both pictures are borrowed and have at least `NARROWEST` columns.
        unsafe { (L::DISTANCE)(&pair, enough) }
    }

    /// Computes ranges as [`Loops::OUTSIDE_RANGES`] reads them: widened by the largest difference below the threshold.
    #[inline(never)]
    fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        let margin = u8::try_from(self.plain.table.threshold().saturating_sub(1)).unwrap_or(u8::MAX);
        (L::RANGES)(rows, margin, low, high);
    }

    #[inline(never)]
    fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let Some(rows) = Rows::of_blocks(blocks, template) else { return Some(plain::most(template, template)) };
        let full = rows.full_after(0);
        let allowed = rows.pixels_after(0).checked_sub(Rows::pixels_of(floor))?;
        let some_count = (1..256).contains(&self.plain.table.threshold());
        if !some_count || !Self::can_take(rows.width) {
            return Some(full);
        }
        // SAFETY: the template has at least `NARROWEST` columns. `of_blocks` found a range for each of its pixels, and
        // gave both halves of the ranges the same stride.
        let misses = unsafe { (L::OUTSIDE_RANGES)(&rows, allowed) };
        (misses <= allowed).then(|| full.wrapping_sub(misses.wrapping_mul(u32::from(ONE))))
    }
}

/// Computes the distance of narrow pictures. In a separate function, so that the usual case need not save registers.
#[cold]
#[inline(never)]
fn narrow_distance(patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
    plain::distance(patch, template, enough)
}

/// Number of 4x4 blocks in the four rows, but at most the length of `low` and of `high`. Blocks overlap: each begins
/// one column after the block before it.
#[inline]
pub(crate) fn blocks(rows: &[&[u8]; 4], low: &[u8], high: &[u8]) -> usize {
    rows.iter().fold(low.len().min(high.len()), |blocks, row| blocks.min(row.len().saturating_sub(3)))
}
