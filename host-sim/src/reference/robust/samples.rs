//! Samples: the first one and the newest, what each shows and what it counts.

use super::Numbers;
use super::features::Cells;
use super::grid::Shape;
use super::rounding::whole;

/// A piece of a frame in which the target was seen.
pub struct Sample {
    pub cells: Cells,
    /// Where the target is, from the middle, in cells.
    pub x: f64,
    pub y: f64,
    /// What it counts of all, in units of 1/65536.
    pub share: f64,
}

/// All samples.
#[derive(Default)]
pub struct Samples {
    first: Option<Sample>,
    /// What the first one counts against the others, in units of 1/65536.
    first_counts: f64,
    /// From the newest to the oldest.
    recent: Vec<Sample>,
}

impl Samples {
    pub fn iter(&self) -> impl Iterator<Item = &Sample> {
        self.first.iter().chain(&self.recent)
    }

    /// Takes the middle of a search window in which the target is (`x`, `y`) cells from the middle: moved by whole cells towards
    /// the target as far as there are cells. Each sample that follows the first one lessens what that counts.
    pub fn take(&mut self, numbers: &Numbers, shape: &Shape, window: &Cells, (x, y): (f64, f64)) {
        let spare = numbers.reach - numbers.learns;
        let towards = |at: f64| whole((at + 0.5).floor()).clamp(-spare, spare);
        let (right, down) = (towards(x), towards(y));
        let (across, rows) = (shape.across + 2 * numbers.learns, shape.down + 2 * numbers.learns);
        let cells = window.cut(spare + right, spare + down, across, rows);
        let sample = Sample { cells, x: x - right as f64, y: y - down as f64, share: 0.0 };
        if self.first.is_none() {
            (self.first, self.first_counts) = (Some(sample), 65536.0);
        } else {
            self.recent.insert(0, sample);
            self.recent.truncate(numbers.recent.len());
            self.first_counts = (self.first_counts * numbers.kept / 65536.0).floor();
        }
        self.share(numbers);
    }

    /// What each counts over what all count, rounded down to 2 / 65536.
    fn share(&mut self, numbers: &Numbers) {
        let counts: Vec<f64> =
            std::iter::once(self.first_counts).chain(numbers.recent).take(1 + self.recent.len()).collect();
        let all: f64 = counts.iter().sum();
        for (sample, counts) in self.first.iter_mut().chain(&mut self.recent).zip(&counts) {
            sample.share = 2.0 * (counts * 32768.0 / all).floor();
        }
    }
}
