//! Figure 2: what each method differs by from its template, in the place that won and in the true one; and how often.

use super::drawing::{GAP, LINE, Sheet, template, wide};
use super::{METHODS, asked, clearest};
use crate::colors::{Color, color_of_method};
use crate::report::diagram::Stroke;
use crate::report::difference::{BAR, BARS, Difference};
use crate::report::film::{Film, Still};
use crate::report::image::Pixels;
use crate::report::search::Search;
use anyhow::{Context, Result, ensure};
use smr_core::{Image, Rect};
use smr_recordings::BoundingBox;

/// Bars that are drawn: differences above are rare.
const SHOWN: usize = BARS / 2;

/// The frame that is asked for, else the one in which SMR is farthest ahead.
pub(super) fn frame(film: &Film, wish: Option<usize>) -> Result<usize> {
    ensure!(film.truth.is_some(), "it needs ground truth, for the true place of the target");
    let Some(frame) = wish else {
        return clearest(film).context("there is no frame in which SMR has an answer and the target is visible");
    };
    let frame = asked(film, frame)?;
    ensure!(
        film.truth_at(frame).is_some(),
        "the target is hidden in frame {}: expected one where it is visible",
        frame + 1
    );
    Ok(frame)
}

pub(super) fn draw(film: &Film, still: &Still) -> Result<Sheet> {
    const PATCH: (f64, f64) = (160.0, 120.0);
    const ROW: f64 = PATCH.1 + 2.0 * LINE;
    const PLOT: f64 = 190.0;
    let top = 2.0 * GAP + LINE;
    let mut sheet = Sheet::new(
        top + 2.0 * ROW + GAP + PLOT + 3.0 * LINE,
        &format!("{}, frame {}: differences to the template", film.name, still.index + 1),
    );
    let truth = film.truth_at(still.index).context("the target is visible")?;
    let mut lines: Vec<(Color, Stroke, [f64; BARS])> = Vec::new();
    let columns = [GAP + 60.0, GAP + 80.0 + PATCH.0, GAP + 100.0 + 2.0 * PATCH.0];
    for (x, words) in columns.into_iter().zip(["template", "in its box", "in the true box"]) {
        sheet.words(x, 2.0 * GAP + 8.0, 0.0, words, None);
    }
    for (row, (method, sight)) in METHODS.into_iter().zip(&still.sights).enumerate() {
        let search = sight.search.as_ref().context("something is compared in every frame but the first")?;
        let (color, top) = (color_of_method(method), top + row as f64 * ROW);
        let name = film.methods[row].name.to_uppercase();
        sheet.words(GAP, top + 8.0, 0.0, &name, Some(color));
        sheet.patch(template(&search.difference), (columns[0], top), PATCH);
        let there = at_truth(film, still, search, &truth)?;
        for ((difference, stroke), x) in
            [(&search.difference, Stroke::Solid), (&there, Stroke::Dashed)].into_iter().zip(&columns[1..])
        {
            let (size, levels) = (difference.size, difference.pixels.clone());
            let alpha = search.alpha.unwrap_or(0);
            sheet.patch(Pixels::Differences { size, levels, alpha }, (*x, top), PATCH);
            let mean = difference.pixels.iter().map(|&pixel| f64::from(pixel)).sum::<f64>()
                / difference.pixels.len().max(1) as f64;
            let figure = match search.alpha {
                Some(alpha) => format!("{:.0}% count", 100.0 * difference.counting(alpha)),
                None => format!("mean {mean:.1}"),
            };
            sheet.words(*x, top + PATCH.1 + 12.0, 0.0, &figure, None);
            lines.push((color, stroke, difference.histogram()));
        }
    }
    let right = columns[2] + PATCH.0 + GAP;
    let alpha = still.sights[super::SMR].search.as_ref().and_then(|search| search.alpha);
    scale(&mut sheet, right, top, alpha);
    let most = lines.iter().flat_map(|line| &line.2[..SHOWN]).fold(0.0, |most: f64, &part| most.max(part));
    let top = top + 2.0 * ROW + GAP + 10.0;
    let levels = (SHOWN * BAR) as f64;
    let axes = wide(top, PLOT, (0.0, levels), (0.0, (most * 5.0).ceil().max(1.0) * 20.0));
    sheet.axes(&axes, ("difference in gray levels", "% of the pixels, line: its box, dashed: the true box"), 0);
    if let Some(alpha) = alpha {
        let x = axes.x(f64::from(alpha).min(levels));
        sheet.line(vec![(x, axes.top), (x, axes.bottom)], [200; 3], Stroke::Dotted);
        sheet.words(x + 6.0, axes.top + 8.0, 0.0, &format!("alpha {alpha}"), None);
    }
    for (color, stroke, histogram) in lines {
        let point = |(bar, part): (usize, &f64)| (axes.x((bar * BAR) as f64 + BAR as f64 / 2.0), axes.y(100.0 * part));
        sheet.line(histogram[..SHOWN].iter().enumerate().map(point).collect(), color, stroke);
    }
    Ok(sheet)
}

/// The difference in the place where the target truly is: the box of the method, put where the ground truth is.
///
/// The method may have been started beside the annotator's box; it is put as far beside it here.
fn at_truth(film: &Film, still: &Still, search: &Search, truth: &BoundingBox) -> Result<Difference> {
    let start = BoundingBox::from(film.targets[0].start()).centre();
    let beside = |first: BoundingBox| (start.0 - first.centre().0, start.1 - first.centre().1);
    let beside = film.truth_at(0).map_or((0.0, 0.0), beside);
    let Difference { size: (width, height), template, .. } = &search.difference;
    let (x, y) = truth.centre();
    let place = BoundingBox {
        x: x + beside.0 - f64::from(*width) / 2.0,
        y: y + beside.1 - f64::from(*height) / 2.0,
        width: f64::from(*width),
        height: f64::from(*height),
    };
    let at: Rect = place.to_rect().context("the box of the ground truth is far away")?;
    Ok(Difference::new(&still.frame, at, Image::new(template, *width, *height)?))
}

/// Draws the legend of the shades.
fn scale(sheet: &mut Sheet, left: f64, top: f64, alpha: Option<u16>) {
    const SIZE: (u16, u16) = (120, 14);
    let (width, height) = (f64::from(SIZE.0), f64::from(SIZE.1));
    let levels: Vec<u8> =
        (0..SIZE.1).flat_map(|_| (0..SIZE.0).map(|x| u8::try_from(x * 127 / (SIZE.0 - 1)).unwrap_or(127))).collect();
    let ramp = |alpha: u16| Pixels::Differences { size: SIZE, levels: levels.clone(), alpha };
    sheet.words(left, top + 8.0, 0.0, "0", None);
    sheet.words(left + width, top + 8.0, 1.0, "127+", None);
    sheet.patch(ramp(0), (left, top + LINE), (width, height));
    if let Some(alpha) = alpha {
        sheet.patch(ramp(alpha), (left, top + 3.0 * LINE), (width, height));
        sheet.words(left, top + 3.0 * LINE + height + 12.0, 0.0, "that count", None);
    }
}
