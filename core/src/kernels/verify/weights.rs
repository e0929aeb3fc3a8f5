//! Compares weights of a filter.

use crate::kernels::plain::weights as plain;

/// Checks the largest of the numbers.
#[track_caller]
pub(crate) fn largest(largest: u32, weights: &[i32], factor: i64, sums: &[i32], left: u32) {
    assert_eq!(largest, plain::largest(weights, factor, sums, left), "the largest number");
}

/// Checks coded numbers.
#[track_caller]
pub(crate) fn code(out: &[i16], weights: &[i32], factor: i64, sums: &[i32], left: u32, shift: u32) {
    let coded = plain::coded(weights, factor, sums, left, shift);
    assert!(out.iter().copied().zip(coded).all(|(given, wanted)| given == wanted), "coded numbers");
}

/// Checks a step against a gradient.
#[track_caller]
pub(crate) fn step(weights: &[i32], before: &mut heapless::Vec<i32, 4096>, slopes: &[i16], length: i64, back: u32) {
    plain::step(before, slopes, length, back);
    assert_eq!(weights, &**before, "moved weights, given and expected");
}

/// Checks numbers that were scaled down, and the sum of their products.
#[track_caller]
pub(crate) fn scale_by(sum: i32, numbers: &[i16], before: &mut heapless::Vec<i16, 16>, part: i32) {
    assert_eq!((plain::scale_by(before, part), &**before), (sum, numbers), "scaled numbers");
}
