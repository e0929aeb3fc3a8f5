//! Weights of a filter: coded in 16 bits, moved along a gradient, scaled down. Helium and the DSP extension have loops
//! of their own.

use super::backend::native;

/// Numbers `weight * factor / 2^32 + sum * 2^left`, one for each pair of a weight and a sum. The quotient is rounded
/// down.
///
/// Each result is more than -2^31 and less than 2^31. A product or a sum alone may be larger.
#[derive(Clone, Copy)]
pub(crate) struct ScaledSums<'a> {
    pub(crate) weights: &'a [i32],
    pub(crate) factor: i64,
    pub(crate) sums: &'a [i32],
    pub(crate) left: u32,
}

impl<'a> ScaledSums<'a> {
    /// The sums alone, without weights. They may be -2^31.
    pub(crate) fn of(sums: &'a [i32]) -> Self {
        Self { weights: sums, factor: 0, sums, left: 0 }
    }

    /// The largest absolute value.
    #[inline(never)]
    pub(crate) fn largest(self) -> u32 {
        let Self { weights, factor, sums, left } = self;
        native::weights::largest(weights, factor, sums, left)
    }

    /// Codes all numbers: divides them by `2^shift` and rounds. The caller chooses `shift` so that they fit in 16 bits.
    #[inline(never)]
    pub(crate) fn code(self, shift: u32, out: &mut [i16]) {
        let Self { weights, factor, sums, left } = self;
        native::weights::code(weights, factor, sums, left, shift, out);
    }
}

/// A step against a gradient: subtracts `slope * length / 2^back`, rounded, from each weight. `back` is 0 to 62, and no
/// product reaches 2^62.
#[derive(Clone, Copy)]
pub(crate) struct GradientStep {
    pub(crate) length: i64,
    pub(crate) back: u32,
}

impl GradientStep {
    /// Takes the step. A weight that would overflow an `i32` stays.
    #[inline(never)]
    pub(crate) fn apply(self, weights: &mut [i32], slopes: &[i16]) {
        let Self { length, back } = self;
        debug_assert!(back <= 62);
        native::weights::step(weights, slopes, length, back);
    }
}

/// Multiplies up to 16 numbers (each at most 8191) by `part / 16384`, rounded. `part` is at most 16384. Returns the sum
/// of the products of old and new numbers, which is below 2^31.
#[inline(always)]
pub(crate) fn scale_by(numbers: &mut [i16], part: i32) -> i32 {
    debug_assert!(numbers.len() <= 16 && numbers.iter().all(|number| number.unsigned_abs() <= 8191));
    debug_assert!((0..=1 << 14).contains(&part));
    native::weights::scale_by(numbers, part)
}
