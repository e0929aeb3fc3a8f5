//! Light: a template as it would look in the light of a patch, so that a lamp or a shadow does not count as another target.

use crate::image::Image;
use crate::similarity::rolled;

/// Mean and mean absolute deviation from it; the mean is rounded to a gray level, the sum of deviations is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Contrast {
    pixels: u32,
    mean: u32,
    /// The sum over all pixels.
    deviation: u32,
    /// Pixels that are cut off at black or at white.
    cut_off: u32,
}

impl Contrast {
    /// Of nothing.
    pub(super) const NONE: Self = Self { pixels: 0, mean: 0, deviation: 0, cut_off: 0 };

    #[inline(never)] // one copy in flash
    pub(super) fn of(pixels: Image<'_>) -> Self {
        let sum_of = |count: fn(u8, u32) -> u32, mean| {
            let row = |y| rolled(pixels.row(y).iter()).map(|&pixel| count(pixel, mean)).sum::<u32>();
            (0..pixels.height()).map(row).sum::<u32>()
        };
        let count = u32::from(pixels.width()) * u32::from(pixels.height());
        let mean = (sum_of(|pixel, _| pixel.into(), 0) + count / 2) / count.max(1);
        // Both in one pass: the upper half of a sum counts what is cut off, the lower one holds the deviations, at most 1600 * 255.
        let sums = sum_of(
            |pixel, mean| u32::from(pixel).abs_diff(mean) + (u32::from(matches!(pixel, 0 | u8::MAX)) << CUT_OFF),
            mean,
        );
        Self { pixels: count, mean, deviation: sums % (1 << CUT_OFF), cut_off: sums >> CUT_OFF }
    }

    /// Whether a patch like this one can show a target with the contrast `target`: it has at least a quarter of that, and at least half of
    /// its pixels are not cut off. What a covered lens shows does not.
    pub(super) fn shows(&self, target: Self) -> bool {
        // Both have as many pixels.
        SHOWN * self.deviation >= target.deviation && 2 * self.cut_off <= self.pixels
    }

    /// The mean absolute deviation itself, rounded down, 8 to 100 gray levels: what agrees with a patch in its light differs by
    /// less.
    pub(super) fn threshold(&self) -> u16 {
        u16::try_from((self.deviation / self.pixels.max(1)).clamp(8, 100)).unwrap_or(0)
    }
}

/// Where the count of cut-off pixels begins in a sum: 1600 * 255 is less than 2^19, and 1600 less than 2^13.
const CUT_OFF: u32 = 19;
/// So many times the contrast of what is seen must be at least that of the target.
const SHOWN: u32 = 4;

/// The least and the most that contrast may change by, in units of 1/256: half and twice.
const LEAST: i32 = 128;
const MOST: i32 = 512;

/// Puts a template in other light: its brightness and contrast `was` become those of `seen`, which are returned.
///
/// Each pixel becomes mean(seen) + (pixel - mean(template)) * gain, cut to 0 to 255; the gain is the ratio of the mean absolute
/// deviations, in units of 1/256 rounded down, half to twice.
pub(super) fn of(template: &mut [u8], was: Contrast, seen: Image<'_>) -> Contrast {
    let is = Contrast::of(seen);
    let gain = (256 * is.deviation / was.deviation.max(1)).cast_signed().clamp(LEAST, MOST);
    for pixel in rolled(template.iter_mut()) {
        let value = is.mean.cast_signed() + (((i32::from(*pixel) - was.mean.cast_signed()) * gain) >> 8);
        *pixel = u8::try_from(value.clamp(0, 255)).unwrap_or(0);
    }
    is
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(template: &[u8], seen: &[u8]) -> std::vec::Vec<u8> {
        let mut lit = template.to_vec();
        let image = |pixels| Image::new(pixels, 2, 2).unwrap();
        of(&mut lit, Contrast::of(image(template)), image(seen));
        lit
    }

    #[test]
    fn brightness_and_contrast_are_taken_over() {
        assert_eq!(lit(&[80, 120, 80, 120], &[80, 120, 80, 120]), [80, 120, 80, 120]);
        assert_eq!(lit(&[80, 120, 80, 120], &[160, 220, 160, 220]), [160, 220, 160, 220]);
    }

    #[test]
    fn what_has_little_contrast_or_is_mostly_cut_off_shows_nothing() {
        let contrast = |pixels: &[u8]| Contrast::of(Image::new(pixels, 4, 1).unwrap());
        let target = contrast(&[60, 140, 60, 140]);
        let shows = |pixels: &[u8; 4]| contrast(pixels).shows(target);
        assert!(shows(&[90, 110, 90, 110]) && !shows(&[90, 109, 90, 110]), "a quarter of 40 is 10");
        assert!(shows(&[0, 200, 50, 255]) && !shows(&[0, 255, 50, 255]), "two of four may be cut off, three may not");
        assert!(contrast(&[7; 4]).shows(contrast(&[90; 4])), "a plain target has no contrast that could be missed");
    }

    #[test]
    fn the_largest_sums() {
        let board: std::vec::Vec<u8> = (0..1600).map(|at| if at % 2 == 0 { 0 } else { 255 }).collect();
        let contrast = Contrast::of(Image::new(&board, 40, 40).unwrap());
        assert_eq!((contrast.mean, contrast.deviation, contrast.cut_off), (128, 800 * (128 + 127), 1600));
    }

    #[test]
    fn thresholds_have_bounds() {
        let threshold = |pixels: &[u8], columns| Contrast::of(Image::new(pixels, columns, 1).unwrap()).threshold();
        assert_eq!([threshold(&[9], 1), threshold(&[80, 120, 80, 121], 4), threshold(&[0, 255], 2)], [8, 20, 100]);
    }

    #[test]
    fn a_plain_patch_is_no_target_in_poor_light() {
        assert_eq!(lit(&[0, 200, 0, 200], &[100, 100, 100, 100]), [50, 150, 50, 150], "half the contrast at least");
        assert_eq!(lit(&[9, 9, 9, 9], &[0, 255, 0, 255]), [128; 4]);
    }
}
