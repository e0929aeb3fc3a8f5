//! The correlation filter: its weights, its responses to a window of features, and the gradient of its error.
//!
//! ```text
//! response   r[d]    = sum over cells c and channels k of  w[c, k] * x[c + d, k]
//! gradient   g[c, k] = sum over offsets d of               e[d] * x[c + d, k]
//! ```
//!
//! | symbol | what | unit | bound |
//! |---|---|---|---|
//! | `x` | feature | 1/127 | -128 to 127 |
//! | `w` | coded weight ([`Coded`]) | 2^shift of a weight's unit, 2^-16 / 16384 | +-8191 |
//! | `r` | response | 1/16384 of the label | +-2^24 |
//! | `e` | coded error | 2^shift / 16384 | +-16,383 |
//!
//! At most 2000 weights and 289 offsets keep every sum below 2^31: 2000 * 8191 * 128 and 289 * 16,383 * 128. Cost: one
//! product for each weight and offset.

use crate::kernels::{GradientStep, Layout, Packed, Products, ScaledSums, rolled};
use heapless::{Vec, VecView};

/// The features of a window, cell by cell. `layout` tells which of the features the filter covers at each offset.
#[derive(Clone, Copy)]
pub(crate) struct FeatureWindow<'a> {
    pub(crate) cells: &'a [i8],
    pub(crate) layout: Layout,
}

impl FeatureWindow<'_> {
    /// The part of the window that the filter covers at offsets of up to 5/8 of the search radius.
    pub(super) fn inner(mut self) -> Self {
        let Layout { stride, step, span, .. } = self.layout;
        let margin = span / 2 - 5 * (span / 2) / 8;
        self.cells = self.cells.get(margin * (stride + step)..).unwrap_or_default();
        self.layout.span -= 2 * margin;
        self
    }
}

/// Adds one piece of the gradient. True after the last piece. `packed` and `spare` are scratch memory.
pub(super) fn add_gradient<const S: usize>(
    products: Products,
    packed: &mut Packed,
    spare: &mut [i32],
    FeatureWindow { cells, layout }: FeatureWindow<'_>,
    errors: &[[i16; S]],
    piece: usize,
    gradient: &mut [i32],
) -> bool {
    products.gather(piece..piece + 1, packed, spare, cells, layout, errors, gradient);
    piece + 1 >= products.gather_pieces(layout, gradient.len())
}

/// The largest number in `Coded`, so that a sum of 2000 products with 8-bit features stays below 2^31.
pub(crate) const LARGEST: u32 = 8191;

/// 16-bit integers with a common exponent (block floating point): each value is number * 2^`shift`. `V` is a vector, or
/// by default a view of one with any capacity.
pub(crate) struct Coded<V: ?Sized = VecView<i16>> {
    shift: u32,
    numbers: V,
}

impl<const N: usize> Coded<Vec<i16, N>> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { shift: 0, numbers: Vec::new() }
    }
}

impl Coded {
    pub(crate) fn numbers(&self) -> &[i16] {
        &self.numbers
    }

    pub(crate) const fn shift(&self) -> u32 {
        self.shift
    }

    /// Sets the direction of a step to `sums` + `beta` * the previous direction. Sums are in units of 2^`unit`, beta in
    /// units of 2^-25. If beta is not 0, sums are at most 2047.
    #[inline(never)]
    #[allow(clippy::cast_possible_truncation)] // at most 2047 + 3/4 * 8191, a coded value
    pub(super) fn set_direction(&mut self, sums: &[i32], unit: u32, beta: i64) {
        // The largest beta, 3/4, in units of 1/65536. The next right shift converts beta to this unit (9 bits) and from
        // the scale of the old direction to that of the new one (`self.shift` - `unit` bits).
        const MAX: i32 = 3 << 14;
        let beta = beta >> (9 + self.shift).saturating_sub(unit);
        let beta = i32::try_from(beta).unwrap_or(MAX).min(MAX);
        self.shift = unit;
        for (number, sum) in rolled(self.numbers.iter_mut().zip(sums)) {
            *number = (sum + ((beta * i32::from(*number)) >> 16)) as i16;
        }
    }

    /// Computes one piece of the responses at all offsets, without the factor 2^`shift`. True after the last piece.
    #[inline(never)]
    pub(crate) fn respond<const S: usize>(
        &self,
        products: Products,
        packed: &mut Packed,
        spare: &mut [i32],
        FeatureWindow { cells, layout }: FeatureWindow<'_>,
        piece: usize,
        out: &mut [[i32; S]; S],
    ) -> bool {
        products.responses(piece..piece + 1, packed, spare, cells, layout, &self.numbers, out);
        piece + 1 >= products.pieces(layout, self.numbers.len())
    }

    /// Multiplies the sums of `respond` by 2^(`shift` - 16) and clamps them to +-2^24: responses in units of 1/16384.
    #[inline(never)]
    pub(crate) fn to_responses<const S: usize>(&self, sums: &mut [[i32; S]]) {
        // At least one of the shifts `left` and `right` is 0.
        let (left, right) = (self.shift.saturating_sub(16), 16_u32.saturating_sub(self.shift));
        // Clamps before the left shift, which then loses no bit.
        let most = (1 << 24) >> left;
        rolled(sums.as_flattened_mut().iter_mut()).for_each(|sum| *sum = (*sum >> right).min(most).max(-most) << left);
    }
}

/// The least right shift that makes `largest` less than `bound`.
#[cfg_attr(smr_small, inline(never))]
pub(super) fn shift_below(largest: u32, bound: u32) -> u32 {
    let mut shift = 0;
    while largest >> shift >= bound {
        shift += 1;
    }
    shift
}

/// The correlation filter: one weight for each channel of each cell, in units of 2^-16 / 16384. `V` as in [`Coded`].
pub(crate) struct Filter<V: ?Sized = VecView<i32>> {
    weights: V,
}

impl<const N: usize> Filter<Vec<i32, N>> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { weights: Vec::new() }
    }
}

impl Filter {
    pub(crate) fn start(&mut self, count: usize) {
        self.weights.clear();
        // Cannot fail: no grid has more weights than its tracker has room for.
        let _ = self.weights.resize_default(count);
    }

    pub(crate) fn restore(&mut self, count: usize, weights: impl Iterator<Item = i32>) {
        self.start(count);
        self.weights.iter_mut().zip(weights).for_each(|(weight, saved)| *weight = saved);
    }

    pub(crate) fn weights(&self) -> &[i32] {
        &self.weights
    }

    #[inline(never)]
    pub(crate) fn code(&self, coded: &mut Coded) {
        let numbers = ScaledSums::of(&self.weights);
        coded.shift = shift_below(numbers.largest(), LARGEST);
        // Cannot fail: both vectors have the same capacity.
        let _ = coded.numbers.resize_default(self.weights.len());
        numbers.code(coded.shift, &mut coded.numbers);
    }

    /// A gradient step: w -= length * direction. `length` has 44 fractional bits and is below 2^47, so every product is
    /// below 2^60. A weight that would overflow an `i32` stays unchanged.
    #[inline(never)]
    pub(crate) fn descend(&mut self, length: i64, direction: &Coded) {
        GradientStep { length, back: 44u32.saturating_sub(direction.shift()) }
            .apply(&mut self.weights, direction.numbers());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coded_numbers_are_bounded() {
        for largest in [0, 1, 8190, 8191, 8192, 1 << 30, i32::MAX] {
            let (coded, filter): (&mut Coded, &mut Filter) =
                (&mut Coded::<Vec<i16, 2>>::new(), &mut Filter::<Vec<i32, 2>>::new());
            filter.restore(2, [largest, -largest].into_iter());
            filter.code(coded);
            assert!(coded.numbers.iter().all(|coded| u32::from(coded.unsigned_abs()) <= LARGEST), "{largest}");
            assert!(coded.shift == 0 || coded.numbers[0] > 4000, "{largest}");
        }
    }
}
