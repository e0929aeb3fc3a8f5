//! The filter: a weight for each channel of each cell on the target and around it.

use super::Coded;
use crate::kernels::{GradientStep, ScaledSums};
use heapless::Vec;

/// Up to `N` weights, cell by cell, in units of 2^-16 / 16384.
pub(crate) struct Filter<const N: usize> {
    weights: Vec<i32, N>,
}

impl<const N: usize> Filter<N> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { weights: Vec::new() }
    }

    /// Starts with `count` weights of 0.
    pub(crate) fn start(&mut self, count: usize) {
        self.weights.clear();
        // Cannot fail: no grid has more than `N` weights.
        let _ = self.weights.resize_default(count);
    }

    /// Takes `count` saved weights.
    pub(crate) fn restore(&mut self, count: usize, weights: impl Iterator<Item = i32>) {
        self.start(count);
        self.weights.iter_mut().zip(weights).for_each(|(weight, saved)| *weight = saved);
    }

    pub(crate) fn weights(&self) -> &[i32] {
        &self.weights
    }

    /// Writes the weights to `coded`.
    #[inline(never)]
    pub(crate) fn code(&self, coded: &mut Coded<N>) {
        let numbers = ScaledSums::of(&self.weights);
        coded.set(numbers, self.weights.len(), numbers.largest(), 0);
    }

    /// Takes a step: w -= length * direction. `length` has 44 fractional bits and is below 2^47, so every product is
    /// below 2^60. A weight that would overflow an `i32` stays as it is.
    #[inline(never)]
    pub(crate) fn descend(&mut self, length: i64, direction: &Coded<N>) {
        GradientStep { length, back: 44u32.saturating_sub(direction.shift()) }
            .apply(&mut self.weights, direction.numbers());
    }
}
