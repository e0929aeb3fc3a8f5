//! How far a score of smr-core may be from the exact sum: the one number in `check` that need not be equal.

/// The most that a score of `pixels` pixels can differ from the exact sum, in units of 1/65535.
pub(super) fn bound(pixels: u32) -> f64 {
    let n = f64::from(pixels);
    // Half a unit for each table entry. f64 adds n numbers of at most 65535, each off by 2^-52 of itself, and rounds
    // each partial sum of at most n * 65535 by another 2^-53 of itself.
    n * 0.5 + n * (n + 2.0) * 65535.0 * f64::EPSILON
}
