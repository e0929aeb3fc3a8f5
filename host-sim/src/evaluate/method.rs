//! What every tracker that can be run here has in common: [`Method`]; both of SMR as two of them, and a [`Run`] of any.

use super::Configs;
use super::baseline::{Baseline, Flow, Measure};
use crate::Tracker;
use crate::sequence::{BoundingBox, GrayFrame};
use anyhow::{Context, Result, anyhow};
use clap::ValueEnum;
use smr_core::{Answer, Frame, Image, LockError, Rect, robust};

/// A tracker that follows one box.
pub trait Method {
    /// Starts on the target in `target`.
    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()>;

    /// Looks for the target in the next frame.
    fn update(&mut self, frame: &Frame<'_>) -> Result<Report>;

    /// What the next frame will be compared with; `None` before the first lock, and from the robust tracker, whose filter is no picture.
    fn template(&self) -> Option<Image<'_>>;
}

/// What a method says about one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// The target's box; `None` when it is lost.
    pub target: Option<BoundingBox>,
    pub state: State,
    /// What SMR decided on; `None` in the frame that was locked on, and from the baselines.
    pub evidence: Option<Evidence>,
    /// Comparisons of bytes, or products of a filter, that the answer took, at most; `None` from methods that do not count them.
    pub comparisons: Option<u64>,
}

/// The figures behind an answer of SMR, with 1.0 as 1.0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// The paper's tracker's ratio; the robust one's confidence.
    pub ratio: f64,
    /// `None` where nothing depended on it, and from the robust tracker.
    pub runner_up_ratio: Option<f64>,
    /// In gray levels, rounded up, as the tracker uses it; `None` from the robust tracker, which has one for each comparison.
    pub alpha: Option<u16>,
}

impl Report {
    /// The frame that was locked on: the box is the one that was given.
    #[must_use]
    pub fn locked(target: Rect) -> Self {
        Self { target: Some(target.into()), state: State::Tracking, evidence: None, comparisons: None }
    }
}

impl Report {
    fn answered(target: BoundingBox, state: State, evidence: Evidence) -> Self {
        let target = (state != State::Lost).then_some(target);
        Self { target, state, evidence: Some(evidence), comparisons: None }
    }
}

impl From<Answer> for Report {
    fn from(answer: Answer) -> Self {
        let evidence = Evidence {
            ratio: of_one(answer.ratio),
            runner_up_ratio: answer.runner_up_ratio.map(of_one),
            alpha: Some(answer.alpha),
        };
        Self::answered(answer.bbox.into(), answer.state.into(), evidence)
    }
}

impl From<robust::Answer> for Report {
    fn from(answer: robust::Answer) -> Self {
        let evidence = Evidence { ratio: of_one(answer.confidence), runner_up_ratio: None, alpha: None };
        let report = Self::answered(answer.fine.into(), answer.state.into(), evidence);
        Self { comparisons: Some(answer.work.into()), ..report }
    }
}

/// A ratio with 1.0 as 1.0.
fn of_one(ratio: u16) -> f64 {
    f64::from(ratio) / f64::from(u16::MAX)
}

/// What a method holds of its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    Tracking,
    /// The paper's tracker: partly outside the frame.
    Leaving,
    /// The robust tracker: it may be something else.
    Uncertain,
    Lost,
}

impl State {
    /// As it is printed everywhere.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tracking => "tracking",
            Self::Leaving => "leaving",
            Self::Uncertain => "uncertain",
            Self::Lost => "lost",
        }
    }
}

impl From<smr_core::State> for State {
    fn from(state: smr_core::State) -> Self {
        match state {
            smr_core::State::Tracking => Self::Tracking,
            smr_core::State::Leaving => Self::Leaving,
            smr_core::State::Lost => Self::Lost,
        }
    }
}

impl From<robust::State> for State {
    fn from(state: robust::State) -> Self {
        match state {
            robust::State::Tracking => Self::Tracking,
            robust::State::Uncertain => Self::Uncertain,
            robust::State::Lost => Self::Lost,
        }
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
    /// Lucas-Kanade: translation, with an image pyramid
    Lk,
}

impl MethodKind {
    /// As in results: as on the command line, but for SMR as the robust tracker.
    pub const fn name(self, configs: &Configs) -> &'static str {
        match self {
            Self::Smr if configs.robust.is_some() => "robust",
            Self::Smr => "smr",
            Self::Sad => "sad",
            Self::Ssd => "ssd",
            Self::Ncc => "ncc",
            Self::Lk => "lk",
        }
    }

    /// A tracker without a target.
    ///
    /// # Errors
    /// A number of the configuration that SMR cannot use.
    pub fn build(self, configs: &Configs) -> Result<Box<dyn Method>> {
        let baseline = |measure| Box::new(Baseline::new(measure, &configs.paper));
        Ok(match (self, configs.robust) {
            (Self::Smr, None) => Box::new(Tracker::new(configs.paper)?),
            (Self::Smr, Some(config)) => Box::new(<robust::Tracker>::new(config)),
            (Self::Sad, _) => baseline(Measure::Absolute),
            (Self::Ssd, _) => baseline(Measure::Squared),
            (Self::Ncc, _) => baseline(Measure::Correlation),
            (Self::Lk, _) => Box::new(Flow::new(&configs.paper)),
        })
    }
}

impl Method for Tracker {
    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        Self::lock(self, frame, target).map_err(|error| match error {
            LockError::BoxTooLarge => anyhow!(
                "{error}: expected at most {}, as a score has 32 bits; --config robust has no such bound",
                crate::MOST_PIXELS
            ),
            LockError::WindowTooLarge => anyhow!("{error}: expected at most {} on an axis", crate::MOST_OFFSETS),
            error => error.into(),
        })
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

impl Method for robust::Tracker {
    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        Ok(Self::lock(self, frame, target)?)
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<Report> {
        Ok(Self::update(self, frame)?.into())
    }

    fn template(&self) -> Option<Image<'_>> {
        None
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
            1 => lock(self.method.as_mut(), &frame.frame(), self.start).map(|()| Report::locked(self.start)),
            _ => self.method.update(&frame.frame()),
        };
        report.with_context(|| format!("frame {}", self.frames))
    }
}

/// Starts `method` on the target in `target`.
///
/// # Errors
/// The method's, with the numbers that it is about.
pub fn lock(method: &mut dyn Method, frame: &Frame<'_>, target: Rect) -> Result<()> {
    method.lock(frame, target).with_context(|| {
        let (Rect { x, y, width, height }, bounds) = (target, frame.bounds());
        let pixels = u64::from(width) * u64::from(height);
        format!("the box {x},{y},{width},{height} of {pixels} pixels in a frame of {}x{}", bounds.width, bounds.height)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::Config;

    fn plain(width: u16, height: u16) -> GrayFrame {
        GrayFrame { width, height, pixels: vec![7; usize::from(width) * usize::from(height)] }
    }

    /// With the paper's tracker, and with the robust one.
    fn all_configs() -> [Configs; 2] {
        // In plain frames no peak exceeds the runner-up, which only the camera's preset does not ask for.
        let paper = Configs::from(Config::camera());
        [paper, Configs { robust: Some(robust::Config::robust()), ..paper }]
    }

    #[test]
    fn a_run_locks_once_and_then_updates() {
        let start = Rect::new(3, 2, 4, 4);
        for (configs, &kind) in all_configs().iter().flat_map(|configs| all_kinds().map(move |kind| (configs, kind))) {
            let mut run = Run::new(kind.build(configs).unwrap(), start);
            assert_eq!(run.step(&plain(16, 12)).unwrap(), Report::locked(start));
            let report = run.step(&plain(16, 12)).unwrap();
            let expected = (Some(start.into()), State::Tracking);
            assert_eq!((report.target, report.state), expected, "{}", kind.name(configs));
            assert_eq!(report.evidence.is_some(), kind == MethodKind::Smr);
            assert_eq!(report.comparisons.is_some(), kind == MethodKind::Smr);
        }
    }

    fn all_kinds() -> impl Iterator<Item = &'static MethodKind> {
        MethodKind::value_variants().iter()
    }

    #[test]
    fn errors_name_the_frame() {
        let [paper, robust] = all_configs();
        let of_paper = (LockError::BoxOutsideFrame.to_string(), smr_core::UpdateError::FrameSizeChanged.to_string());
        let of_robust =
            (robust::LockError::BoxOutsideFrame.to_string(), robust::UpdateError::FrameSizeChanged.to_string());
        let papers = all_kinds().map(|&kind| (kind, paper, &of_paper));
        for (kind, configs, (lock, update)) in papers.chain([(MethodKind::Smr, robust, &of_robust)]) {
            let mut run = Run::new(kind.build(&configs).unwrap(), Rect::new(3, 2, 4, 4));
            run.step(&plain(16, 12)).unwrap();
            let error = run.step(&plain(16, 13)).unwrap_err();
            assert_eq!(format!("{error:#}"), format!("frame 2: {update}"));
            let mut run = Run::new(kind.build(&configs).unwrap(), Rect::new(13, 2, 4, 4));
            let error = run.step(&plain(16, 12)).unwrap_err();
            let numbers = "the box 13,2,4,4 of 16 pixels in a frame of 16x12";
            assert_eq!(format!("{error:#}"), format!("frame 1: {numbers}: {lock}"));
        }
    }

    #[test]
    fn a_robust_answer_is_finer_than_a_pixel_and_a_lost_one_is_none() {
        let fine = robust::FineRect { x: -384, y: 128, width: 2560, height: 1 };
        let answer = |state| robust::Answer {
            fine,
            bbox: Rect::new(-1, 1, 10, 1),
            state,
            confidence: u16::MAX,
            ratio: 9,
            response: 1 << 14,
            scale: 1 << 16,
            found_again: false,
            work: 7,
        };
        let report = Report::from(answer(robust::State::Uncertain));
        let expected = BoundingBox { x: -1.5, y: 0.5, width: 10.0, height: 1.0 / 256.0 };
        assert_eq!((report.target, report.state.name(), report.comparisons), (Some(expected), "uncertain", Some(7)));
        assert_eq!(report.evidence, Some(Evidence { ratio: 1.0, runner_up_ratio: None, alpha: None }));
        assert_eq!(Report::from(answer(robust::State::Lost)).target, None);
    }

    #[test]
    fn names_are_those_of_the_command_line() {
        let [paper, robust] = all_configs();
        for &kind in all_kinds() {
            assert_eq!(MethodKind::from_str(kind.name(&paper), false), Ok(kind));
        }
        assert_eq!((MethodKind::Smr.name(&robust), MethodKind::Ncc.name(&robust)), ("robust", "ncc"));
    }
}
