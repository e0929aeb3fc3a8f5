//! The five figures of the paper, of any recording: SMR beside SAD.
//!
//! A recording is followed twice: first for what happens in it, then for the pictures of the frames that are shown.

mod choice;
mod drawn;
mod sheet;

use super::film::{Film, Still};
use super::search::Search;
use anyhow::{Context, Result, ensure};
use smr_evaluation::MethodKind;
use smr_recordings::FrameRange;
use std::fmt;

/// Methods in the figures.
pub const METHODS: [MethodKind; 2] = [MethodKind::Smr, MethodKind::Sad];
const SMR: usize = 0;
const SAD: usize = 1;

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
    /// The frames whose pictures are in it, in order; the first is 0.
    pub frames: Vec<usize>,
    /// First and last frame in which the target is hidden, for the last figure.
    hidden: (usize, usize),
}

impl Plan {
    /// Chosen by what happened, but for what the user names: the `frame` of boxes and differences, of which the first is 0, and those in which
    /// the target is `hidden`.
    /// Errors: What the figure needs is not in the recording, or in its ground truth.
    pub fn new(figure: Figure, film: &Film, frame: Option<usize>, hidden: Option<FrameRange>) -> Result<Self> {
        let plan = || {
            let mut span = (0, 0);
            let frames = match figure {
                Figure::Boxes => vec![choice::boxes(film, frame)?],
                Figure::Differences => vec![choice::differences(film, frame)?],
                Figure::Leaving => choice::leaving(film)?,
                Figure::Drift => {
                    ensure!(film.truth.is_some(), "it needs ground truth, for the distance from it");
                    Vec::new()
                }
                Figure::Occlusion => {
                    span = choice::span(film, hidden)?;
                    choice::occlusion(film, span)
                }
            };
            Ok(Self { figure, frames, hidden: span })
        };
        plan().with_context(|| format!("{}: no figure {} ({})", film.name, figure as u8 + 1, figure.name()))
    }

    /// Returns it as SVG. The film has the frames of the plan as its stills, and maybe others.
    pub fn draw(&self, film: &Film) -> Result<String> {
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

fn compared(still: &Still, method: usize) -> Result<&Search> {
    still.sights[method].search.as_ref().context("something is compared in every frame but the first")
}

/// The files of the built-in recording are tested in `tests/host_sim/figures.rs`, and errors in `tests/cases`.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Refusal, watch};
    use smr_core::paper::Config;
    use smr_evaluation::{Configs, Variant};
    use smr_recordings::{OpenOptions, Sequence};
    use std::path::Path;

    fn watched(name: &str, change: impl FnOnce(Sequence) -> Sequence) -> Film {
        let sequence = change(smr_recordings::open(Path::new(name), &OpenOptions::default()).unwrap());
        let methods = METHODS.map(|kind| Variant::new(kind, &Configs::from(Config::paper())));
        watch(sequence, vec![], &methods, Refusal::Fails, &[].into(), None, || ()).unwrap()
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
                let expected = format!("frame {} compares nothing: expected 2 to 240", frame + 1);
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
