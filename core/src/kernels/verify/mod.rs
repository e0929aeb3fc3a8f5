//! Compares each kernel with the plain loop, in every call (unit tests, and feature `verify`). A difference panics.

pub(crate) mod bilinear;
#[cfg(feature = "refiner")]
pub(crate) mod dense;
pub(crate) mod extremes;
pub(crate) mod gradients;
pub(crate) mod levels;
pub(crate) mod products;
pub(crate) mod scores;
pub(crate) mod weights;

/// A copy of at most `N` numbers that a kernel is about to change.
pub(crate) fn copy<T: Copy, const N: usize>(numbers: &[T]) -> heapless::Vec<T, N> {
    numbers.iter().copied().collect()
}
