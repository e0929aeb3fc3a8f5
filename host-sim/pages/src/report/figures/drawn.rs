//! Draws the paper's five figures as SVG.

use super::frames::{SAD, SMR, around, compared, overlap, spans};
use super::sheet::{COLUMN, DASHED, DOTTED, GAP, LINE, Pair, Plot, SOLID, Sheet, TOP, color_of, nice, tile};
use crate::colors::{self, WHITE};
use crate::report::difference::{BAR, BARS, Difference, differences as map, part, patch};
use crate::report::film::{FilmedRecording, Still};
use anyhow::{Context, Result};
use smr_core::Rect;
use smr_evaluation::{CORRECT, centre_errors, name_of};
use smr_recordings::{BoundingBox, GrayFrame};

pub(super) fn boxes(film: &FilmedRecording, still: &Still) -> Result<String> {
    const TILE: f64 = 400.0;
    const PATCH: Pair = (140.0, 120.0);
    const ROW: f64 = PATCH.1 + 3.0 * LINE;
    let truth = film.truth_at(still.index);
    let mut sheet = Sheet::new(&format!("{}, frame {}", film.name, still.index + 1));
    sheet.legend(truth.is_some());
    let size = tile(film, TILE, 0);
    sheet.frame(film, still, (GAP, 2.0 * GAP), size, 0)?;
    for row in [SMR, SAD] {
        let at =
            |column: f64, down: f64| (TILE + 2.0 * GAP + column * (PATCH.0 + GAP), 2.0 * GAP + row as f64 * ROW + down);
        let target = film.moments[still.index].reports[row].target;
        let overlap = truth.zip(target).map(|(truth, target)| format!(" IoU {:.2}", target.iou(&truth)));
        let state = if target.is_none() { " lost" } else { "" };
        let words = format!("{}{state}{}", name(film, row), overlap.unwrap_or_default());
        sheet.words(at(0.0, 8.0), "start", &words, color_of(row));
        let seen = &compared(still, row)?.difference;
        sheet.patch(at(0.0, LINE), PATCH, &patch(&seen.template)?);
        let bbox = still.observations[row].bbox.to_rect().context("a box of pixels")?;
        sheet.patch(at(1.0, LINE), PATCH, &patch(&part(&still.frame, bbox))?);
        sheet.words(at(0.0, LINE + PATCH.1 + 12.0), "start", "template", WHITE);
        sheet.words(at(1.0, LINE + PATCH.1 + 12.0), "start", "in its box", WHITE);
    }
    Ok(sheet.svg(3.0 * GAP + size.1.max(2.0 * ROW - GAP)))
}

/// Draws, for each method, the template and two maps of differences from it, for the method's box and for the true box.
/// Below is a histogram of each map.
pub(super) fn differences(film: &FilmedRecording, still: &Still) -> Result<String> {
    const PATCH: Pair = (160.0, 120.0);
    const ROW: f64 = PATCH.1 + 2.0 * LINE;
    const PLOT: f64 = 190.0;
    /// Count of histogram bars that are drawn; larger differences are rare.
    const SHOWN: usize = BARS / 2;
    let mut sheet = Sheet::new(&format!("{}, frame {}: differences to the template", film.name, still.index + 1));
    let columns = [0.0, 1.0, 2.0].map(|column| GAP + 60.0 + column * (PATCH.0 + GAP));
    for (x, words) in columns.into_iter().zip(["template", "in its box", "in the true box"]) {
        sheet.words((x, 2.0 * GAP + 8.0), "start", words, WHITE);
    }
    let mut curves = Vec::new();
    for row in [SMR, SAD] {
        let top = TOP + row as f64 * ROW;
        sheet.words((GAP, top + 8.0), "start", &name(film, row), color_of(row));
        let search = compared(still, row)?;
        sheet.patch((columns[0], top), PATCH, &patch(&search.difference.template)?);
        let there = at_truth(film, still, &search.difference)?;
        for (x, stroke, seen) in [(columns[1], SOLID, &search.difference), (columns[2], DASHED, &there)] {
            sheet.patch((x, top), PATCH, &map(&seen.pixels, search.alpha)?);
            let pixels = &seen.pixels.pixels;
            let sum: f64 = pixels.iter().map(|&pixel| f64::from(pixel)).sum();
            let figure = match search.alpha {
                Some(alpha) => format!("{:.0}% count", 100.0 * seen.counting(alpha)),
                None => format!("mean {:.1}", sum / pixels.len().max(1) as f64),
            };
            sheet.words((x, top + PATCH.1 + 12.0), "start", &figure, WHITE);
            curves.push((color_of(row), stroke, seen.histogram()));
        }
    }
    let alpha = compared(still, SMR)?.alpha;
    shades(&mut sheet, columns[2] + PATCH.0 + GAP, alpha)?;
    let most = curves.iter().flat_map(|curve| &curve.2[..SHOWN]).fold(0.0, |most: f64, &part| most.max(part));
    let (top, levels) = (TOP + 2.0 * ROW + GAP + 10.0, (SHOWN * BAR) as f64);
    let names = ["difference in gray levels", "% of the pixels, line: its box, dashed: the true box"];
    let plot = sheet.plot((top, PLOT), (0.0, levels), (most * 5.0).ceil().max(1.0) * 20.0, names, 0);
    if let Some(alpha) = alpha {
        let x = plot.x(f64::from(alpha));
        sheet.line(&[(x, plot.top), (x, plot.bottom)], WHITE, DOTTED);
        sheet.words((x + 6.0, plot.top + 8.0), "start", &format!("alpha {alpha}"), WHITE);
    }
    for (color, stroke, histogram) in curves {
        let point = |bar: usize| (plot.x((bar * BAR) as f64 + BAR as f64 / 2.0), plot.y(100.0 * histogram[bar]));
        sheet.line(&(0..SHOWN).map(point).collect::<Vec<_>>(), color, stroke);
    }
    Ok(sheet.svg(top + PLOT + 3.0 * LINE))
}

/// Returns the difference between the template and the part of the frame around the true centre. The true centre is
/// first moved by the start box's offset from the true centre in the first frame.
fn at_truth(film: &FilmedRecording, still: &Still, seen: &Difference) -> Result<Difference> {
    let start = BoundingBox::from(film.targets[0].start()).centre();
    let first = film.truth_at(0).map_or(start, |first| first.centre());
    let (x, y) = film.truth_at(still.index).context("the target is visible")?.centre();
    let (width, height) = (f64::from(seen.template.width), f64::from(seen.template.height));
    let (x, y) = (x + start.0 - first.0 - width / 2.0, y + start.1 - first.1 - height / 2.0);
    let at: Rect = BoundingBox { x, y, width, height }.to_rect().context("the box of the ground truth is far away")?;
    Ok(Difference::new(&still.frame, at, seen.template.clone()))
}

fn shades(sheet: &mut Sheet, left: f64, alpha: Option<u16>) -> Result<()> {
    const SIZE: Pair = (120.0, 14.0);
    let levels = GrayFrame { width: 128, height: 15, pixels: (0..128).collect::<Vec<_>>().repeat(15) };
    sheet.words((left, TOP + 8.0), "start", "0", WHITE);
    sheet.words((left + SIZE.0, TOP + 8.0), "end", "127+", WHITE);
    sheet.patch((left, TOP + LINE), SIZE, &map(&levels, None)?);
    if alpha.is_some() {
        sheet.patch((left, TOP + 3.0 * LINE), SIZE, &map(&levels, alpha)?);
        sheet.words((left, TOP + 3.0 * LINE + SIZE.1 + 12.0), "start", "that count", WHITE);
    }
    Ok(())
}

/// Draws frames in which a target leaves, with a margin of padding, and the templates, marked unchanged or updated.
pub(super) fn leaving(film: &FilmedRecording, stills: &[&Still]) -> Result<String> {
    let mut sheet = Sheet::new(&format!("{}: leaving the frame", film.name));
    sheet.legend(film.truth.is_some());
    let (lefts, bottom) = sheet.strip(film, stills, film.margin())?;
    let mut before = None;
    for (left, still) in lefts.into_iter().zip(stills) {
        let state = film.moments[still.index].reports[SMR].state;
        sheet.words((left + COLUMN, 2.0 * GAP + 8.0), "end", name_of(state), colors::color_of(state));
        let template = &compared(still, SMR)?.difference.template;
        let words = match before.replace(template) {
            None => "template",
            Some(before) if before == template => "unchanged",
            Some(_) => "updated",
        };
        sheet.words((left, bottom + 14.0), "start", words, WHITE);
    }
    Ok(sheet.svg(bottom + 2.0 * LINE))
}

/// Plots drift: in each frame, the distance in pixels between the centre of a method's box and the true centre.
pub(super) fn drift(film: &FilmedRecording) -> String {
    const PLOT: f64 = 260.0;
    let mut sheet = Sheet::new(&format!("{}: centre error over frames", film.name));
    sheet.legend(false);
    let truth = film.truth.as_deref().unwrap_or_default();
    let errors = [SMR, SAD].map(|method| centre_errors(&film.trajectory(method), truth));
    let most = nice(errors.iter().flatten().flatten().fold(4.0, |most: f64, &error| most.max(error)));
    let across = (1.0, film.moments.len().max(2) as f64);
    let plot = sheet.plot((4.0 * GAP, PLOT), across, most, ["frame", "pixels"], usize::from(most < 20.0));
    let hidden = spans(film);
    sheet.hidden(&plot, &hidden);
    for method in [SAD, SMR] {
        sheet.curve(&plot, 1, &errors[method], method);
        let measured: Vec<f64> = errors[method].iter().flatten().copied().collect();
        let mean = measured.iter().sum::<f64>() / measured.len().max(1) as f64;
        let words = format!("{}: mean {mean:.1} over {} frames", name(film, method), measured.len());
        sheet.words((GAP, plot.bottom + 38.0 + LINE * method as f64), "start", &words, color_of(method));
    }
    if !hidden.is_empty() {
        let y = plot.bottom + 40.0 + 2.0 * LINE;
        sheet.shade((GAP, y - 4.0), (30.0, 12.0));
        sheet.words((GAP + 40.0, y), "start", "target hidden", WHITE);
    }
    sheet.svg(4.0 * GAP + PLOT + 5.0 * LINE)
}

/// Draws an occlusion: frames, SMR's templates, and IoU over frames. A slow occluder can get into the template, so that
/// SMR follows the occluder.
pub(super) fn occlusion(film: &FilmedRecording, stills: &[&Still], hidden: (usize, usize)) -> Result<String> {
    const PLOT: f64 = 150.0;
    let mut sheet = Sheet::new(&format!("{}: hidden {} to {}", film.name, hidden.0 + 1, hidden.1 + 1));
    sheet.legend(true);
    let (lefts, bottom) = sheet.strip(film, stills, 0)?;
    let is_hidden = |still: &Still| (hidden.0..=hidden.1).contains(&still.index);
    for (left, _) in lefts.into_iter().zip(stills).filter(|(_, still)| is_hidden(still)) {
        sheet.words((left + COLUMN, 2.0 * GAP + 8.0), "end", "hidden", WHITE);
    }
    sheet.words((GAP, bottom + 14.0), "start", "below each frame the template of SMR", WHITE);
    let (from, to) = around(film, hidden);
    let names = ["frame", "IoU, shaded: hidden, dotted: correct above 0.25"];
    let top = bottom + 14.0 + 2.0 * LINE + 10.0;
    let plot = sheet.plot((top, PLOT), (from as f64 + 1.0, to as f64 + 1.0), 1.0, names, 2);
    sheet.hidden(&plot, &[hidden]);
    let limit = plot.y(CORRECT);
    sheet.line(&[(Plot::LEFT, limit), (Plot::RIGHT, limit)], WHITE, DOTTED);
    for method in [SAD, SMR] {
        let values: Vec<Option<f64>> = (from..=to).map(|index| overlap(film, method, index)).collect();
        sheet.curve(&plot, from + 1, &values, method);
    }
    Ok(sheet.svg(plot.bottom + 3.0 * LINE))
}

fn name(film: &FilmedRecording, method: usize) -> String {
    film.methods[method].name.to_uppercase()
}
