//! The rows of two pictures by address, for loops that load whole words and so gain nothing from the bounds of slices.

use crate::image::Image;

/// Two pictures, as far as they have common rows and columns.
pub(super) struct Pair {
    pub(super) patch: Rows,
    pub(super) template: Rows,
    pub(super) width: usize,
    pub(super) height: usize,
}

/// The rows of one picture.
pub(super) struct Rows {
    /// The address of the first row.
    pub(super) first: *const u8,
    pub(super) stride: usize,
}

impl Pair {
    #[inline(always)]
    pub(super) fn new(patch: Image<'_>, template: Image<'_>) -> Self {
        Self {
            patch: Rows::of(patch),
            template: Rows::of(template),
            width: usize::from(patch.width().min(template.width())),
            height: usize::from(patch.height().min(template.height())),
        }
    }
}

impl Rows {
    /// An [`Image`] has been checked to have all bytes of all its rows.
    #[inline(always)]
    fn of(image: Image<'_>) -> Self {
        let mut rests = image.rows_and_rest();
        // SAFETY: no image is without rows.
        let first = unsafe { rests.next().unwrap_unchecked() };
        // Where there is no second row no stride is needed.
        let stride = first.len() - rests.next().map_or(first.len(), <[u8]>::len);
        Self { first: first.as_ptr(), stride }
    }
}
