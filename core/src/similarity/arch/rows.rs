//! The rows of two pictures side by side, as cheap to go through as two addresses.

use super::super::Table;
use crate::image::Image;

/// The common top left part of two pictures.
///
/// [`Image::rows`] looks for the end of the slice in every row. Where a row is one register that costs as much as the row,
/// so here are addresses: kernels read `width` bytes from each, and may not read more.
#[derive(Clone, Copy)]
pub(super) struct Rows {
    patch: *const u8,
    template: *const u8,
    patch_stride: usize,
    template_stride: usize,
    /// Bytes in a row of both.
    pub(super) width: usize,
    /// Rows of both.
    pub(super) height: usize,
}

impl Rows {
    #[inline]
    pub(super) fn of(patch: Image<'_>, template: Image<'_>) -> Self {
        let (f, patch_stride) = patch.parts();
        let (g, template_stride) = template.parts();
        Self {
            patch: f.as_ptr(),
            template: g.as_ptr(),
            patch_stride,
            template_stride,
            width: usize::from(patch.width().min(template.width())),
            height: usize::from(patch.height().min(template.height())),
        }
    }

    /// The score of equal rows from `y` on; it fits a `u32` for as many pixels as a template may have.
    #[inline]
    pub(super) fn full_after(&self, y: usize) -> u32 {
        let pixels = self.width.wrapping_mul(self.height.wrapping_sub(y));
        #[allow(clippy::cast_possible_truncation)] // at most Table::MAX_PIXELS
        u32::from(Table::ONE).wrapping_mul(pixels as u32)
    }

    /// Where row `y` of both begins: as long as the pictures live, there are `width` readable bytes if `y` < `height`.
    ///
    /// That is what [`Image::with_stride`] has checked.
    #[inline]
    pub(super) fn row(&self, y: usize) -> (*const u8, *const u8) {
        let place = |first: *const u8, stride: usize| first.wrapping_add(y.wrapping_mul(stride));
        (place(self.patch, self.patch_stride), place(self.template, self.template_stride))
    }
}
