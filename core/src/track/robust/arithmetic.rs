//! 64-bit division. On 32-bit processors a loop divides bit by bit: the compiler's function is faster, but takes 1 KB
//! of flash, and an update does few 64-bit divisions.

/// `number` / `divisor`, rounded toward zero; 0 if `divisor` is 0.
#[inline(never)]
pub(super) fn quotient(number: i64, divisor: i64) -> i64 {
    let size = divided(number.unsigned_abs(), divisor.unsigned_abs()).cast_signed();
    if (number < 0) == (divisor < 0) { size } else { size.wrapping_neg() }
}

#[cfg(target_pointer_width = "64")]
fn divided(number: u64, divisor: u64) -> u64 {
    number.checked_div(divisor).unwrap_or(0)
}

#[cfg(not(target_pointer_width = "64"))]
fn divided(number: u64, divisor: u64) -> u64 {
    long_division(number, divisor)
}

/// Long division in binary; 0 if `divisor` is 0.
#[cfg(any(not(target_pointer_width = "64"), test))]
fn long_division(number: u64, divisor: u64) -> u64 {
    if divisor == 0 {
        return 0;
    }
    // Aligns the highest bits of divisor and number, then shifts the divisor back bit by bit.
    let places = divisor.leading_zeros().saturating_sub(number.leading_zeros());
    let (mut rest, mut subtracted, mut quotient) = (number, divisor << places, 0);
    for _ in 0..=places {
        quotient <<= 1;
        if rest >= subtracted {
            rest -= subtracted;
            quotient += 1;
        }
        subtracted >>= 1;
    }
    quotient
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bit_by_bit_the_quotient_is_the_same(number: u64, divisor: u64, less in 0u32..64, shorter in 0u32..64) {
            let (number, divisor) = (number >> less, divisor >> shorter);
            prop_assert_eq!(long_division(number, divisor), number.checked_div(divisor).unwrap_or(0));
        }

        #[test]
        fn a_quotient_is_rounded_toward_zero(number in -(1i64 << 60)..1 << 60, divisor in -(1i64 << 40)..1 << 40) {
            prop_assert_eq!(quotient(number, divisor), number.checked_div(divisor).unwrap_or(0));
        }
    }
}
