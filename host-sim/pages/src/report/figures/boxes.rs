//! Figure 1: the boxes of SMR and SAD in one frame, with what each compared.

use super::drawing::{GAP, LINE, Sheet, template};
use super::{METHODS, asked, clearest};
use crate::colors::color_of_method;
use crate::report::film::{Film, Still};
use crate::report::image::Pixels;
use anyhow::{Context, Result};
use smr_core::Rect;
use smr_recordings::GrayFrame;

/// The frame that is asked for, else the one in which SMR is farthest ahead.
pub(super) fn frame(film: &Film, wish: Option<usize>) -> Result<usize> {
    match wish {
        Some(frame) => asked(film, frame),
        None => clearest(film).context("there is no frame in which both have an answer"),
    }
}

pub(super) fn draw(film: &Film, still: &Still) -> Result<Sheet> {
    const TILE: f64 = 400.0;
    const PATCH: (f64, f64) = (140.0, 120.0);
    const ROW: f64 = PATCH.1 + 3.0 * LINE;
    let truth = film.truth_at(still.index);
    let height = TILE * f64::from(still.frame.height) / f64::from(still.frame.width.max(still.frame.height));
    let mut sheet =
        Sheet::new(3.0 * GAP + height.max(2.0 * ROW - GAP), &format!("{}, frame {}", film.name, still.index + 1));
    sheet.legend(GAP, truth.is_some());
    let top = 2.0 * GAP;
    sheet.tile(film, still, (GAP, top), TILE, 0);
    let left = TILE + 2.0 * GAP;
    for (row, (method, sight)) in METHODS.into_iter().zip(&still.sights).enumerate() {
        let search = sight.search.as_ref().context("something is compared in every frame but the first")?;
        let color = Some(color_of_method(method));
        let top = top + row as f64 * ROW;
        let report = &film.moments[still.index].reports[row];
        let overlap = truth.zip(report.target).map(|(truth, target)| format!(" IoU {:.2}", target.iou(&truth)));
        let name = film.methods[row].name.to_uppercase();
        let state = if report.target.is_none() { " lost" } else { "" };
        sheet.words(left, top + 8.0, 0.0, &format!("{name}{state}{}", overlap.unwrap_or_default()), color);
        sheet.patch(template(&search.difference), (left, top + LINE), PATCH);
        let winner = cut(&still.frame, &sight.bbox.to_rect().context("a box of pixels")?);
        sheet.patch(winner, (left + PATCH.0 + GAP, top + LINE), PATCH);
        let below = top + LINE + PATCH.1 + 12.0;
        sheet.words(left, below, 0.0, "template", None);
        sheet.words(left + PATCH.0 + GAP, below, 0.0, "in its box", None);
    }
    Ok(sheet)
}

fn cut(frame: &GrayFrame, at: &Rect) -> Pixels {
    let places = (at.y..).take(at.height.into()).flat_map(|y| (at.x..).take(at.width.into()).map(move |x| (x, y)));
    Pixels::Patch { size: (at.width, at.height), levels: places.map(|(x, y)| frame.level(x, y)).collect() }
}
