//! Gaussians: the label (the desired filter response, 1.0 at the target), and the learning window, which weights cells.

use super::Numbers;
use super::rounding::{nearest, to_f64, to_i64};
use super::sampling::Shape;
use crate::paper::similarity;

/// A label or response of 1.0, in units of 1/16384.
pub const ONE: f64 = 16384.0;

/// Factor of the label on one axis, `cells` from the target; the label is the product of both axes' factors.
pub fn label_factor(numbers: &Numbers, shape: &Shape, cells: f64) -> f64 {
    let area = to_f64(shape.columns * shape.rows);
    let (width, of) = numbers.label_width;
    gaussian((area * (256.0 * width / (of * to_f64(numbers.cell))).powi(2)).floor(), cells)
}

/// Factor of the learning window on one axis, `cells` from the middle. The standard deviation is half the template's
/// `side` on this axis, in template pixels.
pub fn learning_window(numbers: &Numbers, side: i64, cells: f64) -> f64 {
    gaussian((256.0 * to_f64(side) / to_f64(2 * numbers.cell)).powi(2), cells)
}

/// Gaussian exp(-x / 255) in units of 1/16384, with x = 255 * `cells`^2 / (2 * variance); `variance` is in units of
/// (1/256 cell)^2. Its value is exp(-(x mod 256) / 255) * exp(-256 / 255)^n, with n = floor(x / 256), at most 16.
fn gaussian(variance: f64, cells: f64) -> f64 {
    let factor = (255.0 * 16_777_216.0 / variance.max(1.0)).floor();
    let x = ((cells * 256.0).powi(2) * factor / 33_554_432.0).floor();
    let lower = (65_536.0 * (-256.0_f64 / 255.0).exp()).round();
    let times = to_i64((x / 256.0).floor().min(16.0));
    let value = (0..times).fold(similarity(x % 256.0, 255.0).rounded, |value, _| (value * lower / 65_536.0).floor());
    nearest(value / 4.0, 1.0)
}

pub fn label(across: f64, down: f64) -> f64 {
    nearest(across * down / ONE, 1.0)
}
