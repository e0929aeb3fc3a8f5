//! Samples: what the filter learns from, the first one and the last three, each with the place of the target in it.

use super::features::CHANNELS;
use super::grid::{Grid, MOST_SIDE};
use super::label::Bell;
use super::{MOST_CELLS, REACH};
use heapless::Vec;

/// How many are kept.
pub(super) const SAMPLES: usize = 4;
/// The filter learns at offsets of so many cells to each side.
const LEARNS: u16 = 6;
/// Offsets on an axis.
pub(super) const OFFSETS: usize = 2 * LEARNS as usize + 1;
/// Bytes of the largest sample: the longest filter has the longest rim.
const BYTES: usize =
    (MOST_SIDE + 2 * LEARNS) as usize * (MOST_CELLS / MOST_SIDE as usize + 2 * LEARNS as usize) * CHANNELS;
/// What the last three samples count, from the newest, in units of 1/65536: 0.05, and 0.95 times as much for each frame.
const RECENT: [u32; SAMPLES - 1] = [3277, 3113, 2957];
/// The first one counts 1, and 0.95 times as much with each sample that is taken.
const KEPT: u32 = 62_259;

/// A piece of a frame's cells in which the target was seen.
pub(super) struct Sample {
    cells: Vec<i8, BYTES>,
    /// Where the target is, from the middle, in units of 1/256 cell.
    x: i32,
    y: i32,
    /// What it counts, in units of 1/65536 of all.
    pub(super) share: u32,
}

impl Sample {
    const fn new() -> Self {
        Self { cells: Vec::new(), x: 0, y: 0, share: 0 }
    }

    /// The cells.
    pub(super) fn cells(&self) -> &[i8] {
        &self.cells
    }

    /// Both axes' parts of the label at each offset.
    pub(super) fn bell(&self, bell: Bell) -> [[i32; OFFSETS]; 2] {
        [self.x, self.y].map(|target| {
            let mut offset = -256 * i32::from(LEARNS) - target;
            core::array::from_fn(|_| {
                let part = bell.at(offset);
                offset += 256;
                part
            })
        })
    }
}

/// The first sample and the last three.
pub(super) struct Samples {
    samples: [Sample; SAMPLES],
    /// How many there are.
    count: usize,
    /// The newest.
    newest: usize,
    /// What the first one counts.
    first: u32,
}

impl Samples {
    pub(super) const fn new() -> Self {
        Self { samples: [const { Sample::new() }; SAMPLES], count: 0, newest: 0, first: 0 }
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        (self.count, self.newest, self.first) = (0, 0, 1 << 16);
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter().take(self.count)
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Takes the middle of a search window of cells, in which the target is (`x`, `y`) from the middle, in units of 1/256 cell; where
    /// it is far from there, as far in that direction as there are cells.
    pub(super) fn take(&mut self, grid: &Grid, window: &[i8], (x, y): (i32, i32)) {
        let spare = i32::from(REACH - LEARNS);
        let cells = |at: i32| ((at + 128) >> 8).clamp(-spare, spare);
        let (right, down) = (cells(x), cells(y));
        self.advance();
        let Some(sample) = self.samples.get_mut(self.newest) else { return };
        let (across, rows) = (grid.across + 2 * LEARNS, grid.down + 2 * LEARNS);
        let stride = usize::from(grid.across + 2 * REACH) * CHANNELS;
        let start = |moved: i32| usize::try_from(spare + moved).unwrap_or(0);
        sample.cells.clear();
        for row in window.chunks(stride.max(1)).skip(start(down)).take(rows.into()) {
            let first = start(right) * CHANNELS;
            let cells = row.get(first..first + usize::from(across) * CHANNELS).unwrap_or_default();
            // Cannot fail: no sample is larger than BYTES. Not extend, which has a path to a panic.
            let _ = sample.cells.extend_from_slice(cells);
        }
        (sample.x, sample.y) = (x - 256 * right, y - 256 * down);
        self.share();
    }

    /// The newest sample is where there is room, or where the oldest one was that is not the first.
    fn advance(&mut self) {
        if self.count < SAMPLES {
            self.newest = self.count;
            self.count += 1;
        } else {
            self.newest = if self.newest + 1 < SAMPLES { self.newest + 1 } else { 1 };
        }
        if self.count > 1 {
            self.first = (self.first * KEPT) >> 16;
        }
    }

    fn share(&mut self) {
        let (newest, first) = (self.newest, self.first);
        let weight = |at: usize| match at {
            0 => first,
            _ => RECENT.get((newest + RECENT.len() - at) % RECENT.len()).copied().unwrap_or(0),
        };
        // At most 65536 + 9347.
        let all: u32 = (0..self.count).map(weight).sum();
        for (at, sample) in self.samples.iter_mut().take(self.count).enumerate() {
            sample.share = 2 * ((weight(at) << 15) / all.max(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Rect;

    fn grid() -> Grid {
        Grid::new(Rect::new(0, 0, 40, 40))
    }

    fn shares(samples: &Samples) -> std::vec::Vec<u32> {
        samples.iter().map(|sample| sample.share * 1000 / 65_536).collect()
    }

    #[test]
    fn the_first_sample_fades_and_the_oldest_other_is_replaced() {
        let (mut samples, window) = (Samples::new(), std::vec![1; 30 * 30 * CHANNELS]);
        samples.clear();
        let mut all = [0; 7].map(|_| {
            samples.take(&grid(), &window, (0, 0));
            (samples.newest, shares(&samples))
        });
        assert_eq!(all[0], (0, std::vec![1000]));
        assert_eq!(all[3], (3, std::vec![901, 31, 32, 34].iter().map(|&share: &u32| share).collect()), "{all:?}");
        assert_eq!(all.each_mut().map(|(newest, _)| *newest), [0, 1, 2, 3, 1, 2, 3]);
        for _ in 0..200 {
            samples.take(&grid(), &window, (0, 0));
        }
        assert_eq!(shares(&samples)[0], 0, "{:?}", shares(&samples));
    }

    #[test]
    fn a_sample_is_taken_around_the_target_as_far_as_there_are_cells() {
        let window: std::vec::Vec<i8> = (0..30 * 30 * CHANNELS).map(|at| (at / CHANNELS % 30) as i8).collect();
        let mut samples = Samples::new();
        for (at, first, left) in
            [(0, 2, 0), (300, 3, 44), (-127, 2, -127), (5 * 256, 4, 3 * 256), (-9 * 256, 0, -7 * 256)]
        {
            samples.clear();
            samples.take(&grid(), &window, (at, 0));
            let sample = samples.iter().next().unwrap();
            assert_eq!((sample.cells()[0], sample.x), (first, left), "{at}");
            assert_eq!(sample.cells().len(), 26 * 26 * CHANNELS);
        }
    }
}
