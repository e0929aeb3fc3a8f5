//! The quality of a target, which `lock` measures.

use crate::image::{Image, Rect};
use crate::similarity::{Backend, CutTable, Scorer, Table};

/// The quality of a target, from [`Target::lock`](crate::Target::lock): the target's difference from a shifted copy.
///
/// quality = 1 - max(ratio(w / 4, 0), ratio(0, h / 4)), in units of 1/65535
///
/// ratio(dx, dy) is the similarity matching ratio of the target with itself, shifted by (dx, dy). A flat target, an
/// edge and a single pixel have a quality of 0: a tracker follows them, but may slip along them without noticing.
///
/// ```
/// use smr_core::{Frame, Image, Paper, Rect, Tracker, paper};
/// let mut tracker = Tracker::<Paper<256, 161>>::new();
/// let flat = [90; 64 * 48];
/// let quality = tracker.lock(&Frame::whole(Image::new(&flat, 64, 48)?), Rect::new(20, 10, 16, 16))?;
/// assert!(quality.is_poor() && quality.value() == 0);
/// # Ok::<(), smr_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Quality(u16);

impl Quality {
    /// The limit below which a quality is poor. A flat target with noise of +-4 gray levels has a quality of about 700.
    /// The two lowest qualities of the first boxes of 90 recordings are 1128 (a face in the dark) and 16,866.
    pub const POOR_BELOW: u16 = Table::ONE / 64;

    pub(super) const NONE: Self = Self(0);

    /// The quality, from 0 (the shifted target looks the same) to 65535 (no pixel matches).
    #[must_use]
    pub const fn value(self) -> u16 {
        self.0
    }

    pub(super) const fn of_value(value: u16) -> Self {
        Self(value)
    }

    /// True if the target hardly differs from its shifted copy. Choose a better box if there is one.
    #[must_use]
    pub const fn is_poor(self) -> bool {
        self.0 < Self::POOR_BELOW
    }

    /// Computes the quality of a patch of at most [`Table::MAX_PIXELS`] pixels, with the scalar backend.
    #[inline(never)] // keeps its stack out of that of a step
    pub(super) fn of(patch: Image<'_>, table: &CutTable) -> Self {
        let scorer = &Scorer::new(Backend::Scalar, table);
        let quarter = |side: u16| side.div_ceil(4);
        let across = ratio(patch, (quarter(patch.width()), 0), scorer);
        let down = ratio(patch, (0, quarter(patch.height())), scorer);
        Self(Table::ONE - across.max(down))
    }
}

/// The similarity matching ratio of a patch and its shifted copy, in units of 1/65535; 65535 if they do not overlap.
fn ratio(patch: Image<'_>, (right, down): (u16, u16), scorer: &Scorer<'_>) -> u16 {
    let (width, height) = (patch.width() - right, patch.height() - down);
    let moved = patch.crop(Rect::new(right.into(), down.into(), width, height));
    // `moved` is smaller than `patch`: the scorer compares it with the part of `patch` at the top left corner.
    let score = moved.and_then(|moved| scorer.score_at_least(patch, moved, 0));
    let pixels = u32::from(width) * u32::from(height);
    score.map_or(Table::ONE, |score| u16::try_from(score / pixels.max(1)).unwrap_or(Table::ONE))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quality(pixel: impl Fn(usize, usize) -> u8, (width, height): (u16, u16)) -> u16 {
        let places = (0..usize::from(height)).flat_map(|y| (0..usize::from(width)).map(move |x| (x, y)));
        let pixels: std::vec::Vec<u8> = places.map(|(x, y)| pixel(x, y)).collect();
        let table = CutTable::new(&Table::PAPER, 13);
        Quality::of(Image::new(&pixels, width, height).unwrap(), &table).value()
    }

    #[test]
    fn what_looks_the_same_beside_its_place_has_none() {
        for size in [(16, 16), (1, 1), (1, 30), (30, 1), (2, 2), (200, 300)] {
            assert_eq!(quality(|_, _| 90, size), 0, "{size:?}");
        }
        // An edge along an axis and a periodic pattern also have a quality of 0.
        assert_eq!(quality(|x, _| if x < 8 { 20 } else { 200 }, (16, 16)), 0);
        assert_eq!(quality(|x, y| if (x / 2 + y / 2) % 2 == 0 { 20 } else { 200 }, (16, 16)), 0);
    }

    #[test]
    fn noise_of_a_sensor_is_poor_and_texture_is_not() {
        let hash = |x: usize, y: usize| (((x * 31) ^ (y * 57)).wrapping_mul(2_654_435_761) >> 16) as u8;
        assert!(quality(|x, y| 90 + hash(x, y) % 8, (24, 24)) < Quality::POOR_BELOW);
        assert!(quality(|x, y| hash(x / 3, y / 3), (24, 24)) > Table::ONE / 2);
        assert_eq!(quality(|x, y| ((x * 40 + y * 90) % 256) as u8, (4, 2)), Table::ONE);
    }
}
