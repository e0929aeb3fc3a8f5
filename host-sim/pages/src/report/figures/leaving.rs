//! Figure 3: the target leaves the frame and its padding; the template is not updated meanwhile.

use super::SMR;
use super::drawing::{GAP, LINE, Sheet, WIDTH, template};
use crate::colors::color_of;
use crate::report::film::{Film, Still};
use anyhow::{Context, Result};
use smr_core::{Rect, State};
use smr_evaluation::name_of;

/// Frames of a target that leaves: the one before, the one in which the box is farthest out, the first in which it is lost, and the
/// one in which it is wholly inside again.
pub(super) fn frames(film: &Film) -> Result<Vec<usize>> {
    let state = |index: usize| film.moments[index].reports[SMR].state;
    let leaving = (1..film.moments.len()).filter(|&index| state(index) == State::Leaving);
    let deepest = leaving.clone().max_by_key(|&index| outside(film, index));
    let deepest = deepest.context("the box of SMR never reaches over the border of the frame")?;
    let outside = |index: &usize| state(*index) != State::Tracking;
    let first = (1..=deepest).rev().take_while(outside).last().unwrap_or(deepest);
    let last = (deepest..film.moments.len()).take_while(outside).last().unwrap_or(deepest);
    let lost = (first..=last).find(|&index| state(index) == State::Lost);
    let mut frames = vec![(first - 1).max(1), deepest];
    frames.extend(lost);
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

pub(super) fn draw(film: &Film, stills: &[&Still]) -> Result<Sheet> {
    const PATCH: (f64, f64) = (120.0, 96.0);
    let margin = film.margin();
    let within = (WIDTH - 5.0 * GAP) / 4.0;
    let whole = (f64::from(film.size.0 + 2 * margin), f64::from(film.size.1 + 2 * margin));
    let tall = within * whole.1 / whole.0.max(whole.1);
    let top = 2.0 * GAP + LINE;
    let mut sheet = Sheet::new(top + tall + GAP + PATCH.1 + 2.0 * LINE, &format!("{}: leaving the frame", film.name));
    sheet.legend(GAP, film.truth.is_some());
    let mut before: Option<&Vec<u8>> = None;
    for (place, still) in stills.iter().enumerate() {
        let left = GAP + place as f64 * (within + GAP);
        let state = film.moments[still.index].reports[SMR].state;
        sheet.words(left, 2.0 * GAP + 8.0, 0.0, &(still.index + 1).to_string(), None);
        sheet.words(left + within, 2.0 * GAP + 8.0, 1.0, name_of(state), Some(color_of(state)));
        sheet.tile(film, still, (left, top), within, margin);
        let search = still.sights[SMR].search.as_ref().context("something is compared in every frame but the first")?;
        let top = top + tall + GAP;
        let (_, high) = sheet.patch(template(&search.difference), (left, top), PATCH);
        let same = before.is_some_and(|before| *before == search.difference.template);
        let words = match (before, same) {
            (None, _) => "template",
            (_, true) => "unchanged",
            (_, false) => "updated",
        };
        sheet.words(left, top + high + 14.0, 0.0, words, None);
        before = Some(&search.difference.template);
    }
    Ok(sheet)
}
