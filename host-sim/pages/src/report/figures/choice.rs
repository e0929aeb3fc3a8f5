//! The frames of each figure, chosen by what happened in the recording.

use super::{SAD, SMR};
use crate::report::film::Film;
use anyhow::{Context, Result, ensure};
use smr_core::{Rect, State};
use smr_recordings::FrameRange;

/// Frames around the hidden ones that are looked at.
const AROUND: usize = 40;
/// The first picture is of so many frames before the target is hidden, the last of as many after.
const BESIDE: usize = 10;
/// A frame is correct above.
pub(super) const CORRECT: f64 = 0.25;

/// The frame that is asked for, if something is compared in it; else the one in which SMR is farthest ahead.
pub(super) fn boxes(film: &Film, wish: Option<usize>) -> Result<usize> {
    let Some(frame) = wish else {
        let leads = (1..film.moments.len()).filter_map(|index| Some((index, lead(film, index)?)));
        let best = leads.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        return Ok(best.context("there is no frame in which SMR has an answer to compare")?.0);
    };
    let length = film.moments.len();
    ensure!((1..length).contains(&frame), "frame {} compares nothing: expected 2 to {length}", frame + 1);
    Ok(frame)
}

/// As for the boxes, where the target is visible.
pub(super) fn differences(film: &Film, wish: Option<usize>) -> Result<usize> {
    ensure!(film.truth.is_some(), "it needs ground truth, for the true place of the target");
    let frame = boxes(film, wish)?;
    ensure!(
        film.truth_at(frame).is_some(),
        "the target is hidden in frame {}: expected one where it is visible",
        frame + 1
    );
    Ok(frame)
}

/// Lead of SMR over SAD in a frame: the difference of their IoU with the ground truth, else 1 minus the IoU of both.
fn lead(film: &Film, index: usize) -> Option<f64> {
    let [smr, sad] = [SMR, SAD].map(|method| film.moments[index].reports[method].target);
    if film.truth.is_none() {
        return Some(1.0 - smr?.iou(&sad?));
    }
    smr.and(Some(overlap(film, SMR, index)? - overlap(film, SAD, index)?))
}

/// IoU with the ground truth, 0 without an answer; none while the target is hidden.
pub(super) fn overlap(film: &Film, method: usize, index: usize) -> Option<f64> {
    let truth = film.truth_at(index)?;
    Some(film.moments[index].reports[method].target.map_or(0.0, |target| target.iou(&truth)))
}

/// Frames of a target that leaves: the one before, the one in which the box is farthest out, the first in which it is lost, and the
/// one in which it is wholly inside again.
pub(super) fn leaving(film: &Film) -> Result<Vec<usize>> {
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

/// Pixels of the box that are outside of the frame.
fn outside(film: &Film, index: usize) -> u64 {
    let Some(bbox) = film.moments[index].reports[SMR].bbox else { return 0 };
    let frame = Rect::new(0, 0, film.size.0, film.size.1);
    u64::from(bbox.width) * u64::from(bbox.height) - u64::from(bbox.intersection(frame).area())
}

/// The frames in which the target is hidden, by the ground truth: first and last of each run.
pub(super) fn spans(film: &Film) -> Vec<(usize, usize)> {
    let truth = film.truth.iter().flatten().collect::<Vec<_>>();
    let hidden: Vec<usize> = (0..truth.len()).filter(|&index| truth[index].is_none()).collect();
    hidden.chunk_by(|one, next| one + 1 == *next).map(|run| (run[0], run[run.len() - 1])).collect()
}

/// The hidden frames that are given; else those of the ground truth after which SMR is worse than before, by the most.
pub(super) fn span(film: &Film, wish: Option<FrameRange>) -> Result<(usize, usize)> {
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

pub(super) fn occlusion(film: &Film, (first, last): (usize, usize)) -> Vec<usize> {
    let most = film.moments.len() - 1;
    let mut frames = vec![first.saturating_sub(BESIDE).max(1), first.max(1), last.max(1), (last + BESIDE).min(most)];
    frames.dedup();
    frames
}

/// The first and the last frame whose overlaps are drawn.
pub(super) fn around(film: &Film, (first, last): (usize, usize)) -> (usize, usize) {
    (first.saturating_sub(AROUND), (last + AROUND).min(film.moments.len() - 1).max(first + 1))
}
