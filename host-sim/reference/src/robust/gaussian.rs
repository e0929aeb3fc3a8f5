//! Gaussians: the label, 1.0 where the target is, and the learning window, which weights cells by their place.

use super::Numbers;
use super::rounding::{nearest, real};
use super::sampling::Shape;

/// 1.0 in the units of labels and responses.
pub const ONE: f64 = 16384.0;

/// The label on one axis, `cells` from the target. The label is the product of both axes.
///
/// exp(-t^2 / 2), where t is in standard deviations. It comes from a table with `gaussian_entries` for each deviation, up to
/// `gaussian_end`. The standard deviation is a part of the root of the target's area. It is rounded down to 1/256 cell, and its inverse to
/// 2^-20 entries for 1/256 cell.
pub fn part(numbers: &Numbers, shape: &Shape, cells: f64) -> f64 {
    let area = real(shape.columns * shape.rows);
    let (width, of) = numbers.label_width;
    let variance = area * (256.0 * width / (of * real(numbers.cell))).powi(2);
    gaussian(numbers, variance.floor().sqrt().floor().max(1.0), cells)
}

/// The learning window on one axis, `cells` from the target's middle. Its standard deviation is half of the side, which is `side` pixels of
/// the grid.
pub fn learning_window(numbers: &Numbers, side: i64, cells: f64) -> f64 {
    gaussian(numbers, 256.0 * real(side) / real(2 * numbers.cell), cells)
}

fn gaussian(numbers: &Numbers, deviation: f64, cells: f64) -> f64 {
    let entries = (numbers.gaussian_entries * 1_048_576.0 / deviation).floor();
    let t = (cells.abs() * 256.0 * entries / 1_048_576.0).floor() / numbers.gaussian_entries;
    if t < numbers.gaussian_end { nearest(ONE * (-t * t / 2.0).exp(), 1.0) } else { 0.0 }
}

pub fn label(across: f64, down: f64) -> f64 {
    nearest(across * down / ONE, 1.0)
}
