//! One frame with all its boxes, as SVG: drawn over the picture, so that they stay sharp at any size.

use super::data::css;
use super::film::{Film, Still};
use super::{color_of_method, encode};
use crate::evaluate::name_of;
use crate::sequence::BoundingBox;
use anyhow::Result;
use smr_core::Rect;

/// The frame, as much of the padding as boxes reach into, the boxes, and the state.
pub(super) fn tile(film: &Film, still: &Still) -> Result<String> {
    let (width, height) = (i32::from(still.frame.width), i32::from(still.frame.height));
    let margin = i32::from(film.margin());
    let (whole, tall) = (width + 2 * margin, height + 2 * margin);
    let moment = &film.moments[still.index];
    let picture = encode::data_uri("image/jpeg", &encode::jpeg(&still.frame)?);

    let window = still.window().map(|window| {
        let window = window.into();
        outline("window-under", &window) + &outline("window", &window)
    });
    // Each where it is; the ones below are drawn wider, so that of equal boxes all are seen.
    let boxes = film.methods.iter().zip(moment.reports.iter().zip(&still.sights)).rev();
    let boxes = boxes.zip((1..=film.methods.len()).rev()).map(|((method, (report, sight)), place)| {
        let last = if report.target.is_some() { "" } else { " last" };
        let (color, width) = (css(color_of_method(method.kind)), 3 * place);
        let outline = outline(&format!("method{last}"), &sight.bbox);
        outline.replacen("<rect ", &format!("<rect style=\"--c:{color};stroke-width:{width}\" "), 1)
    });
    let truth = film.truth_at(still.index).map(|truth| outline("truth", &truth));
    let boxes = window.into_iter().chain(boxes).chain(truth).collect::<String>();

    let (number, state) = (still.index + 1, name_of(moment.first().state));
    let letters = f64::from(whole) / 17.0;
    let (x, y) = (f64::from(-margin) + letters * 0.5, f64::from(-margin) + letters * 1.2);
    Ok(format!(
        "<svg class=\"tile\" viewBox=\"{} {} {whole} {tall}\" role=\"img\" aria-label=\"frame {number}, {state}\">\
         <rect class=\"padding\" x=\"{}\" y=\"{}\" width=\"{whole}\" height=\"{tall}\"/>\
         <image href=\"{picture}\" width=\"{width}\" height=\"{height}\"/>{boxes}\
         <text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{letters:.1}\">{number} \
         <tspan class=\"{state}\">{state}</tspan></text></svg>",
        -margin, -margin, -margin, -margin
    ))
}

/// The box itself: its edges are the middle of the line.
fn outline(class: &str, &BoundingBox { x, y, width, height }: &BoundingBox) -> String {
    format!("<rect class=\"box {class}\" x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\"/>")
}

/// A box in words.
pub(super) fn words(Rect { x, y, width, height }: Rect) -> String {
    format!("{width}x{height} at ({x}, {y})")
}
