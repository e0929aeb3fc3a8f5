//! The correction of the box: the leaky sum of the network's estimates from frame to frame.
//!
//! ```text
//! centre' = 15/16 (centre + estimate / 4)                     in units of the box's side
//! factor' = 1 + 15/16 (factor (1 + estimate / 4) - 1)         of width and height
//! ```
//!
//! The next crop is that of the corrected box, so the network corrects its own errors. Without the leak of 1/16 errors
//! would add up. In frames in which the early template gives the exact place and size, the network does not run, and
//! the correction fades by a quarter.

use super::network::Outputs;
use crate::image::FineRect;
use crate::track::saved::{Reader, Writer};

const ONE: i32 = 1 << 16;
/// The least and the largest factor of width and height: 1/2 and 2, in units of 1/65536.
const MIN_FACTOR: i32 = ONE / 2;
const MAX_FACTOR: i32 = 2 * ONE;
/// The largest shift of the centre, in units of 1/4096 of the box's side: half a side.
const MAX_SHIFT: i32 = 1 << 11;
/// The largest magnitude of an estimate: 1, in units of 1/4096. Larger estimates are clamped to it.
const MAX_ESTIMATE: i32 = 1 << 12;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Correction {
    /// The shift of the centre to the right and down, in units of 1/4096 of the corrected side.
    centre: [i32; 2],
    /// The factors of width and height, in units of 1/65536.
    sides: [i32; 2],
}

impl Correction {
    pub(crate) const NONE: Self = Self { centre: [0; 2], sides: [ONE; 2] };

    pub(crate) fn add(&mut self, &[right, down, width, height, ..]: &Outputs) {
        let bounded = |estimate: i32| estimate.clamp(-MAX_ESTIMATE, MAX_ESTIMATE);
        for (centre, new) in self.centre.iter_mut().zip([right, down]) {
            *centre = (((4 * *centre + bounded(new)) * 15) >> 6).clamp(-MAX_SHIFT, MAX_SHIFT);
        }
        for (side, new) in self.sides.iter_mut().zip([width, height]) {
            // The product of side and estimate is at most 2^17 * 2^12.
            let grown = *side + ((*side * bounded(new)) >> 14);
            *side = (ONE + (((grown - ONE) * 15) >> 4)).clamp(MIN_FACTOR, MAX_FACTOR);
        }
    }

    /// Reduces the correction by a quarter, in a frame in which the early template gives the exact place and size.
    pub(crate) fn fade(&mut self) {
        self.centre = self.centre.map(|centre| (3 * centre) >> 2);
        self.sides = self.sides.map(|side| ONE + ((3 * (side - ONE)) >> 2));
    }

    #[inline(never)]
    pub(crate) fn correct(&self, target: FineRect) -> FineRect {
        let [right, down] = self.centre;
        let [wider, higher] = self.sides;
        let (x, width) = corrected(target.x, target.width, right, wider);
        let (y, height) = corrected(target.y, target.height, down, higher);
        FineRect { x, y, width, height }
    }

    pub(super) const SAVED: usize = 16;

    pub(crate) fn save(&self, to: &mut Writer<'_>) {
        self.centre.into_iter().chain(self.sides).for_each(|number| to.i32(number));
    }

    pub(crate) fn read(from: &mut Reader<'_>) -> Option<Self> {
        Self::restore([from.i32()?, from.i32()?], [from.i32()?, from.i32()?])
    }

    fn restore(centre: [i32; 2], sides: [i32; 2]) -> Option<Self> {
        let possible = centre.iter().all(|by| (-MAX_SHIFT..=MAX_SHIFT).contains(by))
            && sides.iter().all(|side| (MIN_FACTOR..=MAX_FACTOR).contains(side));
        possible.then_some(Self { centre, sides })
    }
}

/// The left or top edge and the side of a corrected box, on one axis.
#[inline(never)]
fn corrected(from: i32, side: u32, moved: i32, factor: i32) -> (i32, u32) {
    let new = (i64::from(side) * i64::from(factor) + (1 << 15)) >> 16;
    let middle = i64::from(from) + i64::from(side / 2) + ((i64::from(moved) * new) >> 12);
    let small = |number: i64| i32::try_from(number).unwrap_or(0);
    (small(middle - new / 2), u32::try_from(new).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: FineRect = FineRect { x: 256 * 20, y: -300, width: 256 * 40 + 3, height: 256 * 10 + 1 };

    #[test]
    fn no_correction_changes_nothing() {
        assert_eq!(Correction::NONE.correct(BOX), BOX);
        let mut still = Correction::NONE;
        still.add(&[0; 7]);
        assert_eq!(still, Correction::NONE);
    }

    #[test]
    fn a_box_grows_around_its_corrected_middle() {
        let correction = Correction { centre: [1 << 10, -(1 << 11)], sides: [ONE * 2, ONE / 2] };
        let FineRect { x, y, width, height } = correction.correct(BOX);
        assert_eq!([width, height], [256 * 80 + 6, 256 * 5 + 1]);
        // The centre moves right by a quarter of the new width, and up by half of the new height.
        assert_eq!([x, y], [256 * 20 + (128 * 40 + 1) + (256 * 20 + 1) - (128 * 80 + 3), -300 + 1280 - 641 - 640]);
    }

    #[test]
    fn the_same_estimate_again_and_again_stays_within_bounds() {
        for estimate in [i32::MIN, -4096, 4096, i32::MAX] {
            let mut correction = Correction::NONE;
            for _ in 0..100 {
                correction.add(&[estimate; 7]);
            }
            let Correction { centre, sides } = correction;
            assert_eq!(Correction::restore(centre, sides), Some(correction), "{estimate}");
            assert!(
                centre[0].abs() == MAX_SHIFT && (sides[0] == MIN_FACTOR || sides[0] == MAX_FACTOR),
                "{estimate}: {correction:?}"
            );
        }
    }

    #[test]
    fn a_correction_fades() {
        let mut correction = Correction { centre: [500, -500], sides: [ONE + 9000, ONE - 9000] };
        for _ in 0..200 {
            correction.add(&[0; 7]);
        }
        let mut faded = Correction { centre: [500, -500], sides: [ONE + 9000, ONE - 9000] };
        faded.fade();
        assert_eq!((faded.centre, faded.sides), ([375, -375], [ONE + 6750, ONE - 6750]));
        let Correction { centre, sides } = correction;
        assert!(
            centre.iter().all(|by| by.abs() < 17) && sides.iter().all(|side| (side - ONE).abs() < 17),
            "{correction:?}"
        );
    }
}
