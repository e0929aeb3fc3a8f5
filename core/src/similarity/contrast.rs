//! The contrast of a patch, by which `paper/gate.rs` and `robust/verification/lighting.rs` detect a covered lens. The
//! picture of a covered lens can match the template well, but has less contrast than the target.

use crate::image::Image;
use crate::kernels::deviation;

/// The rounded mean gray level of a patch and the exact sum of absolute deviations from this rounded mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Contrast {
    pub(crate) pixels: u32,
    pub(crate) mean: u32,
    pub(crate) deviation: u32,
    /// The number of pixels of gray level 0 or 255.
    clipped: u32,
}

impl Contrast {
    /// Stands for a contrast that is not known.
    pub(crate) const NONE: Self = Self { pixels: 0, mean: 0, deviation: 0, clipped: 0 };

    /// Computes the contrast of at most 65537 pixels. 256 times the largest gray sum (65537 * 255) fits in a `u32`.
    #[inline(never)]
    pub(crate) fn of(pixels: Image<'_>) -> Self {
        let from = |level| {
            let rows = (0..pixels.height()).map(|y| deviation(pixels.row(y), level));
            rows.fold([0; 2], |[sum, clipped], [of_row, clipped_of_row]| [sum + of_row, clipped + clipped_of_row])
        };
        let count = u32::from(pixels.width()) * u32::from(pixels.height());
        let [sum, _] = from(0);
        let mean = (sum + count / 2) / count.max(1);
        let [level, ..] = mean.to_le_bytes(); // a mean of bytes is a byte
        let [deviation, clipped] = from(level);
        Self { pixels: count, mean, deviation, clipped }
    }

    /// True only if, for every target of this size, `has_contrast_of` is true and `is_more_clipped_than` false.
    pub(crate) const fn is_enough_for_any(&self) -> bool {
        LARGEST_CONTRAST_RATIO * self.deviation >= MAX_DEVIATION * self.pixels && 2 * self.clipped <= self.pixels
    }

    /// True if the patch has at least a quarter of the contrast of `target`, which has the same number of pixels.
    pub(crate) const fn has_contrast_of(&self, target: Self) -> bool {
        LARGEST_CONTRAST_RATIO * self.deviation >= target.deviation
    }

    /// True if the clipped pixels exceed those of `target` (of the same size) by more than half of all pixels.
    pub(crate) const fn is_more_clipped_than(&self, target: Self) -> bool {
        self.clipped > self.pixels / 2 + target.clipped
    }
}

/// The largest possible mean absolute deviation (127.5, if half of the pixels are 0 and half are 255), rounded up.
const MAX_DEVIATION: u32 = 128;
/// The largest ratio of the target's contrast to the contrast of a patch that may still show the target.
pub(crate) const LARGEST_CONTRAST_RATIO: u32 = 4;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::similarity::Table;
    use std::vec::Vec;

    #[test]
    fn little_contrast_and_pixels_that_are_clipped_are_noticed() {
        let contrast = |pixels: &[u8]| Contrast::of(Image::new(pixels, 4, 1).unwrap());
        let target = contrast(&[60, 140, 60, 140]);
        let has_contrast = |pixels: &[u8; 4]| contrast(pixels).has_contrast_of(target);
        assert!(has_contrast(&[90, 110, 90, 110]) && !has_contrast(&[90, 109, 90, 110]), "a quarter of 40 is 10");
        assert!(contrast(&[7; 4]).has_contrast_of(contrast(&[90; 4])), "a plain target has no contrast to miss");
        let is_clipped = |pixels: &[u8; 4], target| contrast(pixels).is_more_clipped_than(target);
        assert!(!is_clipped(&[0, 200, 50, 255], target), "two of four may be");
        assert!(is_clipped(&[0, 255, 50, 255], target), "three may not");
        assert!(!is_clipped(&[0, 255, 50, 255], contrast(&[0, 200, 50, 90])), "where one is in the target, three may");
    }

    #[test]
    fn the_largest_sums() {
        let of = |pixels: &[u8], width, height| Contrast::of(Image::new(pixels, width, height).unwrap());
        let board: Vec<u8> = (0..Table::MAX_PIXELS).map(|at| if at % 2 == 0 { 0 } else { 255 }).collect();
        let contrast = of(&board, 65535, 1);
        assert_eq!((contrast.mean, contrast.deviation, contrast.clipped), (127, 32768 * 127 + 32767 * 128, 65535));
        let contrast = of(&board[..65536], 256, 256);
        assert_eq!((contrast.mean, contrast.deviation, contrast.clipped), (128, 32768 * 255, 65536));
        // Each pixel of the first row deviates by 254 from the mean, nearly the largest possible value.
        let mut rows = [255; 257 * 255];
        rows[..257].fill(0);
        let contrast = of(&rows, 257, 255);
        assert_eq!((contrast.mean, contrast.deviation, contrast.clipped), (254, 257 * 254 + 257 * 254, 257 * 255));
        assert!(u32::try_from(Table::MAX_PIXELS).is_ok_and(|most| most.checked_mul(256 * 255).is_some()));
    }
}
