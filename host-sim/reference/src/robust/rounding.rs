//! The grids of the method's numbers, and rounding to them.
//!
//! A grid is given by its parts of 1; all are powers of two. Numbers on them are exact in f64, and so are their sums and
//! products here, which stay below 2^53.

pub(super) use crate::paper::index;

/// Positions and steps, in pixels.
pub const POSITION: f64 = 4096.0;
pub const SCALE: f64 = 65536.0;
/// Fractions of what is mixed, means of gray levels, parts of a cell, and the box of an answer.
pub const FINE: f64 = 256.0;

/// The gain for each gray level of contrast in a search window.
pub const LIGHT: f64 = 16384.0;

/// Parts of a pixel of the grid.
pub const SUB: f64 = 64.0;

/// Rounds down to the grid.
pub fn down(value: f64, parts: f64) -> f64 {
    (value * parts).floor() / parts
}

/// Rounds toward 0 to the grid.
pub fn to_zero(value: f64, parts: f64) -> f64 {
    (value * parts).trunc() / parts
}

/// Rounds to the nearest number on the grid; of two, to the larger.
pub fn nearest(value: f64, parts: f64) -> f64 {
    (value * parts + 0.5).floor() / parts
}

/// Quotient of two whole numbers, rounded down. It is computed in integers: `number` may be too large for f64 to tell the
/// quotient from the next whole number.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)] // whole numbers; the quotient is below 2^53
pub fn quotient(number: f64, by: f64) -> f64 {
    (number as i128).div_euclid(by as i128) as f64
}

/// The least power of two by which a whole number, divided and rounded to the nearest, is at most `most`.
pub fn divisor(largest: f64, most: f64) -> f64 {
    let mut divisor = 1.0;
    while (largest / divisor).floor() + 1.0 > most {
        divisor *= 2.0;
    }
    divisor
}

/// Converts a whole number to an integer.
#[allow(clippy::cast_possible_truncation)] // they are far below 2^53
pub fn whole(value: f64) -> i64 {
    value as i64
}

/// Converts an integer to f64.
#[allow(clippy::cast_precision_loss)] // they are far below 2^53
pub fn real(value: i64) -> f64 {
    value as f64
}
