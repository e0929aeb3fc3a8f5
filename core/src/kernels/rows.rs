//! Row addresses of two pictures, for loops without bounds checks.

use super::scores::{Blocks, ONE};
use crate::image::Image;

/// Rows of a patch (or of two pictures that bound it) and a template, cropped to their common top left part.
///
/// [`Image::rows`] checks the end of the slice in every row. For a row that fits in one register, the check costs as
/// much as the row itself. So this holds addresses: a kernel may read `width` bytes of each row and no more.
#[derive(Clone, Copy)]
pub(crate) struct Rows {
    pub(crate) patch: *const u8,
    /// The upper bound of the patch; equal to `patch` if the patch itself is known.
    #[cfg_attr(smr_swar, allow(dead_code))] // bounds have loops of their own there
    pub(crate) high: *const u8,
    pub(crate) template: *const u8,
    pub(crate) patch_stride: usize,
    #[cfg_attr(smr_swar, allow(dead_code))]
    pub(crate) high_stride: usize,
    pub(crate) template_stride: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Rows {
    #[inline]
    pub(crate) fn of(patch: Image<'_>, template: Image<'_>) -> Self {
        let ((f, patch_stride), (g, template_stride)) = (patch.parts(), template.parts());
        Self {
            patch: f.as_ptr(),
            high: f.as_ptr(),
            template: g.as_ptr(),
            patch_stride,
            high_stride: patch_stride,
            template_stride,
            width: usize::from(patch.width().min(template.width())),
            height: usize::from(patch.height().min(template.height())),
        }
    }

    /// Rows of a template, and of the pixel ranges to compare with it. `None` if there are fewer ranges than pixels.
    #[inline(always)]
    #[cfg_attr(smr_swar, allow(dead_code))]
    pub(crate) fn of_blocks(blocks: &Blocks<'_>, template: Image<'_>) -> Option<Self> {
        let template = Self::of(template, template);
        let above = (template.height - 1).saturating_mul(blocks.stride);
        let end = above.saturating_add(blocks.start.saturating_add(template.width));
        (end <= blocks.low.len().min(blocks.high.len())).then(|| Self {
            patch: blocks.low.as_ptr().wrapping_add(blocks.start),
            high: blocks.high.as_ptr().wrapping_add(blocks.start),
            patch_stride: blocks.stride,
            high_stride: blocks.stride,
            ..template
        })
    }

    /// The largest possible score of the rows from `y` on. It fits in a `u32`.
    #[inline]
    pub(crate) fn full_after(&self, y: usize) -> u32 {
        u32::from(ONE).wrapping_mul(self.pixels_after(y))
    }

    #[inline]
    pub(crate) fn pixels_after(&self, y: usize) -> u32 {
        #[allow(clippy::cast_possible_truncation)] // at most MAX_PIXELS
        {
            self.width.wrapping_mul(self.height.wrapping_sub(y)) as u32
        }
    }

    /// Minimum number of pixels with which a score can reach `floor`.
    #[inline]
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))] // for kernels that count pixels
    pub(crate) const fn pixels_of(floor: u32) -> u32 {
        floor.div_ceil(ONE as u32)
    }

    /// Addresses of row `y` of the patch and of the template. If `y < height`, `width` bytes can be read there as long
    /// as the pictures live: [`Image::with_stride`] has checked that.
    #[inline]
    #[cfg_attr(target_arch = "arm", allow(dead_code))] // loops there are assembly
    pub(crate) fn row(&self, y: usize) -> (*const u8, *const u8) {
        (place(self.patch, self.patch_stride, y), place(self.template, self.template_stride, y))
    }

    #[inline]
    #[cfg_attr(any(target_arch = "arm", smr_swar), allow(dead_code))]
    pub(crate) fn high_row(&self, y: usize) -> *const u8 {
        place(self.high, self.high_stride, y)
    }
}

#[inline]
#[cfg_attr(target_arch = "arm", allow(dead_code))]
fn place(first: *const u8, stride: usize, y: usize) -> *const u8 {
    first.wrapping_add(y.wrapping_mul(stride))
}
