//! Lighting: adaptation of the template's brightness and contrast to those of the patch.

use super::Numbers;
use super::gradients::Cells;
use super::rounding::{FINE, LIGHT, down, nearest, to_f64, to_zero};
use super::sampling::Patch;

/// Mean, rounded to a whole gray level, and the sum of absolute deviations from this mean.
fn mean_and_deviation(patch: &Patch) -> (f64, f64) {
    let count = patch.columns * patch.rows;
    let mean = nearest(patch.pixels.iter().sum::<f64>() / to_f64(count), 1.0);
    (mean, patch.pixels.iter().map(|pixel| (pixel - mean).abs()).sum())
}

/// Threshold alpha of a comparison, in gray levels: the smaller of the patch's mean absolute deviation and `gain` times
/// the template's, rounded down and clamped to `alpha_bounds`.
pub fn threshold(numbers: &Numbers, template: &Patch, seen: &Patch, gain: f64) -> f64 {
    let deviation = mean_and_deviation(seen).1.min((mean_and_deviation(template).1 * gain).floor());
    let (least, most) = numbers.alpha_bounds;
    (deviation / to_f64(seen.columns * seen.rows)).floor().clamp(least, most)
}

/// Contrast of a search window in gray levels: mean absolute deviation of its cells' gray levels, rounded down to 1/16,
/// at least `least_window`.
pub fn window_contrast(numbers: &Numbers, cells: &Cells) -> f64 {
    let count = to_f64(cells.across * cells.down);
    let mean = to_zero(cells.grays().sum::<f64>() / count, 1.0);
    down(cells.grays().map(|gray| (gray - mean).abs()).sum::<f64>() / count, 16.0).max(numbers.least_window)
}

/// Lighting: the template's gain divided by the contrast of the search window in gray levels.
pub fn gain_per_contrast(gain: f64, window: f64) -> f64 {
    down(gain / window, LIGHT)
}

/// Running mean of the lighting after a frame whose lighting is `new`.
pub fn running_light(numbers: &Numbers, light: f64, new: f64) -> f64 {
    light + down((new - light) * numbers.light_rate, LIGHT)
}

/// Predicts the template's gain from the lighting and the contrast of the search window.
pub fn expected_gain(numbers: &Numbers, light: f64, window: f64) -> f64 {
    let (least, most) = numbers.gain_bounds;
    down(light * window, FINE).clamp(least, most)
}

/// True if the patch `seen` can show `target`: enough contrast, and not many more clipped pixels than `target`.
pub fn can_show(numbers: &Numbers, target: &Patch, seen: &Patch, expected: f64) -> bool {
    let (was, is) = (mean_and_deviation(target).1, mean_and_deviation(seen).1);
    let cut_off =
        |patch: &Patch| patch.pixels.iter().map(|pixel| f64::from(*pixel <= 0.0 || *pixel >= 255.0)).sum::<f64>();
    let pixels = to_f64(seen.columns * seen.rows);
    is >= was * expected * numbers.least_contrast
        && is >= pixels * numbers.least_deviation
        && cut_off(seen) <= pixels * numbers.most_cut_off + cut_off(target)
}

/// Contrast of `seen` divided by that of `template`, rounded down to 1/256.
pub fn free_gain(template: &Patch, seen: &Patch) -> f64 {
    // The contrast of a flat template counts as 1, because any gain leaves a flat template flat.
    down(mean_and_deviation(seen).1 / mean_and_deviation(template).1.max(1.0), FINE)
}

/// Gain: contrast of `seen` / that of `template`, within a factor `most_change` of `expected`, at least
/// `gain_bounds.0`.
pub fn gain(numbers: &Numbers, template: &Patch, seen: &Patch, expected: f64) -> f64 {
    let least = down(expected / numbers.most_change, FINE).max(numbers.gain_bounds.0);
    free_gain(template, seen).clamp(least, expected * numbers.most_change)
}

/// Returns `template` with the mean of `seen`, and contrast scaled by `gain`. Scaled deviations are rounded down.
pub fn relit(template: &Patch, seen: &Patch, gain: f64) -> Patch {
    let (was, is) = (mean_and_deviation(template), mean_and_deviation(seen));
    let pixel = |pixel: &f64| (is.0 + ((pixel - was.0) * gain).floor()).clamp(0.0, 255.0);
    Patch { pixels: template.pixels.iter().map(pixel).collect(), ..*template }
}
