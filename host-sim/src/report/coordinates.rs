//! One frame with its coordinates, as a picture: what a box is chosen from and checked by.

use super::picture::{Canvas, WHITE, ink, palette};
use super::{SMR, encode, font};
use crate::sequence::{BoundingBox, GrayFrame};
use anyhow::Result;

/// A frame is enlarged by a whole factor as long as no side becomes longer than this.
const SIDE: u32 = 1280;
const MOST_ENLARGED: u32 = 16;
/// Letters are drawn twice as large as they are.
const LETTER: u32 = 2;
const LINE: u32 = font::HEIGHT * LETTER;
const GAP: u32 = 8;
/// Around the frame: room for a number of five digits, and for a line of text.
const MARGIN: (u32, u32) = (5 * (font::WIDTH + 1) * LETTER + 2 * GAP, LINE + 2 * GAP);
/// Lines with a number are at least this far apart in the picture.
const APART: u32 = 64;
/// Gray levels, as the palette counts them, by which a line differs from what is under it: seen in the dark and in the light.
const STRONG: u8 = 40;
const FAINT: u8 = 14;
/// Width of the box's outline.
const OUTLINE: i64 = 2;

/// The `number`th frame with a grid, numbered axes in pixels of the frame, and the outline of `target` around its pixels.
///
/// # Errors
/// The encoder's; no picture is known that it refuses.
pub fn coordinates(frame: &GrayFrame, number: usize, target: Option<&BoundingBox>) -> Result<Vec<u8>> {
    let sheet = Sheet::new(frame);
    let mut canvas = Canvas::new(sheet.at(0, u32::from(frame.width)) + MARGIN.0, sheet.bottom() + 2 * MARGIN.1);
    sheet.frame(&mut canvas, frame);
    sheet.numbers(&mut canvas);
    if let Some(target) = target {
        sheet.outline(&mut canvas, target);
    }
    sheet.caption(&mut canvas, number, target);
    encode::png(canvas.size(), canvas.pixels(), &palette())
}

/// Where the frame is in the picture.
struct Sheet {
    /// Width and height of the frame.
    size: [u32; 2],
    /// Left and upper end of the frame in the picture.
    origin: [u32; 2],
    /// Pixels of the picture for one of the frame.
    scale: u32,
    /// Pixels of the frame from one numbered line to the next.
    step: u32,
    /// The same for all lines.
    fine: u32,
}

impl Sheet {
    fn new(frame: &GrayFrame) -> Self {
        let size = [frame.width, frame.height].map(u32::from);
        let scale = (SIDE / size[0].max(size[1]).max(1)).clamp(1, MOST_ENLARGED);
        let (step, fine) = steps(scale);
        Self { size, origin: [MARGIN.0, MARGIN.1], scale, step, fine }
    }

    /// The picture's pixel at which the frame's pixel `place` begins, across (`axis` 0) or down (1).
    fn at(&self, axis: usize, place: u32) -> u32 {
        self.origin[axis] + place * self.scale
    }

    fn bottom(&self) -> u32 {
        self.at(1, self.size[1])
    }

    /// The pixels, and the grid in them.
    fn frame(&self, canvas: &mut Canvas, frame: &GrayFrame) {
        let [width, height] = self.size.map(|side| side * self.scale);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let (column, row) = (x / self.scale, y / self.scale);
            let gray = frame.pixels[(row * self.size[0] + column) as usize] / 2;
            // A line is the first row or column of picture pixels that belongs to the pixel it names.
            let on = |step: u32| {
                (x.is_multiple_of(self.scale) && column.is_multiple_of(step))
                    || (y.is_multiple_of(self.scale) && row.is_multiple_of(step))
            };
            let ink = if on(self.step) {
                contrasted(gray, STRONG)
            } else if on(self.fine) {
                contrasted(gray, FAINT)
            } else {
                gray
            };
            canvas.set(self.origin[0] + x, self.origin[1] + y, ink);
        }
    }

    /// The numbers of the lines, on all four sides.
    fn numbers(&self, canvas: &mut Canvas) {
        let middle = font::HEIGHT * LETTER / 2;
        for (axis, side) in self.size.into_iter().enumerate() {
            for place in (0..side).step_by(self.step as usize) {
                let (at, text) = (self.at(axis, place), place.to_string());
                let width = Canvas::width_of(&text);
                if axis == 0 {
                    canvas.text(at.saturating_sub(width / 2), GAP, &text, WHITE);
                    canvas.text(at.saturating_sub(width / 2), self.bottom() + GAP, &text, WHITE);
                } else {
                    let top = at.saturating_sub(middle);
                    canvas.text(self.origin[0] - GAP - width, top, &text, WHITE);
                    canvas.text(self.at(0, self.size[0]) + GAP, top, &text, WHITE);
                }
            }
        }
        canvas.text(GAP, GAP, "X", WHITE);
        canvas.text(GAP, self.origin[1], "Y", WHITE);
    }

    /// Around the box's pixels, none of which is hidden. What is outside of the frame is not drawn.
    fn outline(&self, canvas: &mut Canvas, target: &BoundingBox) {
        let ends = |axis: usize, first: f64, size: f64| {
            let scale = f64::from(self.scale);
            let origin = i64::from(self.origin[axis]);
            (origin + whole(first * scale), origin + whole((first + size) * scale) - 1)
        };
        let ((left, right), (top, bottom)) = (ends(0, target.x, target.width), ends(1, target.y, target.height));
        let mut dot = |x: i64, y: i64| {
            let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
            let inside = |axis: usize, at: u32| {
                (self.origin[axis] - GAP / 2..=self.at(axis, self.size[axis]) + GAP / 2).contains(&at)
            };
            if inside(0, x) && inside(1, y) {
                canvas.set(x, y, ink(SMR));
            }
        };
        let within = |value: i64| value.clamp(-OUTLINE, i64::from(u16::MAX) * 2);
        for grown in 1..=OUTLINE {
            let (left, right, top, bottom) = (left - grown, right + grown, top - grown, bottom + grown);
            for x in within(left)..=within(right) {
                dot(x, top);
                dot(x, bottom);
            }
            for y in within(top)..=within(bottom) {
                dot(left, y);
                dot(right, y);
            }
        }
    }

    fn caption(&self, canvas: &mut Canvas, number: usize, target: Option<&BoundingBox>) {
        let top = self.bottom() + MARGIN.1;
        let end = canvas.text(self.origin[0], top, &format!("FRAME {number}   "), WHITE);
        if let Some(BoundingBox { x, y, width, height }) = target {
            canvas.text(end, top, &format!("X {x}  Y {y}  W {width}  H {height}"), ink(SMR));
        }
    }
}

/// Pixels of the frame between numbered lines and between all lines, where a pixel is `scale` wide in the picture.
fn steps(scale: u32) -> (u32, u32) {
    let round = [(5, 1), (10, 2), (20, 5), (50, 10), (100, 20)];
    round.into_iter().find(|(step, _)| step * scale >= APART).unwrap_or((100, 20))
}

/// A gray level of the palette that differs from `gray` by `contrast`.
fn contrasted(gray: u8, contrast: u8) -> u8 {
    if gray > WHITE / 2 { gray.saturating_sub(contrast) } else { gray.saturating_add(contrast).min(WHITE) }
}

#[allow(clippy::cast_possible_truncation)] // what is too large becomes the largest, and is then clamped
fn whole(place: f64) -> i64 {
    (place.round() as i64).clamp(-1_000_000, 1_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::Decoded;

    fn plain(width: u16, height: u16, gray: u8) -> GrayFrame {
        GrayFrame { width, height, pixels: vec![gray; usize::from(width) * usize::from(height)] }
    }

    fn drawn(frame: &GrayFrame, target: Option<&str>) -> Decoded {
        let target = target.map(|target| target.parse().unwrap());
        let png = coordinates(frame, 1, target.as_ref()).unwrap();
        Decoded::new(&png)
    }

    /// The picture's pixel at the upper left corner of the frame's pixel.
    fn at(picture: &Decoded, scale: u32, x: u32, y: u32) -> [u8; 3] {
        picture.at(MARGIN.0 + x * scale, MARGIN.1 + y * scale)
    }

    #[test]
    fn lines_are_where_their_numbers_say() {
        for gray in [0, 90, 128, 255] {
            let picture = drawn(&plain(320, 240, gray), None);
            let [line, fine, other] = [(20, 1), (5, 1), (6, 1)].map(|(x, y)| i32::from(at(&picture, 4, x, y)[0]));
            assert!(other.abs_diff(gray.into()) <= 1, "{gray}: {other}");
            assert!((line - other).abs() >= 70, "{gray}: {line} on {other}");
            assert!((20..60).contains(&(fine - other).abs()), "{gray}: {fine} on {other}");
        }
    }

    #[test]
    fn lines_are_seen_on_every_gray() {
        for (gray, contrast) in (0..=WHITE).flat_map(|gray| [(gray, STRONG), (gray, FAINT)]) {
            let line = contrasted(gray, contrast);
            assert!(line <= WHITE && line.abs_diff(gray) == contrast, "{gray}: {line}");
        }
    }

    #[test]
    fn the_outline_is_around_the_pixels_of_the_box() {
        let (frame, scale) = (plain(320, 240, 90), 4);
        let (with, without) = (drawn(&frame, Some("31,42,10,20")), drawn(&frame, None));
        for (x, y) in (31..41).flat_map(|x| (42..62).map(move |y| (x, y))) {
            assert_eq!(at(&with, scale, x, y), at(&without, scale, x, y), "({x}, {y})");
        }
        let (left, right, top, bottom) = (31 * scale, 41 * scale, 42 * scale, 62 * scale);
        for (x, y) in
            [(left - 1, top), (left - 2, bottom - 1), (right, top), (right + 1, top), (left, top - 2), (left, bottom)]
        {
            assert_eq!(with.at(MARGIN.0 + x, MARGIN.1 + y), SMR, "({x}, {y})");
        }
    }

    #[test]
    fn frames_and_boxes_of_any_size_have_a_picture() {
        for (width, height, scale) in [(1, 1, 16), (24, 28, 16), (640, 480, 2), (1, 2000, 1), (1921, 3, 1)] {
            let frame = plain(width, height, 200);
            for target in [None, Some("0,0,1,1"), Some("-50,-50,9999,9999"), Some("1e9,-1e9,65535,1e300")] {
                let picture = drawn(&frame, target);
                let expected = (u32::from(width) * scale + 2 * MARGIN.0, u32::from(height) * scale + 3 * MARGIN.1);
                assert_eq!(picture.size, expected, "{width}x{height}");
            }
        }
    }

    #[test]
    fn numbered_lines_are_far_enough_apart_to_be_read() {
        for scale in 1..=MOST_ENLARGED {
            let (step, fine) = steps(scale);
            assert!(step * scale >= APART && step.is_multiple_of(fine), "{scale}");
        }
    }
}
