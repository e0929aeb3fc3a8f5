//! The frames of each figure: those in which the two methods differ, the target leaves, or is hidden.

use crate::report::film::{FilmedRecording, Still};
use crate::report::observation::Search;
use anyhow::{Context, Result, ensure};
use smr_core::{Rect, State};
use smr_evaluation::{CORRECT, MethodKind};
use smr_recordings::FrameRange;

pub const METHODS: [MethodKind; 2] = [MethodKind::Paper, MethodKind::Sad];
pub const SMR: usize = 0;
pub const SAD: usize = 1;

pub fn compared(still: &Still, method: usize) -> Result<&Search> {
    still.observations[method].search.as_ref().context("something is compared in every frame but the first")
}

/// Number of frames to score and plot before an occlusion, and the same number after it.
const AROUND: usize = 40;
/// Distance in frames between an occlusion and the images that show the target before and after it.
const BESIDE: usize = 10;

/// Returns the frame `wish`, which must not be the first; without a wish, the frame in which SMR leads SAD by the most.
pub fn lead_frame(film: &FilmedRecording, wish: Option<usize>) -> Result<usize> {
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
pub fn visible_frame(film: &FilmedRecording, wish: Option<usize>) -> Result<usize> {
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
pub fn lead(film: &FilmedRecording, index: usize) -> Option<f64> {
    let [smr, sad] = [SMR, SAD].map(|method| film.moments[index].reports[method].target);
    if film.truth.is_none() {
        return Some(1.0 - smr?.iou(&sad?));
    }
    smr.and(Some(overlap(film, SMR, index)? - overlap(film, SAD, index)?))
}

/// Returns the IoU of a method's box with the ground truth: 0 if the method has no box, `None` if the target is hidden.
pub fn overlap(film: &FilmedRecording, method: usize, index: usize) -> Option<f64> {
    let truth = film.truth_at(index)?;
    Some(film.moments[index].reports[method].target.map_or(0.0, |target| target.iou(&truth)))
}

/// Returns the frames around the target's exit: the last before it, the one with the box farthest outside, the first in
/// which the target is lost, and the first in which it is wholly inside again.
pub fn leaving_frames(film: &FilmedRecording) -> Result<Vec<usize>> {
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
pub fn outside(film: &FilmedRecording, index: usize) -> u64 {
    let Some(bbox) = film.moments[index].reports[SMR].bbox else { return 0 };
    let frame = Rect::new(0, 0, film.size.0, film.size.1);
    u64::from(bbox.width) * u64::from(bbox.height) - u64::from(bbox.intersection(frame).area())
}

/// Returns (first, last) of each run of frames in which the target is hidden, according to the ground truth.
pub fn spans(film: &FilmedRecording) -> Vec<(usize, usize)> {
    let truth = film.truth.iter().flatten().collect::<Vec<_>>();
    let hidden: Vec<usize> = (0..truth.len()).filter(|&index| truth[index].is_none()).collect();
    hidden.chunk_by(|one, next| one + 1 == *next).map(|run| (run[0], run[run.len() - 1])).collect()
}

/// Returns the user's occlusion `wish`; without a wish, the occlusion after which SMR's accuracy falls most.
pub fn span(film: &FilmedRecording, wish: Option<FrameRange>) -> Result<(usize, usize)> {
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

pub fn hidden_frames(film: &FilmedRecording, (first, last): (usize, usize)) -> Vec<usize> {
    let most = film.moments.len() - 1;
    let mut frames = vec![first.saturating_sub(BESIDE).max(1), first.max(1), last.max(1), (last + BESIDE).min(most)];
    frames.dedup();
    frames
}

pub fn around(film: &FilmedRecording, (first, last): (usize, usize)) -> (usize, usize) {
    (first.saturating_sub(AROUND), (last + AROUND).min(film.moments.len() - 1).max(first + 1))
}
