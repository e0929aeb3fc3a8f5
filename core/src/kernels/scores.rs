//! The similarity kernels of a backend, as a trait (scores, distances, and upper bounds that exclude offsets), and the
//! unit of similarities.

use crate::image::Image;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// The similarity of equal pixels: 1.0, which tables store as 65535.
pub(crate) const ONE: u16 = u16::MAX;

/// Maximum number of pixels whose similarities a `u32` can sum: 65537.
pub(crate) const MAX_PIXELS: usize = u32::MAX as usize / ONE as usize;

/// Bit mask of all four neighbouring offsets of [`Scores::candidates`].
pub(crate) const ALL_FOUR: u8 = 0b1111;

/// Output of [`Scores::ranges_of_rows`]: lowest and highest pixel of 4x4 blocks, as the backend encodes them.
#[cfg_attr(any(smr_dsp, smr_helium, smr_swar), allow(dead_code))] // for backends that use vectors
pub(crate) struct RowsOfRanges<'a> {
    pub(crate) low: &'a mut [u8],
    pub(crate) high: &'a mut [u8],
    pub(crate) stride: usize,
}

/// Pixel ranges of 4x4 blocks: the lowest and the highest pixel, as the backend encodes them.
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
    /// The lower and the upper bounds of a patch as pictures of the size of `template`.
    #[cfg_attr(any(smr_dsp, smr_helium), allow(dead_code))]
    pub(crate) fn pictures(&self, template: Image<'_>) -> Option<(Image<'a>, Image<'a>)> {
        let (width, height) = (template.width(), template.height());
        let low = Image::with_stride(self.low.get(self.start..)?, width, height, self.stride).ok()?;
        Some((low, low.like(self.high.get(self.start..)?)?))
    }
}

/// The similarity kernels. Their implementation in `plain/scores.rs` is the specification.
pub(crate) trait Scores {
    /// The score without a floor. Separate from `score_at_least`: a program without floors then links no bounds.
    #[inline(always)]
    fn score(&self, patch: Image<'_>, template: Image<'_>) -> u32 {
        self.score_at_least(patch, template, 0).unwrap_or(0)
    }

    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32>;

    /// Returns `wanted`, a bit for each of four neighbouring offsets, with some bits cleared. Bit i is the offset i
    /// columns to the right; it is cleared only if the score there cannot reach `floor`. Backends without a fast bound
    /// return `wanted`.
    ///
    /// # Safety
    /// The patch has at least as many rows as the template, and three more columns.
    #[inline(always)]
    unsafe fn candidates(&self, _patch: Image<'_>, _template: Image<'_>, _floor: u32, wanted: u8) -> u8 {
        wanted
    }

    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32;

    /// Computes the lowest and the highest pixel of 4x4 blocks for [`Scores::bound`], as the backend encodes them.
    fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]);

    /// Computes the pixel ranges of the 4x4 blocks that begin in every `step`th row of `pixels`. Returns false, and
    /// does nothing, if this backend does not compute them faster than row by row.
    #[inline(always)]
    fn ranges_of_rows(&self, _pixels: Image<'_>, _step: usize, _to: &mut RowsOfRanges<'_>) -> bool {
        false
    }

    /// Upper bound of the score of every patch with pixels in the ranges `blocks`, which [`Scores::ranges`] has
    /// computed. `None` if it is below `floor`.
    fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32>;
}

/// Decides how often a bound is computed: less and less often while it excludes no offset, down to one call in 64, so
/// that a useless bound costs little. Atomic, so that a scorer can be shared. No result depends on it.
#[allow(dead_code)] // not every target has a backend that bounds four offsets
pub(crate) struct Effort {
    /// Number of calls, from the next one on, that skip the bound.
    without: AtomicU8,
    /// Bit mask: one set bit for each bound since the last one that excluded an offset, at most six bits.
    in_vain: AtomicU8,
}

#[allow(dead_code)]
impl Effort {
    #[allow(clippy::declare_interior_mutable_const)] // each use is a new one
    pub(crate) const NEW: Self = Self { without: AtomicU8::new(0), in_vain: AtomicU8::new(0) };

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
