//! The paper's tracker against its reference, score by score, through a recording.
//!
//! Two comparisons, in every frame and for every candidate:
//!
//! 1. **Bit for bit.** With the reference's p rounded to the table's grid, all scores, the peak, alpha, the box, the state
//!    and the template's bytes must be equal; so must the runner-up, in the frames in which it is asked for.
//! 2. **Within the bound.** With the reference's p exact, a score of n pixels may differ by n times half a unit of
//!    1/65535, the rounding of n table entries, and by f64's own rounding. Where the exact sums have another arg max, the
//!    lead of that offset over core's may not exceed twice the bound.

use super::{Mismatch, Violation, bound, differs};
use crate::Tracker;
use crate::reference::{Belief, Numbers, Reference, Step};
use crate::sequence::GrayFrame;
use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::Serialize;
use smr_core::{Answer, Config, Rect, State};

/// What was compared, and what was found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The recording's name.
    pub sequence: String,
    /// Frames compared: all but the first, which is locked on, or up to and including the first violation.
    pub frames: usize,
    /// Candidates compared in all frames together.
    pub scores: u64,
    /// Of the frames, those in which the runner-up was asked for, and so compared: by the gate, or by the configuration.
    pub runners_up: usize,
    /// The first frame in which something that must hold did not.
    pub violation: Option<Violation>,
    /// The largest |core's score - exact score| of a candidate, in units of 1/65535.
    pub largest_difference: f64,
    /// What that may be at most, for this template's number of pixels.
    pub bound: f64,
    /// Frames where the exact sums have another arg max than core.
    pub other_peaks: Vec<OtherPeak>,
}

impl Report {
    /// True if everything that must hold did.
    pub fn holds(&self) -> bool {
        self.violation.is_none()
    }
}

/// A frame in which rounding p to the table's grid decided which offset wins.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OtherPeak {
    /// The frame, counted from 1.
    pub frame: usize,
    /// By how much the exact sum of the other offset is larger, in units of 1/65535.
    pub margin: f64,
}

/// Runs both trackers side by side, one frame at a time.
pub struct Check {
    core: Box<Tracker>,
    reference: Reference,
    report: Report,
}

impl Check {
    /// Locks both on `target` in the first frame. `numbers` and `config` are meant to be the same, said twice.
    pub fn lock(name: &str, config: Config, numbers: Numbers, first: &GrayFrame, target: Rect) -> Result<Self> {
        let mut core = Box::new(Tracker::new(config)?);
        core.lock(&first.frame(), target).with_context(|| format!("{name}: cannot lock on {target:?}"))?;
        let size = (i64::from(first.width), i64::from(first.height));
        let target_size = (i64::from(target.width), i64::from(target.height));
        let box_ = (i64::from(target.x), i64::from(target.y), target_size.0, target_size.1);
        let reference = Reference::lock(numbers, &first.pixels, size, box_);
        let report = Report {
            sequence: name.to_owned(),
            frames: 0,
            scores: 0,
            runners_up: 0,
            violation: None,
            largest_difference: 0.0,
            bound: bound(target.area()),
            other_peaks: Vec::new(),
        };
        Ok(Self { core, reference, report })
    }

    /// Compares one more frame. After a violation the two no longer walk side by side: there is nothing to go on with.
    pub fn update(&mut self, frame: &GrayFrame) -> Result<()> {
        if !self.report.holds() {
            bail!("{}: a check ends with its first violation", self.report.sequence);
        }
        let offsets = self.core.offsets().context("the tracker is locked")?;
        let scores = self.core_scores(frame)?;
        let answer = self.core.update(&frame.frame())?;
        let step = self.reference.update(&frame.pixels);
        self.report.frames += 1;
        self.report.scores += scores.len() as u64;
        self.report.runners_up += usize::from(step.runner_up_asked);
        let number = self.report.frames + 1;
        self.report.violation = window(&offsets, &step)
            .or_else(|| self.each_score(&offsets, &scores, &step))
            .or_else(|| decisions(&answer, &step))
            .or_else(|| self.template())
            .or_else(|| self.exact_arg_max(number, &answer, &step))
            .map(|mismatch| mismatch.in_frame(number));
        Ok(())
    }

    /// The report so far.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// The report, at the end.
    pub fn into_report(self) -> Report {
        self.report
    }

    /// Core's score of every candidate, row by row, each asked for by itself: whatever way the search takes, these are
    /// what it must have found.
    fn core_scores(&self, frame: &GrayFrame) -> Result<Vec<u32>> {
        let (offsets, frame) = (self.core.offsets().context("the tracker is locked")?, frame.frame());
        let score = |x, y| self.core.score_at(&frame, x, y).context("a whole frame holds every pixel");
        offsets.ys().into_par_iter().flat_map_iter(|y| offsets.xs().map(move |x| score(x, y))).collect()
    }

    fn each_score(&mut self, offsets: &smr_core::search::Window, core: &[u32], step: &Step) -> Option<Mismatch> {
        let mut different = None;
        for (((x, y), sums), &score) in step.scores.iter().zip(core) {
            let difference = (f64::from(score) - sums.exact).abs();
            self.report.largest_difference = self.report.largest_difference.max(difference);
            if f64::from(score) != sums.rounded && different.is_none() {
                different = Some(Mismatch::new(format!("score at ({x}, {y})"), score, sums.rounded));
            }
        }
        if self.report.largest_difference > self.report.bound {
            let what = format!("largest difference from an exact score, window {offsets:?}");
            different = different.or(Some(Mismatch::new(what, self.report.largest_difference, self.report.bound)));
        }
        different
    }

    fn template(&self) -> Option<Mismatch> {
        let template = self.core.template()?;
        let core = template.rows().flatten().map(|&pixel| f64::from(pixel));
        let first = core.zip(self.reference.template()).position(|(core, reference)| core != *reference)?;
        let core = template.rows().flatten().nth(first)?;
        Some(Mismatch::new(format!("template pixel {first}"), core, self.reference.template()[first]))
    }

    /// Notes a frame where exact sums would have decided otherwise, and tells whether they may.
    fn exact_arg_max(&mut self, frame: usize, answer: &Answer, step: &Step) -> Option<Mismatch> {
        let peak = (i64::from(answer.found.peak.x), i64::from(answer.found.peak.y));
        if peak == step.exact_peak.0 {
            return None;
        }
        let of_cores_peak = step.scores.iter().find(|(at, _)| *at == peak).map_or(0.0, |(_, sums)| sums.exact);
        let margin = step.exact_peak.1 - of_cores_peak;
        self.report.other_peaks.push(OtherPeak { frame, margin });
        let most = 2.0 * self.report.bound;
        (margin > most).then(|| Mismatch::new("lead of the exact arg max over core's peak".into(), margin, most))
    }
}

fn window(core: &smr_core::search::Window, step: &Step) -> Option<Mismatch> {
    let (xs, ys) = (core.xs(), core.ys());
    let ends = [*xs.start(), *xs.end(), *ys.start(), *ys.end()].map(i64::from);
    let scores = &step.scores;
    let expected = [scores.left, scores.left + scores.columns - 1, scores.top, scores.top + scores.rows - 1];
    differs("window (left, right, top, bottom)", ends, expected)
}

fn decisions(answer: &Answer, step: &Step) -> Option<Mismatch> {
    let found = &answer.found;
    let position = |x: i32, y: i32| (i64::from(x), i64::from(y));
    differs("peak's position", position(found.peak.x, found.peak.y), step.peak.0)
        .or_else(|| differs("peak's score", f64::from(found.peak.score), step.peak.1))
        .or_else(|| {
            differs("runner-up", found.runner_up.map(f64::from), step.runner_up_asked.then_some(step.runner_up))
        })
        .or_else(|| differs("alpha, rounded up", f64::from(answer.alpha), step.alpha.ceil()))
        .or_else(|| differs("state", belief(answer.state), step.belief))
        .or_else(|| differs("box", position(answer.bbox.x, answer.bbox.y), step.position))
}

fn belief(state: State) -> Belief {
    match state {
        State::Tracking => Belief::Tracking,
        State::Leaving => Belief::Leaving,
        State::Lost => Belief::Lost,
    }
}
