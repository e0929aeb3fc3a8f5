//! Features of a cell, ten bytes: a gradient histogram of nine directions, and the mean gray level.

use super::Numbers;
use super::rounding::{down, index, nearest, to_f64};
use super::sampling::Patch;
use std::f64::consts::PI;

const DIRECTIONS: usize = 9;
/// Number of feature bytes per cell.
pub const CHANNELS: usize = DIRECTIONS + 1;

/// Features of a grid of cells, row by row, `CHANNELS` bytes per cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    pub across: i64,
    pub down: i64,
    pub bytes: Vec<f64>,
}

impl Cells {
    pub fn row(&self, x: i64, y: i64, count: i64) -> &[f64] {
        let from = index(y * self.across + x) * CHANNELS;
        &self.bytes[from..from + index(count) * CHANNELS]
    }

    /// Mean gray level of each cell less 128: -128 to 127.
    pub fn grays(&self) -> impl Iterator<Item = f64> {
        self.bytes.iter().skip(DIRECTIONS).step_by(CHANNELS).copied()
    }

    pub fn cut(&self, x: i64, y: i64, across: i64, down: i64) -> Self {
        let bytes = (y..y + down).flat_map(|row| self.row(x, row, across)).copied().collect();
        Self { across, down, bytes }
    }
}

#[derive(Clone)]
struct Sums {
    /// Sum of the cell's gradients by direction, in gray levels.
    gradient: [f64; DIRECTIONS],
    gray: f64,
}

impl Sums {
    fn energy(&self) -> f64 {
        self.gradient.iter().map(|sum| sum.floor().powi(2)).sum()
    }
}

/// Computes the features of a picture of whole cells with a border of one pixel.
pub fn features(numbers: &Numbers, picture: &Patch) -> Cells {
    let (across, down) = ((picture.columns - 2) / numbers.cell, (picture.rows - 2) / numbers.cell);
    let places = || (0..down).flat_map(|y| (0..across).map(move |x| (x, y)));
    let sums: Vec<Sums> = places().map(|(x, y)| sums(numbers, picture, x, y)).collect();
    let bytes = |(x, y): (i64, i64)| {
        let inside = |(x, y): &(i64, i64)| (0..across).contains(x) && (0..down).contains(y);
        let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y))).filter(inside);
        let energies: Vec<f64> = around.map(|(x, y)| sums[index(y * across + x)].energy()).collect();
        let mean = (energies.iter().sum::<f64>() / energies.len() as f64).floor();
        normalised(numbers, &sums[index(y * across + x)], mean)
    };
    Cells { across, down, bytes: places().flat_map(bytes).collect() }
}

fn sums(numbers: &Numbers, picture: &Patch, column: i64, row: i64) -> Sums {
    let mut sums = Sums { gradient: [0.0; DIRECTIONS], gray: 0.0 };
    let pixel = |x: i64, y: i64| picture.row(x, y, 1)[0];
    let side = numbers.cell;
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (1 + column * side + x, 1 + row * side + y))) {
        let (right, down) = (pixel(x + 1, y) - pixel(x - 1, y), pixel(x, y + 1) - pixel(x, y - 1));
        // Directions are unsigned: a gradient and its opposite add to the same direction.
        let turned = down < 0.0 || (down == 0.0 && right < 0.0);
        split(&mut sums.gradient, if turned { (-right, -down) } else { (right, down) });
        sums.gray += pixel(x, y);
    }
    sums.gradient = sums.gradient.map(|sum| down(sum, 4.0));
    sums
}

/// Splits a gradient g between the two neighbouring directions u and v: g = a u + b v. Here a is (g x v) / (u x v), and
/// b is (u x g) / (u x v). Since u x v = sin 20 degrees, u and v are first divided by this sine and rounded to 1/256.
fn split(gradient: &mut [f64; DIRECTIONS], (right, below): (f64, f64)) {
    let step = PI / DIRECTIONS as f64;
    let cross = |number: usize| {
        let angle = number as f64 * step;
        let (x, y) = (nearest(angle.cos() / step.sin(), 256.0), nearest(angle.sin() / step.sin(), 256.0));
        x * below - y * right
    };
    // `second` is the next direction beyond the gradient's angle; after the last direction comes direction 0.
    let second = (1..DIRECTIONS).find(|&number| cross(number) < 0.0).unwrap_or(DIRECTIONS);
    gradient[second - 1] -= cross(second).min(0.0);
    gradient[second % DIRECTIONS] += cross(second - 1).max(0.0);
}

/// Features of a cell: each gradient sum * `norm_gain` / (2 * norm), at most 127; then the mean gray level - 128. All
/// are rounded down. The norm is the root of the mean energy of the 3x3 neighbourhood, plus `norm_floor`.
fn normalised(numbers: &Numbers, sums: &Sums, energy_around: f64) -> Vec<f64> {
    let norm = down(energy_around.sqrt(), 8.0) + numbers.norm_floor;
    // Factor from gradients, in quarters of a gray level, to feature bytes; rounded down to a multiple of 2^-16.
    let quarter = down(numbers.norm_gain / (norm * 8.0), 65536.0);
    let byte = |sum: &f64| (sum * 4.0 * quarter).floor().min(127.0);
    let gray = (sums.gray / to_f64(numbers.cell * numbers.cell)).floor() - 128.0;
    sums.gradient.iter().map(byte).chain([gray]).collect()
}
