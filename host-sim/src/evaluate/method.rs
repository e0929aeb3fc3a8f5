//! What every tracker that can be run here has in common: [`Method`]; both of smr-core as two of them, and a [`Run`] of any.

use super::baseline::{Baseline, Flow, Measure};
use super::{Configs, Refused};
use crate::Paper;
use crate::sequence::{BoundingBox, GrayFrame};
use anyhow::{Context, Result};
use clap::ValueEnum;
use serde::Serialize;
use smr_core::{Answer, Frame, Image, Quality, Rect, Robust, State, Target, Tracker};

/// A tracker that follows one box.
pub trait Method {
    /// Which one it is.
    fn kind(&self) -> MethodKind;

    /// Starts on the target in `target`.
    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()>;

    /// Looks for the target in the next frame.
    fn update(&mut self, frame: &Frame<'_>) -> Result<Report>;

    /// How well the target can be told from what lies beside it; `None` before the first lock, and from the baselines.
    fn quality(&self) -> Option<Quality> {
        None
    }

    /// What a baseline will compare the next frame with; `None` before the first lock, and from smr-core's trackers, which show more than
    /// that: see `report`.
    fn template(&self) -> Option<Image<'_>> {
        None
    }
}

/// What a method says about one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// The target's box, to fractions of a pixel; `None` when it is lost.
    pub target: Option<BoundingBox>,
    /// The same in whole pixels.
    pub bbox: Option<Rect>,
    pub state: State,
    /// What smr-core decided on; `None` in the frame that was locked on, and from the baselines.
    pub evidence: Option<Evidence>,
    /// The work that the answer took, at most, in units of [`Update::step`](smr_core::Update::step); `None` from the baselines.
    pub work: Option<u32>,
}

/// The figures behind an answer of smr-core, with 1.0 as 1.0: see [`Answer`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Evidence {
    pub confidence: f64,
    pub ratio: f64,
    pub runner_up_ratio: Option<f64>,
    /// In gray levels, rounded up, as the tracker uses it.
    pub alpha: Option<u16>,
    pub scale: f64,
    pub found_again: bool,
}

impl Report {
    /// The frame that was locked on: the box is the one that was given.
    #[must_use]
    pub fn locked(target: Rect) -> Self {
        Self::of_baseline(target.into(), true)
    }

    /// What a baseline knows: its best box, inside the frame or not.
    #[must_use]
    pub(super) fn of_baseline(target: BoundingBox, inside: bool) -> Self {
        let state = if inside { State::Tracking } else { State::Leaving };
        Self { target: Some(target), bbox: target.to_rect(), state, evidence: None, work: None }
    }
}

impl From<Answer> for Report {
    fn from(answer: Answer) -> Self {
        let Answer { state, confidence, ratio, runner_up_ratio, alpha, scale, found_again, .. } = answer;
        let evidence = Evidence {
            confidence: of_one(confidence),
            ratio: of_one(ratio),
            runner_up_ratio: runner_up_ratio.map(of_one),
            alpha,
            scale: f64::from(scale) / 65536.0,
            found_again,
        };
        let believed = state != State::Lost;
        let (target, bbox) = (believed.then_some(answer.fine.into()), believed.then_some(answer.bbox));
        Self { target, bbox, state, evidence: Some(evidence), work: None }
    }
}

/// A ratio with 1.0 as 1.0.
fn of_one(ratio: u16) -> f64 {
    f64::from(ratio) / f64::from(u16::MAX)
}

/// A state as it is printed everywhere.
#[must_use]
pub const fn name_of(state: State) -> &'static str {
    match state {
        State::Tracking => "tracking",
        State::Leaving => "leaving",
        State::Uncertain => "uncertain",
        State::Lost => "lost",
    }
}

/// The methods that there are, under their names on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodKind {
    /// The Similarity Matching Ratio, as in the paper
    Smr,
    /// Beyond the paper: holds when light, size and view change
    Robust,
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
    /// As in results, and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Smr => "smr",
            Self::Robust => "robust",
            Self::Sad => "sad",
            Self::Ssd => "ssd",
            Self::Ncc => "ncc",
            Self::Lk => "lk",
        }
    }

    /// True for the two trackers of smr-core.
    #[must_use]
    pub const fn is_core(self) -> bool {
        matches!(self, Self::Smr | Self::Robust)
    }

    /// The states that it can be in, the best one first.
    #[must_use]
    pub const fn states(self) -> &'static [State] {
        match self {
            Self::Smr => &[State::Tracking, State::Leaving, State::Lost],
            Self::Robust => &[State::Tracking, State::Uncertain, State::Lost],
            Self::Sad | Self::Ssd | Self::Ncc | Self::Lk => &[State::Tracking, State::Leaving],
        }
    }

    /// A tracker without a target.
    ///
    /// # Errors
    /// A number of the configuration that smr-core cannot use.
    pub fn build(self, configs: &Configs) -> Result<Box<dyn Method>> {
        let baseline = |measure| Box::new(Baseline::new(measure, &configs.paper));
        Ok(match self {
            Self::Smr => Box::new(Stepped::<Paper>::new(self, configs.paper, configs.step)?),
            Self::Robust => Box::new(Stepped::<Robust>::new(self, configs.robust, configs.step)?),
            Self::Sad => baseline(Measure::Absolute),
            Self::Ssd => baseline(Measure::Squared),
            Self::Ncc => baseline(Measure::Correlation),
            Self::Lk => Box::new(Flow::new(&configs.paper)),
        })
    }
}

/// A tracker of smr-core, updated in steps of so much work.
struct Stepped<T: Target> {
    kind: MethodKind,
    tracker: Tracker<T>,
    step: u32,
}

impl<T: Target> Stepped<T> {
    fn new(kind: MethodKind, config: T::Config, step: u32) -> Result<Self> {
        Ok(Self { kind, tracker: Tracker::new(config)?, step })
    }
}

impl<T: Target> Method for Stepped<T> {
    fn kind(&self) -> MethodKind {
        self.kind
    }

    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        self.tracker.lock(frame, target)?;
        Ok(())
    }

    fn quality(&self) -> Option<Quality> {
        self.tracker.quality()
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<Report> {
        let mut update = self.tracker.begin(frame)?;
        while !update.step(self.step) {}
        let answer = update.finish();
        Ok(Report { work: Some(self.tracker.work()), ..answer.into() })
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

    /// See [`Method::quality`].
    #[must_use]
    pub fn quality(&self) -> Option<Quality> {
        self.method.quality()
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
/// What the method refuses is a [`Refused`].
pub fn lock(method: &mut dyn Method, frame: &Frame<'_>, target: Rect) -> Result<()> {
    method.lock(frame, target).map_err(|error| Refused::or(error, method.kind(), target, frame.bounds()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::{FineRect, UpdateError, paper};

    fn plain(width: u16, height: u16) -> GrayFrame {
        GrayFrame { width, height, pixels: vec![7; usize::from(width) * usize::from(height)] }
    }

    /// In plain frames no peak exceeds the runner-up, which only the camera's preset does not ask for.
    fn built(kind: MethodKind) -> Box<dyn Method> {
        kind.build(&paper::Config::camera().into()).unwrap()
    }

    fn all_kinds() -> impl Iterator<Item = MethodKind> {
        MethodKind::value_variants().iter().copied()
    }

    #[test]
    fn a_run_locks_once_and_then_updates() {
        let start = Rect::new(3, 2, 4, 4);
        for kind in all_kinds() {
            let mut run = Run::new(built(kind), start);
            assert_eq!(run.step(&plain(16, 12)).unwrap(), Report::locked(start));
            let report = run.step(&plain(16, 12)).unwrap();
            assert_eq!((report.target, report.state), (Some(start.into()), State::Tracking), "{}", kind.name());
            assert_eq!((report.evidence.is_some(), report.work.is_some()), (kind.is_core(), kind.is_core()));
        }
    }

    #[test]
    fn errors_name_the_frame() {
        for kind in all_kinds() {
            let mut run = Run::new(built(kind), Rect::new(3, 2, 4, 4));
            run.step(&plain(16, 12)).unwrap();
            let error = run.step(&plain(16, 13)).unwrap_err();
            assert_eq!(format!("{error:#}"), format!("frame 2: {}", UpdateError::FrameSizeChanged));
            let mut run = Run::new(built(kind), Rect::new(13, 2, 4, 4));
            let error = run.step(&plain(16, 12)).unwrap_err();
            let expected = "the box 13,2,4,4 (x,y,width,height) is not wholly inside the frame of 16x12 pixels";
            assert_eq!(format!("{error:#}"), format!("frame 1: {expected}"));
        }
    }

    #[test]
    fn steps_change_no_answer_and_no_work_is_left_out() {
        let frame = |step: u16| {
            let texture =
                |x: u16, y: u16| u8::try_from((x / 3 * 83 + y / 3 * 47 + x / 3 * (y / 3) * 29) % 256).unwrap();
            let pixels = (0..60).flat_map(|y| (0..80).map(move |x| texture(x + step, y))).collect();
            GrayFrame { width: 80, height: 60, pixels }
        };
        for kind in all_kinds().filter(|kind| kind.is_core()) {
            let reports = |step| {
                let configs = Configs { step, ..paper::Config::camera().into() };
                let mut run = Run::new(kind.build(&configs).unwrap(), Rect::new(30, 20, 20, 16));
                (0..6).map(|step| run.step(&frame(step)).unwrap()).collect::<Vec<_>>()
            };
            let whole = reports(u32::MAX);
            for step in [1, 5000] {
                for (whole, stepped) in whole.iter().zip(reports(step)) {
                    assert_eq!(Report { work: None, ..*whole }, Report { work: None, ..stepped }, "{}", kind.name());
                }
            }
        }
    }

    #[test]
    fn an_answer_is_finer_than_a_pixel_and_a_lost_one_is_none() {
        let fine = FineRect { x: -384, y: 128, width: 2560, height: 1 };
        let answer = |state| Answer {
            fine,
            bbox: Rect::new(-1, 1, 10, 1),
            state,
            confidence: u16::MAX,
            ratio: 0,
            runner_up_ratio: None,
            alpha: None,
            scale: 1 << 15,
            found_again: false,
        };
        let report = Report::from(answer(State::Uncertain));
        let expected = BoundingBox { x: -1.5, y: 0.5, width: 10.0, height: 1.0 / 256.0 };
        assert_eq!((report.target, name_of(report.state)), (Some(expected), "uncertain"));
        let evidence = report.evidence.unwrap();
        assert_eq!((evidence.confidence, evidence.ratio, evidence.scale), (1.0, 0.0, 0.5));
        assert_eq!(report.bbox, Some(Rect::new(-1, 1, 10, 1)));
        let lost = Report::from(answer(State::Lost));
        assert_eq!((lost.target, lost.bbox), (None, None));
    }

    #[test]
    fn names_are_those_of_the_command_line() {
        for kind in all_kinds() {
            assert_eq!(MethodKind::from_str(kind.name(), false), Ok(kind));
        }
    }
}
