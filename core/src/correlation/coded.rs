//! Numbers coded in 16 bits each, with one power of two for all (block floating point).

use super::Window;
use crate::kernels::{Packed, Products, ScaledSums, rolled};
use heapless::Vec;

/// The largest coded number: 2000 of them times a byte stay below 2^31.
pub(crate) const LARGEST: u32 = 8191;

/// Up to `N` coded numbers. The value of each is number * 2^`shift`.
pub(crate) struct Coded<const N: usize> {
    numbers: Vec<i16, N>,
    shift: u32,
}

impl<const N: usize> Coded<N> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { numbers: Vec::new(), shift: 0 }
    }

    pub(crate) fn numbers(&self) -> &[i16] {
        &self.numbers
    }

    pub(crate) fn numbers_mut(&mut self) -> &mut [i16] {
        &mut self.numbers
    }

    pub(crate) const fn shift(&self) -> u32 {
        self.shift
    }

    /// Codes `count` numbers in units of 2^`unit`. `largest` is the largest absolute value among them.
    #[cfg_attr(smr_small, inline(never))]
    pub(crate) fn set(&mut self, numbers: ScaledSums<'_>, count: usize, largest: u32, unit: u32) {
        let shift = shift_below(largest, LARGEST);
        // Cannot fail: no caller has more than `N`.
        let _ = self.numbers.resize_default(count);
        numbers.code(shift, &mut self.numbers);
        self.shift = unit + shift;
    }

    /// Computes one piece of the responses at all offsets, in units of 2^`shift`. Returns true after the last piece.
    pub(crate) fn respond<const S: usize>(
        &self,
        products: Products,
        packed: &mut Packed,
        spare: &mut [i32],
        Window { cells, layout }: Window<'_>,
        piece: usize,
        out: &mut [[i32; S]; S],
    ) -> bool {
        products.responses(piece..piece + 1, packed, spare, cells, layout, &self.numbers, out);
        piece + 1 >= products.parts(layout, self.numbers.len())
    }

    /// Converts responses from units of 2^`shift` * 2^-16 / 16384 to 1/16384: times 2^(`shift` - 16), clamped to
    /// +-2^24.
    ///
    /// They are clamped before a shift to the left, so that no bit is lost.
    #[inline(never)]
    pub(crate) fn scale<const S: usize>(&self, rows: &mut [[i32; S]]) {
        let (left, right) = (self.shift.saturating_sub(16), 16_u32.saturating_sub(self.shift));
        let most = (1 << 24) >> left;
        rolled(rows.as_flattened_mut().iter_mut()).for_each(|sum| *sum = (*sum >> right).min(most).max(-most) << left);
    }
}

/// The least shift to the right that makes `largest` less than `bound`.
#[cfg_attr(smr_small, inline(never))]
pub(crate) fn shift_below(largest: u32, bound: u32) -> u32 {
    let mut shift = 0;
    while largest >> shift >= bound {
        shift += 1;
    }
    shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coded_numbers_are_bounded() {
        for largest in [0, 1, 8190, 8191, 8192, 1 << 30, i32::MAX] {
            let (mut coded, numbers) = (Coded::<2>::new(), [largest, -largest]);
            let numbers = ScaledSums::of(&numbers);
            coded.set(numbers, 2, numbers.largest(), 0);
            assert!(coded.numbers.iter().all(|coded| u32::from(coded.unsigned_abs()) <= LARGEST), "{largest}");
            assert!(coded.shift == 0 || coded.numbers[0] > 4000, "{largest}");
        }
    }
}
