//! Boxes and lines of text, drawn over a frame.

use crate::colors::{BLACK, Color};
use crate::report::canvas::{Canvas, Dashes, line, rgb};
use embedded_graphics::Drawable;
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::mono_font::iso_8859_1::FONT_6X10;
use embedded_graphics::primitives::{Primitive, PrimitiveStyleBuilder, Rectangle, StrokeAlignment};
use smr_recordings::{BoundingBox, ColorFrame};

/// A frame that is drawn on.
pub struct Overlay(Canvas);

impl Overlay {
    pub fn new(ColorFrame { width, height, pixels }: ColorFrame) -> Self {
        Self(Canvas { width: width.into(), height: height.into(), pixels })
    }

    pub const fn size(&self) -> (u32, u32) {
        (self.0.width, self.0.height)
    }

    /// Red, green and blue of each pixel.
    pub fn rgb(&self) -> &[u8] {
        self.0.pixels.as_flattened()
    }

    /// Returns the width of lines in pixels. Large frames have wider lines, so that they are seen.
    fn dot(&self) -> u32 {
        self.0.width.min(self.0.height) / 240 + 1
    }

    /// Draws lines around the box, and a dark line outside for any ground. The box stays free: targets are small.
    pub fn outline(&mut self, target: &BoundingBox, color: Color) {
        let Some(rect) = target.to_rect() else { return };
        // Far outside the frame, nothing is seen anyway.
        let place = Point::new(rect.x.clamp(-100_000, 100_000), rect.y.clamp(-100_000, 100_000));
        let area = Rectangle::new(place, Size::new(rect.width.into(), rect.height.into()));
        let dot = self.dot();
        for (width, color) in [(dot + 1, BLACK), (dot, color)] {
            let style = PrimitiveStyleBuilder::new().stroke_color(rgb(color)).stroke_width(width);
            let Ok(()) = area.into_styled(style.stroke_alignment(StrokeAlignment::Outside).build()).draw(&mut self.0);
        }
    }

    /// Draws the edges of the box in dashes, because the target may not be there.
    pub fn dashed_outline(&mut self, target: &BoundingBox, color: Color) {
        let BoundingBox { x, y, width, height } = *target;
        let (right, bottom) = (x + width, y + height);
        if [x, y, right, bottom].iter().any(|edge| edge.is_nan() || edge.abs() > 100_000.0) {
            return;
        }
        let dot = self.dot();
        let corners = [(x, y), (right, y), (right, bottom), (x, bottom), (x, y)];
        let dash = f64::from(5 * dot);
        line(&mut self.0, &corners, dot + 1, BLACK, Dashes::NONE);
        line(&mut self.0, &corners, dot, color, Dashes::new(dash, dash));
    }

    /// Writes a line on a dark ground, in the upper left corner.
    pub fn label(&mut self, text: &str, color: Color) {
        let label = self.lettering(text, color);
        self.0.picture(0, 0, &label);
    }

    /// Writes a line on a dark ground above the box, or in it if there is no room above.
    pub fn label_box(&mut self, target: &BoundingBox, text: &str, color: Color) {
        let label = self.lettering(text, color);
        let gap = f64::from(label.height + self.dot());
        let top = if target.y >= gap { target.y - gap } else { target.y };
        let most = |whole: u32, part: u32| f64::from(whole.saturating_sub(part));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // inside the frame
        let place = |at: f64, most: f64| at.min(most).max(0.0) as u32;
        let left = place(target.x, most(self.0.width, label.width));
        self.0.picture(left, place(top, most(self.0.height, label.height)), &label);
    }

    fn lettering(&self, text: &str, color: Color) -> Canvas {
        let Size { width, height } = FONT_6X10.character_size;
        let mut label = Canvas::new(text.chars().map(|_| width).sum::<u32>() + 4, height + 2, BLACK);
        label.text(2, 1, text, color, &FONT_6X10);
        label.nearest(label.width * self.dot(), label.height * self.dot())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::{GREEN, RED, WHITE};

    fn plain() -> Overlay {
        Overlay::new(ColorFrame { width: 20, height: 16, pixels: vec![[100; 3]; 320] })
    }

    const GROUND: Color = [100; 3];

    #[test]
    fn an_outline_is_around_the_box() {
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: 4.2, y: 5.0, width: 6.0, height: 4.0 }, GREEN);
        for (x, y) in [(3, 4), (10, 4), (3, 9), (10, 9), (6, 4)] {
            assert_eq!(overlay.0.at(x, y), GREEN, "{x},{y}");
        }
        assert_eq!((overlay.0.at(2, 3), overlay.0.at(11, 10)), (BLACK, BLACK));
        for (x, y) in [(4, 5), (9, 8), (12, 11)] {
            assert_eq!(overlay.0.at(x, y), GROUND, "{x},{y}");
        }
        let green = overlay.0.pixels.iter().filter(|&&pixel| pixel == GREEN).count();
        assert_eq!((green, overlay.0.at(0, 0)), (2 * 8 + 2 * 4, GROUND));
    }

    #[test]
    fn what_lies_outside_is_cut() {
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: -5.0, y: -5.0, width: 1000.0, height: 8.0 }, RED);
        assert_eq!((overlay.0.at(0, 3), overlay.0.at(19, 3), overlay.0.at(0, 0)), (RED, RED, GROUND));
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: 1e300, y: f64::NAN, width: 5.0, height: 8.0 }, RED);
        overlay.outline(&BoundingBox { x: 2e9, y: -2e9, width: 65535.0, height: 65535.0 }, RED);
        assert!(overlay.0.pixels.iter().all(|&pixel| pixel == GROUND));
        overlay.label("WIDER THAN THE FRAME", WHITE);
        assert_eq!(overlay.0.at(19, 0), BLACK);
    }

    #[test]
    fn dashes_leave_gaps_and_a_label_stays_in_the_frame() {
        let mut overlay = plain();
        overlay.dashed_outline(&BoundingBox { x: 4.0, y: 5.0, width: 12.0, height: 8.0 }, RED);
        assert_eq!((overlay.0.at(5, 5), overlay.0.at(11, 5), overlay.0.at(8, 8)), (RED, BLACK, GROUND));
        overlay.dashed_outline(&BoundingBox { x: 1e300, y: f64::NAN, width: 5.0, height: 8.0 }, RED);
        overlay.label_box(&BoundingBox { x: 1e9, y: -1e9, width: 5.0, height: 5.0 }, "a", RED);
        assert_eq!((overlay.0.at(19, 0), overlay.0.at(0, 0)), (BLACK, GROUND));
    }
}
