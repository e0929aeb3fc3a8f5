//! Gaussians: the label, 1.0 where the target is, and the learning window, which weights cells by their place.

use super::Numbers;
use super::rounding::{nearest, real, whole};
use super::sampling::Shape;
use crate::paper::similarity;

/// 1.0 in the units of labels and responses.
pub const ONE: f64 = 16384.0;

/// The label on one axis, `cells` from the target. The label is the product of both axes. Its standard deviation is a part of the root of the
/// target's area.
pub fn part(numbers: &Numbers, shape: &Shape, cells: f64) -> f64 {
    let area = real(shape.columns * shape.rows);
    let (width, of) = numbers.label_width;
    gaussian((area * (256.0 * width / (of * real(numbers.cell))).powi(2)).floor(), cells)
}

/// The learning window on one axis, `cells` from the target's middle. Its standard deviation is half of the side, which is `side` pixels of
/// the grid.
pub fn learning_window(numbers: &Numbers, side: i64, cells: f64) -> f64 {
    gaussian((256.0 * real(side) / real(2 * numbers.cell)).powi(2), cells)
}

/// exp(-x / 255), where x is half of 255 times the squared quotient of distance and standard deviation, which is given in units of 1/256
/// cell and squared. It comes from the table of the similarity for the lower eight bits of x, and from powers of exp(-256 / 255) for the rest.
fn gaussian(variance: f64, cells: f64) -> f64 {
    let factor = (255.0 * 16_777_216.0 / variance.max(1.0)).floor();
    let x = ((cells * 256.0).powi(2) * factor / 33_554_432.0).floor();
    let lower = (65_536.0 * (-256.0_f64 / 255.0).exp()).round();
    let times = whole((x / 256.0).floor().min(16.0));
    let value = (0..times).fold(similarity(x % 256.0, 255.0).rounded, |value, _| (value * lower / 65_536.0).floor());
    nearest(value / 4.0, 1.0)
}

pub fn label(across: f64, down: f64) -> f64 {
    nearest(across * down / ONE, 1.0)
}
