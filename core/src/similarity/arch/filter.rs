//! What the backends for Arm's microcontrollers share: a bound that excludes offsets without the table.
//!
//! A pixel that counts and differs by d loses at least c * d of its 65535 ([`scalar::chord`]), one that does not loses all.
//! How many do not, and the sum of the differences of those that do, are sums of bytes, and that is what these instruction
//! sets are fast at; a table they can only look up pixel by pixel. So an offset is first tried by this bound, and scored by
//! the plain loop if that does not exclude it.

use super::super::{Table, scalar};
use super::rows::Rows;
use crate::image::Image;

/// What two rows have of each other.
pub(super) struct Compared {
    /// How many pixels do not count.
    pub(super) different: u32,
    /// The sum of the differences of those that do.
    pub(super) differences: u32,
}

/// A table, cut off at a threshold, and the bound that goes with it.
pub(super) struct Filter {
    table: &'static Table,
    threshold: u16,
    chord: u32,
}

impl Filter {
    pub(super) fn new(table: &'static Table, threshold: u16) -> Self {
        Self { table, threshold, chord: scalar::chord(table, threshold) }
    }

    /// As [`scalar::score_at_least`]. `compare` is given the addresses of two rows, their width, which is at least
    /// `NARROWEST`, and the threshold (1..=255).
    #[inline(always)] // into the one function of a backend that calls it
    pub(super) fn score_at_least<const NARROWEST: usize>(
        &self,
        patch: Image<'_>,
        template: Image<'_>,
        floor: u32,
        compare: impl FnMut(*const u8, *const u8, usize, u8) -> Compared,
    ) -> Option<u32> {
        let pair = Rows::of(patch, template);
        if pair.width >= NARROWEST && self.excludes(&pair, floor, compare) {
            return None;
        }
        scalar::score_at_least(patch, template, self.table, self.threshold, floor)
    }

    /// True only if the score is less than `floor`.
    #[inline(always)]
    fn excludes(
        &self,
        pair: &Rows,
        floor: u32,
        mut compare: impl FnMut(*const u8, *const u8, usize, u8) -> Compared,
    ) -> bool {
        let threshold = match u8::try_from(self.threshold) {
            // No score is less than 0, which is the floor of those who want any score.
            Ok(threshold) if threshold > 0 && floor > 0 => threshold,
            _ => return false,
        };
        let mut reachable = scalar::full(pair.width * pair.height);
        pair.each(|f, g| {
            let row = compare(f, g, pair.width, threshold);
            reachable -= row.different * u32::from(Table::ONE) + row.differences * self.chord;
            reachable >= floor
        });
        reachable < floor
    }
}
