//! Alignment: moves the early template to its best fit in the view, the samples around the filter's peak.
//!
//! The filter's cells have 4x4 pixels, so its peak is off by a pixel or more, and a filter that learns from its own
//! answers drifts. The early template hardly learns. SMR compares it at 17 alignments: nine that are two pixels apart,
//! then the eight neighbours of the best. Cost: 17 scores of at most 1600 pixels.

use super::super::constants::MARGIN;

/// The spacing of the nine coarse offsets of the template, in pixels of the grid. The eight fine offsets are 1 apart.
const COARSE_STEP: i16 = 2;
/// The count of offsets at which the early template is compared with the frame.
pub(super) const ALIGNMENTS: u16 = 17;

/// The template's offset right and down from the view's middle, in pixels of the grid: at most [`MARGIN`] on each axis.
pub(crate) type Alignment = (i16, i16);

#[derive(Clone, Copy)]
pub(super) struct Alignments {
    /// The alignment with the highest score so far.
    pub(crate) best: Alignment,
    score: u32,
    /// The centre of the alignments to compare: first nine coarse ones, then the eight neighbours of the best.
    middle: Alignment,
}

impl Alignments {
    pub(crate) const fn new() -> Self {
        Self { best: (0, 0), score: 0, middle: (0, 0) }
    }

    /// The alignment at `index` in the order of comparison. Index 0 is the middle of the view.
    #[inline(never)]
    pub(crate) fn alignment(&self, index: u16) -> Alignment {
        let (index, step) = if index < 9 { (index, COARSE_STEP) } else { (index - 8, 1) };
        // Index 0 is the middle, which is the fifth of nine alignments in row order.
        let ninth = match index {
            0 => 4,
            1..=4 => index - 1,
            _ => index,
        };
        let by = |third: u16| step * (i16::try_from(third).unwrap_or(1) - 1);
        (self.middle.0 + by(ninth % 3), self.middle.1 + by(ninth / 3))
    }

    /// Adds the score of an alignment. The first of equal scores wins.
    pub(crate) fn add(&mut self, index: u16, score: u32) {
        if score > self.score {
            (self.best, self.score) = (self.alignment(index), score);
        }
        if index == 8 {
            self.middle = self.best;
        }
    }
}

/// The column and row of the view where the aligned template begins.
pub(super) fn in_view((right, down): Alignment) -> [u16; 2] {
    [right, down].map(|by| MARGIN.saturating_add_signed(by))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn the_best_is_surrounded_next() {
        let mut alignments = Alignments::new();
        let mut places = Vec::new();
        for index in 0..ALIGNMENTS {
            places.push(alignments.alignment(index));
            let (x, y) = alignments.alignment(index);
            alignments.add(index, 1000 - u32::from(x.abs_diff(3) + y.abs_diff(-1)));
        }
        assert_eq!(places[..9].iter().filter(|&&(x, y)| x % 2 == 0 && y % 2 == 0).count(), 9);
        assert_eq!(alignments.best, (3, -1));
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), usize::from(ALIGNMENTS), "none is compared twice");
        assert!(places.iter().all(|&(x, y)| x.unsigned_abs() <= MARGIN && y.unsigned_abs() <= MARGIN));
    }
}
