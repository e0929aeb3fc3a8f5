//! Figure 5: the target is hidden slowly. What hides it gets into the template, and is followed then.

use super::drawing::{GAP, LINE, Sheet, WIDTH, template, wide};
use super::{METHODS, SAD, SMR};
use crate::colors::color_of_method;
use crate::report::diagram::Stroke;
use crate::report::film::{Film, Still};
use anyhow::{Context, Result, ensure};
use smr_recordings::FrameRange;

/// Frames around the hidden ones that are looked at.
const AROUND: usize = 40;
/// The first picture is of so many frames before the target is hidden, the last of as many after.
const BESIDE: usize = 10;
/// A frame is correct above.
const CORRECT: f64 = 0.25;

/// The frames in which the target is hidden, by the ground truth: first and last of each run.
pub(super) fn spans(film: &Film) -> Vec<(usize, usize)> {
    let truth = film.truth.as_deref().unwrap_or_default();
    let mut spans: Vec<(usize, usize)> = Vec::new();
    for index in (0..truth.len()).filter(|&index| truth[index].is_none()) {
        match spans.last_mut() {
            Some((_, last)) if *last + 1 == index => *last = index,
            _ => spans.push((index, index)),
        }
    }
    spans
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
        let overlaps = (from..to.min(length)).filter_map(|index| overlap(film, SMR, index));
        let (correct, all) = overlaps.fold((0, 0), |(correct, all), iou| (correct + u32::from(iou > CORRECT), all + 1));
        f64::from(correct) / f64::from(all.max(1))
    };
    let fall = |&(first, last): &(usize, usize)| {
        correct(first.saturating_sub(AROUND), first) - correct(last + 1, last + 1 + AROUND)
    };
    let spans = spans(film);
    let inner = spans.into_iter().filter(|&(first, _)| first > 0);
    inner.max_by(|a, b| fall(a).total_cmp(&fall(b)).then(b.0.cmp(&a.0))).context(
        "the ground truth has no frame in which the target is hidden; where it has a box all the time, say where with --hidden A..B",
    )
}

/// Before, at the first and the last hidden frame, and after.
pub(super) fn frames(film: &Film, (first, last): (usize, usize)) -> Vec<usize> {
    let most = film.moments.len() - 1;
    let mut frames = vec![first.saturating_sub(BESIDE).max(1), first.max(1), last.max(1), (last + BESIDE).min(most)];
    frames.dedup();
    frames
}

/// 0 without an answer; none while the target is hidden.
fn overlap(film: &Film, method: usize, index: usize) -> Option<f64> {
    let truth = film.truth_at(index)?;
    Some(film.moments[index].reports[method].target.map_or(0.0, |target| target.iou(&truth)))
}

pub(super) fn draw(film: &Film, stills: &[&Still], hidden: (usize, usize)) -> Result<Sheet> {
    const PATCH: (f64, f64) = (100.0, 80.0);
    const PLOT: f64 = 150.0;
    let within = (WIDTH - 5.0 * GAP) / 4.0;
    let tall = within * f64::from(film.size.1) / f64::from(film.size.0.max(film.size.1));
    let mut sheet = Sheet::new(
        2.0 * GAP + LINE + tall + PATCH.1 + GAP + 5.0 * LINE + PLOT + GAP,
        &format!("{}: hidden {} to {}", film.name, hidden.0 + 1, hidden.1 + 1),
    );
    sheet.legend(GAP, true);
    let top = 2.0 * GAP + LINE;
    for (place, still) in stills.iter().enumerate() {
        let left = GAP + place as f64 * (within + GAP);
        let words = if (hidden.0..=hidden.1).contains(&still.index) { ": hidden" } else { "" };
        sheet.words(left, 2.0 * GAP + 8.0, 0.0, &format!("{}{words}", still.index + 1), None);
        sheet.tile(film, still, (left, top), within, 0);
        let search = still.sights[SMR].search.as_ref().context("something is compared in every frame but the first")?;
        sheet.patch(template(&search.difference), (left, top + tall + GAP / 2.0), PATCH);
    }
    let below = top + tall + GAP / 2.0 + PATCH.1 + 14.0;
    sheet.words(GAP, below, 0.0, "below each frame the template of SMR", None);
    let top = below + 2.0 * LINE + 10.0;
    let (from, to) =
        (hidden.0.saturating_sub(AROUND), (hidden.1 + AROUND).min(film.moments.len() - 1).max(hidden.0 + 1));
    let axes = wide(top, PLOT, (from as f64 + 1.0, to as f64 + 1.0), (0.0, 1.0));
    sheet.hidden(&axes, &[hidden]);
    sheet.axes(&axes, ("frame", "IoU, shaded: hidden, dotted: correct above 0.25"), 2);
    let limit = axes.y(CORRECT);
    sheet.line(vec![(axes.left, limit), (axes.right, limit)], [220; 3], Stroke::Dotted);
    for method in [SAD, SMR] {
        let values: Vec<Option<f64>> = (from..=to).map(|index| overlap(film, method, index)).collect();
        let stroke = if method == SAD { Stroke::Dashed } else { Stroke::Solid };
        sheet.curve(&axes, from + 1, &values, color_of_method(METHODS[method]), stroke);
    }
    Ok(sheet)
}
