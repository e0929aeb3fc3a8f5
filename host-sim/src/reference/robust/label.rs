//! Bells: the label, 1.0 where the target is; and how much cells learn, by where they are.

use super::Numbers;
use super::grid::Shape;
use super::rounding::{nearest, real};

/// 1.0 in the units of labels and responses.
pub const ONE: f64 = 16384.0;

/// One axis' part of the label, so many cells from the target; the label is the product of both axes' parts.
///
/// exp(-t^2 / 2), t in standard deviations and taken from a table with so many entries for each, up to `bell_end`. A standard
/// deviation is a part of the root of the target's area; it is rounded down to 1/256 cell, and its inverse to 2^-20 entries for
/// 1/256 cell.
pub fn part(numbers: &Numbers, shape: &Shape, cells: f64) -> f64 {
    let area = real(shape.columns * shape.rows);
    let (width, of) = numbers.bell;
    let variance = area * (256.0 * width / (of * real(numbers.cell))).powi(2);
    bell(numbers, variance.floor().sqrt().floor().max(1.0), cells)
}

/// How much a cell learns, by one axis, so many cells from the target's middle: a standard deviation is half of the side, which has
/// so many pixels of the grid.
pub fn learns(numbers: &Numbers, side: i64, cells: f64) -> f64 {
    bell(numbers, 256.0 * real(side) / real(2 * numbers.cell), cells)
}

fn bell(numbers: &Numbers, deviation: f64, cells: f64) -> f64 {
    let entries = (numbers.bell_entries * 1_048_576.0 / deviation).floor();
    let t = (cells.abs() * 256.0 * entries / 1_048_576.0).floor() / numbers.bell_entries;
    if t < numbers.bell_end { nearest(ONE * (-t * t / 2.0).exp(), 1.0) } else { 0.0 }
}

/// The label from both axes' parts.
pub fn label(across: f64, down: f64) -> f64 {
    nearest(across * down / ONE, 1.0)
}
