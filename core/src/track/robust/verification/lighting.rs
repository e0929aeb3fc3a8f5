//! Lighting: adapts the template to the light of a patch, so that a lamp, dusk or fog does not lower the agreement.
//!
//! ```text
//! relit(p) = mean(patch) + gain * (template(p) - mean(template)), clamped to 0 to 255
//! gain     = deviation(patch) / deviation(template), clamped to 1/2 to 2 times the expected gain
//! expected = light * deviation(window), clamped to 1/256 to 16
//! light'   = light + (gain / deviation(window) - light) / 8, after a frame from which the filter learns
//! alpha    = deviation(patch) or gain * deviation(template), whichever is less, clamped to 2 to 100 gray levels
//! ```
//!
//! A change of light scales the contrast of the target and that of the search window around it by the same factor, so
//! their quotient (`light`) stays. Something else in the target's place has another quotient. `deviation` is the mean
//! absolute deviation from the mean gray level; in the window it is that of the cells' gray.
//!
//! | symbol | unit | bound |
//! |---|---|---|
//! | `gain` | 1/256 | 1 to 2^13 |
//! | `deviation(window)` | 1/16 gray level | 4 to 2040 |
//! | `light` | 2^-14 for each gray level | 2^21 |
//!
//! Cost: 12 units of work for each cell of the window. Verification counts the work on the template's pixels.

use super::super::constants::{CHANNELS, ONE_GAIN};
use super::super::features::Extent;
use crate::image::Image;
use crate::kernels::rolled;
use crate::similarity::{Contrast, LARGEST_CONTRAST_RATIO};

/// The minimum and the maximum of the threshold alpha, in gray levels. Two pixels match if they differ by less than
/// alpha, so a minimum of 2 tolerates a rounding error of 1. With a minimum of 8, a target with little contrast would
/// match any plain patch.
const MIN_ALPHA: u32 = 2;
const MAX_ALPHA: u32 = 100;
/// The largest expected gain of contrast from the template to the patch: a factor of 16, in units of 1/256.
const MAX_EXPECTED: u32 = 16 * ONE_GAIN;
/// The minimum contrast of a search window: 1/4 gray level, in units of 1/16. Lower contrasts are raised to it.
const MIN_WINDOW: u32 = 4;
/// The learning rate of the target's `Light`, as a right shift: each learned frame moves the target's `Light` by 2^-3
/// of the difference to the frame's `Light`. With 2^0 (the whole difference), the share of wrong frames that are
/// *tracking* would be higher by 0.05, measured on half of the recordings.
const LIGHT_RATE: u32 = 3;

/// Units of work for measuring the contrast of a window, for each of the window's cells.
const MEASURED: u32 = 12;

pub(crate) const fn most_work(extent: Extent) -> u32 {
    MEASURED * (extent.across + 2 * extent.reach) * (extent.down + 2 * extent.reach)
}

pub(crate) fn measuring(cells: &[i8]) -> u32 {
    MEASURED * count(cells)
}

fn count(cells: &[i8]) -> u32 {
    u32::try_from(cells.len() / CHANNELS).unwrap_or(0)
}

/// The gain of the target's contrast divided by the search window's contrast, in units of 1/16384 per gray level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Light(u32);

impl Light {
    pub(crate) const NONE: Self = Self(0);
    const MAX: u32 = ((2 * MAX_EXPECTED) << 10) / MIN_WINDOW;

    /// Divides the target's `gain` of contrast (1/256) by its search window's contrast, `window` (1/16 gray level).
    pub(crate) fn of(gain: u32, window: u32) -> Self {
        Self((gain << 10) / window.max(MIN_WINDOW))
    }

    /// The expected gain of the target's contrast (1/256) in a search window of contrast `window` (1/16 gray level).
    pub(crate) fn gain(self, window: u32) -> u32 {
        ((self.0 * window) >> 10).clamp(1, MAX_EXPECTED)
    }

    pub(crate) fn following(self, new: Self) -> Self {
        Self(self.0.saturating_add_signed((new.0.cast_signed() - self.0.cast_signed()) >> LIGHT_RATE))
    }

    pub(crate) const fn number(self) -> u32 {
        self.0
    }

    pub(crate) const fn restore(number: u32) -> Option<Self> {
        if number <= Self::MAX { Some(Self(number)) } else { None }
    }
}

#[inline(never)]
pub(crate) fn window_contrast(cells: &[i8]) -> u32 {
    let grays = || rolled(cells.as_chunks::<CHANNELS>().0.iter().map(|&[.., gray]| i32::from(gray)));
    let count = count(cells).max(1);
    let mean = grays().sum::<i32>().checked_div(count.cast_signed()).unwrap_or(0);
    (16 * grays().map(|gray| gray.abs_diff(mean)).sum::<u32>() / count).max(MIN_WINDOW)
}

/// The threshold alpha of the similarity, 2 to 100 gray levels: the patch's deviation or, if lower, the template's
/// deviation times `gain`. With the patch's deviation alone, noise would match a template that has little contrast in
/// the present light.
pub(crate) fn alpha(patch: Contrast, template: Contrast, gain: u32) -> u16 {
    // The product is at most 2^13 * 2^18, below 2^32.
    let deviation = patch.deviation.min((gain * template.deviation) >> 8);
    u16::try_from((deviation / patch.pixels.max(1)).clamp(MIN_ALPHA, MAX_ALPHA)).unwrap_or(0)
}

/// True if a patch can show the target. Its contrast is at least a quarter of the expected one, and at least one gray
/// level. Its clipped pixels exceed the template's by at most half of all pixels. `template` is not yet relit.
pub(super) fn can_show(patch: Contrast, template: Contrast, expected: u32) -> bool {
    LARGEST_CONTRAST_RATIO * ONE_GAIN * patch.deviation >= expected * template.deviation
        && patch.deviation >= patch.pixels
        && !patch.is_more_clipped_than(template)
}

/// Adapts `template`, whose contrast is `from`, to the light of `patch`. Returns the contrast of `patch`, and the gain.
pub(super) fn relight(template: &mut [u8], from: Contrast, patch: Image<'_>, expected: u32) -> (Contrast, u32) {
    let to = Contrast::of(patch);
    // Does not use `clamp`, which can panic.
    let gain = (ONE_GAIN * to.deviation / from.deviation.max(1)).min(2 * expected).max((expected / 2).max(1));
    for pixel in rolled(template.iter_mut()) {
        let deviation = (i32::from(*pixel) - from.mean.cast_signed()) * gain.cast_signed();
        *pixel = u8::try_from((to.mean.cast_signed() + (deviation >> 8)).clamp(0, 255)).unwrap_or(0);
    }
    (to, gain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn contrast(pixels: &[u8]) -> Contrast {
        Contrast::of(Image::new(pixels, pixels.len().try_into().unwrap(), 1).unwrap())
    }

    fn relit(template: &[u8], patch: &[u8], expected: u32) -> Vec<u8> {
        let mut relit = template.to_vec();
        relight(&mut relit, contrast(template), Image::new(patch, 2, 2).unwrap(), expected);
        relit
    }

    #[test]
    fn brightness_and_contrast_are_taken_over() {
        assert_eq!(relit(&[80, 120, 80, 120], &[80, 120, 80, 120], 256), [80, 120, 80, 120]);
        assert_eq!(relit(&[80, 120, 80, 120], &[160, 220, 160, 220], 256), [160, 220, 160, 220]);
        assert_eq!(
            relit(&[80, 120, 80, 120], &[10, 18, 10, 18], 60),
            [10, 17, 10, 17],
            "a fifth, rounded down, and about that is expected"
        );
    }

    #[test]
    fn a_plain_patch_is_no_target_in_poor_light() {
        assert_eq!(relit(&[0, 200, 0, 200], &[100; 4], 256), [50, 150, 50, 150], "half the expected contrast at least");
        assert_eq!(relit(&[9, 9, 9, 9], &[0, 255, 0, 255], 256), [128; 4]);
        let target = contrast(&[60, 140, 60, 140]);
        let can_show = |pixels: &[u8], expected| can_show(contrast(pixels), target, expected);
        assert!(can_show(&[90, 110, 90, 110], 256) && !can_show(&[90, 109, 90, 110], 256), "a quarter of 40 is 10");
        assert!(can_show(&[90, 94, 90, 94], 51) && !can_show(&[90, 91, 90, 92], 51), "a quarter of a fifth of 40 is 2");
        assert!(can_show(&[90, 92, 90, 92], 1) && !can_show(&[90, 91, 90, 92], 1), "one gray level at least");
    }

    #[test]
    fn a_target_may_be_black_and_white() {
        let can_show = |target: &[u8], patch: &[u8]| can_show(contrast(patch), contrast(target), ONE_GAIN);
        assert!(can_show(&[60, 140, 60, 140], &[0, 140, 60, 255]), "half of the pixels may be clipped");
        assert!(!can_show(&[60, 140, 60, 140], &[0, 140, 0, 255]), "three of four may not");
        assert!(can_show(&[0, 140, 60, 140], &[0, 140, 0, 255]), "but for those of the target");
        assert!(can_show(&[0, 255, 0, 255], &[0, 255, 0, 255]));
    }

    #[test]
    fn alpha_has_bounds() {
        let of = |pixels: &[u8], gain| alpha(contrast(pixels), contrast(&[0, 255, 0, 255]), gain);
        assert_eq!([of(&[9, 9, 9, 9], 256), of(&[80, 120, 80, 121], 256), of(&[0, 255, 0, 255], 512)], [2, 20, 100]);
        assert_eq!(of(&[80, 120, 80, 121], 32), 15, "an eighth of 127");
    }

    /// If the window's contrast falls to a fifth, the expected gain falls to a fifth.
    #[test]
    fn the_window_tells_the_light() {
        let window = |dark: i8, bright: i8| {
            let cell =
                |at: usize| [&[0; CHANNELS - 1][..], &[if at.is_multiple_of(2) { dark } else { bright }]].concat();
            window_contrast(&(0..400).flat_map(cell).collect::<Vec<_>>())
        };
        let day = window(-40, 40);
        assert_eq!(day, 16 * 40);
        let light = Light::of(256, day);
        assert!(light.gain(day).abs_diff(256) < 2 && light.gain(window(-108, -92)).abs_diff(256 / 5) < 2);
        assert_eq!(window(7, 7), MIN_WINDOW);
    }

    #[test]
    fn the_largest_numbers() {
        let mut cells = vec![-128; 400 * CHANNELS];
        cells[..200 * CHANNELS].fill(127);
        let most = window_contrast(&cells);
        assert!((2030..=2040).contains(&most), "{most}");
        let light = Light::of(2 * MAX_EXPECTED, MIN_WINDOW);
        assert_eq!((light.number(), light.gain(2040)), (Light::MAX, MAX_EXPECTED));
        assert_eq!((Light::restore(Light::MAX), Light::restore(Light::MAX + 1)), (Some(light), None));
        assert_eq!((Light::NONE.following(light).number(), light.following(Light::NONE).number()), (1 << 18, 7 << 18));
        let board: Vec<u8> = (0..1600).map(|at: u16| if at.is_multiple_of(2) { 0 } else { 255 }).collect();
        assert!(!can_show(contrast(&[90; 1600]), contrast(&board), MAX_EXPECTED));
        let mut relit = board.clone();
        let (_, gain) = relight(&mut relit, contrast(&board), Image::new(&board, 40, 40).unwrap(), MAX_EXPECTED);
        assert_eq!((gain, relit), (MAX_EXPECTED / 2, board));
    }
}
