//! The kernels that a backend of SMR has: scores, distances, and bounds that exclude offsets.

use crate::image::Image;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// All four offsets, one bit for each: see [`Scores::candidates`].
pub(crate) const ALL_FOUR: u8 = 0b1111;

/// Memory for rows of ranges: the lowest and the highest pixel of each 4x4 block, or what a backend stores instead.
/// They bound the scores of groups of offsets.
#[cfg_attr(any(smr_dsp, smr_helium, smr_swar), allow(dead_code))] // for backends that use vectors
pub(crate) struct RowsOfRanges<'a> {
    pub(crate) low: &'a mut [u8],
    pub(crate) high: &'a mut [u8],
    /// Bytes from row to row.
    pub(crate) stride: usize,
}

/// Rows of ranges.
#[derive(Clone, Copy)]
pub(crate) struct Blocks<'a> {
    pub(crate) low: &'a [u8],
    pub(crate) high: &'a [u8],
    /// The index, in `low` and `high`, of the range of the template's first pixel.
    pub(crate) start: usize,
    /// Bytes from row to row, a multiple of four.
    pub(crate) stride: usize,
}

impl<'a> Blocks<'a> {
    /// The lower and the upper bounds of a patch, of the size of `template`.
    #[cfg_attr(any(smr_dsp, smr_helium), allow(dead_code))]
    pub(crate) fn pictures(&self, template: Image<'_>) -> Option<(Image<'a>, Image<'a>)> {
        let (width, height) = (template.width(), template.height());
        let low = Image::with_stride(self.low.get(self.start..)?, width, height, self.stride).ok()?;
        Some((low, low.like(self.high.get(self.start..)?)?))
    }
}

/// The kernels of SMR. For each of them the function of the same name in `plain/scores.rs` is the specification.
pub(crate) trait Scores {
    /// The score. It is a separate method, so that a program that never uses a floor does not link the bounds.
    #[inline(always)]
    fn score(&self, patch: Image<'_>, template: Image<'_>) -> u32 {
        self.score_at_least(patch, template, 0).unwrap_or(0)
    }

    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32>;

    /// The offsets among the `wanted` of four that may score at least `floor`. Bit i is cleared only if the offset i
    /// columns to the right cannot. The patch has three more columns than the template. Backends without a fast way
    /// return all of them.
    #[inline(always)]
    fn candidates(&self, _patch: Image<'_>, _template: Image<'_>, _floor: u32, wanted: u8) -> u8 {
        wanted
    }

    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32;

    /// Computes the ranges of 4x4 blocks for [`Scores::bound`]. A backend may store them in a form of its own.
    fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]);

    /// Computes the ranges for all blocks of `pixels`, every `step`th row. Returns false, and does nothing, if this
    /// backend does not compute them faster than row by row.
    #[inline(always)]
    fn ranges_of_rows(&self, _pixels: Image<'_>, _step: usize, _to: &mut RowsOfRanges<'_>) -> bool {
        false
    }

    /// An upper bound of the score of every patch between `blocks`, which [`Scores::ranges`] has computed; `None` if it
    /// is less than `floor`.
    fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32>;
}

/// Decides how often a bound is computed. While it excludes nothing, it is computed less and less often, in the end one
/// time in 64. So a bound that never helps costs 1/64 of its time. The fields are atomic, so that a scorer can be
/// shared. No result depends on them.
#[allow(dead_code)] // not every target has a backend that bounds four offsets
pub(crate) struct Effort {
    /// The number of times that the loop goes on without the bound.
    without: AtomicU8,
    /// One set bit for each successive time that the bound excluded nothing, at most six.
    in_vain: AtomicU8,
}

#[allow(dead_code)]
impl Effort {
    #[allow(clippy::declare_interior_mutable_const)] // each use is a new one
    pub(crate) const NEW: Self = Self { without: AtomicU8::new(0), in_vain: AtomicU8::new(0) };

    /// True if the bound is to be computed this time.
    #[inline(always)]
    pub(crate) fn is_worth_it(&self) -> bool {
        let left = self.without.load(Relaxed).checked_sub(1);
        if let Some(without) = left {
            self.without.store(without, Relaxed);
        }
        left.is_none()
    }

    #[inline(always)]
    pub(crate) fn note(&self, excluded: bool) {
        let in_vain = if excluded { 0 } else { (self.in_vain.load(Relaxed) << 1 | 1) & 63 };
        self.in_vain.store(in_vain, Relaxed);
        self.without.store(in_vain, Relaxed);
    }
}
