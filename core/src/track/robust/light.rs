//! Light: a template as it would look in the light of a patch, so that a lamp or a shadow does not count as another target.

use super::MOST_PIXELS;
use crate::image::Image;
use heapless::Vec;

/// Mean and mean absolute deviation from it; the mean is rounded to a gray level, the sum of deviations is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Contrast {
    pixels: u32,
    mean: u32,
    /// The sum over all pixels.
    deviation: u32,
}

impl Contrast {
    /// Of nothing.
    pub(super) const NONE: Self = Self { pixels: 0, mean: 0, deviation: 0 };

    pub(super) fn of(pixels: impl Iterator<Item = u8> + Clone) -> Self {
        let (count, sum) = pixels.clone().fold((0, 0), |(count, sum), pixel| (count + 1, sum + u32::from(pixel)));
        let mean = (sum + count / 2) / count.max(1);
        Self { pixels: count, mean, deviation: pixels.map(|pixel| u32::from(pixel).abs_diff(mean)).sum() }
    }
}

impl Contrast {
    /// The mean absolute deviation itself, rounded down, 8 to 100 gray levels: what agrees with a patch in its light differs by
    /// less.
    pub(super) fn threshold(&self) -> u16 {
        u16::try_from((self.deviation / self.pixels.max(1)).clamp(8, 100)).unwrap_or(0)
    }
}

/// The least and the most that contrast may change by, in units of 1/256: half and twice.
const LEAST: i32 = 128;
const MOST: i32 = 512;

/// Makes `lit` out of `template`: its brightness and contrast `was` become those of `seen`, which are returned.
///
/// Each pixel is mean(seen) + (pixel - mean(template)) * gain, cut to 0 to 255; the gain is the ratio of the mean absolute
/// deviations, in units of 1/256 rounded down, half to twice.
pub(super) fn of(
    template: impl ExactSizeIterator<Item = u8>,
    was: Contrast,
    seen: Image<'_>,
    lit: &mut Vec<u8, MOST_PIXELS>,
) -> Contrast {
    // Row by row by its number: `Image::rows` divides by the stride, which could be a panic where it is folded.
    let is = Contrast::of((0..seen.height()).flat_map(|y| seen.row(y)).copied());
    let gain = (256 * is.deviation / was.deviation.max(1)).cast_signed().clamp(LEAST, MOST);
    // Cannot fail: there are no more than MOST_PIXELS.
    let _ = lit.resize_default(template.len().min(MOST_PIXELS));
    for (lit, pixel) in lit.iter_mut().zip(template) {
        let value = is.mean.cast_signed() + (((i32::from(pixel) - was.mean.cast_signed()) * gain) >> 8);
        *lit = u8::try_from(value.clamp(0, 255)).unwrap_or(0);
    }
    is
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(template: &[u8], seen: &[u8]) -> std::vec::Vec<u8> {
        let mut lit = Vec::new();
        let template = template.iter().copied();
        of(template.clone(), Contrast::of(template), Image::new(seen, 2, 2).unwrap(), &mut lit);
        lit.to_vec()
    }

    #[test]
    fn brightness_and_contrast_are_taken_over() {
        assert_eq!(lit(&[80, 120, 80, 120], &[80, 120, 80, 120]), [80, 120, 80, 120]);
        assert_eq!(lit(&[80, 120, 80, 120], &[160, 220, 160, 220]), [160, 220, 160, 220]);
    }

    #[test]
    fn thresholds_have_bounds() {
        let threshold = |pixels: &[u8]| Contrast::of(pixels.iter().copied()).threshold();
        assert_eq!([threshold(&[]), threshold(&[80, 120, 80, 121]), threshold(&[0, 255])], [8, 20, 100]);
    }

    #[test]
    fn a_plain_patch_is_no_target_in_poor_light() {
        assert_eq!(lit(&[0, 200, 0, 200], &[100, 100, 100, 100]), [50, 150, 50, 150], "half the contrast at least");
        assert_eq!(lit(&[9, 9, 9, 9], &[0, 255, 0, 255]), [128; 4]);
    }
}
