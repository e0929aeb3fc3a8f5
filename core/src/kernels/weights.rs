//! Weights of a filter: coded in 16 bits, moved along a gradient, scaled down. Helium and the DSP extension have loops
//! of their own.

#[cfg(smr_dsp)]
use super::arm::dsp::weights as dsp;
#[cfg(smr_helium)]
use super::arm::helium::weights as helium;
use super::plain::weights as plain;
use super::unrolling::rolled_if_spare;

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
        #[cfg(smr_helium)]
        if let Ok(factor) = i32::try_from(factor) {
            let largest = helium::largest(weights, factor, sums, left);
            #[cfg(any(test, feature = "verify"))]
            assert_eq!(largest, plain::largest(weights, factor.into(), sums, left), "the largest number");
            return largest;
        }
        #[cfg(smr_dsp)]
        {
            let largest = dsp::largest(weights, factor, sums, left);
            #[cfg(any(test, feature = "verify"))]
            assert_eq!(largest, plain::largest(weights, factor, sums, left), "the largest number");
            return largest;
        }
        #[cfg(not(smr_dsp))]
        plain::largest(weights, factor, sums, left)
    }

    /// Codes all numbers: divides them by `2^shift` and rounds. The caller chooses `shift` so that they fit in 16 bits.
    #[inline(never)]
    pub(crate) fn code(self, shift: u32, out: &mut [i16]) {
        let Self { weights, factor, sums, left } = self;
        #[cfg(any(not(smr_dsp), test, feature = "verify"))]
        let coded = plain::code(weights, factor, sums, left, shift);
        #[cfg(smr_helium)]
        if let Ok(factor) = i32::try_from(factor) {
            helium::code(weights, factor, sums, left, shift, out);
            #[cfg(any(test, feature = "verify"))]
            assert!(out.iter().copied().zip(coded).all(|(given, wanted)| given == wanted), "coded numbers");
            return;
        }
        #[cfg(smr_dsp)]
        {
            dsp::code(weights, factor, sums, left, shift, out);
            #[cfg(any(test, feature = "verify"))]
            assert!(out.iter().copied().zip(coded).all(|(given, wanted)| given == wanted), "coded numbers");
        }
        #[cfg(not(smr_dsp))]
        out.iter_mut().zip(coded).for_each(|(out, coded)| *out = coded);
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
        let stepped = |weight, slope| plain::stepped(weight, slope, length, back);
        #[cfg(any(test, feature = "verify"))]
        let wanted: heapless::Vec<i32, 4096> = weights.iter().zip(slopes).map(|(&w, &s)| stepped(w, s)).collect();
        #[cfg(smr_helium)]
        let done = helium::step(weights, slopes, length, back);
        #[cfg(smr_dsp)]
        let done = dsp::step(weights, slopes, length, back);
        #[cfg(not(any(smr_dsp, smr_helium)))]
        let done = false;
        if !done {
            rolled_if_spare(weights.iter_mut().zip(slopes))
                .for_each(|(weight, &slope)| *weight = stepped(*weight, slope));
        }
        #[cfg(any(test, feature = "verify"))]
        assert!(weights.iter().zip(&wanted).all(|(given, wanted)| given == wanted), "moved weights");
    }
}

/// Multiplies up to 16 numbers (each at most 8191) by `part / 16384`, rounded. `part` is at most 16384. Returns the sum
/// of the products of old and new numbers, which is below 2^31.
#[inline(always)]
pub(crate) fn scale_by(numbers: &mut [i16], part: i32) -> i32 {
    #[cfg(not(smr_helium))]
    return plain::scale_by(numbers, part);
    #[cfg(smr_helium)]
    {
        #[cfg(any(test, feature = "verify"))]
        let mut wanted: heapless::Vec<i16, 16> = numbers.iter().copied().collect();
        let sum = helium::scale_by(numbers, part);
        #[cfg(any(test, feature = "verify"))]
        assert_eq!((plain::scale_by(&mut wanted, part), &*wanted), (sum, &*numbers), "scaled numbers");
        sum
    }
}
