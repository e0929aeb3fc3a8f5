//! Boxes and a line of text, drawn over a frame.

use crate::report::font;
use crate::sequence::{BoundingBox, GrayFrame};

/// What can be drawn with, beside the picture's gray levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    Black,
    White,
    Green,
    Amber,
    Red,
}

impl Ink {
    /// All of them, in the order of a palette.
    pub const ALL: [Self; 5] = [Self::Black, Self::White, Self::Green, Self::Amber, Self::Red];

    #[must_use]
    pub const fn color(self) -> [u8; 3] {
        match self {
            Self::Black => [0, 0, 0],
            Self::White => [255, 255, 255],
            Self::Green => [40, 230, 100],
            Self::Amber => [255, 190, 0],
            Self::Red => [255, 70, 60],
        }
    }
}

/// A frame that is drawn on.
pub struct Overlay {
    frame: GrayFrame,
    /// What covers each pixel.
    ink: Vec<Option<Ink>>,
}

impl Overlay {
    #[must_use]
    pub fn new(frame: GrayFrame) -> Self {
        let ink = vec![None; frame.pixels.len()];
        Self { frame, ink }
    }

    #[must_use]
    pub fn size(&self) -> (u16, u16) {
        (self.frame.width, self.frame.height)
    }

    /// What is seen at each pixel: a gray level, or what was drawn there.
    pub fn pixels(&self) -> impl Iterator<Item = (u8, Option<Ink>)> {
        self.frame.pixels.iter().copied().zip(self.ink.iter().copied())
    }

    /// Red, green and blue of each pixel.
    #[must_use]
    pub fn rgb(&self) -> Vec<u8> {
        self.pixels().flat_map(|(gray, ink)| ink.map_or([gray; 3], Ink::color)).collect()
    }

    /// How large a dot of what is drawn is, so that it is seen in large frames, too.
    fn dot(&self) -> i64 {
        i64::from(self.frame.width.min(self.frame.height) / 240 + 1)
    }

    /// Lines around the box, a dark one outside so that they are seen on any ground. What is in the box stays to be seen: targets are small.
    pub fn outline(&mut self, target: &BoundingBox, ink: Ink) {
        let Some(rect) = target.to_rect() else { return };
        let (left, top) = (i64::from(rect.x), i64::from(rect.y));
        let (right, bottom) = (left + i64::from(rect.width), top + i64::from(rect.height));
        let around = |wide: i64| [left - wide, top - wide, right + wide, bottom + wide];
        let dot = self.dot();
        self.ring(around(dot + 1), 1, Ink::Black);
        self.ring(around(dot), dot, ink);
    }

    fn ring(&mut self, [left, top, right, bottom]: [i64; 4], thickness: i64, ink: Ink) {
        self.fill([left, top, right, top + thickness], ink);
        self.fill([left, bottom - thickness, right, bottom], ink);
        self.fill([left, top, left + thickness, bottom], ink);
        self.fill([right - thickness, top, right, bottom], ink);
    }

    /// As much of it as lies in the frame.
    fn fill(&mut self, [left, top, right, bottom]: [i64; 4], ink: Ink) {
        let (width, height) = (usize::from(self.frame.width), usize::from(self.frame.height));
        let within = |value: i64, side: usize| usize::try_from(value.max(0)).map_or(side, |value| value.min(side));
        let (left, right) = (within(left, width), within(right, width));
        for row in within(top, height)..within(bottom, height) {
            if left < right {
                self.ink[row * width + left..row * width + right].fill(Some(ink));
            }
        }
    }

    /// A line in capitals and digits on a dark ground, in the upper left corner.
    pub fn label(&mut self, text: &str, ink: Ink) {
        let dot = self.dot();
        let (letter, high) = (i64::from(font::WIDTH) + 1, i64::from(font::HEIGHT));
        let letters = i64::try_from(text.chars().count()).unwrap_or(0);
        self.fill([0, 0, (letters * letter + 3) * dot, (high + 4) * dot], Ink::Black);
        for (index, sign) in (0..).zip(text.chars()) {
            for (column, row) in font::ink(sign) {
                let (x, y) = ((2 + index * letter + i64::from(column)) * dot, (2 + i64::from(row)) * dot);
                self.fill([x, y, x + dot, y + dot], ink);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> Overlay {
        Overlay::new(GrayFrame { width: 20, height: 16, pixels: vec![100; 320] })
    }

    fn at(overlay: &Overlay, x: usize, y: usize) -> Option<Ink> {
        overlay.ink[y * 20 + x]
    }

    #[test]
    fn an_outline_is_around_the_box() {
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: 4.2, y: 5.0, width: 6.0, height: 4.0 }, Ink::Green);
        for (x, y) in [(3, 4), (10, 4), (3, 9), (10, 9), (6, 4)] {
            assert_eq!(at(&overlay, x, y), Some(Ink::Green), "{x},{y}");
        }
        assert_eq!((at(&overlay, 2, 3), at(&overlay, 11, 10)), (Some(Ink::Black), Some(Ink::Black)));
        for (x, y) in [(4, 5), (9, 8), (12, 11)] {
            assert_eq!(at(&overlay, x, y), None, "{x},{y}");
        }
        let inked = overlay.ink.iter().flatten().filter(|&&ink| ink == Ink::Green).count();
        assert_eq!((inked, overlay.rgb()[..3].to_vec()), (2 * 8 + 2 * 4, vec![100; 3]));
    }

    #[test]
    fn what_lies_outside_is_cut() {
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: -5.0, y: -5.0, width: 1000.0, height: 8.0 }, Ink::Red);
        assert_eq!(
            (at(&overlay, 0, 3), at(&overlay, 19, 3), at(&overlay, 0, 0)),
            (Some(Ink::Red), Some(Ink::Red), None)
        );
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: 1e300, y: f64::NAN, width: 5.0, height: 8.0 }, Ink::Red);
        overlay.outline(&BoundingBox { x: 2e9, y: -2e9, width: 65535.0, height: 65535.0 }, Ink::Red);
        assert!(overlay.ink.iter().all(Option::is_none));
        overlay.label("WIDER THAN THE FRAME", Ink::White);
        assert_eq!(at(&overlay, 19, 0), Some(Ink::Black));
    }
}
