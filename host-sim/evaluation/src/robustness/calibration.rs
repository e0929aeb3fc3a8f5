//! Calibration: what the ratio that a tracker reports says of its chance to be right.

use super::Robustness;
use crate::{CORRECT, Layout, Trajectory, header, overlaps};
use anyhow::Result;
use serde::Serialize;

/// So many bins from 0 to 1.
const BINS: usize = 40;

/// Frames by the ratio that was reported in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Calibration([Count; BINS]);

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Count {
    frames: u64,
    correct: u64,
}

/// The frames of a tracker in all runs with a ratio of at least `from` and below `to`; the last bin has 1, too.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
        Self([Count::default(); BINS])
    }
}

impl Calibration {
    /// Of one run: the ratio, where there is one, in each frame.
    pub fn new(ratios: &[Option<f64>], answers: &Trajectory, truth: &Trajectory) -> Result<Self> {
        let mut calibration = Self::default();
        for (ratio, iou) in ratios.iter().zip(overlaps(answers, truth)?) {
            let Some(ratio) = ratio else { continue };
            let count = &mut calibration.0[bin(*ratio)];
            count.frames += 1;
            count.correct += u64::from(iou.is_some_and(|iou| iou > CORRECT));
        }
        Ok(calibration)
    }

    /// Of several runs.
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
    /// The middle of its ratios.
    pub fn middle(&self) -> f64 {
        f64::midpoint(self.from, self.to)
    }

    /// The part of its frames that is correct; `None` without frames.
    pub fn chance(&self) -> Option<f64> {
        (self.frames > 0).then(|| self.correct as f64 / self.frames as f64)
    }
}

impl Robustness {
    /// The bins of all trackers that report a ratio.
    pub fn calibration(&self) -> &[Bin] {
        &self.calibration
    }

    /// The same as text, without the bins that have no frames.
    pub fn calibration_table(&self, layout: Layout) -> String {
        let line = |bin: &Bin| {
            let range = format!("{:.3} to {:.3}", bin.from, bin.to);
            let chance = format!("{:.3}", bin.chance()?);
            Some(vec![bin.tracker.clone(), range, bin.frames.to_string(), bin.correct.to_string(), chance])
        };
        let lines = std::iter::once(header("tracker|ratio|frames|correct|chance"))
            .chain(self.calibration.iter().filter_map(line));
        layout.table(&lines.collect::<Vec<_>>(), 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::BoundingBox;

    fn at(x: f64) -> Option<BoundingBox> {
        Some(BoundingBox { x, y: 0.0, width: 10.0, height: 10.0 })
    }

    #[test]
    fn frames_are_counted_by_their_ratio() {
        let truth = [at(0.0), at(0.0), at(0.0), at(0.0), None, at(0.0)];
        let answers = [at(0.0), at(1.0), at(50.0), None, at(0.0), at(0.0)];
        let ratios = [None, Some(0.51), Some(0.52), Some(0.51), Some(0.524), Some(1.0)];
        let run = Calibration::new(&ratios, &answers, &truth).unwrap();
        let bins = Calibration::total([run, run].iter()).bins("robust");
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
    }

    #[test]
    fn without_ratios_there_are_no_bins() {
        let run = Calibration::new(&[None], &[at(0.0)], &[at(0.0)]).unwrap();
        assert_eq!(run.bins("sad"), []);
    }
}
