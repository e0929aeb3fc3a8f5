//! The film strip as one picture: what a README shows.

use super::canvas::{Canvas, Dashes, FONT, few_colors, line, pixel};
use super::coinciding_boxes::turns;
use super::film::{Film, Still};
use super::palette::color_of_file;
use crate::colors::{BLACK, Color, PAPER, TRUTH, WHITE, color_of, color_of_method};
use anyhow::Result;
use embedded_graphics::draw_target::DrawTargetExt;
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::primitives::Rectangle;
use smr_evaluation::name_of;
use smr_recordings::BoundingBox;

/// No side of a frame is longer in the picture.
const TILE: u32 = 320;
const COLUMNS: u32 = 3;
const GAP: u32 = 10;
/// A line of text with what is between it and the next.
const LINE: u32 = FONT.character_size.height + GAP;

/// The frames to show, side by side with their boxes and states, as a PNG.
pub fn picture(film: &Film) -> Result<Vec<u8>> {
    let height = fitted(film.size).1;
    let cell = (TILE + GAP, height + LINE + GAP / 2);
    let rows = u32::try_from(film.stills.len())?.div_ceil(COLUMNS);
    let mut canvas = Canvas::new(GAP + COLUMNS * cell.0, GAP + rows * cell.1 + LINE, PAPER);
    // The lines and letters need some, too.
    let pictures = few_colors(film.stills.iter().map(|still| &still.colors), 160);
    for ((number, still), picture) in (0..).zip(&film.stills).zip(&pictures) {
        let (left, top) = (GAP + number % COLUMNS * cell.0, GAP + number / COLUMNS * cell.1);
        tile(&mut canvas, (left, top), film, still, picture);
        let state = film.moments[still.index].first().state;
        let (left, top) = (i32::try_from(left)?, i32::try_from(top + height + GAP / 2)?);
        let end = canvas.text(
            left,
            top,
            &format!("frame {}  {}: ", still.index + film.first, film.methods[0].name),
            WHITE,
            FONT,
        );
        canvas.text(end, top, name_of(state), color_of(state), FONT);
    }
    let (mut left, top) = (i32::try_from(GAP)?, i32::try_from(GAP + rows * cell.1)?);
    for (word, color) in legend(film) {
        left = canvas.text(left, top, &format!("{word}  "), color, FONT);
    }
    canvas.png()
}

/// The color of a method. Of several targets each has its own.
fn ink_of(film: &Film, method: usize) -> Color {
    if film.targets.len() == 1 { color_of_method(film.methods[method].kind) } else { color_of_file(method) }
}

fn legend(film: &Film) -> impl Iterator<Item = (String, Color)> {
    let methods = (0..film.methods.len()).map(|method| (film.title(method), ink_of(film, method)));
    let truth = film.truth.as_ref().map(|_| ("ground truth".to_owned(), TRUTH));
    methods.chain(truth).chain([("search window".to_owned(), WHITE)])
}

/// The size of a frame in the picture.
fn fitted((width, height): (u16, u16)) -> (u32, u32) {
    let longest = u32::from(width.max(height)).max(1);
    let fit = |side: u16| (u32::from(side) * TILE / longest).max(1);
    (fit(width), fit(height))
}

/// One frame with its boxes. What lies outside of it is not drawn.
fn tile(canvas: &mut Canvas, (left, top): (u32, u32), film: &Film, still: &Still, picture: &Canvas) {
    const DASH: f64 = 8.0;
    let (width, height) = fitted((still.frame.width, still.frame.height));
    // The nearest pixel each: whole factors stay sharp.
    canvas.picture(left, top, &picture.nearest(width, height));
    let (left, top, size) = (f64::from(left), f64::from(top), [width, height].map(f64::from));
    let scale = size[0] / f64::from(still.frame.width);
    let mut clipped = canvas.clipped(&Rectangle::new(Point::new(pixel(left), pixel(top)), Size::new(width, height)));
    let mut outline = |of: &BoundingBox, thick: u32, color: Color, dashes: Dashes| {
        let at = |place: f64, side: f64| (place * scale).round().clamp(-9.0, side + 9.0);
        let (x, right) = (left + at(of.x, size[0]), left + at(of.x + of.width, size[0]) - 1.0);
        let (y, bottom) = (top + at(of.y, size[1]), top + at(of.y + of.height, size[1]) - 1.0);
        let corners = [(x, y), (right, y), (right, bottom), (x, bottom), (x, y)];
        // Edges of boxes that nearly coincide are not of one length: dashes begin anew at each corner.
        corners.windows(2).for_each(|edge| line(&mut clipped, edge, thick, color, dashes));
    };
    if let Some(window) = still.window() {
        // Black and white: to be seen on anything. Only what is in the frame is in the tile.
        let seen = window.intersection(smr_core::Rect::new(0, 0, still.frame.width, still.frame.height)).into();
        outline(&seen, 1, BLACK, Dashes::NONE);
        outline(&seen, 1, WHITE, Dashes::new(5.0, 5.0));
    }
    let moment = &film.moments[still.index];
    let mut found = Vec::new();
    let begun = |method: &usize| still.index >= film.begins(*method);
    for method in (0..film.methods.len()).filter(begun) {
        let (color, sight) = (ink_of(film, method), &still.sights[method]);
        match moment.reports[method].target {
            Some(_) => found.push((color, sight.bbox)),
            None => outline(&sight.bbox, 3, color, Dashes::new(5.0, 5.0)),
        }
    }
    found.extend(film.truth_at(still.index).map(|truth| (TRUTH, truth)));
    let turns = turns(&found.iter().map(|(_, bbox)| *bbox).collect::<Vec<_>>());
    for ((color, bbox), (place, all)) in found.into_iter().zip(turns) {
        let off = DASH * (all - 1) as f64;
        outline(&bbox, 3, color, Dashes { on: DASH, off, after: DASH * place as f64 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::{SAD, SMR};
    use crate::report::{Choice, Refusal, watch};
    use smr_core::paper::Config;
    use smr_evaluation::{MethodKind, Variant};
    use smr_recordings::Colors;
    use smr_recordings::{GrayFrame, OpenOptions, Sequence, synthetic};
    use std::collections::BTreeSet;
    use std::path::Path;

    fn drawn(sequence: Sequence, choice: Choice) -> Canvas {
        let variant = |kind| Variant::new(kind, &Config::paper().into());
        let methods = [MethodKind::Smr, MethodKind::Sad].map(variant);
        let film = watch(sequence, &methods, Refusal::Fails, choice, None, || ()).unwrap();
        Canvas::decoded(&picture(&film).unwrap())
    }

    fn plain(width: u16, height: u16) -> Sequence {
        let frame = GrayFrame { width, height, pixels: vec![90; usize::from(width) * usize::from(height)] };
        Sequence {
            name: "plain".to_owned(),
            frames: Box::new([Ok(frame)].into_iter()),
            length: Some(1),
            first: 1,
            init: Some("0,0,1,1".parse().unwrap()),
            truth: None,
            colors: Colors::None,
            notes: Vec::new(),
        }
    }

    #[test]
    fn boxes_are_where_they_belong_and_all_are_seen() {
        let sequence = smr_recordings::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        let picture = drawn(sequence, Choice::Listed([0].into()));
        assert_eq!(picture.width, 1000);
        // Frame 1 is twice as large at (10, 10); the target's box begins at (36, 24).
        let at = |x: u32, y: u32| picture.at(10 + 2 * 36 + x - 4, 10 + 2 * 24 + y - 4);
        // The edge is the middle of a line of three pixels, on which they take turns.
        let colors = BTreeSet::from([SMR, SAD, TRUTH]);
        for line in [3, 4, 5] {
            assert_eq!((8..48).map(|y| at(line, y)).collect::<BTreeSet<_>>(), colors, "{line}");
            assert_eq!((8..48).map(|x| at(x, line)).collect::<BTreeSet<_>>(), colors, "{line}");
        }
        for line in [2, 6] {
            assert!((8..48).all(|along| !colors.contains(&at(line, along)) && !colors.contains(&at(along, line))));
        }
    }

    #[test]
    fn frames_of_any_shape_have_a_picture() {
        for (width, height, tile) in [(1, 1, 320), (640, 480, 240), (1, 2000, 320), (2000, 1, 1)] {
            let picture = drawn(plain(width, height), Choice::Spread);
            assert_eq!((picture.width, picture.height), (1000, GAP + tile + LINE + GAP / 2 + LINE), "{width}x{height}");
        }
    }
}
