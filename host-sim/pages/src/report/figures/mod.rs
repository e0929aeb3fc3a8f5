//! The paper's figures (SMR beside SAD) for any recording: a first run chooses the frames, a second keeps those frames.

mod drawn;
mod sheet;

use super::film::{FilmedRecording, Still};
use super::search::Search;
use anyhow::{Context, Result, ensure};
use smr_core::{Rect, State};
use smr_evaluation::{CORRECT, MethodKind};
use smr_recordings::FrameRange;
use std::fmt;

pub const METHODS: [MethodKind; 2] = [MethodKind::Paper, MethodKind::Sad];
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

fn compared(still: &Still, method: usize) -> Result<&Search> {
    still.observations[method].search.as_ref().context("something is compared in every frame but the first")
}

/// Number of frames to score and plot before an occlusion, and the same number after it.
const AROUND: usize = 40;
/// Distance in frames between an occlusion and the images that show the target before and after it.
const BESIDE: usize = 10;

/// Returns the frame `wish`, which must not be the first; without a wish, the frame in which SMR leads SAD by the most.
fn lead_frame(film: &FilmedRecording, wish: Option<usize>) -> Result<usize> {
    let Some(frame) = wish else {
        let leads = (1..film.moments.len()).filter_map(|index| Some((index, lead(film, index)?)));
        let best = leads.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        return Ok(best.context("there is no frame in which SMR has an answer to compare")?.0);
    };
    let length = film.moments.len();
    ensure!((1..length).contains(&frame), "frame {} cannot be drawn: expected 2 to {length}", frame + 1);
    Ok(frame)
}

/// Returns the frame of [`lead_frame`]; fails if the target is hidden in it.
fn visible_frame(film: &FilmedRecording, wish: Option<usize>) -> Result<usize> {
    ensure!(film.truth.is_some(), "it needs ground truth, for the true place of the target");
    let frame = lead_frame(film, wish)?;
    ensure!(
        film.truth_at(frame).is_some(),
        "the target is hidden in frame {}: expected one where it is visible",
        frame + 1
    );
    Ok(frame)
}

/// Returns SMR's IoU with the ground truth minus SAD's; without ground truth, 1 minus the IoU of SMR's and SAD's boxes.
fn lead(film: &FilmedRecording, index: usize) -> Option<f64> {
    let [smr, sad] = [SMR, SAD].map(|method| film.moments[index].reports[method].target);
    if film.truth.is_none() {
        return Some(1.0 - smr?.iou(&sad?));
    }
    smr.and(Some(overlap(film, SMR, index)? - overlap(film, SAD, index)?))
}

/// Returns the IoU of a method's box with the ground truth: 0 if the method has no box, `None` if the target is hidden.
fn overlap(film: &FilmedRecording, method: usize, index: usize) -> Option<f64> {
    let truth = film.truth_at(index)?;
    Some(film.moments[index].reports[method].target.map_or(0.0, |target| target.iou(&truth)))
}

/// Returns the frames around the target's exit: the last before it, the one with the box farthest outside, the first in
/// which the target is lost, and the first in which it is wholly inside again.
fn leaving_frames(film: &FilmedRecording) -> Result<Vec<usize>> {
    let state = |index: usize| film.moments[index].reports[SMR].state;
    let leaving = (1..film.moments.len()).filter(|&index| state(index) == State::Leaving);
    let deepest = leaving.max_by_key(|&index| outside(film, index));
    let deepest = deepest.context("the box of SMR never reaches over the border of the frame")?;
    let away = |index: &usize| state(*index) != State::Tracking;
    let first = (1..=deepest).rev().take_while(away).last().unwrap_or(deepest);
    let last = (deepest..film.moments.len()).take_while(away).last().unwrap_or(deepest);
    let mut frames = vec![(first - 1).max(1), deepest];
    frames.extend((first..=last).find(|&index| state(index) == State::Lost));
    frames.extend(Some(last + 1).filter(|&after| after < film.moments.len()));
    frames.sort_unstable();
    frames.dedup();
    Ok(frames)
}

/// Returns the area in pixels of SMR's box outside the frame.
fn outside(film: &FilmedRecording, index: usize) -> u64 {
    let Some(bbox) = film.moments[index].reports[SMR].bbox else { return 0 };
    let frame = Rect::new(0, 0, film.size.0, film.size.1);
    u64::from(bbox.width) * u64::from(bbox.height) - u64::from(bbox.intersection(frame).area())
}

/// Returns (first, last) of each run of frames in which the target is hidden, according to the ground truth.
fn spans(film: &FilmedRecording) -> Vec<(usize, usize)> {
    let truth = film.truth.iter().flatten().collect::<Vec<_>>();
    let hidden: Vec<usize> = (0..truth.len()).filter(|&index| truth[index].is_none()).collect();
    hidden.chunk_by(|one, next| one + 1 == *next).map(|run| (run[0], run[run.len() - 1])).collect()
}

/// Returns the user's occlusion `wish`; without a wish, the occlusion after which SMR's accuracy falls most.
fn span(film: &FilmedRecording, wish: Option<FrameRange>) -> Result<(usize, usize)> {
    ensure!(film.truth.is_some(), "it needs ground truth, for what is correct");
    let length = film.moments.len();
    if let Some(range) = wish {
        let (first, last) = (range.first(), range.last().unwrap_or(length));
        ensure!(first > 1 && last <= length, "--hidden {range}: expected frames of 2..{length}");
        return Ok((first - 1, last - 1));
    }
    let correct = |from: usize, to: usize| {
        let overlaps: Vec<f64> = (from..to.min(length)).filter_map(|index| overlap(film, SMR, index)).collect();
        overlaps.iter().filter(|&&iou| iou > CORRECT).count() as f64 / overlaps.len().max(1) as f64
    };
    let fall = |&(first, last): &(usize, usize)| {
        correct(first.saturating_sub(AROUND), first) - correct(last + 1, last + 1 + AROUND)
    };
    let inner = spans(film).into_iter().filter(|&(first, _)| first > 0);
    inner.max_by(|a, b| fall(a).total_cmp(&fall(b)).then(b.0.cmp(&a.0))).context(
        "the ground truth has no frame in which the target is hidden; where it has a box all the time, say where with --hidden A..B",
    )
}

fn hidden_frames(film: &FilmedRecording, (first, last): (usize, usize)) -> Vec<usize> {
    let most = film.moments.len() - 1;
    let mut frames = vec![first.saturating_sub(BESIDE).max(1), first.max(1), last.max(1), (last + BESIDE).min(most)];
    frames.dedup();
    frames
}

fn around(film: &FilmedRecording, (first, last): (usize, usize)) -> (usize, usize) {
    (first.saturating_sub(AROUND), (last + AROUND).min(film.moments.len() - 1).max(first + 1))
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
