//! The table of p, the similarity of two pixels: an exponential of their difference (step 3 of the method).
//!
//! A `const fn` computes it in integers, so it is a constant in flash and the same on every platform.

use crate::kernels::{self, CutTable};
use core::fmt;

/// A table of the similarity p: entry d is 65535 * exp(-d / scale), rounded to the nearest integer. 512 bytes.
///
/// The unit is 1/65535 ([`Table::ONE`]): 1.0 is exact, and an entry fits in 16 bits. A score is the sum of at most
/// [`Table::MAX_PIXELS`] = 65537 entries, and 65537 * 65535 = 2^32 - 1: it never overflows a `u32`.
///
/// ```
/// use smr_core::similarity::Table;
/// static STEEP: Table = match Table::new(40) {
///     Ok(table) => table,
///     Err(_) => panic!("40 is in range"), // at compile time
/// };
/// assert_eq!(STEEP.similarity(0), Table::ONE);
/// assert_eq!(STEEP.similarity(40), 24109); // 65535 / e
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    entries: [u16; 256],
}

/// Prints one entry, which identifies the scale. All 256 would be a kilobyte of log.
#[cfg(feature = "defmt")]
impl defmt::Format for Table {
    fn format(&self, to: defmt::Formatter<'_>) {
        defmt::write!(to, "Table(p(1) = {=u16})", self.similarity(1));
    }
}

/// The only copy of [`Table::PAPER`] in flash. The constant itself would be copied into every crate that borrows it.
pub(crate) static PAPER: Table = Table::PAPER;

impl Table {
    /// The similarity of equal pixels: 65535, which stands for 1.0.
    pub const ONE: u16 = kernels::ONE;

    /// The largest number of pixels whose similarities a score can sum without overflow: 65537.
    pub const MAX_PIXELS: usize = kernels::MAX_PIXELS;

    /// The scales that [`Table::new`] accepts, from that of the steepest table (1) to that of the flattest (4096).
    pub const SCALES: core::ops::RangeInclusive<u16> = 1..=4096;

    /// The paper's table: intensities run from 0 to 1, so a difference of d gray levels has p = exp(-d / 255).
    pub const PAPER: Self = Self::exponential(255);

    /// The table of exp(-d / scale), for a scale of 1 (almost only equal pixels are similar) to 4096 (almost all are).
    ///
    /// # Errors
    /// [`TableError::ScaleOutOfRange`] outside [`Table::SCALES`].
    pub const fn new(scale: u16) -> Result<Self, TableError> {
        if scale < *Self::SCALES.start() || scale > *Self::SCALES.end() {
            return Err(TableError::ScaleOutOfRange);
        }
        Ok(Self::exponential(scale))
    }

    /// The similarity p, in units of 1/65535, of two pixels that differ by `difference` gray levels.
    #[must_use]
    #[inline]
    #[allow(clippy::indexing_slicing)] // a u8 cannot be out of the bounds of 256 entries
    pub const fn similarity(&self, difference: u8) -> u16 {
        self.entries[difference as usize]
    }

    /// All 256 entries, indexed by the difference in gray levels.
    #[must_use]
    pub const fn entries(&self) -> &[u16; 256] {
        &self.entries
    }

    const fn exponential(scale: u16) -> Self {
        let mut table = Self { entries: [Self::ONE; 256] };
        table.fill(scale);
        table
    }

    /// Computes entry d as 65535 * r^d with r = exp(-1 / scale) in 64 fractional bits: one multiplication per entry. r
    /// is too small by less than 2^-64, and each multiplication increases the error by less than 2^-63. So r^255 is too
    /// small by less than 2^-55, and 65535 * r^255 by less than 2^-39. For no scale is an exact value that close to the
    /// middle between two integers (a test tries all scales), so the rounding is correct.
    #[allow(clippy::indexing_slicing, clippy::cast_possible_truncation)] // d < 256; every quotient is below 2^16
    const fn fill(&mut self, scale: u16) {
        const HALF: u128 = 1 << 63;
        let r = exp_of_minus_one_over(scale);
        self.entries[0] = Self::ONE;
        let mut power = r;
        let mut d = 1;
        while d < 256 {
            self.entries[d] = ((power * Self::ONE as u128 + HALF) >> 64) as u16;
            power = (power * r) >> 64;
            d += 1;
        }
    }
}

impl CutTable {
    /// The entries of `table` for differences below `threshold` (0..=256); 0 for larger differences.
    #[cfg(any(test, feature = "unstable"))]
    #[must_use]
    pub fn new(table: &Table, threshold: u16) -> Self {
        let mut cut = Self::EMPTY;
        cut.set(table, threshold);
        cut
    }

    /// Sets the entries to those of `table` for differences below `threshold`, and to 0 for larger ones.
    #[inline(always)]
    pub(crate) fn set(&mut self, table: &Table, threshold: u16) {
        self.cut(table.entries(), threshold);
    }
}

/// exp(-1 / scale) in 64 fractional bits, by the alternating series 1 - x + x^2/2! - x^3/3! + ... with x = 1 / scale,
/// summed in 120 fractional bits until the terms vanish (33 terms for the steepest scale, 1).
const fn exp_of_minus_one_over(scale: u16) -> u128 {
    let mut term: u128 = 1 << 120;
    let mut sum: u128 = 0;
    let mut n = 0;
    while term > 0 {
        if n % 2 == 0 {
            sum += term;
        } else {
            sum -= term;
        }
        n += 1;
        term = match term.checked_div(scale as u128 * n) {
            Some(term) => term,
            None => 0, // never: the divisor is not 0
        };
    }
    sum >> 56
}

/// The reason why a table was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TableError {
    /// The scale is not in [`Table::SCALES`].
    ScaleOutOfRange,
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the scale of the table must be 1 to 4096")
    }
}

impl core::error::Error for TableError {}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares each entry with the value in `f64`, whose error here is below 2^-33; the error of `fill` is below
    /// 2^-39. No value before rounding, at any scale, is within 2^-28 of the middle between two integers, so both round
    /// to the same integer.
    #[test]
    fn every_entry_is_the_correctly_rounded_exponential() {
        for scale in Table::SCALES {
            let table = Table::new(scale).unwrap();
            for d in 0..=255u8 {
                let exact = 65535.0 * (-f64::from(d) / f64::from(scale)).exp();
                assert!((exact.fract() - 0.5).abs() > f64::powi(2.0, -28), "scale {scale}, difference {d}: {exact}");
                assert_eq!(f64::from(table.similarity(d)), exact.round(), "scale {scale}, difference {d}");
            }
        }
    }

    #[test]
    fn the_largest_score_fits_a_u32() {
        assert_eq!(Table::MAX_PIXELS as u64 * u64::from(Table::ONE), u64::from(u32::MAX));
    }

    #[test]
    fn scales_outside_the_range_are_refused() {
        assert_eq!(Table::new(0), Err(TableError::ScaleOutOfRange));
        assert_eq!(Table::new(4097), Err(TableError::ScaleOutOfRange));
    }
}
