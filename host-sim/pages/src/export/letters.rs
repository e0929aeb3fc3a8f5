//! Outlines of the letters in videos: DejaVu Sans, with Latin, Greek, Cyrillic, Armenian and Georgian letters.

use anyhow::{Context, Result};
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

const FONT: &[u8] = include_bytes!("../../fonts/DejaVuSansCondensed-Bold.ttf");

/// Stands for a letter that the font lacks.
const UNKNOWN: char = '□';

/// A line of text, whose baseline begins at (0, 0).
pub(super) struct Line {
    /// Outlines of the letters; `None` if the text has only spaces.
    pub path: Option<Path>,
    pub width: f32,
    /// Height of the letters, from the lowest to the highest, in pixels.
    pub size: f32,
}

impl Line {
    pub(super) fn new(text: &str, size: f32) -> Result<Self> {
        let face = Face::parse(FONT, 0).context("the font is damaged")?;
        let mut pen = Pen { path: PathBuilder::new(), x: 0.0, scale: size / f32::from(face.units_per_em()) };
        for letter in text.chars() {
            let glyph = face.glyph_index(letter).or_else(|| face.glyph_index(UNKNOWN)).unwrap_or(GlyphId(0));
            face.outline_glyph(glyph, &mut pen);
            pen.x += pen.scale * f32::from(face.glyph_hor_advance(glyph).unwrap_or(0));
        }
        Ok(Self { path: pen.path.finish(), width: pen.x, size })
    }
}

/// Moves outlines, whose y axis points up, to the place of their letter.
struct Pen {
    path: PathBuilder,
    x: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + self.scale * x, -self.scale * y)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_of_names_have_outlines() {
        let width = |text: &str| Line::new(text, 20.0).unwrap().width;
        let unknown = Line::new("\u{E000}", 20.0).unwrap();
        for letter in "Straße Żółw λύκος Ёжик Հայ ქარ 0123456789".chars().filter(|letter| *letter != ' ')
        {
            let line = Line::new(&letter.to_string(), 20.0).unwrap();
            assert!(line.path.is_some_and(|path| Some(path) != unknown.path), "{letter}");
        }
        assert!(unknown.path.is_some() && Line::new("  ", 20.0).unwrap().path.is_none());
        assert!(width("ab") > width("a") && width("") == 0.0 && width("0") == width("1"), "digits are equally wide");
        let path = Line::new("g", 20.0).unwrap().path.unwrap();
        assert!(path.bounds().top() < 0.0 && path.bounds().bottom() > 0.0, "on the line, and below it");
    }
}
