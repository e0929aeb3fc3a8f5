//! Boxes and a line of text, drawn over a frame.

use crate::report::Color;
use crate::report::canvas::{BLACK, Canvas, gray_image, rgb};
use crate::sequence::{BoundingBox, GrayFrame};
use embedded_graphics::Drawable;
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::mono_font::iso_8859_1::FONT_6X10;
use embedded_graphics::primitives::{Primitive, PrimitiveStyleBuilder, Rectangle, StrokeAlignment};
use image::imageops::{FilterType, replace, resize};
use image::{DynamicImage, RgbImage};

pub const WHITE: Color = [255; 3];
pub const GREEN: Color = [40, 230, 100];
pub const AMBER: Color = [255, 190, 0];
pub const RED: Color = [255, 70, 60];
/// What can be drawn with, beside gray levels.
pub(super) const INKS: [Color; 3] = [GREEN, AMBER, RED];

/// A frame that is drawn on.
pub struct Overlay(Canvas);

impl Overlay {
    #[must_use]
    pub fn new(frame: &GrayFrame) -> Self {
        Self(Canvas(DynamicImage::from(gray_image(frame)).into_rgb8()))
    }

    #[must_use]
    pub const fn pixels(&self) -> &RgbImage {
        &self.0.0
    }

    /// How large a dot of what is drawn is, so that it is seen in large frames, too.
    fn dot(&self) -> u32 {
        self.pixels().width().min(self.pixels().height()) / 240 + 1
    }

    /// Lines around the box, a dark one outside so that they are seen on any ground. What is in the box stays to be seen: targets are small.
    pub fn outline(&mut self, target: &BoundingBox, color: Color) {
        let Some(rect) = target.to_rect() else { return };
        // Far outside nothing is seen anyway.
        let place = Point::new(rect.x.clamp(-100_000, 100_000), rect.y.clamp(-100_000, 100_000));
        let area = Rectangle::new(place, Size::new(rect.width.into(), rect.height.into()));
        let dot = self.dot();
        for (width, color) in [(dot + 1, BLACK), (dot, color)] {
            let style = PrimitiveStyleBuilder::new().stroke_color(rgb(color)).stroke_width(width);
            let Ok(()) = area.into_styled(style.stroke_alignment(StrokeAlignment::Outside).build()).draw(&mut self.0);
        }
    }

    /// A line on a dark ground, in the upper left corner.
    pub fn label(&mut self, text: &str, color: Color) {
        let letters = (0..).zip(text.chars()).map(|_| FONT_6X10.character_size.width);
        let mut label = Canvas::new(letters.sum::<u32>() + 4, FONT_6X10.character_size.height + 2, BLACK);
        label.text(2, 1, text, color, &FONT_6X10);
        let (width, height) = (label.0.width() * self.dot(), label.0.height() * self.dot());
        replace(&mut self.0.0, &resize(&label.0, width, height, FilterType::Nearest), 0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> Overlay {
        Overlay::new(&GrayFrame { width: 20, height: 16, pixels: vec![100; 320] })
    }

    fn at(overlay: &Overlay, x: u32, y: u32) -> Color {
        overlay.pixels().get_pixel(x, y).0
    }

    const GROUND: Color = [100; 3];

    #[test]
    fn an_outline_is_around_the_box() {
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: 4.2, y: 5.0, width: 6.0, height: 4.0 }, GREEN);
        for (x, y) in [(3, 4), (10, 4), (3, 9), (10, 9), (6, 4)] {
            assert_eq!(at(&overlay, x, y), GREEN, "{x},{y}");
        }
        assert_eq!((at(&overlay, 2, 3), at(&overlay, 11, 10)), (BLACK, BLACK));
        for (x, y) in [(4, 5), (9, 8), (12, 11)] {
            assert_eq!(at(&overlay, x, y), GROUND, "{x},{y}");
        }
        let green = overlay.pixels().pixels().filter(|pixel| pixel.0 == GREEN).count();
        assert_eq!((green, at(&overlay, 0, 0)), (2 * 8 + 2 * 4, GROUND));
    }

    #[test]
    fn what_lies_outside_is_cut() {
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: -5.0, y: -5.0, width: 1000.0, height: 8.0 }, RED);
        assert_eq!((at(&overlay, 0, 3), at(&overlay, 19, 3), at(&overlay, 0, 0)), (RED, RED, GROUND));
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: 1e300, y: f64::NAN, width: 5.0, height: 8.0 }, RED);
        overlay.outline(&BoundingBox { x: 2e9, y: -2e9, width: 65535.0, height: 65535.0 }, RED);
        assert!(overlay.pixels().pixels().all(|pixel| pixel.0 == GROUND));
        overlay.label("WIDER THAN THE FRAME", WHITE);
        assert_eq!(at(&overlay, 19, 0), BLACK);
    }
}
