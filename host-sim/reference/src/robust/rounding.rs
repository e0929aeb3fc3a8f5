//! Rounding to fixed-point grids of 2^n steps per unit. Values, sums and products are below 2^53, so exact in f64.

pub(super) use crate::paper::index;

/// Resolution of positions and sampling steps: 1/4096 pixel.
pub const POSITION: f64 = 4096.0;
pub const SCALE: f64 = 65536.0;
/// Resolution of interpolation weights, mean gray levels, fractions of a cell, and answered boxes: 1/256.
pub const FINE: f64 = 256.0;

/// Resolution of the lighting (the template's gain divided by the search window's contrast in gray levels): 1/16384.
pub const LIGHT: f64 = 16384.0;

/// Resolution of the Gauss-Newton move: 1/64 template pixel.
pub const SUB: f64 = 64.0;

/// Rounds down to a multiple of 1 / `parts`.
pub fn down(value: f64, parts: f64) -> f64 {
    (value * parts).floor() / parts
}

/// Rounds toward 0 to a multiple of 1 / `parts`.
pub fn to_zero(value: f64, parts: f64) -> f64 {
    (value * parts).trunc() / parts
}

/// Rounds to the nearest multiple of 1 / `parts`, halves up.
pub fn nearest(value: f64, parts: f64) -> f64 {
    (value * parts + 0.5).floor() / parts
}

/// Quotient of two whole numbers, rounded down; computed in integers, because an f64 quotient can be rounded up.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)] // whole numbers; the quotient is below 2^53
pub fn quotient(number: f64, by: f64) -> f64 {
    (number as i128).div_euclid(by as i128) as f64
}

/// Smallest power of two `d` with floor(`largest` / d) + 1 <= `most`: numbers up to `largest`, divided by `d` and
/// rounded, are at most `most`.
pub fn divisor(largest: f64, most: f64) -> f64 {
    let mut divisor = 1.0;
    while (largest / divisor).floor() + 1.0 > most {
        divisor *= 2.0;
    }
    divisor
}

#[allow(clippy::cast_possible_truncation)] // they are far below 2^53
pub fn to_i64(value: f64) -> i64 {
    value as i64
}

#[allow(clippy::cast_precision_loss)] // they are far below 2^53
pub fn to_f64(value: i64) -> f64 {
    value as f64
}
