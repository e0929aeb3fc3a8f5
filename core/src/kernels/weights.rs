//! Weights of a filter: as numbers of 16 bits, and moved. Helium takes four at a time.

use super::unrolling::rolled_if_spare;
#[cfg(smr_helium)]
use core::arch::asm;

/// Numbers that are made of a weight and a sum each: weight * factor / 2^32, rounded down, and the sum times 2 to the power `left`. Each
/// is more than -2^31 and less than 2^31; of what it is made of that need not hold.
#[derive(Clone, Copy)]
pub(crate) struct Numbers<'a> {
    pub(crate) weights: &'a [i32],
    pub(crate) factor: i64,
    pub(crate) sums: &'a [i32],
    pub(crate) left: u32,
}

impl<'a> Numbers<'a> {
    /// The sums alone; they may be -2^31.
    pub(crate) fn of(sums: &'a [i32]) -> Self {
        Self { weights: sums, factor: 0, sums, left: 0 }
    }

    /// The largest without its sign, which is taken away before it is rounded down.
    #[inline(never)] // one copy in flash
    pub(crate) fn largest(self) -> u32 {
        #[cfg(smr_helium)]
        if let Ok(factor) = i32::try_from(self.factor) {
            let largest = self.fast_largest(factor);
            #[cfg(feature = "verify")]
            assert_eq!(largest, self.plain_largest(), "the largest number");
            return largest;
        }
        self.plain_largest()
    }

    fn plain_largest(self) -> u32 {
        let Self { weights, factor, sums, left } = self;
        let size = |(&weight, &sum): (&i32, &i32)| match number(weight, factor, sum << left) {
            number @ 0.. => number.unsigned_abs(),
            _ => number(weight, -factor, (sum << left).wrapping_neg()).cast_unsigned(),
        };
        rolled_if_spare(weights.iter().zip(sums)).map(size).max().unwrap_or(0)
    }

    /// All of them divided by 2 to the power `shift` and rounded. They then have 16 bits.
    #[inline(never)] // one copy in flash
    pub(crate) fn code(self, shift: u32, out: &mut [i16]) {
        #[cfg(smr_helium)]
        if let Ok(factor) = i32::try_from(self.factor) {
            self.fast_code(factor, shift, out);
            #[cfg(feature = "verify")]
            assert!(out.iter().copied().zip(self.coded(shift)).all(|(given, wanted)| given == wanted), "coded numbers");
            return;
        }
        out.iter_mut().zip(self.coded(shift)).for_each(|(out, coded)| *out = coded);
    }

    fn coded(self, shift: u32) -> impl Iterator<Item = i16> {
        let Self { weights, factor, sums, left } = self;
        // What is rounded up is the last bit that is lost: there is not room for half of the divisor in every sum.
        let (first, last) = (shift.saturating_sub(1), shift.min(1));
        let shifted = move |number: i32| ((number >> first) + last.cast_signed()) >> last;
        rolled_if_spare(weights.iter().zip(sums))
            .map(move |(&weight, &sum)| low(shifted(number(weight, factor, sum << left))))
    }

    #[cfg(smr_helium)]
    fn fast_largest(self, factor: i32) -> u32 {
        let count = self.weights.len().min(self.sums.len());
        let mut largest = 0;
        if count == 0 {
            return largest;
        }
        // SAFETY: `count` numbers of each are there, and the last round has as many lanes as are left.
        unsafe {
            asm!(
                "vdup.32 q4, {factor}",
                "vneg.s32 q5, q4",
                "dlstp.32 lr, {count}",
                "2:",
                "vldrw.u32 q0, [{weights}], #16",
                "vldrw.u32 q1, [{sums}], #16",
                "vshl.s32 q1, {left}",
                "vmulh.s32 q2, q0, q4",
                "vadd.i32 q2, q2, q1",
                "vmulh.s32 q3, q0, q5",
                "vsub.i32 q3, q3, q1",
                "vpt.s32 lt, q2, zr",
                "vorrt q2, q3, q3",
                "vmaxv.u32 {largest}, q2",
                "letp lr, 2b",
                weights = inout(reg) self.weights.as_ptr() => _,
                sums = inout(reg) self.sums.as_ptr() => _,
                factor = in(reg) factor,
                left = in(reg) self.left,
                largest = inout(reg) largest,
                count = in(reg) count,
                out("lr") _,
                out("q0") _,
                out("q1") _,
                out("q2") _,
                out("q3") _,
                out("q4") _,
                out("q5") _,
                options(readonly, nostack),
            );
        }
        largest
    }

    #[cfg(smr_helium)]
    fn fast_code(self, factor: i32, shift: u32, out: &mut [i16]) {
        let count = self.weights.len().min(self.sums.len()).min(out.len());
        if count == 0 {
            return;
        }
        // SAFETY: `count` numbers of each are there, and the last round has as many lanes as are left.
        unsafe {
            asm!(
                "vdup.32 q2, {factor}",
                "dlstp.32 lr, {count}",
                "2:",
                "vldrw.u32 q0, [{weights}], #16",
                "vldrw.u32 q1, [{sums}], #16",
                "vmulh.s32 q0, q0, q2",
                "vshl.s32 q1, {left}",
                "vadd.i32 q0, q0, q1",
                "vrshl.s32 q0, {right}",
                "vstrh.32 q0, [r0], #8",
                "letp lr, 2b",
                weights = inout(reg) self.weights.as_ptr() => _,
                sums = inout(reg) self.sums.as_ptr() => _,
                factor = in(reg) factor,
                left = in(reg) self.left,
                right = in(reg) shift.wrapping_neg(),
                count = in(reg) count,
                inout("r0") out.as_mut_ptr() => _,
                out("lr") _,
                out("q0") _,
                out("q1") _,
                out("q2") _,
                options(nostack),
            );
        }
    }
}

/// One of them.
#[inline(always)]
#[allow(clippy::cast_possible_truncation)] // see `Numbers`
fn number(weight: i32, factor: i64, sum: i32) -> i32 {
    ((i64::from(weight).wrapping_mul(factor) >> 32) as i32).wrapping_add(sum)
}

/// The lower 16 bits, which are all that there are.
#[allow(clippy::cast_possible_truncation)]
fn low(number: i32) -> i16 {
    number as i16
}

/// How far weights move: the slope of each times `length`, less `back` places, 0 to 62, rounded. No product reaches 2^62.
#[derive(Clone, Copy)]
pub(crate) struct Move {
    pub(crate) length: i64,
    pub(crate) back: u32,
}

impl Move {
    /// Moves weights down their slopes; those that would leave an `i32` stay.
    #[inline(never)] // one copy in flash
    pub(crate) fn apply(self, weights: &mut [i32], slopes: &[i16]) {
        #[cfg(feature = "verify")]
        let wanted: heapless::Vec<i32, 4096> = weights.iter().zip(slopes).map(|(&w, &s)| self.moved(w, s)).collect();
        if !self.fast(weights, slopes) {
            rolled_if_spare(weights.iter_mut().zip(slopes))
                .for_each(|(weight, &slope)| *weight = self.moved(*weight, slope));
        }
        #[cfg(feature = "verify")]
        assert!(weights.iter().zip(&wanted).all(|(given, wanted)| given == wanted), "moved weights");
    }

    fn moved(self, weight: i32, slope: i16) -> i32 {
        let change = (i64::from(slope) * self.length + (1 << self.back >> 1)) >> self.back;
        i32::try_from(i64::from(weight) - change).unwrap_or(weight)
    }

    #[cfg(not(smr_helium))]
    fn fast(self, _: &mut [i32], _: &[i16]) -> bool {
        false
    }

    /// False, and nothing is moved, if changes might leave an `i32` or the numbers below.
    ///
    /// A product is made of three, of 16 bits of the length each: what is beyond the lower 16 bits of one is added to the next. With any
    /// slope the first two fit in an `i32`, and with a length below 2^47 the third one does. The changes fit where the length is below
    /// 2^(15 + back). What is rounded by is no part of the lowest 16 bits if `back` is more than 16.
    #[cfg(smr_helium)]
    fn fast(self, weights: &mut [i32], slopes: &[i16]) -> bool {
        let Self { length, back } = self;
        let count = weights.len().min(slopes.len());
        if count == 0 || !(17..=47).contains(&back) || length.unsigned_abs() >> (15 + back).min(47) != 0 {
            return false;
        }
        let half = 1_i64 << (back - 1);
        let piece = |number: i64| u32::try_from(number & 0xFFFF).unwrap_or(0);
        let upper = |number: i64| i32::try_from(number >> 32).unwrap_or(0);
        // SAFETY: `count` numbers of each are there, and the last round has as many lanes as are left.
        unsafe {
            asm!(
                "dlstp.32 lr, lr",
                "2:",
                "vldrh.s32 q0, [r0], #8",
                "vmul.i32 q1, q0, {first}",
                "vshr.s32 q1, q1, #16",
                "vadd.i32 q1, q1, {half}",
                "vmla.i32 q1, q0, {second}",
                "vshr.s32 q2, q1, #16",
                "vadd.i32 q2, q2, {upper_half}",
                "vmla.i32 q2, q0, {third}",
                "vmovlb.u16 q1, q1",
                "vshl.u32 q1, {right}",
                "vshl.s32 q2, {left}",
                "vadd.i32 q1, q1, q2",
                "vldrw.u32 q0, [{weights}]",
                "vsub.i32 q2, q0, q1",
                "vqsub.s32 q0, q0, q1",
                "vpt.i32 eq, q0, q2",
                "vstrwt.32 q0, [{weights}]",
                "adds {weights}, #16",
                "letp lr, 2b",
                weights = inout(reg) weights.as_mut_ptr() => _,
                first = in(reg) piece(length),
                second = in(reg) piece(length >> 16),
                third = in(reg) upper(length),
                half = in(reg) piece(half >> 16),
                upper_half = in(reg) upper(half),
                // A shift to the left by less than 0 is one to the right.
                left = in(reg) 32_u32.wrapping_sub(back),
                right = in(reg) 16_u32.wrapping_sub(back),
                inout("r0") slopes.as_ptr() => _,
                inout("lr") count => _,
                out("q0") _,
                out("q1") _,
                out("q2") _,
                options(nostack),
            );
        }
        true
    }
}

/// Makes of at most 16 numbers, each at most 8191, so many 16384ths, at most all, rounded; and gives the sum of the products of what they
/// were and what they are, below 2^31.
#[inline(always)] // into its one caller
pub(crate) fn lessen_by(numbers: &mut [i16], part: i32) -> i32 {
    #[cfg(not(smr_helium))]
    return plain_lessen_by(numbers, part);
    #[cfg(smr_helium)]
    {
        #[cfg(feature = "verify")]
        let mut wanted: heapless::Vec<i16, 16> = numbers.iter().copied().collect();
        let sum = fast_lessen_by(numbers, part);
        #[cfg(feature = "verify")]
        assert_eq!((plain_lessen_by(&mut wanted, part), &*wanted), (sum, &*numbers), "lessened numbers");
        sum
    }
}

#[cfg(any(not(smr_helium), feature = "verify"))]
#[inline(always)]
fn plain_lessen_by(numbers: &mut [i16], part: i32) -> i32 {
    let less = |number: i16| low((i32::from(number) * part + (1 << 13)) >> 14);
    rolled_if_spare(numbers.iter_mut())
        .map(|number| i32::from(core::mem::replace(number, less(*number))) * i32::from(*number))
        .sum()
}

#[cfg(smr_helium)]
#[inline(always)]
fn fast_lessen_by(numbers: &mut [i16], part: i32) -> i32 {
    let mut sum = 0;
    if numbers.is_empty() {
        return sum;
    }
    // What is multiplied is doubled twice, once by the instruction: so 2^15 is half of what is taken away.
    // SAFETY: as many numbers are there; the last round has as many lanes as are left.
    unsafe {
        asm!(
            "dlstp.16 lr, {count}",
            "2:",
            "vldrh.u16 q0, [{numbers}]",
            "vadd.i16 q1, q0, q0",
            "vqrdmulh.s16 q1, q1, {part}",
            "vstrh.16 q1, [{numbers}], #16",
            "vmladava.s16 r0, q0, q1",
            "letp lr, 2b",
            numbers = inout(reg) numbers.as_mut_ptr() => _,
            count = in(reg) numbers.len(),
            part = in(reg) part,
            inout("r0") sum,
            out("lr") _,
            out("q0") _,
            out("q1") _,
            options(nostack),
        );
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded() {
        for number in [i32::MIN, i32::MIN + 1, -70_000, -3, -2, -1, 0, 1, 2, 3, 70_000, i32::MAX - 1, i32::MAX] {
            let numbers = Numbers::of(core::slice::from_ref(&number));
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
            Numbers { weights: &[weight], factor: factor << 16, sums: &[sum], left }.largest()
        };
        assert_eq!([largest(1, 1 << 15, 3, 1), largest(-1, 1 << 15, -3, 1), largest(-1, 1 << 16, -3, 1)], [6, 6, 7]);
        assert_eq!(largest(-1, 1 << 15, 0, 0), 0);
    }

    #[test]
    fn numbers_are_lessened() {
        for part in [0, 1, 8191, 8192, 16_383, 16_384] {
            let before = [-8191, -4097, -2, -1, 0, 1, 2, 3, 4097, 8191];
            let mut numbers = before;
            let sum = lessen_by(&mut numbers, part);
            let wanted = before.map(|number| (f64::from(number) * f64::from(part) / 16_384.0 + 0.5).floor());
            assert_eq!(numbers.map(f64::from), wanted, "{part}");
            assert_eq!(f64::from(sum), wanted.iter().zip(before).map(|(a, b)| a * f64::from(b)).sum::<f64>());
        }
    }

    #[test]
    fn weights_stay_where_there_is_no_room() {
        let moved = |weight, slope, length, back| {
            let mut weights = [weight];
            Move { length, back }.apply(&mut weights, &[slope]);
            weights[0]
        };
        assert_eq!([moved(100, 3, 1 << 20, 20), moved(100, -3, 3 << 19, 20), moved(5, 1, -1, 1)], [97, 104, 5]);
        assert_eq!([moved(i32::MIN, 1, 1 << 20, 20), moved(i32::MIN + 1, 1, 1 << 20, 20)], [i32::MIN; 2]);
        assert_eq!([moved(7, 8191, (1 << 47) - 1, 7), moved(i32::MAX, -8191, 1 << 47, 44)], [7, i32::MAX]);
    }
}
