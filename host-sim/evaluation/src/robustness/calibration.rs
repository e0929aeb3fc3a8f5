//! Calibration: what the ratio that a tracker reports says of its chance to be right.

use super::Robustness;
use crate::Layout;
use crate::tables::{Columns, Listed};
use serde::{Deserialize, Serialize};

/// So many bins from 0 to 1.
const BINS: usize = 40;

/// Frames by the ratio that was reported in them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Calibration(Vec<Count>);

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Count {
    frames: u64,
    correct: u64,
}

/// The frames of a tracker in all runs with a ratio of at least `from` and below `to`; the last bin has 1, too.
#[derive(Clone, Debug, PartialEq)]
pub struct Bin {
    pub tracker: String,
    pub from: f64,
    pub to: f64,
    pub frames: u64,
    /// Of these, the correct ones. Without an answer a frame is not correct, and neither is one in which the target is hidden.
    pub correct: u64,
}

impl Default for Calibration {
    fn default() -> Self {
        Self(vec![Count::default(); BINS])
    }
}

impl Calibration {
    /// One more frame with this ratio, right or not.
    pub fn count(&mut self, ratio: f64, right: bool) {
        let count = &mut self.0[bin(ratio)];
        count.frames += 1;
        count.correct += u64::from(right);
    }

    pub fn total<'a>(parts: impl Iterator<Item = &'a Self>) -> Self {
        let mut total = Self::default();
        for (sum, part) in parts.flat_map(|part| (0..BINS).zip(&part.0)) {
            total.0[sum].frames += part.frames;
            total.0[sum].correct += part.correct;
        }
        total
    }

    /// The bins of `tracker`; none if it reported no ratio at all.
    pub fn bins(&self, tracker: &str) -> Vec<Bin> {
        if self.0.iter().all(|count| count.frames == 0) {
            return Vec::new();
        }
        let edge = |bin: usize| bin as f64 / BINS as f64;
        let bin = |(bin, count): (usize, &Count)| Bin {
            tracker: tracker.to_owned(),
            from: edge(bin),
            to: edge(bin + 1),
            frames: count.frames,
            correct: count.correct,
        };
        (0..).zip(&self.0).map(bin).collect()
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a ratio is 0 to 1
fn bin(ratio: f64) -> usize {
    ((ratio * BINS as f64) as usize).min(BINS - 1)
}

impl Bin {
    pub fn middle(&self) -> f64 {
        f64::midpoint(self.from, self.to)
    }

    /// The part of its frames that is correct; `None` without frames.
    pub fn chance(&self) -> Option<f64> {
        (self.frames > 0).then(|| self.correct as f64 / self.frames as f64)
    }
}

impl Robustness {
    pub fn calibration(&self) -> &[Bin] {
        &self.calibration
    }

    /// The same as text, without the bins that have no frames.
    pub fn calibration_table(&self, layout: Layout) -> String {
        let bins: Vec<Bin> = self.calibration.iter().filter(|bin| bin.frames > 0).cloned().collect();
        Columns::new(COLUMNS).text(&bins, layout, 2)
    }
}

pub(super) const COLUMNS: &[Listed<Bin>] = &[
    ("tracker", "tracker", |bin| bin.tracker.as_str().into()),
    ("from", "", |bin| bin.from.into()),
    ("to", "", |bin| bin.to.into()),
    ("", "ratio", |bin| format!("{:.3} to {:.3}", bin.from, bin.to).into()),
    ("frames", "frames", |bin| bin.frames.into()),
    ("correct", "correct", |bin| bin.correct.into()),
    ("", "chance", |bin| bin.chance().map(|chance| format!("{chance:.3}")).into()),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_counted_by_their_ratio() {
        let mut run = Calibration::default();
        for (ratio, right) in [(0.51, true), (0.52, false), (0.51, false), (0.524, false), (1.0, true)] {
            run.count(ratio, right);
        }
        let bins = Calibration::total([run.clone(), run].iter()).bins("robust");
        let counted: Vec<_> =
            bins.iter().filter(|bin| bin.frames > 0).map(|bin| (bin.from, bin.to, bin.frames, bin.correct)).collect();
        assert_eq!(counted, [(0.5, 0.525, 8, 2), (0.975, 1.0, 2, 2)]);
        assert_eq!((bins.len(), bins[20].chance(), bins[0].chance()), (BINS, Some(0.25), None));

        let results = Robustness { calibration: bins, ..Robustness::default() };
        let expected = "\
tracker  ratio           frames  correct  chance
robust   0.500 to 0.525       8        2   0.250
robust   0.975 to 1.000       2        2   1.000
";
        assert_eq!(results.calibration_table(Layout::Text), expected);
        assert_eq!(Calibration::default().bins("sad"), [], "without ratios there are no bins");
    }
}
