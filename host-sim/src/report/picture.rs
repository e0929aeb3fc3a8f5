//! The film strip as one picture: what a README shows.

use super::film::{Film, Still};
use super::turns::turns;
use super::{Color, SAD, SMR, TRUTH, color_of, color_of_method, encode, font, pictures};
use crate::evaluate::{MethodKind, name_of};
use crate::sequence::BoundingBox;
use anyhow::Result;
use smr_core::State;

/// No side of a frame is longer in the picture.
const TILE: u32 = 320;
const COLUMNS: u32 = 3;
const GAP: u32 = 10;
/// Letters are drawn so many times larger than they are.
const LETTER: u32 = 2;
/// A line of text with what is between it and the next.
const LINE: u32 = font::HEIGHT * LETTER + GAP;

/// Colors come after this many gray levels. Half of the 256 are enough for the eye, and noise makes up most of the file.
const GRAYS: u8 = 128;
const PAPER: u8 = 12;
const BLACK: u8 = 0;
pub(super) const WHITE: u8 = GRAYS - 1;
const INKS: [Color; 6] = [SMR, SAD, TRUTH, color_of(State::Tracking), color_of(State::Leaving), color_of(State::Lost)];
/// Those of the other methods; they are in the palette of a picture that shows one of them.
const MORE_INKS: [Color; 4] = [
    color_of_method(MethodKind::Robust),
    color_of_method(MethodKind::Ssd),
    color_of_method(MethodKind::Ncc),
    color_of_method(MethodKind::Lk),
];

/// The frames to show, side by side with their boxes and states, as a PNG.
///
/// # Errors
/// The encoder's; no picture is known that it refuses.
pub fn picture(film: &Film) -> Result<Vec<u8>> {
    let height = fitted(film.size).1;
    let cell = (TILE + GAP, height + LINE + GAP / 2);
    let rows = u32::try_from(film.stills.len())?.div_ceil(COLUMNS);
    let mut canvas = Canvas::new(GAP + COLUMNS * cell.0, GAP + rows * cell.1 + LINE);
    for (number, still) in (0..).zip(&film.stills) {
        let (left, top) = (GAP + number % COLUMNS * cell.0, GAP + number / COLUMNS * cell.1);
        Tile::new(left, top, still).draw(&mut canvas, film, still);
        let report = film.moments[still.index].first();
        let end = canvas.text(left, top + height + GAP / 2, &format!("frame {}  ", still.index + 1), WHITE);
        canvas.text(end, top + height + GAP / 2, name_of(report.state), ink(color_of(report.state)));
    }
    let mut left = GAP;
    for (word, ink) in legend(film) {
        left = canvas.text(left, GAP + rows * cell.1, &word, ink) + 2 * GAP;
    }
    let more = film.methods.iter().any(|method| MORE_INKS.contains(&color_of_method(method.kind)));
    let more = if more { &MORE_INKS[..] } else { &[] };
    encode::png((canvas.width, canvas.height), &canvas.pixels, &[&palette(), more].concat())
}

fn legend(film: &Film) -> impl Iterator<Item = (String, u8)> {
    let methods = film.methods.iter().map(|method| (method.name.to_uppercase(), ink(color_of_method(method.kind))));
    let truth = film.truth.as_ref().map(|_| ("ground truth".to_owned(), ink(TRUTH)));
    methods.chain(truth).chain([("search window".to_owned(), WHITE)])
}

pub(super) fn palette() -> Vec<Color> {
    let gray = |level: u8| [level * 2 + level / 64; 3];
    (0..GRAYS).map(gray).chain(INKS).collect()
}

/// That of pictures with differences: what counts in them is green.
pub(super) fn full_palette() -> Vec<Color> {
    palette().into_iter().chain(MORE_INKS).chain(greens()).collect()
}

/// Neighbours are hardly told apart: every second is enough.
fn greens() -> impl Iterator<Item = Color> {
    (0..64).step_by(2).map(pictures::counting_color)
}

/// Where `color` is in the full palette, of which the others are the beginning; a green may be its neighbour.
pub(super) fn ink(color: Color) -> u8 {
    let inks = (GRAYS..).zip(INKS.into_iter().chain(MORE_INKS).chain(greens()));
    let distance = |known: Color| known.iter().zip(color).map(|(a, b)| u32::from(a.abs_diff(b))).sum::<u32>();
    let nearest = inks.map(|(index, known)| (distance(known), index)).min();
    let [r, g, b] = color;
    let gray = (r == g && g == b).then_some(r / 2);
    gray.or(nearest.map(|(_, index)| index)).unwrap_or(WHITE)
}

/// The size of a frame in the picture.
fn fitted((width, height): (u16, u16)) -> (u32, u32) {
    let longest = u32::from(width.max(height)).max(1);
    let fit = |side: u16| (u32::from(side) * TILE / longest).max(1);
    (fit(width), fit(height))
}

/// Indices into the palette.
pub(super) struct Canvas {
    width: u32,
    height: u32,
    pixels: Vec<u8>,
}

impl Canvas {
    pub(super) fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![PAPER; width as usize * height as usize] }
    }

    /// What is outside is not drawn.
    pub(super) fn set(&mut self, x: u32, y: u32, ink: u8) {
        if x < self.width && y < self.height {
            self.pixels[y as usize * self.width as usize + x as usize] = ink;
        }
    }

    pub(super) const fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    pub(super) fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// The width of `text` when it is written.
    pub(super) fn width_of(text: &str) -> u32 {
        (0..).zip(text.chars()).map(|_| (font::WIDTH + 1) * LETTER).sum()
    }

    /// Writes `text` and tells where it ends.
    pub(super) fn text(&mut self, mut left: u32, top: u32, text: &str, ink: u8) -> u32 {
        for letter in text.chars() {
            for (column, row) in font::ink(letter) {
                for (x, y) in (0..LETTER * LETTER).map(|dot| (dot % LETTER, dot / LETTER)) {
                    self.set(left + column * LETTER + x, top + row * LETTER + y, ink);
                }
            }
            left += (font::WIDTH + 1) * LETTER;
        }
        left
    }
}

/// The place of one frame.
struct Tile {
    left: u32,
    top: u32,
    width: u32,
    height: u32,
    /// Pixels of the picture for one of the frame.
    scale: f64,
}

/// How an outline is drawn.
struct Pen {
    /// Pixels to each side of the box's edge.
    half: i64,
    ink: u8,
    dashes: Dashes,
}

enum Dashes {
    /// With gaps between.
    Gaps,
    /// With another ink between.
    Ink(u8),
    /// Its place among so many that take turns.
    Turn(i64, i64),
}

impl Tile {
    fn new(left: u32, top: u32, still: &Still) -> Self {
        let (width, height) = fitted((still.frame.width, still.frame.height));
        Self { left, top, width, height, scale: f64::from(width) / f64::from(still.frame.width) }
    }

    fn draw(&self, canvas: &mut Canvas, film: &Film, still: &Still) {
        self.frame(canvas, still);
        let moment = &film.moments[still.index];
        if let Some(window) = still.window() {
            // Black and white: to be seen on anything. Only what is in the frame is in the tile.
            let seen = window.intersection(smr_core::Rect::new(0, 0, still.frame.width, still.frame.height));
            self.outline(canvas, &seen.into(), &Pen { half: 0, ink: WHITE, dashes: Dashes::Ink(BLACK) });
        }
        let mut found = Vec::new();
        for (method, (report, sight)) in film.methods.iter().zip(moment.reports.iter().zip(&still.sights)) {
            let ink = ink(color_of_method(method.kind));
            if report.target.is_some() {
                found.push((ink, sight.bbox));
            } else {
                self.outline(canvas, &sight.bbox, &Pen { half: 1, ink, dashes: Dashes::Gaps });
            }
        }
        found.extend(film.truth_at(still.index).map(|truth| (ink(TRUTH), truth)));
        let turns = turns(&found.iter().map(|(_, bbox)| *bbox).collect::<Vec<_>>());
        for ((ink, bbox), (place, all)) in found.into_iter().zip(turns) {
            let turn = |number: usize| i64::try_from(number).unwrap_or(i64::MAX);
            self.outline(canvas, &bbox, &Pen { half: 1, ink, dashes: Dashes::Turn(turn(place), turn(all)) });
        }
    }

    /// The nearest pixel each: whole factors stay sharp.
    fn frame(&self, canvas: &mut Canvas, still: &Still) {
        let frame = &still.frame;
        let nearest = |place: u32, side: u32, of: u16| (place * u32::from(of) / side) as usize;
        for y in 0..self.height {
            let row = nearest(y, self.height, frame.height) * usize::from(frame.width);
            for x in 0..self.width {
                let gray = frame.pixels[row + nearest(x, self.width, frame.width)];
                canvas.set(self.left + x, self.top + y, gray / 2);
            }
        }
    }

    fn outline(&self, canvas: &mut Canvas, of: &BoundingBox, pen: &Pen) {
        let at = |place: f64, side: u32| whole(place * self.scale).clamp(-9, i64::from(side) + 9);
        let (left, right) = (at(of.x, self.width), at(of.x + of.width, self.width) - 1);
        let (top, bottom) = (at(of.y, self.height), at(of.y + of.height, self.height) - 1);
        for grown in -pen.half..=pen.half {
            let (left, right, top, bottom) = (left - grown, right + grown, top - grown, bottom + grown);
            for x in left..=right {
                self.dot(canvas, (x, top), x, pen);
                self.dot(canvas, (x, bottom), x, pen);
            }
            for y in top..=bottom {
                self.dot(canvas, (left, y), y, pen);
                self.dot(canvas, (right, y), y, pen);
            }
        }
    }

    /// What is outside of the tile is not drawn. `along` is the place on the line.
    fn dot(&self, canvas: &mut Canvas, (x, y): (i64, i64), along: i64, pen: &Pen) {
        let dash = along.rem_euclid(10) < 5;
        let ink = match pen.dashes {
            Dashes::Turn(place, all) => (along.div_euclid(8).rem_euclid(all) == place).then_some(pen.ink),
            Dashes::Gaps => dash.then_some(pen.ink),
            Dashes::Ink(other) => Some(if dash { pen.ink } else { other }),
        };
        let Some(ink) = ink else { return };
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
        if x < self.width && y < self.height {
            canvas.set(self.left + x, self.top + y, ink);
        }
    }
}

#[allow(clippy::cast_possible_truncation)] // what is too large becomes the largest, and is then clamped
fn whole(place: f64) -> i64 {
    place.round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Variant;
    use crate::export::Decoded;
    use crate::report::{Choice, watch};
    use crate::sequence::Damage;
    use crate::sequence::{self, GrayFrame, OpenOptions, Sequence, synthetic};
    use smr_core::paper::Config;
    use std::collections::BTreeSet;
    use std::path::Path;

    fn drawn(sequence: Sequence, choice: Choice) -> Decoded {
        let variant = |kind| Variant::new(kind, &Config::paper().into());
        let methods = [MethodKind::Smr, MethodKind::Sad].map(variant);
        let film = watch(sequence, &methods, choice, None, || ()).unwrap();
        Decoded::new(&picture(&film).unwrap())
    }

    fn plain(width: u16, height: u16) -> Sequence {
        let frame = GrayFrame { width, height, pixels: vec![90; usize::from(width) * usize::from(height)] };
        Sequence {
            name: "plain".to_owned(),
            frames: Box::new([Ok(frame)].into_iter()),
            length: Some(1),
            init: Some("0,0,1,1".parse().unwrap()),
            truth: None,
            damage: Damage::default(),
        }
    }

    #[test]
    fn boxes_are_where_they_belong_and_all_are_seen() {
        let sequence = sequence::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        let picture = drawn(sequence, Choice::Listed([0].into()));
        assert_eq!(picture.size.0, 1000);
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
            assert_eq!(picture.size, (1000, GAP + tile + LINE + GAP / 2 + LINE), "{width}x{height}");
        }
    }
}
