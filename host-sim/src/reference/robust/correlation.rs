//! Where in a window a template correlates best, whatever the light.

use super::grid::Patch;
use super::rounding::real;

/// The offset with the largest covariance over the root of the patch's variance, both times the number of pixels, squared (and
/// the root, and what is left of it, rounded down); of equals the upper and then the left one. A patch with less than the
/// template's variance over `plain` is none.
pub(super) fn best(window: &Patch, template: &Patch, plain: f64) -> Option<(i64, i64)> {
    // Whole numbers below 2^53: f64 has them exactly.
    let count = real(template.columns * template.rows);
    let sum = |patch: &Patch| patch.pixels.iter().sum::<f64>();
    let covariance = |a: &Patch, b: &Patch| {
        let products: f64 = a.pixels.iter().zip(&b.pixels).map(|(a, b)| a * b).sum();
        count * products - sum(a) * sum(b)
    };
    let least = (covariance(template, template) / plain).floor().max(1.0);
    let mut best = (0.0, None);
    for y in 0..=window.rows - template.rows {
        for x in 0..=window.columns - template.columns {
            let patch = window.cut(x, y, template.columns, template.rows)?;
            let variance = covariance(&patch, &patch);
            if variance >= least {
                let score = (covariance(&patch, template) / variance.sqrt().floor()).floor();
                if score > best.0 {
                    best = (score, Some((x, y)));
                }
            }
        }
    }
    best.1
}
