//! The paper's figures (SMR beside SAD) for any recording: a first run chooses the frames, a second keeps those frames.

mod drawn;
mod frames;
mod sheet;

pub use frames::METHODS;

use super::film::{FilmedRecording, Still};
use anyhow::{Context, Result, ensure};
use frames::{hidden_frames, lead_frame, leaving_frames, span, visible_frame};
use smr_recordings::FrameRange;
use std::fmt;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    Boxes,
    Differences,
    Leaving,
    Drift,
    Occlusion,
}

impl Figure {
    pub const ALL: [Self; 5] = [Self::Boxes, Self::Differences, Self::Leaving, Self::Drift, Self::Occlusion];

    fn name(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}.svg", *self as u8 + 1, self.name())
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    pub figure: Figure,
    /// Indices of the frames to show, from 0, in order.
    pub frames: Vec<usize>,
    /// Indices of the first and the last frame in which the target is hidden, for the figure of an occlusion.
    hidden: (usize, usize),
}

impl Plan {
    /// Chooses the frames of a figure, unless the user does: `frame` (index from 0) for `Boxes` and `Differences`,
    /// `hidden` for `Occlusion`. Errors: The recording, or its ground truth, lacks what the figure needs.
    pub fn new(
        figure: Figure,
        film: &FilmedRecording,
        frame: Option<usize>,
        hidden: Option<FrameRange>,
    ) -> Result<Self> {
        let plan = || {
            let mut hides = (0, 0);
            let frames = match figure {
                Figure::Boxes => vec![lead_frame(film, frame)?],
                Figure::Differences => vec![visible_frame(film, frame)?],
                Figure::Leaving => leaving_frames(film)?,
                Figure::Drift => {
                    ensure!(film.truth.is_some(), "it needs ground truth, for the distance from it");
                    Vec::new()
                }
                Figure::Occlusion => {
                    hides = span(film, hidden)?;
                    hidden_frames(film, hides)
                }
            };
            Ok(Self { figure, frames, hidden: hides })
        };
        plan().with_context(|| format!("{}: no figure {} ({})", film.name, figure as u8 + 1, figure.name()))
    }

    /// Returns the figure as SVG. Fails if the stills of `film` lack a frame of the plan.
    pub fn draw(&self, film: &FilmedRecording) -> Result<String> {
        let still = |&index: &usize| film.stills.iter().find(|still| still.index == index);
        let stills: Option<Vec<&Still>> = self.frames.iter().map(still).collect();
        let stills = stills.context("the frames of the plan are kept")?;
        match self.figure {
            Figure::Boxes => drawn::boxes(film, stills[0]),
            Figure::Differences => drawn::differences(film, stills[0]),
            Figure::Leaving => drawn::leaving(film, &stills),
            Figure::Drift => Ok(drawn::drift(film)),
            Figure::Occlusion => drawn::occlusion(film, &stills, self.hidden),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Watch, watch};
    use smr_core::paper::Config;
    use smr_evaluation::{Configs, Variant};
    use smr_recordings::{OpenOptions, Sequence};
    use std::path::Path;

    fn watched(name: &str, change: impl FnOnce(Sequence) -> Sequence) -> FilmedRecording {
        let sequence = change(smr_recordings::open(Path::new(name), &OpenOptions::default()).unwrap());
        let methods = METHODS.map(|kind| Variant::new(kind, &Configs::from(Config::paper())));
        watch(sequence, Watch::new(&methods), || ()).unwrap()
    }

    #[test]
    fn frames_are_those_of_the_ground_truth_or_those_that_are_given() {
        let film = watched("synthetic", |sequence| sequence);
        let plan = |figure, frame, hidden: Option<&str>| {
            Plan::new(figure, &film, frame, hidden.map(|span| span.parse().unwrap()))
                .map_err(|error| format!("{error:#}"))
        };
        assert_eq!(plan(Figure::Occlusion, None, None).unwrap().hidden, (173, 199));
        assert_eq!(plan(Figure::Occlusion, None, Some("82..130")).unwrap().hidden, (81, 129));
        let late = plan(Figure::Occlusion, None, Some("200..300")).unwrap_err();
        assert!(late.ends_with("--hidden 200..300: expected frames of 2..240"), "{late}");
        for figure in [Figure::Boxes, Figure::Differences] {
            assert_eq!(plan(figure, Some(59), None).unwrap().frames, [59]);
            for frame in [0, 240] {
                let expected = format!("frame {} cannot be drawn: expected 2 to 240", frame + 1);
                assert!(plan(figure, Some(frame), None).unwrap_err().ends_with(&expected), "{figure}");
            }
        }
        let hidden = plan(Figure::Differences, Some(185), None).unwrap_err();
        assert!(hidden.contains("hidden in frame 186"), "{hidden}");
        assert!(
            Plan::new(Figure::Leaving, &watched("border", |sequence| sequence), None, None).unwrap().frames.len() > 1
        );
    }

    #[test]
    fn boxes_and_leaving_need_no_ground_truth() {
        let blind = watched("synthetic", |sequence| Sequence { truth: None, ..sequence });
        let planned = Figure::ALL.into_iter().filter(|&figure| Plan::new(figure, &blind, None, None).is_ok());
        assert_eq!(planned.collect::<Vec<_>>(), [Figure::Boxes, Figure::Leaving]);
    }
}
