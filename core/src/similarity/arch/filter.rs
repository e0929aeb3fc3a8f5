//! What the backends for Arm's microcontrollers share: a bound that excludes offsets without the table.
//!
//! A pixel that counts and differs by d loses at least c * d of its 65535 ([`scalar::chord`]), one that does not loses all.
//! How many do not, and the sum of the differences of those that do, are sums of bytes, and that is what these instruction
//! sets are fast at; a table they can only look up pixel by pixel. So an offset is first tried by this bound, and scored by
//! the plain loop if that does not exclude it.

use super::rows::Pair;
use super::{Kernels, Plain};
use crate::image::Image;
use crate::similarity::{Table, scalar};

/// The plain loop, and what goes before it.
pub(super) struct Filter {
    plain: Plain,
    chord: u32,
}

/// When an offset is excluded: once its pixels have lost more than `allowed`.
pub(super) struct Limit {
    /// A pixel counts if it differs by less: 1..=255.
    pub(super) threshold: u8,
    /// What a pixel that counts loses with each gray level. One that does not count loses [`Table::ONE`].
    pub(super) chord: u32,
    pub(super) allowed: u32,
}

impl Filter {
    pub(super) fn new(table: &'static Table, threshold: u16) -> Self {
        Self { plain: Plain { table, threshold }, chord: scalar::chord(table, threshold) }
    }

    /// As [`scalar::score_at_least`]. `excludes` is asked of two pictures of at least `NARROWEST` columns.
    #[inline(always)] // into the one function of a backend that calls it
    pub(super) fn score_at_least<const NARROWEST: usize>(
        &self,
        patch: Image<'_>,
        template: Image<'_>,
        floor: u32,
        excludes: impl FnOnce(&Pair, &Limit) -> bool,
    ) -> Option<u32> {
        let pair = Pair::new(patch, template);
        let allowed = scalar::full(pair.width * pair.height).checked_sub(floor)?;
        match u8::try_from(self.plain.threshold) {
            // No score is less than 0, which is the floor of those who want any score.
            Ok(threshold) if threshold > 0 && floor > 0 && pair.width >= NARROWEST => {
                if excludes(&pair, &Limit { threshold, chord: self.chord, allowed }) {
                    return None;
                }
            }
            _ => {}
        }
        self.plain.score_at_least(patch, template, floor)
    }
}
