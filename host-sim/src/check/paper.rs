//! Comparison of the paper tracker with its reference, in every frame and at every candidate position:
//!
//! 1. **Bit for bit.** With the reference's similarities rounded to 1/65535, all scores, the peak, a runner-up that is
//!    needed, alpha, the box, the state and the template must be equal.
//! 2. **Within a bound.** With exact similarities, a score of n pixels may differ by n half units of 1/65535 and by the
//!    rounding of f64. If the exact scores peak elsewhere, they may exceed core's peak by at most twice the bound.

use super::{Checked, Sides, Violation, differs};
use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;
use smr_core::unstable::{Peaks, Window, offsets, peaks, score_of};
use smr_core::{Answer, Rect, State};
use smr_evaluation::Paper;
use smr_recordings::GrayFrame;
use smr_reference::{Decision, Numbers, Reference, Step};

#[derive(Clone, Debug, Default, Serialize)]
pub struct Counts {
    pub scores: u64,
    /// Number of frames in which the decision or the settings required a runner-up: the best score outside the peak's
    /// neighbourhood. Only these frames have a runner-up to compare.
    pub runners_up: usize,
    /// Largest |core's score - exact score|, in units of 1/65535.
    pub largest_difference: f64,
    /// Upper bound of `largest_difference`, from the template's pixel count.
    pub bound: f64,
    /// Frames in which the exact scores peak at another position than core's scores.
    pub other_peaks: Vec<OtherPeak>,
}

/// A frame in which rounding the similarities changed the position of the peak.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OtherPeak {
    /// Frame number, counted from 1.
    pub frame: usize,
    /// Exact score at the exact peak, less the exact score at core's peak, in units of 1/65535.
    pub margin: f64,
}

impl Checked for Paper {
    type Reference = Reference;
    type Numbers = Numbers;
    type Counts = Counts;

    fn reference(numbers: Numbers, first: &[u8], size: (i64, i64), target: (i64, i64, i64, i64)) -> Reference {
        Reference::lock(numbers, first, size, target)
    }

    fn counts(target: Rect) -> Counts {
        Counts { bound: bound(target.area()), ..Counts::default() }
    }

    fn compare(sides: &mut Sides<Self>, frame: &GrayFrame, number: usize) -> Result<Option<Violation>> {
        let offsets = offsets(sides.core.target()).context("the tracker is locked")?;
        let scores = core_scores(sides.core.target(), &offsets, frame)?;
        let answer = sides.update(&frame.frame())?;
        let peaks = peaks(sides.core.workspace()).context("the update is finished")?;
        let step = sides.reference.update(&frame.pixels);
        sides.counts.scores += scores.len() as u64;
        sides.counts.runners_up += usize::from(step.runner_up_asked);
        Ok(window(&offsets, &step)
            .or_else(|| sides.counts.each_score(&offsets, &scores, &step))
            .or_else(|| decisions(&answer, &peaks, &step))
            .or_else(|| template(sides.core.target(), &sides.reference))
            .or_else(|| sides.counts.exact_arg_max(number, &peaks, &step)))
    }
}

/// Largest possible difference between a score of `pixels` pixels and the exact one, in units of 1/65535.
fn bound(pixels: u32) -> f64 {
    let n = f64::from(pixels);
    // Core rounds each of the n similarities by at most half a unit. The reference's sum in f64 has n terms of at most
    // 65535, each with a relative error of 2^-52; each partial sum, at most n * 65535, is rounded by a relative 2^-53.
    n * 0.5 + n * (n + 2.0) * 65535.0 * f64::EPSILON
}

/// Core's scores at all positions of the window `offsets`, row by row. Core computes each score on its own, so the
/// order in which its search visits the positions does not matter.
fn core_scores(core: &Paper, offsets: &Window, frame: &GrayFrame) -> Result<Vec<u32>> {
    let frame = frame.frame();
    let score = |x, y| score_of(core, &frame, (x, y)).context("a whole frame holds every pixel");
    offsets.ys().into_par_iter().flat_map_iter(|y| offsets.xs().map(move |x| score(x, y))).collect()
}

impl Counts {
    fn each_score(&mut self, offsets: &Window, core: &[u32], step: &Step) -> Option<Violation> {
        let mut different = None;
        for (((x, y), sums), &score) in step.scores.iter().zip(core) {
            let difference = (f64::from(score) - sums.exact).abs();
            self.largest_difference = self.largest_difference.max(difference);
            if f64::from(score) != sums.rounded && different.is_none() {
                different = Some(Violation::new(format!("score at ({x}, {y})"), score, sums.rounded));
            }
        }
        if self.largest_difference > self.bound {
            let what = format!("largest difference from an exact score, window {offsets:?}");
            different = different.or(Some(Violation::new(what, self.largest_difference, self.bound)));
        }
        different
    }

    /// Records a frame in which core's peak is at another position than the exact peak. It is a violation if the exact
    /// score at core's peak is lower than the exact peak by over `2 * bound`.
    fn exact_arg_max(&mut self, frame: usize, peaks: &Peaks, step: &Step) -> Option<Violation> {
        let peak = (i64::from(peaks.peak.x), i64::from(peaks.peak.y));
        if peak == step.exact_peak.0 {
            return None;
        }
        let of_cores_peak = step.scores.iter().find(|(at, _)| *at == peak).map_or(0.0, |(_, sums)| sums.exact);
        let margin = step.exact_peak.1 - of_cores_peak;
        self.other_peaks.push(OtherPeak { frame, margin });
        let most = 2.0 * self.bound;
        (margin > most).then(|| Violation::new("lead of the exact arg max over core's peak".into(), margin, most))
    }
}

fn template(core: &Paper, reference: &Reference) -> Option<Violation> {
    let template = core.template()?;
    let core = template.rows().flatten().map(|&pixel| f64::from(pixel));
    let first = core.zip(reference.template()).position(|(core, reference)| core != *reference)?;
    let core = template.rows().flatten().nth(first)?;
    Some(Violation::new(format!("template pixel {first}"), core, reference.template()[first]))
}

fn window(core: &Window, step: &Step) -> Option<Violation> {
    let (xs, ys) = (core.xs(), core.ys());
    let ends = [*xs.start(), *xs.end(), *ys.start(), *ys.end()].map(i64::from);
    let scores = &step.scores;
    let expected = [scores.left, scores.left + scores.columns - 1, scores.top, scores.top + scores.rows - 1];
    differs("window (left, right, top, bottom)", ends, expected)
}

fn decisions(answer: &Answer, peaks: &Peaks, step: &Step) -> Option<Violation> {
    let position = |x: i32, y: i32| (i64::from(x), i64::from(y));
    differs("peak's position", position(peaks.peak.x, peaks.peak.y), step.peak.0)
        .or_else(|| differs("peak's score", f64::from(peaks.peak.score), step.peak.1))
        .or_else(|| {
            differs("runner-up", peaks.runner_up.map(f64::from), step.runner_up_asked.then_some(step.runner_up))
        })
        .or_else(|| differs("alpha, rounded up", answer.alpha.map(f64::from), Some(step.alpha.ceil())))
        .or_else(|| differs("state", answer.state, state(step.decision)))
        .or_else(|| differs("box", position(answer.bbox.x, answer.bbox.y), step.position))
}

fn state(decision: Decision) -> State {
    match decision {
        Decision::Tracking => State::Tracking,
        Decision::Leaving => State::Leaving,
        Decision::Lost => State::Lost,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Check, Comparison};
    use super::*;
    use smr_core::paper::Config;

    /// Compares core, set by `Config::camera()`, with the reference, set by `numbers`, on two checkerboard frames. Each
    /// frame has its own two gray levels.
    fn report(numbers: Numbers, first: [u8; 2], second: [u8; 2]) -> Comparison<Counts> {
        let frame = |levels: [u8; 2]| {
            let pixels = (0..30 * 30).map(|at| levels[(at % 30 + at / 30) % 2]).collect();
            GrayFrame { width: 30, height: 30, pixels }
        };
        let target = Rect::new(11, 11, 8, 8);
        let mut check = Check::<Paper>::lock("two levels", (Config::camera(), numbers), 5000, &frame(first), target)
            .expect("a box in the frame");
        check.update(&frame(second)).expect("a frame of the same size");
        check.into_comparison()
    }

    /// In each case the second frame is similar to the first, but has too little contrast or too many clipped pixels.
    #[test]
    fn other_numbers_of_the_contrast_are_noticed() {
        type Other = (fn(&mut Numbers), [u8; 2], [u8; 2]);
        let others: [Other; 2] = [
            (|numbers| numbers.gate.least_contrast = 0.0, [120, 140], [130, 130]),
            (|numbers| numbers.gate.most_cut_off = 1.0, [5, 250], [0, 255]),
        ];
        for (change, first, second) in others {
            let mut numbers = Numbers::camera();
            assert_eq!(report(numbers.clone(), first, second).violation, None);
            change(&mut numbers);
            let violation = report(numbers, first, second).violation.expect("core says lost");
            assert!(violation.what.contains("state"), "{violation:?}");
        }
    }
}
