//! The ranges of blocks of pixels: of each block of 4x4 pixels its lowest and its highest one, or what a backend stores
//! instead. They bound the scores of groups of offsets.

use crate::image::Image;

/// Memory for rows of ranges.
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
    /// The index of the range that the first pixel of a template is compared with.
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
