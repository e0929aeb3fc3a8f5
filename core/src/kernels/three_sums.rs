//! Filter responses at two rows of offsets by three sums of products instead of four (Karatsuba and Ofman, 1962).
//!
//! `w[i]` is row i of the filter, `X[m]` row m of the cells, and `w * X` their sums of products at all horizontal offsets:
//!
//! ```text
//! response[2k]     = sum over i of  w[2i] * X[2m]     + w[2i + 1] * X[2m + 1],    m = k + i
//! response[2k + 1] = sum over i of  w[2i] * X[2m + 1] + w[2i + 1] * X[2m + 2]
//!
//! upper[k] = sum over i of  w[2i] * (X[2m] - X[2m + 1])
//! both[k]  = sum over i of  (w[2i] + w[2i + 1]) * X[2m + 1]
//! lower[k] = sum over i of  w[2i + 1] * (X[2m + 2] - X[2m + 1])
//!
//! response[2k] = both[k] + upper[k],    response[2k + 1] = both[k] + lower[k]
//! ```
//!
//! Differences of cells and sums of two weights fit in 16 bits. Intermediate sums may wrap.

use super::unrolling::rolled;
use core::ops::Range;

/// Number of partial sums: `upper`, `both` and `lower`, with the indices 0 to 2.
pub(crate) const SUMS: usize = 3;
pub(crate) const BOTH: usize = 1;

/// Number of filter rows (`down`) and of rows of offsets (`span`), which determine the sizes of the three partial sums.
#[derive(Clone, Copy)]
pub(crate) struct PairedSizes {
    down: usize,
    span: usize,
}

/// Implemented by a backend: multiplies rows of cells by rows of filter factors.
pub(crate) trait Rows {
    /// Selects the cells to multiply: row `first`, minus row `second` if there is one.
    fn take(&mut self, first: usize, second: Option<usize>);

    /// Adds to each offset's sum the dot product of the selected cells with row `number` of [`PairedSizes::factors`].
    fn add(&mut self, number: usize, sums: &mut [i32]);
}

/// Rows of `count` factors that slide along rows of `width` numbers.
#[derive(Clone, Copy)]
pub(crate) struct Slide<T> {
    pub(crate) factors: *const T,
    pub(crate) count: usize,
    pub(crate) numbers: *const T,
    pub(crate) width: usize,
    pub(crate) rows: usize,
}

impl PairedSizes {
    pub(crate) fn new(down: usize, span: usize) -> Self {
        Self { down, span }
    }

    pub(crate) fn rows_of_factors(self) -> usize {
        2 * self.down.div_ceil(2) + self.down / 2
    }

    /// One or two rows of the filter. Their sum is row `number` of the factors.
    pub(crate) fn factors(self, number: usize) -> (usize, Option<usize>) {
        let half = half(self.down, BOTH);
        let sum = (number / half.max(1)).min(SUMS - 1);
        let first = 2 * (number - sum * half) + sum / 2;
        (first, Some(first + 1).filter(|&row| sum == BOTH && row < self.down))
    }

    pub(crate) fn both(self) -> usize {
        self.offsets_of(BOTH)
    }

    /// Number of rows that are multiplied for the partial sum `sum`: `upper` (0), `both` (1) or `lower` (2).
    #[allow(dead_code)] // for backends that go sum by sum
    pub(crate) fn rows_of(self, sum: usize) -> usize {
        half(self.down, sum)
    }

    /// Number of vertical offsets of the partial sum with index `sum`: `upper` (0), `both` (1) or `lower` (2).
    pub(crate) fn offsets_of(self, sum: usize) -> usize {
        half(self.span, sum)
    }

    /// Adds `parts` (two rows of cells each) to the filter responses. `both` and `out` must persist between calls.
    #[inline(always)]
    pub(crate) fn responses<const N: usize>(
        self,
        parts: Range<usize>,
        rows: &mut impl Rows,
        both: &mut [[i32; N]],
        out: &mut [[i32; N]],
    ) {
        let Self { down, span } = self;
        let count = down + span - 1;
        if parts.start == 0 {
            out.iter_mut().take(span).chain(&mut *both).for_each(|sums| sums.fill(0));
        }
        // One loop over parts and sums, because the compiler would unroll a loop over the three sums.
        let (mut part, mut sum) = (parts.start, 0);
        while part < parts.end && 2 * part + sum < count {
            rows.take(2 * part + sum, Some(2 * part + 1).filter(|&row| sum != BOTH && row < count));
            for number in (part + 1).saturating_sub(half(span, sum))..half(down, sum).min(part + 1) {
                let at = part - number;
                let sums = if sum == BOTH { both.get_mut(at) } else { out.get_mut(2 * at + sum / 2) };
                let Some(sums) = sums.and_then(|sums| sums.get_mut(..span)) else { continue };
                rows.add(sum * half(down, BOTH) + number, sums);
            }
            sum += 1;
            if sum == SUMS {
                (part, sum) = (part + 1, 0);
            }
        }
        if parts.end >= count.div_ceil(2) {
            for (number, out) in out.iter_mut().take(span).enumerate() {
                let Some(both) = both.get(number / 2) else { return };
                rolled(out.iter_mut().zip(both).take(span)).for_each(|(out, both)| *out = out.wrapping_add(*both));
            }
        }
    }
}

/// The number of even rows among `rows` rows, or of odd rows if `sum` is 2 (`lower`).
fn half(rows: usize, sum: usize) -> usize {
    (rows + 1 - sum / 2) / 2
}
