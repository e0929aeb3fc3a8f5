//! Samples: what the filter learns from. The first one and the last three, each with the place of the target in it.

use super::features::CHANNELS;
use super::grid::{Grid, MOST_SIDE};
use super::tuning::Tuning;
use super::{MOST_CELLS, REACH};
use heapless::Vec;

/// How many are kept.
pub(super) const SAMPLES: usize = 4;
/// The filter learns at offsets of so many cells to each side.
pub(super) const LEARNS: u16 = 6;
/// Offsets on an axis.
pub(super) const OFFSETS: usize = 2 * LEARNS as usize + 1;
/// Bytes of the largest sample: a filter of 32x6 cells has the longest rim.
const BYTES: usize = ((MOST_SIDE + 2 * LEARNS) as usize) * (MOST_CELLS / MOST_SIDE as usize + 2 * LEARNS as usize) * CHANNELS;

pub(super) struct Sample {
    cells: Vec<i8, BYTES>,
    /// Cells in a row.
    across: u16,
    /// Where the target is, from the middle, in units of 1/256 cell.
    x: i32,
    y: i32,
    /// What it counts, in units of 1/65536 of all.
    pub(super) share: u32,
    /// 1/(256 sigma) in units of 2^-20: makes 1/256 cells into label steps.
    narrow: i64,
}

impl Sample {
    const fn new() -> Self {
        Self { cells: Vec::new(), across: 0, x: 0, y: 0, share: 0, narrow: 0 }
    }

    /// The cells from row `y` of the offsets on.
    pub(super) fn row(&self, y: usize) -> &[i8] {
        self.cells.get(y * self.stride()..).unwrap_or_default()
    }

    /// Bytes from a row to the next.
    pub(super) fn stride(&self) -> usize {
        usize::from(self.across) * CHANNELS
    }

    /// What the response should be at an offset, in units of 1/16384.
    pub(super) fn label(&self, x: usize, y: usize) -> i32 {
        let part = |at: usize, target: i32| {
            let distance = (i64::try_from(at).unwrap_or(0) - i64::from(LEARNS)) * 256 - i64::from(target);
            gauss((distance.abs() * self.narrow) >> 20)
        };
        (part(x, self.x) * part(y, self.y) + (1 << 13)) >> 14
    }
}

/// exp(-t^2 / 2) in units of 1/16384, t in units of 1/32.
fn gauss(t: i64) -> i32 {
    usize::try_from(t).ok().and_then(|t| GAUSS.get(t)).map_or(0, |&value| value.into())
}

const GAUSS: [u16; 160] = super::gauss::TABLE;

/// The first sample and the last three.
pub(super) struct Samples {
    samples: [Sample; SAMPLES],
    /// How many there are.
    count: usize,
    /// The one that is replaced next, never the first.
    next: usize,
    /// What the first one counts, in units of 1/65536; the others count [`Tuning::rates`].
    first: u32,
}

impl Samples {
    pub(super) const fn new() -> Self {
        Self { samples: [const { Sample::new() }; SAMPLES], count: 0, next: 0, first: 0 }
    }

    pub(super) fn clear(&mut self) {
        (self.count, self.next, self.first) = (0, 0, 1 << 16);
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter().take(self.count)
    }

    /// Takes the middle of a window of cells, in which the target is (`x`, `y`) cells from the middle, in units of 1/256.
    pub(super) fn take(&mut self, grid: &Grid, window: &[i8], (x, y): (i32, i32), tuning: &Tuning) {
        let reach = i32::from(REACH - LEARNS);
        let near = |at: i32| ((at + 128) >> 8).clamp(-reach, reach);
        let (right, down) = (near(x), near(y));
        if self.count < SAMPLES {
            self.next = self.count;
            self.count += 1;
        } else {
            self.next = if self.next + 1 < SAMPLES { self.next + 1 } else { 1 };
        }
        let Some(sample) = self.samples.get_mut(self.next) else { return };
        let (across, rows) = (grid.across + 2 * LEARNS, grid.down + 2 * LEARNS);
        let stride = usize::from(grid.across + 2 * REACH) * CHANNELS;
        let start = |moved: i32| usize::try_from(reach + moved).unwrap_or(0);
        sample.cells.clear();
        for row in window.chunks(stride).skip(start(down)).take(rows.into()) {
            let from = start(right) * CHANNELS;
            let cells = row.get(from..from + usize::from(across) * CHANNELS);
            // Cannot fail: no sample is larger than BYTES.
            let _ = sample.cells.extend_from_slice(cells.unwrap_or_default());
        }
        (sample.across, sample.x, sample.y) = (across, x - 256 * right, y - 256 * down);
        sample.narrow = narrow(grid, tuning);
        self.weigh(tuning);
    }

    fn weigh(&mut self, tuning: &Tuning) {
        if self.count > 1 {
            self.first = (self.first * tuning.keeps) >> 16;
        }
        let (count, next) = (self.count, self.next);
        let rates = tuning.rates;
        let age = |at: usize| if at == 0 { None } else { Some((next + SAMPLES - 1 - at) % (SAMPLES - 1)) };
        let first = self.first;
        let weight = |at: usize| age(at).map_or(first, |age| rates.get(age).copied().unwrap_or(0));
        let all: u32 = (0..count).map(weight).sum();
        for (at, sample) in self.samples.iter_mut().take(count).enumerate() {
            sample.share = (weight(at) << 15) / all.max(1) * 2;
        }
    }
}

/// 32 label steps for a standard deviation of 0.1 times the root of the target's cells.
fn narrow(grid: &Grid, tuning: &Tuning) -> i64 {
    // sigma in 1/256 cells: 0.1 * sqrt(pixels / 16) * 256 = 6.4 * sqrt(pixels).
    let sigma = i64::from((4096 * u64::from(grid.pixels()) * tuning.label * tuning.label / 10_000).isqrt() as u32).max(1);
    (32 << 20) / sigma
}
