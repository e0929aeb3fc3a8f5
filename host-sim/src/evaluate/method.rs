//! What every tracker that can be run here has in common: [`Method`]; SMR as one of them, and a [`Run`] of any.

use super::baseline::{Baseline, Measure};
use crate::Tracker;
use crate::sequence::GrayFrame;
use anyhow::{Context, Result};
use clap::ValueEnum;
use smr_core::{Answer, Config, Frame, Image, Rect, State};

/// A tracker that follows one box.
pub trait Method {
    /// Starts on the target in `target`.
    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()>;

    /// Looks for the target in the next frame.
    fn update(&mut self, frame: &Frame<'_>) -> Result<Report>;

    /// What the next frame will be compared with; `None` before the first lock.
    fn template(&self) -> Option<Image<'_>>;
}

/// What a method says about one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// The target's box; `None` when it is lost.
    pub target: Option<Rect>,
    pub state: State,
    /// What SMR's gate decided on; `None` in the frame that was locked on, and from methods that have no gate.
    pub evidence: Option<Evidence>,
    /// Comparisons of bytes that the answer took, at most; `None` from methods that do not count them.
    pub comparisons: Option<u64>,
}

/// The figures behind an answer of SMR, with 1.0 as 1.0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    pub ratio: f64,
    /// `None` where nothing depended on it.
    pub runner_up_ratio: Option<f64>,
    /// In gray levels, rounded up, as the tracker uses it.
    pub alpha: u16,
}

impl Report {
    /// The frame that was locked on: the box is the one that was given.
    #[must_use]
    pub const fn locked(target: Rect) -> Self {
        Self { target: Some(target), state: State::Tracking, evidence: None, comparisons: None }
    }

    /// The state, as it is printed everywhere.
    #[must_use]
    pub const fn state_name(&self) -> &'static str {
        match self.state {
            State::Tracking => "tracking",
            State::Leaving => "leaving",
            State::Lost => "lost",
        }
    }
}

impl From<Answer> for Report {
    fn from(answer: Answer) -> Self {
        let evidence = Evidence {
            ratio: f64::from(answer.ratio) / f64::from(u16::MAX),
            runner_up_ratio: answer.runner_up_ratio.map(|ratio| f64::from(ratio) / f64::from(u16::MAX)),
            alpha: answer.alpha,
        };
        let target = (answer.state != State::Lost).then_some(answer.bbox);
        Self { target, state: answer.state, evidence: Some(evidence), comparisons: None }
    }
}

/// The methods that there are, under their names on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodKind {
    /// The Similarity Matching Ratio, by smr-core
    Smr,
    /// The sum of absolute differences
    Sad,
    /// The sum of squared differences
    Ssd,
    /// Zero-mean normalised cross-correlation
    Ncc,
}

impl MethodKind {
    /// As on the command line and in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Smr => "smr",
            Self::Sad => "sad",
            Self::Ssd => "ssd",
            Self::Ncc => "ncc",
        }
    }

    /// A tracker without a target. The baselines take window and padding from `config`; the rest is SMR's own.
    ///
    /// # Errors
    /// A number of the configuration that SMR cannot use.
    pub fn build(self, config: &Config) -> Result<Box<dyn Method>> {
        Ok(match self {
            Self::Smr => Box::new(Tracker::new(*config)?),
            Self::Sad => Box::new(Baseline::new(Measure::Absolute, config)),
            Self::Ssd => Box::new(Baseline::new(Measure::Squared, config)),
            Self::Ncc => Box::new(Baseline::new(Measure::Correlation, config)),
        })
    }
}

impl Method for Tracker {
    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        Ok(Self::lock(self, frame, target)?)
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<Report> {
        let mut update = self.begin(frame)?;
        while !update.step(u32::MAX) {}
        let comparisons = Some(update.work());
        Ok(Report { comparisons, ..update.finish().into() })
    }

    fn template(&self) -> Option<Image<'_>> {
        Self::template(self)
    }
}

/// One method on its way through one sequence: locks on the first frame, looks for the target in all others.
pub struct Run {
    method: Box<dyn Method>,
    start: Rect,
    frames: usize,
}

impl Run {
    /// `method` will be locked on `start`.
    #[must_use]
    pub fn new(method: Box<dyn Method>, start: Rect) -> Self {
        Self { method, start, frames: 0 }
    }

    /// What the method says about the next frame.
    ///
    /// # Errors
    /// The method's, with the number of the frame; the first is 1.
    pub fn step(&mut self, frame: &GrayFrame) -> Result<Report> {
        self.frames += 1;
        let report = match self.frames {
            1 => self.method.lock(&frame.frame(), self.start).map(|()| Report::locked(self.start)),
            _ => self.method.update(&frame.frame()),
        };
        report.with_context(|| format!("frame {}", self.frames))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(width: u16, height: u16) -> GrayFrame {
        GrayFrame { width, height, pixels: vec![7; usize::from(width) * usize::from(height)] }
    }

    #[test]
    fn a_run_locks_once_and_then_updates() {
        let start = Rect::new(3, 2, 4, 4);
        for &kind in MethodKind::value_variants() {
            let mut run = Run::new(kind.build(&Config::paper()).unwrap(), start);
            assert_eq!(run.step(&plain(16, 12)).unwrap(), Report::locked(start));
            let report = run.step(&plain(16, 12)).unwrap();
            assert_eq!((report.target, report.state), (Some(start), State::Tracking), "{}", kind.name());
            assert_eq!(report.evidence.is_some(), kind == MethodKind::Smr);
            assert_eq!(report.comparisons.is_some(), kind == MethodKind::Smr);
        }
    }

    #[test]
    fn errors_name_the_frame() {
        for &kind in MethodKind::value_variants() {
            let mut run = Run::new(kind.build(&Config::paper()).unwrap(), Rect::new(3, 2, 4, 4));
            run.step(&plain(16, 12)).unwrap();
            let error = run.step(&plain(16, 13)).unwrap_err();
            assert_eq!(format!("{error:#}"), format!("frame 2: {}", smr_core::UpdateError::FrameSizeChanged));
            let mut run = Run::new(kind.build(&Config::paper()).unwrap(), Rect::new(13, 2, 4, 4));
            let error = run.step(&plain(16, 12)).unwrap_err();
            assert_eq!(format!("{error:#}"), format!("frame 1: {}", smr_core::LockError::BoxOutsideFrame));
        }
    }

    #[test]
    fn names_are_those_of_the_command_line() {
        for &kind in MethodKind::value_variants() {
            assert_eq!(MethodKind::from_str(kind.name(), false), Ok(kind));
        }
    }
}
