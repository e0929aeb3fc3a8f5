//! The rows of two pictures side by side, as cheap to go through as two addresses.

use super::cut_table::ONE;
use crate::image::Image;

/// The common top left part of a template and of a patch, or of the two pictures that a patch is between.
///
/// [`Image::rows`] looks for the end of the slice in every row. Where a row is one register that costs as much as the row,
/// so here are addresses: kernels read `width` bytes from each, and may not read more.
#[derive(Clone, Copy)]
pub(crate) struct Rows {
    pub(crate) patch: *const u8,
    /// What the patch is at most; of a patch that is known, itself.
    pub(crate) high: *const u8,
    pub(crate) template: *const u8,
    pub(crate) patch_stride: usize,
    pub(crate) high_stride: usize,
    pub(crate) template_stride: usize,
    /// Bytes in a row of all.
    pub(crate) width: usize,
    /// Rows of all.
    pub(crate) height: usize,
}

impl Rows {
    #[inline]
    pub(crate) fn of(patch: Image<'_>, template: Image<'_>) -> Self {
        Self::between(patch, patch, template)
    }

    #[inline]
    pub(crate) fn between(low: Image<'_>, high: Image<'_>, template: Image<'_>) -> Self {
        let ((l, patch_stride), (h, high_stride), (g, template_stride)) = (low.parts(), high.parts(), template.parts());
        Self {
            patch: l.as_ptr(),
            high: h.as_ptr(),
            template: g.as_ptr(),
            patch_stride,
            high_stride,
            template_stride,
            width: usize::from(low.width().min(high.width()).min(template.width())),
            height: usize::from(low.height().min(high.height()).min(template.height())),
        }
    }

    /// Of every row the first pixels, `width` at most.
    #[inline]
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))] // for SSE2
    pub(crate) fn first(&self, width: usize) -> Self {
        Self { width: self.width.min(width), ..*self }
    }

    /// The score of equal rows from `y` on; it fits a `u32` for as many pixels as a template may have.
    #[inline]
    pub(crate) fn full_after(&self, y: usize) -> u32 {
        u32::from(ONE).wrapping_mul(self.pixels_after(y))
    }

    /// Pixels in the rows from `y` on.
    #[inline]
    pub(crate) fn pixels_after(&self, y: usize) -> u32 {
        #[allow(clippy::cast_possible_truncation)] // at most MAX_PIXELS
        {
            self.width.wrapping_mul(self.height.wrapping_sub(y)) as u32
        }
    }

    /// The least number of equal pixels whose score is at least `floor`.
    #[inline]
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))] // for those that count, with little time between looks
    pub(crate) const fn pixels_of(floor: u32) -> u32 {
        floor.div_ceil(ONE as u32)
    }

    /// Where row `y` of patch and template begins: as long as the pictures live, there are `width` readable bytes if `y` <
    /// `height`.
    ///
    /// That is what [`Image::with_stride`] has checked.
    #[inline]
    #[cfg_attr(target_arch = "arm", allow(dead_code))] // whole loops are asm! there
    pub(crate) fn row(&self, y: usize) -> (*const u8, *const u8) {
        (place(self.patch, self.patch_stride, y), place(self.template, self.template_stride, y))
    }

    /// The same of what the patch is at most.
    #[inline]
    #[cfg_attr(target_arch = "arm", allow(dead_code))]
    pub(crate) fn high_row(&self, y: usize) -> *const u8 {
        place(self.high, self.high_stride, y)
    }
}

#[inline]
#[cfg_attr(target_arch = "arm", allow(dead_code))]
fn place(first: *const u8, stride: usize, y: usize) -> *const u8 {
    first.wrapping_add(y.wrapping_mul(stride))
}
