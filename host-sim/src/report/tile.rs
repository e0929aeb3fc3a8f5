//! One frame with all its boxes, as SVG: drawn over the picture, so that they stay sharp at any size.

use super::encode;
use super::film::{Film, Still};
use crate::sequence::BoundingBox;
use anyhow::Result;
use smr_core::Rect;

/// The frame, as much of the padding as boxes reach into, the boxes, and the state.
pub(super) fn tile(film: &Film, still: &Still) -> Result<String> {
    let (width, height) = (i32::from(still.frame.width), i32::from(still.frame.height));
    // A wide padding would leave little room for the frame.
    let margin = i32::from(film.padding).min(width.max(height) / 4);
    let (whole, tall) = (width + 2 * margin, height + 2 * margin);
    let moment = &film.moments[still.index];
    let picture = encode::data_uri("image/jpeg", &encode::jpeg(&still.frame)?);

    let window = still.sight.search.as_ref().map(|search| {
        let window = search.window.into();
        outline("window-under", &window, 0.0) + &outline("window", &window, 0.0)
    });
    // Side by side, a pixel of the screen each: of equal boxes all are seen.
    let pixel = f64::from(whole) / 280.0;
    let sad = moment.sad.target.map(|sad| outline("sad", &sad, 3.0 * pixel));
    let smr = outline(if moment.smr.target.is_some() { "smr" } else { "smr last" }, &still.sight.smr_box, 0.0);
    let truth = film.truth_at(still.index).map(|truth| outline("truth", &truth, -2.0 * pixel));
    let boxes = [window, sad, Some(smr), truth].into_iter().flatten().collect::<String>();

    let (number, state) = (still.index + 1, moment.smr.state.name());
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

/// The box, larger by `grown` on each side.
fn outline(class: &str, of: &BoundingBox, grown: f64) -> String {
    let (x, y) = (of.x - grown, of.y - grown);
    let (width, height) = ((of.width + 2.0 * grown).max(0.0), (of.height + 2.0 * grown).max(0.0));
    format!("<rect class=\"box {class}\" x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\"/>")
}

/// A box in words.
pub(super) fn words(Rect { x, y, width, height }: Rect) -> String {
    format!("{width}x{height} at ({x}, {y})")
}
