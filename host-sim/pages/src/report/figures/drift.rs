//! Figure 4: drift, as the distance from the true centre over the frames.

use super::drawing::{GAP, LINE, Sheet, nice, wide};
use super::{METHODS, SAD};
use crate::colors::color_of_method;
use crate::report::diagram::Stroke;
use crate::report::film::Film;
use anyhow::{Result, ensure};
use smr_evaluation::centre_errors;

pub(super) fn possible(film: &Film) -> Result<()> {
    ensure!(film.truth.is_some(), "it needs ground truth, for the distance from it");
    Ok(())
}

pub(super) fn draw(film: &Film) -> Sheet {
    const PLOT: f64 = 260.0;
    let mut sheet = Sheet::new(4.0 * GAP + PLOT + 5.0 * LINE, &format!("{}: centre error over frames", film.name));
    sheet.legend(GAP, false);
    let truth = film.truth.as_deref().unwrap_or_default();
    let errors = [0, 1].map(|method| centre_errors(&film.trajectory(method), truth));
    let most = errors.iter().flatten().flatten().fold(4.0, |most: f64, &error| most.max(error));
    let top = 4.0 * GAP;
    let axes = wide(top, PLOT, (1.0, film.moments.len().max(2) as f64), (0.0, nice(most)));
    let hidden = super::occlusion::spans(film);
    sheet.hidden(&axes, &hidden);
    sheet.axes(&axes, ("frame", "pixels"), usize::from(axes.up.1 < 20.0));
    for (method, values) in errors.iter().enumerate().rev() {
        let stroke = if method == SAD { Stroke::Dashed } else { Stroke::Solid };
        sheet.curve(&axes, 1, values, color_of_method(METHODS[method]), stroke);
    }
    for (method, values) in errors.iter().enumerate() {
        let measured: Vec<f64> = values.iter().flatten().copied().collect();
        let mean = measured.iter().sum::<f64>() / measured.len().max(1) as f64;
        let words =
            format!("{}: mean {mean:.1} over {} frames", film.methods[method].name.to_uppercase(), measured.len());
        let y = axes.bottom + 38.0 + LINE * method as f64;
        sheet.words(GAP, y, 0.0, &words, Some(color_of_method(METHODS[method])));
    }
    if !hidden.is_empty() {
        sheet.shade(GAP, axes.bottom + 36.0 + 2.0 * LINE, 30.0, 12.0);
        sheet.words(GAP + 40.0, axes.bottom + 40.0 + 2.0 * LINE, 0.0, "target hidden", None);
    }
    sheet
}
