//! Lighting: adapts the template to the light of a patch, so that a lamp or a shadow does not lower the agreement.
//!
//! ```text
//! relit(p) = mean(patch) + gain * (template(p) - mean(template)), clamped to 0 to 255
//! gain     = deviation(patch) / deviation(template), clamped to 1/2 to 2
//! alpha    = deviation(patch), clamped to 8 to 100 gray levels
//! ```
//!
//! `deviation` is the mean absolute deviation from the mean. The gain is in units of 1/256.

use super::constants::{LEAST_ALPHA, LEAST_GAIN, MOST_ALPHA, MOST_GAIN};
use crate::image::Image;
use crate::kernels::rolled;
use crate::similarity::Contrast;

/// Alpha: a matching pixel differs by less than the deviation of the patch.
pub(super) fn alpha(patch: Contrast) -> u16 {
    u16::try_from((patch.deviation / patch.pixels.max(1)).clamp(LEAST_ALPHA, MOST_ALPHA)).unwrap_or(0)
}

/// Adapts `template`, whose own contrast is `from`, to the light of `patch`. Returns the contrast of `patch`.
pub(super) fn relight(template: &mut [u8], from: Contrast, patch: Image<'_>) -> Contrast {
    let to = Contrast::of(patch);
    let gain = (256 * to.deviation / from.deviation.max(1)).cast_signed().clamp(LEAST_GAIN, MOST_GAIN);
    for pixel in rolled(template.iter_mut()) {
        let value = to.mean.cast_signed() + (((i32::from(*pixel) - from.mean.cast_signed()) * gain) >> 8);
        *pixel = u8::try_from(value.clamp(0, 255)).unwrap_or(0);
    }
    to
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relit(template: &[u8], patch: &[u8]) -> std::vec::Vec<u8> {
        let mut relit = template.to_vec();
        let image = |pixels| Image::new(pixels, 2, 2).unwrap();
        relight(&mut relit, Contrast::of(image(template)), image(patch));
        relit
    }

    #[test]
    fn brightness_and_contrast_are_taken_over() {
        assert_eq!(relit(&[80, 120, 80, 120], &[80, 120, 80, 120]), [80, 120, 80, 120]);
        assert_eq!(relit(&[80, 120, 80, 120], &[160, 220, 160, 220]), [160, 220, 160, 220]);
    }

    #[test]
    fn alpha_has_bounds() {
        let of = |pixels: &[u8], columns| alpha(Contrast::of(Image::new(pixels, columns, 1).unwrap()));
        assert_eq!([of(&[9], 1), of(&[80, 120, 80, 121], 4), of(&[0, 255], 2)], [8, 20, 100]);
    }

    #[test]
    fn a_plain_patch_is_no_target_in_poor_light() {
        assert_eq!(relit(&[0, 200, 0, 200], &[100, 100, 100, 100]), [50, 150, 50, 150], "half the contrast at least");
        assert_eq!(relit(&[9, 9, 9, 9], &[0, 255, 0, 255]), [128; 4]);
    }
}
