//! Lighting: gives the template the brightness and the contrast of the patch.

use super::Numbers;
use super::gradients::Cells;
use super::rounding::{FINE, LIGHT, down, nearest, real, to_zero};
use super::sampling::Patch;

/// The mean in whole gray levels, and the sum of all absolute deviations from it.
fn mean_and_deviation(patch: &Patch) -> (f64, f64) {
    let count = patch.columns * patch.rows;
    let mean = nearest(patch.pixels.iter().sum::<f64>() / real(count), 1.0);
    (mean, patch.pixels.iter().map(|pixel| (pixel - mean).abs()).sum())
}

/// The threshold alpha of a comparison: the mean absolute deviation of the patch, or that of the template with this gain if it is less,
/// rounded down, within bounds.
pub fn threshold(numbers: &Numbers, template: &Patch, seen: &Patch, gain: f64) -> f64 {
    let deviation = mean_and_deviation(seen).1.min((mean_and_deviation(template).1 * gain).floor());
    let (least, most) = numbers.alpha_bounds;
    (deviation / real(seen.columns * seen.rows)).floor().clamp(least, most)
}

/// The contrast of a search window: the mean absolute deviation of its cells' gray, on a grid of 1/16 gray level.
pub fn window_contrast(numbers: &Numbers, cells: &Cells) -> f64 {
    let count = real(cells.across * cells.down);
    let mean = to_zero(cells.grays().sum::<f64>() / count, 1.0);
    down(cells.grays().map(|gray| (gray - mean).abs()).sum::<f64>() / count, 16.0).max(numbers.least_window)
}

/// The light in which the target has this gain, and its window this contrast.
pub fn light(gain: f64, window: f64) -> f64 {
    down(gain / window, LIGHT)
}

/// The light after a frame whose light is `new`.
pub fn followed(numbers: &Numbers, light: f64, new: f64) -> f64 {
    light + down((new - light) * numbers.light_rate, LIGHT)
}

/// The gain that is expected in this light, if the search window has this contrast.
pub fn expected_gain(numbers: &Numbers, light: f64, window: f64) -> f64 {
    let (least, most) = numbers.gain_bounds;
    down(light * window, FINE).clamp(least, most)
}

/// True if `seen` can show `target`: it has enough of the expected contrast, and not many more pixels cut off at black or white than `target`.
pub fn can_show(numbers: &Numbers, target: &Patch, seen: &Patch, expected: f64) -> bool {
    let (was, is) = (mean_and_deviation(target).1, mean_and_deviation(seen).1);
    let cut_off =
        |patch: &Patch| patch.pixels.iter().map(|pixel| f64::from(*pixel <= 0.0 || *pixel >= 255.0)).sum::<f64>();
    let pixels = real(seen.columns * seen.rows);
    is >= was * expected * numbers.least_contrast
        && is >= pixels * numbers.least_deviation
        && cut_off(seen) <= pixels * numbers.most_cut_off + cut_off(target)
}

/// The contrast of `seen` over that of `template`, on a grid of 1/256.
pub fn free_gain(template: &Patch, seen: &Patch) -> f64 {
    // A template without contrast keeps only its mean, whatever the gain.
    down(mean_and_deviation(seen).1 / mean_and_deviation(template).1.max(1.0), FINE)
}

/// The gain of `template` in the light of `seen`: near the expected one.
pub fn gain(numbers: &Numbers, template: &Patch, seen: &Patch, expected: f64) -> f64 {
    let least = down(expected / numbers.most_change, FINE).max(numbers.gain_bounds.0);
    free_gain(template, seen).clamp(least, expected * numbers.most_change)
}

/// `template` with this gain and the brightness of `seen`. The product of the gain with a deviation is rounded down.
pub fn relit(template: &Patch, seen: &Patch, gain: f64) -> Patch {
    let (was, is) = (mean_and_deviation(template), mean_and_deviation(seen));
    let pixel = |pixel: &f64| (is.0 + ((pixel - was.0) * gain).floor()).clamp(0.0, 255.0);
    Patch { pixels: template.pixels.iter().map(pixel).collect(), ..*template }
}
