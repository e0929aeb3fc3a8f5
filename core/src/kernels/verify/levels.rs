//! Compares sums over gray levels.

use crate::kernels::plain::levels as plain;

/// Checks the sum of differences and the number of clipped pixels.
#[track_caller]
pub(crate) fn deviation(sums: [u32; 2], pixels: &[u8], level: u8) {
    assert_eq!(sums, plain::deviation(pixels, level), "{} pixels", pixels.len());
}

/// The largest of `largest` and the differences of the pixels.
pub(crate) fn largest(old: &[u8], new: &[u8], largest: u8) -> u8 {
    old.iter().zip(new).fold(largest, |largest, (old, &new)| largest.max(old.abs_diff(new)))
}
