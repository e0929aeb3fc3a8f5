//! Weights of a filter: coded in 16 bits, moved along a gradient, scaled down. Helium and the DSP extension have loops
//! of their own.

use super::backend::native;

/// Numbers `weight * factor / 2^32 + sum * 2^left`, one for each pair of a weight and a sum. The quotient is rounded
/// down.
///
/// Each result is more than -2^31 and less than 2^31. A product or a sum alone may be larger.
#[derive(Clone, Copy)]
#[cfg_attr(any(test, feature = "unstable"), derive(Debug))]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded() {
        for number in [i32::MIN, i32::MIN + 1, -70_000, -3, -2, -1, 0, 1, 2, 3, 70_000, i32::MAX - 1, i32::MAX] {
            let numbers = ScaledSums::of(core::slice::from_ref(&number));
            assert_eq!(numbers.largest(), number.unsigned_abs());
            for shift in 0..32 {
                let rounded = (i64::from(number) + (1 << shift >> 1)) >> shift;
                let Ok(rounded) = i16::try_from(rounded) else { continue };
                let mut out = [7];
                numbers.code(shift, &mut out);
                assert_eq!(out, [rounded], "{number} >> {shift}");
            }
        }
    }

    #[test]
    fn the_largest_is_rounded_down_without_its_sign() {
        let largest = |weight, factor: i64, sum, left| {
            ScaledSums { weights: &[weight], factor: factor << 16, sums: &[sum], left }.largest()
        };
        assert_eq!([largest(1, 1 << 15, 3, 1), largest(-1, 1 << 15, -3, 1), largest(-1, 1 << 16, -3, 1)], [6, 6, 7]);
        assert_eq!(largest(-1, 1 << 15, 0, 0), 0);
    }

    #[test]
    fn numbers_are_lessened() {
        for part in [0, 1, 8191, 8192, 16_383, 16_384] {
            let before = [-8191, -4097, -2, -1, 0, 1, 2, 3, 4097, 8191];
            let mut numbers = before;
            let sum = scale_by(&mut numbers, part);
            let wanted = before.map(|number| (f64::from(number) * f64::from(part) / 16_384.0 + 0.5).floor());
            assert_eq!(numbers.map(f64::from), wanted, "{part}");
            assert_eq!(f64::from(sum), wanted.iter().zip(before).map(|(a, b)| a * f64::from(b)).sum::<f64>());
        }
    }

    #[test]
    fn weights_stay_where_there_is_no_room() {
        let moved = |weight, slope, length, back| {
            let mut weights = [weight];
            GradientStep { length, back }.apply(&mut weights, &[slope]);
            weights[0]
        };
        assert_eq!([moved(100, 3, 1 << 20, 20), moved(100, -3, 3 << 19, 20), moved(5, 1, -1, 1)], [97, 104, 5]);
        assert_eq!([moved(i32::MIN, 1, 1 << 20, 20), moved(i32::MIN + 1, 1, 1 << 20, 20)], [i32::MIN; 2]);
        assert_eq!([moved(7, 8191, (1 << 47) - 1, 7), moved(i32::MAX, -8191, 1 << 47, 44)], [7, i32::MAX]);
    }
}
