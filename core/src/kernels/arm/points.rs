//! Points: a sum of bytes, cheap to compute, that bounds the score of an offset.
//!
//! A pixel that differs by d has 255 - d points if d is below the threshold, else none. Points fall with the difference
//! almost as similarities do. So a score is at most the number of points divided by a fixed rate. An offset with too
//! few points is excluded without a table lookup.

use crate::kernels::rows::Rows;
use crate::kernels::scores::ONE;
use crate::kernels::unrolling::rolled;

/// Constants that bound a score by its points (the sum of 255 - difference), for a table and its threshold.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    /// The largest difference below the threshold.
    pub(super) largest: u8,
    /// A pixel of similarity p has at least p * `rate` / 2^24 points (255 - difference). `rate` 0 disables the bound.
    rate: u32,
    /// The largest integer c such that the similarity p(d) is at most 65535 - c * d for every difference d below the
    /// threshold. If p is exponential, the largest d sets c (flattest chord from p(0)). Stored, as division is slow.
    chord: u32,
}

impl Points {
    /// Points of a pixel with difference 0, the maximum.
    pub(super) const MAX: u8 = u8::MAX;

    pub(crate) const NONE: Self = Self { largest: 0, rate: 0, chord: 0 };

    /// Computes the constants for `entries` and `threshold`. The thresholds 0 and 256 disable the bound.
    pub(crate) fn set(&mut self, entries: &[u16; 256], threshold: u16) {
        *self = Self::NONE;
        if let Some(largest) = u8::try_from(threshold).ok().and_then(|threshold| threshold.checked_sub(1)) {
            let (most, one) = (u32::from(Self::MAX), u32::from(ONE));
            let (mut rate, mut chord) = (u32::MAX, one);
            for (d, &p) in rolled((0..).zip(entries.iter().take(usize::from(threshold)))) {
                let p = u32::from(p);
                rate = rate.min((most.wrapping_sub(d) << 24) / p.max(1));
                chord = (one - p).checked_div(d).unwrap_or(chord).min(chord);
            }
            *self = Self { largest, rate, chord };
        }
    }

    /// Minimum sum of points (255 - difference) with which `pixels` pixels can reach the score `floor`; 0 if the bound
    /// is disabled. Returns the larger of two bounds. The second one is tight where most pixels are similar:
    ///
    /// - A score of `floor` needs at least `floor` * `rate` / 2^24 points.
    /// - A pixel loses at least `chord` of its score for each point it lacks; beyond the threshold 65535 / 255 = 257.
    pub(super) fn needed(&self, floor: u32, pixels: u32) -> u32 {
        if self.rate == 0 {
            return 0;
        }
        // The rate is at most 255 * 2^24 / 65535, its value for equal pixels, so the quotient fits in a `u32`.
        let of_score = u32::try_from((u64::from(floor) * u64::from(self.rate)).div_ceil(1 << 24)).unwrap_or(u32::MAX);
        let lost = (pixels * u32::from(ONE)).saturating_sub(floor);
        let lacking = lost / self.chord.clamp(1, u32::from(ONE / u16::from(Self::MAX)));
        (pixels * u32::from(Self::MAX)).saturating_sub(lacking).max(of_score)
    }

    /// Initial margins of four offsets: the maximum sum of points minus `needed`, but a negative number if the offset's
    /// bit in `wanted` is 0. A loop then subtracts (255 - points) of each pixel. A negative margin excludes the offset.
    #[inline(always)]
    pub(super) fn initial_margins(rows: &Rows, needed: u32, wanted: u8) -> [i32; OFFSETS] {
        let start = u32::from(Self::MAX).wrapping_mul(rows.pixels_after(0)).wrapping_sub(needed).cast_signed();
        [0, 1, 2, 3].map(|offset| if wanted >> offset & 1 == 0 { i32::MIN / 2 } else { start })
    }

    /// The points of a row whose pixels all equal those of the template: 255 for each pixel.
    #[inline(always)]
    pub(super) fn of_row(rows: &Rows) -> u32 {
        #[allow(clippy::cast_possible_truncation)] // at most 65535 columns
        u32::from(Self::MAX).wrapping_mul(rows.width as u32)
    }
}

/// Number of horizontally neighbouring offsets whose scores are bounded at once.
pub(super) const OFFSETS: usize = 4;
