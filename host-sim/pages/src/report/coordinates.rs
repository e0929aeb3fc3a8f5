//! One frame with its coordinates, as a picture: what a box is chosen from and checked by.

use super::canvas::{Canvas, FONT, coarse, pixel, rgb, width_of};
use crate::colors::{PAPER, SMR, WHITE};
use anyhow::Result;
use embedded_graphics::Drawable;
use embedded_graphics::draw_target::DrawTargetExt;
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::primitives::{Primitive, PrimitiveStyleBuilder, Rectangle, StrokeAlignment};
use smr_recordings::{BoundingBox, GrayFrame};

/// A frame is enlarged by a whole factor as long as no side becomes longer than this.
const SIDE: u32 = 1280;
const MOST_ENLARGED: u32 = 16;
const GAP: u32 = 8;
/// Around the frame: room for a number of five digits, and for a line of text.
const MARGIN: (u32, u32) = (5 * FONT.character_size.width + 2 * GAP, FONT.character_size.height + 2 * GAP);
/// Lines with a number are at least this far apart in the picture.
const APART: u32 = 64;
/// Gray levels by which a line differs from what is under it: seen in the dark and in the light.
const STRONG: u8 = 80;
const FAINT: u8 = 28;
/// Width of the box's outline.
const OUTLINE: u32 = 2;

/// The `number`th frame with a grid, numbered axes in pixels of the frame, and the outline of `target` around its pixels.
pub fn coordinates(frame: &GrayFrame, number: usize, target: Option<&BoundingBox>) -> Result<Vec<u8>> {
    let size = [frame.width, frame.height].map(u32::from);
    let scale = (SIDE / size[0].max(size[1]).max(1)).clamp(1, MOST_ENLARGED);
    let [width, height] = size.map(|side| side * scale);
    let canvas = Canvas::new(width + 2 * MARGIN.0, height + 3 * MARGIN.1, PAPER);
    let mut sheet = Sheet { canvas, size, scale };
    sheet.frame(frame);
    sheet.numbers()?;
    if let Some(target) = target {
        sheet.outline(target);
    }
    sheet.caption(number, target)?;
    sheet.canvas.png()
}

/// Where the frame is in the picture.
struct Sheet {
    canvas: Canvas,
    /// Width and height of the frame.
    size: [u32; 2],
    /// Pixels of the picture for one of the frame.
    scale: u32,
}

impl Sheet {
    /// The picture's pixel at which the frame's pixel begins.
    fn at(&self, x: f64, y: f64) -> Point {
        let place = |value: f64, margin: u32| {
            pixel((value * f64::from(self.scale)).clamp(-1e5, 1e6)).saturating_add_unsigned(margin)
        };
        Point::new(place(x, MARGIN.0), place(y, MARGIN.1))
    }

    /// The pixels, and the grid in them.
    fn frame(&mut self, frame: &GrayFrame) {
        let (step, fine) = steps(self.scale);
        let [width, height] = self.size.map(|side| side * self.scale);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let (column, row) = (x / self.scale, y / self.scale);
            let gray = frame.pixels[(row * self.size[0] + column) as usize];
            // A line is the first row or column of picture pixels that belongs to the pixel it names.
            let on = |step: u32| {
                (x.is_multiple_of(self.scale) && column.is_multiple_of(step))
                    || (y.is_multiple_of(self.scale) && row.is_multiple_of(step))
            };
            let gray = if on(step) {
                contrasted(gray, STRONG)
            } else if on(fine) {
                contrasted(gray, FAINT)
            } else {
                gray
            };
            self.canvas.set(MARGIN.0 + x, MARGIN.1 + y, coarse(gray));
        }
    }

    fn text(&mut self, left: u32, top: u32, text: &str) -> Result<i32> {
        Ok(self.canvas.text(i32::try_from(left)?, i32::try_from(top)?, text, WHITE, FONT))
    }

    /// The numbers of the lines, on all four sides.
    fn numbers(&mut self) -> Result<()> {
        let (step, _) = steps(self.scale);
        let [right, bottom] = [MARGIN.0 + self.size[0] * self.scale, MARGIN.1 + self.size[1] * self.scale];
        for place in (0..self.size[0]).step_by(step as usize) {
            let text = place.to_string();
            let left = (MARGIN.0 + place * self.scale).saturating_sub(width_of(&text) / 2);
            self.text(left, GAP, &text)?;
            self.text(left, bottom + GAP, &text)?;
        }
        for place in (0..self.size[1]).step_by(step as usize) {
            let text = place.to_string();
            let top = (MARGIN.1 + place * self.scale).saturating_sub(FONT.character_size.height / 2);
            self.text(MARGIN.0 - GAP - width_of(&text), top, &text)?;
            self.text(right + GAP, top, &text)?;
        }
        self.text(GAP, GAP, "X")?;
        self.text(GAP, MARGIN.1, "Y")?;
        Ok(())
    }

    /// Around the box's pixels, none of which is hidden. What is outside of the frame is not drawn.
    fn outline(&mut self, target: &BoundingBox) {
        let corners = (self.at(target.x, target.y), self.at(target.x + target.width, target.y + target.height));
        let bbox = Rectangle::with_corners(corners.0, corners.1 - Point::new_equal(1));
        let style = PrimitiveStyleBuilder::new().stroke_color(rgb(SMR)).stroke_width(OUTLINE);
        let style = style.stroke_alignment(StrokeAlignment::Outside).build();
        let [width, height] = self.size.map(|side| side * self.scale);
        let near = Rectangle::new(self.at(0.0, 0.0), Size::new(width, height)).offset(4);
        let Ok(()) = bbox.into_styled(style).draw(&mut self.canvas.clipped(&near));
    }

    fn caption(&mut self, number: usize, target: Option<&BoundingBox>) -> Result<()> {
        let top = 2 * MARGIN.1 + self.size[1] * self.scale;
        let end = self.text(MARGIN.0, top, &format!("frame {number}   "))?;
        if let Some(BoundingBox { x, y, width, height }) = target {
            self.canvas.text(end, i32::try_from(top)?, &format!("x {x}  y {y}  w {width}  h {height}"), SMR, FONT);
        }
        Ok(())
    }
}

/// Pixels of the frame between numbered lines and between all lines, where a pixel is `scale` wide in the picture.
fn steps(scale: u32) -> (u32, u32) {
    let round = [(5, 1), (10, 2), (20, 5), (50, 10), (100, 20)];
    round.into_iter().find(|(step, _)| step * scale >= APART).unwrap_or((100, 20))
}

/// A gray level that differs from `gray` by `contrast`.
fn contrasted(gray: u8, contrast: u8) -> u8 {
    if gray > u8::MAX / 2 { gray.saturating_sub(contrast) } else { gray.saturating_add(contrast) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(width: u16, height: u16, gray: u8) -> GrayFrame {
        GrayFrame { width, height, pixels: vec![gray; usize::from(width) * usize::from(height)] }
    }

    fn drawn(frame: &GrayFrame, target: Option<&str>) -> Canvas {
        let target = target.map(|target| target.parse().unwrap());
        let png = coordinates(frame, 1, target.as_ref()).unwrap();
        Canvas::decoded(&png)
    }

    /// The picture's pixel at the upper left corner of the frame's pixel.
    fn at(picture: &Canvas, scale: u32, x: u32, y: u32) -> [u8; 3] {
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
        for (gray, contrast) in (0..=u8::MAX).flat_map(|gray| [(gray, STRONG), (gray, FAINT)]) {
            let line = contrasted(gray, contrast);
            assert_eq!(line.abs_diff(gray), contrast, "{gray}: {line}");
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
                assert_eq!((picture.width, picture.height), expected, "{width}x{height}");
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
