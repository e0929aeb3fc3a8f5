//! The rows of two pictures side by side, as cheap to go through as two addresses.

use crate::image::Image;
use core::ops::Range;

/// The common top left part of two pictures.
///
/// [`Image::rows`] looks for the end of the slice in every row. Where a row is one register that costs as much as the row,
/// so here are addresses: kernels read `width` bytes from each, and may not read more.
#[derive(Clone, Copy)]
pub(super) struct Rows {
    pub(super) patch: *const u8,
    pub(super) template: *const u8,
    pub(super) patch_stride: usize,
    pub(super) template_stride: usize,
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

    /// All rows in blocks of `size`, the last of which may be smaller.
    #[inline]
    pub(super) fn blocks(&self, size: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let height = self.height;
        (0..height).step_by(size).map(move |first| first..height.min(first + size))
    }

    /// Gives `compare` the addresses of each two rows, from the top and as long as it says true.
    #[inline(always)]
    #[cfg_attr(target_arch = "x86_64", allow(dead_code))] // there, rows are looked at in blocks
    pub(super) fn each(&self, mut compare: impl FnMut(*const u8, *const u8) -> bool) {
        for y in 0..self.height {
            let (f, g) = self.row(y);
            if !compare(f, g) {
                return;
            }
        }
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
