//! One frame with all its boxes, as SVG: drawn over the picture, so that they stay sharp at any size.

use super::data::css;
use super::film::{Film, Still};
use super::turns::turns;
use super::{Color, TRUTH, color_of_method, encode};
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
        outline("window-under", &window, "") + &outline("window", &window, "")
    });
    let sights = film.methods.iter().zip(moment.reports.iter().zip(&still.sights));
    let (found, lasts): (Vec<_>, Vec<_>) = sights.partition(|(_, (report, _))| report.target.is_some());
    let lasts = lasts.iter().map(|(method, (_, sight))| {
        outline("method last", &sight.bbox, &format!("--c:{}", css(color_of_method(method.kind))))
    });
    let mut boxes: Vec<_> =
        found.iter().map(|(method, (_, sight))| ("method", color_of_method(method.kind), sight.bbox)).collect();
    boxes.extend(film.truth_at(still.index).map(|truth| ("truth", TRUTH, truth)));
    let boxes = window.into_iter().chain(lasts).chain(together(&boxes)).collect::<String>();

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

/// Boxes that coincide share one line.
fn together(boxes: &[(&str, Color, BoundingBox)]) -> Vec<String> {
    const DASH: usize = 8;
    let turns = turns(&boxes.iter().map(|(_, _, bbox)| *bbox).collect::<Vec<_>>());
    let outlined = |((class, color, bbox), (place, all)): (&(&str, Color, BoundingBox), (usize, usize))| {
        let dashes = match all {
            1 => String::new(),
            _ => format!(";stroke-dasharray:{DASH} {};stroke-dashoffset:-{}", DASH * (all - 1), DASH * place),
        };
        outline(class, bbox, &format!("--c:{}{dashes}", css(*color)))
    };
    boxes.iter().zip(turns).map(outlined).collect()
}

/// The box itself: its edges are the middle of the line.
fn outline(class: &str, &BoundingBox { x, y, width, height }: &BoundingBox, style: &str) -> String {
    let style = if style.is_empty() { String::new() } else { format!(" style=\"{style}\"") };
    format!(
        "<rect class=\"box {class}\" x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\"{style}/>"
    )
}

/// A box in words.
pub(super) fn words(Rect { x, y, width, height }: Rect) -> String {
    format!("{width}x{height} at ({x}, {y})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_that_coincide_take_turns() {
        let at = |x: f64| BoundingBox { x, y: 0.0, width: 10.0, height: 10.0 };
        let boxes = [("method", [1, 2, 3], at(0.0)), ("method", [4, 5, 6], at(0.5)), ("truth", [7, 8, 9], at(20.0))];
        let drawn = together(&boxes);
        assert!(drawn[0].contains("stroke-dasharray:8 8;stroke-dashoffset:-0"), "{}", drawn[0]);
        assert!(drawn[1].contains("stroke-dasharray:8 8;stroke-dashoffset:-8"), "{}", drawn[1]);
        assert!(!drawn[2].contains("dash"), "{}", drawn[2]);
    }
}
