//! Light: a template as it would look in the light of a patch, so that a lamp or a shadow does not count as another target.

use crate::image::Image;
use crate::kernels::rolled;
use crate::similarity::Contrast;

/// The mean absolute deviation itself, rounded down, 8 to 100 gray levels: what agrees with a patch in its light differs by less.
pub(super) fn threshold(seen: Contrast) -> u16 {
    u16::try_from((seen.deviation / seen.pixels.max(1)).clamp(8, 100)).unwrap_or(0)
}

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
    fn thresholds_have_bounds() {
        let of = |pixels: &[u8], columns| threshold(Contrast::of(Image::new(pixels, columns, 1).unwrap()));
        assert_eq!([of(&[9], 1), of(&[80, 120, 80, 121], 4), of(&[0, 255], 2)], [8, 20, 100]);
    }

    #[test]
    fn a_plain_patch_is_no_target_in_poor_light() {
        assert_eq!(lit(&[0, 200, 0, 200], &[100, 100, 100, 100]), [50, 150, 50, 150], "half the contrast at least");
        assert_eq!(lit(&[9, 9, 9, 9], &[0, 255, 0, 255]), [128; 4]);
    }
}
