//! Lighting: a template with the brightness and the contrast of what is seen.

use super::Numbers;
use super::rounding::{FINE, down, nearest, real};
use super::sampling::Patch;

/// The mean in whole gray levels, and the sum of all absolute deviations from it.
fn mean_and_deviation(patch: &Patch) -> (f64, f64) {
    let count = patch.columns * patch.rows;
    let mean = nearest(patch.pixels.iter().sum::<f64>() / real(count), 1.0);
    (mean, patch.pixels.iter().map(|pixel| (pixel - mean).abs()).sum())
}

/// The threshold alpha of a comparison with `seen`: its mean absolute deviation, rounded down, within bounds.
pub fn threshold(numbers: &Numbers, seen: &Patch) -> f64 {
    let (_, deviation) = mean_and_deviation(seen);
    let (least, most) = numbers.alpha_bounds;
    (deviation / real(seen.columns * seen.rows)).floor().clamp(least, most)
}

/// True if `seen` can show `target`: its contrast is large enough, and not too many of its pixels are cut off at black or white.
pub fn can_show(numbers: &Numbers, target: &Patch, seen: &Patch) -> bool {
    let (was, is) = (mean_and_deviation(target).1, mean_and_deviation(seen).1);
    let cut_off = seen.pixels.iter().filter(|&&pixel| pixel <= 0.0 || pixel >= 255.0).count();
    #[allow(clippy::cast_precision_loss)] // a few thousand
    let part = cut_off as f64 / seen.pixels.len() as f64;
    is >= was * numbers.least_contrast && part <= numbers.most_cut_off
}

/// `template` in the light of `seen`: the gain is on a grid of 1/256, its product with a deviation is rounded down.
pub fn relit(numbers: &Numbers, template: &Patch, seen: &Patch) -> Patch {
    let (was, is) = (mean_and_deviation(template), mean_and_deviation(seen));
    // Of a template without contrast nothing but its mean is left, whatever the gain.
    let gain = down(is.1 / was.1.max(1.0), FINE).clamp(1.0 / numbers.most_gain, numbers.most_gain);
    let pixel = |pixel: &f64| (is.0 + ((pixel - was.0) * gain).floor()).clamp(0.0, 255.0);
    Patch { pixels: template.pixels.iter().map(pixel).collect(), ..*template }
}
