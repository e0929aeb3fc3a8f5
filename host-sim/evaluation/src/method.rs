//! The trait of all trackers that run here, their names, and their answer in a frame.

use anyhow::Result;
use clap::ValueEnum;
use serde::Serialize;
use smr_core::{Answer, Frame, Image, Quality, Rect, State};
use smr_recordings::BoundingBox;

pub trait Method {
    fn kind(&self) -> MethodKind;

    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()>;

    fn update(&mut self, frame: &Frame<'_>) -> Result<MethodAnswer>;

    /// Returns how well the target differs from shifted copies of itself; `None` before the first lock, and from baselines.
    fn quality(&self) -> Option<Quality> {
        None
    }

    /// Returns the most pixels that a lock or an update has read so far; 0 from baselines.
    fn most_pixels(&self) -> usize {
        0
    }

    /// Returns the template of a baseline; `None` before the first lock, and from smr-core's trackers.
    fn template(&self) -> Option<Image<'_>> {
        None
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodAnswer {
    /// The target's box, to fractions of a pixel; `None` when it is lost.
    pub target: Option<BoundingBox>,
    /// The target's box in whole pixels; `None` when it is lost.
    pub bbox: Option<Rect>,
    pub state: State,
    /// Numbers behind smr-core's decision; `None` in the frame of a lock, and from baselines.
    pub evidence: Option<Evidence>,
    /// Upper bound of the update's work, in units of [`Tracker::update_step`](smr_core::Tracker::update_step); `None`
    /// in the frame of a lock, and from baselines.
    pub work: Option<u32>,
}

/// Numbers from smr-core's [`Answer`], which explains them; its fixed-point numbers are converted to floats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Evidence {
    pub confidence: f64,
    pub ratio: f64,
    pub runner_up_ratio: Option<f64>,
    /// Threshold alpha of the frame, rounded up to whole gray levels; `None` from `Robust`.
    pub alpha: Option<u16>,
    /// From 0, certainly not the target of the lock, to 1; `None` without the refiner.
    pub identity: Option<f64>,
    pub scale: f64,
    pub found_again: bool,
}

impl MethodAnswer {
    /// Creates the report of a frame in which the tracker was locked on `target`.
    pub fn locked(target: Rect) -> Self {
        Self::of_baseline(target.into(), true)
    }

    pub fn confidence(&self) -> Option<f64> {
        self.evidence.map(|evidence| evidence.confidence)
    }

    pub(super) fn of_baseline(target: BoundingBox, inside: bool) -> Self {
        let state = if inside { State::Tracking } else { State::Leaving };
        Self { target: Some(target), bbox: target.to_rect(), state, evidence: None, work: None }
    }
}

impl From<Answer> for MethodAnswer {
    fn from(answer: Answer) -> Self {
        let Answer { state, confidence, ratio, runner_up_ratio, alpha, identity, scale, found_again, .. } = answer;
        let of_one = |ratio: u16| f64::from(ratio) / f64::from(u16::MAX);
        let (confidence, ratio, scale) = (of_one(confidence), of_one(ratio), f64::from(scale) / 65536.0);
        let (runner_up_ratio, identity) = (runner_up_ratio.map(of_one), identity.map(of_one));
        let evidence = Evidence { confidence, ratio, runner_up_ratio, alpha, identity, scale, found_again };
        let believed = state != State::Lost;
        let (target, bbox) = (believed.then_some(answer.fine.into()), believed.then_some(answer.bbox));
        Self { target, bbox, state, evidence: Some(evidence), work: None }
    }
}

pub const fn name_of(state: State) -> &'static str {
    state.name()
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodKind {
    /// The Similarity Matching Ratio, as in the paper
    #[value(alias = "smr")]
    Paper,
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
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Robust => "robust",
            Self::Sad => "sad",
            Self::Ssd => "ssd",
            Self::Ncc => "ncc",
            Self::Lk => "lk",
        }
    }

    pub const fn is_core(self) -> bool {
        matches!(self, Self::Paper | Self::Robust)
    }

    /// Returns the states that the method can report, the best one first.
    pub const fn states(self) -> &'static [State] {
        match self {
            Self::Paper => &[State::Tracking, State::Leaving, State::Lost],
            Self::Robust => &[State::Tracking, State::Uncertain, State::Lost],
            Self::Sad | Self::Ssd | Self::Ncc | Self::Lk => &[State::Tracking, State::Leaving],
        }
    }
}

/// The two trackers of smr-core, for commands without baselines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum CoreKind {
    /// The Similarity Matching Ratio, as in the paper
    #[value(alias = "smr")]
    #[default]
    Paper,
    /// Beyond the paper: holds when light, size and view change
    Robust,
}

impl From<CoreKind> for MethodKind {
    fn from(method: CoreKind) -> Self {
        match method {
            CoreKind::Paper => Self::Paper,
            CoreKind::Robust => Self::Robust,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::FineRect;

    #[test]
    fn an_answer_is_finer_than_a_pixel_and_a_lost_one_is_none() {
        let fine = FineRect { x: -384, y: 128, width: 2560, height: 1 };
        let answer = |state| {
            let mut answer = Answer::new(fine, state);
            (answer.confidence, answer.scale) = (u16::MAX, 1 << 15);
            answer
        };
        let report = MethodAnswer::from(answer(State::Uncertain));
        let expected = BoundingBox { x: -1.5, y: 0.5, width: 10.0, height: 1.0 / 256.0 };
        assert_eq!((report.target, name_of(report.state)), (Some(expected), "uncertain"));
        let evidence = report.evidence.unwrap();
        assert_eq!((evidence.confidence, evidence.ratio, evidence.scale), (1.0, 0.0, 0.5));
        assert_eq!(report.bbox, Some(Rect::new(-1, 1, 10, 1)));
        let lost = MethodAnswer::from(answer(State::Lost));
        assert_eq!((lost.target, lost.bbox), (None, None));
    }

    #[test]
    fn names_are_those_of_the_command_line() {
        for &kind in MethodKind::value_variants() {
            assert_eq!(MethodKind::from_str(kind.name(), false), Ok(kind));
        }
    }
}
