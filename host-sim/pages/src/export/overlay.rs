//! Draws boxes and lines of text on a frame.

use crate::colors::{BLACK, Color};
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoTextStyle, iso_8859_1::FONT_6X10};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::primitives::{
    Line, Primitive, PrimitiveStyle, PrimitiveStyleBuilder, Rectangle, StrokeAlignment,
};
use embedded_graphics::text::{Baseline, Text};
use embedded_graphics::{Drawable, Pixel, draw_target::DrawTarget};
use smr_recordings::{BoundingBox, ColorFrame};
use std::convert::Infallible;

/// An RGB frame to draw on, which clips all drawings.
pub struct Overlay {
    width: u32,
    height: u32,
    pixels: Vec<Color>,
}

impl Overlay {
    pub fn new(ColorFrame { width, height, pixels }: ColorFrame) -> Self {
        Self { width: width.into(), height: height.into(), pixels }
    }

    pub const fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    pub fn rgb(&self) -> &[u8] {
        self.pixels.as_flattened()
    }

    fn at(&self, x: u32, y: u32) -> Color {
        self.pixels[(y * self.width + x) as usize]
    }

    fn set(&mut self, x: u32, y: u32, color: Color) {
        if x < self.width && y < self.height {
            self.pixels[(y * self.width + x) as usize] = color;
        }
    }

    /// Returns the width of lines in pixels, larger in large frames so that lines stay visible.
    fn dot(&self) -> u32 {
        self.width.min(self.height) / 240 + 1
    }

    /// Draws an outline outside the box, so that it hides no small target. A dark border makes it visible anywhere.
    pub fn outline(&mut self, target: &BoundingBox, color: Color) {
        let Some(rect) = target.to_rect() else { return };
        // Clamping prevents overflow. It moves only boxes far outside the frame, whose lines are invisible anyway.
        let place = Point::new(rect.x.clamp(-100_000, 100_000), rect.y.clamp(-100_000, 100_000));
        let area = Rectangle::new(place, Size::new(rect.width.into(), rect.height.into()));
        let dot = self.dot();
        for (width, color) in [(dot + 1, BLACK), (dot, color)] {
            let style = PrimitiveStyleBuilder::new().stroke_color(rgb(color)).stroke_width(width);
            let Ok(()) = area.into_styled(style.stroke_alignment(StrokeAlignment::Outside).build()).draw(self);
        }
    }

    /// Draws the box's edges with dashes, for a target that may not be there.
    pub fn dashed_outline(&mut self, target: &BoundingBox, color: Color) {
        let BoundingBox { x, y, width, height } = *target;
        let (right, bottom) = (x + width, y + height);
        if [x, y, right, bottom].iter().any(|edge| edge.is_nan() || edge.abs() > 100_000.0) {
            return;
        }
        let dot = self.dot();
        let corners = [(x, y), (right, y), (right, bottom), (x, bottom), (x, y)];
        self.line(&corners, dot + 1, BLACK, LONGEST);
        self.line(&corners, dot, color, f64::from(5 * dot));
    }

    /// Draws a line through `points`. Dashes and gaps have the same length, and continue around corners.
    fn line(&mut self, points: &[(f64, f64)], width: u32, color: Color, dash: f64) {
        let style = PrimitiveStyle::with_stroke(rgb(color), width);
        let mut before = 0.0;
        for ends in points.windows(2) {
            let (from, to) = (ends[0], ends[1]);
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            let at = |along: f64| {
                let part = if length > 0.0 { (along - before) / length } else { 0.0 };
                Point::new(pixel(from.0 + (to.0 - from.0) * part), pixel(from.1 + (to.1 - from.1) * part))
            };
            let mut next = (before / (2.0 * dash)).floor() * 2.0 * dash;
            while next <= before + length {
                let (start, end) = (next.max(before), (next + dash - 1.0).min(before + length));
                if start <= end {
                    let Ok(()) = Line::new(at(start), at(end)).into_styled(style).draw(self);
                }
                next += 2.0 * dash;
            }
            before += length;
        }
    }

    /// Draws the path through `points`.
    pub fn path(&mut self, points: &[(f64, f64)], color: Color) {
        if points.iter().all(|(x, y)| x.abs() < 100_000.0 && y.abs() < 100_000.0) {
            self.line(points, self.dot(), color, LONGEST);
        }
    }

    /// Returns a part of the frame: `size` pixels around `centre`, moved and made smaller so that it lies in the frame. The
    /// width and the height are even, as videos need, unless the frame has a single column or row.
    pub fn part(&self, centre: (f64, f64), size: (u32, u32)) -> Self {
        let even = |wanted: u32, most: u32| (wanted.min(most) & !1).max(1);
        let (width, height) = (even(size.0, self.width), even(size.1, self.height));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates, and is cut
        let first =
            |centre: f64, size: u32, most: u32| ((centre - f64::from(size) / 2.0).round() as u32).min(most - size);
        let (left, top) = (first(centre.0, width, self.width), first(centre.1, height, self.height));
        let pixels = (top..top + height).flat_map(|y| (left..left + width).map(move |x| self.at(x, y))).collect();
        Self { width, height, pixels }
    }

    pub fn label(&mut self, text: &str, color: Color) {
        let label = lettering(text, color);
        self.image(0, 0, &label);
    }

    /// Writes a line of text on a dark background above the box, or in it if there is no space above.
    pub fn label_box(&mut self, target: &BoundingBox, text: &str, color: Color) {
        let label = lettering(text, color);
        let (width, height) = (label.width * self.dot(), label.height * self.dot());
        let gap = f64::from(height + self.dot());
        let top = if target.y >= gap { target.y - gap } else { target.y };
        let most = |whole: u32, part: u32| f64::from(whole.saturating_sub(part));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // inside the frame
        let place = |at: f64, most: f64| at.min(most).max(0.0) as u32;
        self.image(place(target.x, most(self.width, width)), place(top, most(self.height, height)), &label);
    }

    fn image(&mut self, left: u32, top: u32, image: &Self) {
        let dot = self.dot();
        for y in 0..image.height * dot {
            (0..image.width * dot).for_each(|x| self.set(left + x, top + y, image.at(x / dot, y / dot)));
        }
    }
}

/// Length of a dash that is longer than any line, which makes the line solid.
const LONGEST: f64 = 1e9;

fn lettering(text: &str, color: Color) -> Overlay {
    let Size { width, height } = FONT_6X10.character_size;
    let (width, height) = (text.chars().map(|_| width).sum::<u32>() + 4, height + 2);
    let mut label = Overlay { width, height, pixels: vec![BLACK; (width * height) as usize] };
    let style = MonoTextStyle::new(&FONT_6X10, rgb(color));
    let Ok(_) = Text::with_baseline(text, Point::new(2, 1), style, Baseline::Top).draw(&mut label);
    label
}

#[allow(clippy::cast_possible_truncation)] // it saturates
fn pixel(place: f64) -> i32 {
    place.round() as i32
}

const fn rgb([r, g, b]: Color) -> Rgb888 {
    Rgb888::new(r, g, b)
}

impl OriginDimensions for Overlay {
    fn size(&self) -> Size {
        Size::new(self.width, self.height)
    }
}

impl DrawTarget for Overlay {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            if let (Ok(x), Ok(y)) = (u32::try_from(at.x), u32::try_from(at.y)) {
                self.set(x, y, [color.r(), color.g(), color.b()]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::{WHITE, of_target};

    const GREEN: Color = of_target(4);
    const RED: Color = of_target(6);

    fn plain() -> Overlay {
        Overlay::new(ColorFrame { width: 20, height: 16, pixels: vec![[100; 3]; 320] })
    }

    const GROUND: Color = [100; 3];

    #[test]
    fn an_outline_is_around_the_box() {
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: 4.2, y: 5.0, width: 6.0, height: 4.0 }, GREEN);
        for (x, y) in [(3, 4), (10, 4), (3, 9), (10, 9), (6, 4)] {
            assert_eq!(overlay.at(x, y), GREEN, "{x},{y}");
        }
        assert_eq!((overlay.at(2, 3), overlay.at(11, 10)), (BLACK, BLACK));
        for (x, y) in [(4, 5), (9, 8), (12, 11)] {
            assert_eq!(overlay.at(x, y), GROUND, "{x},{y}");
        }
        let green = overlay.pixels.iter().filter(|&&pixel| pixel == GREEN).count();
        assert_eq!((green, overlay.at(0, 0)), (2 * 8 + 2 * 4, GROUND));
    }

    #[test]
    fn what_lies_outside_is_cut() {
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: -5.0, y: -5.0, width: 1000.0, height: 8.0 }, RED);
        assert_eq!((overlay.at(0, 3), overlay.at(19, 3), overlay.at(0, 0)), (RED, RED, GROUND));
        let mut overlay = plain();
        overlay.outline(&BoundingBox { x: 1e300, y: f64::NAN, width: 5.0, height: 8.0 }, RED);
        overlay.outline(&BoundingBox { x: 2e9, y: -2e9, width: 65535.0, height: 65535.0 }, RED);
        assert!(overlay.pixels.iter().all(|&pixel| pixel == GROUND));
        overlay.label("WIDER THAN THE FRAME", WHITE);
        assert_eq!(overlay.at(19, 0), BLACK);
    }

    #[test]
    fn a_part_lies_in_the_frame_and_a_path_goes_through_its_points() {
        let mut overlay = plain();
        overlay.path(&[(2.0, 3.0), (2.0, 9.0), (8.0, 9.0)], GREEN);
        assert_eq!(
            [(2, 3), (2, 6), (5, 9), (8, 9), (9, 9)].map(|(x, y)| overlay.at(x, y) == GREEN),
            [true, true, true, true, false]
        );
        overlay.path(&[(f64::NAN, 3.0), (1e300, 9.0)], RED);
        let part = overlay.part((3.0, 9.0), (7, 5));
        assert_eq!((part.size(), part.at(2, 2), part.at(3, 2), part.at(5, 3)), ((6, 4), GREEN, GREEN, GROUND));
        for centre in [(-50.0, -50.0), (1e300, f64::NAN), (10.0, 8.0)] {
            assert_eq!((overlay.part(centre, (99, 9)).size(), overlay.part(centre, (0, 1)).size()), ((20, 8), (1, 1)));
        }
    }

    #[test]
    fn dashes_go_on_around_the_corner() {
        let mut overlay = Overlay { width: 30, height: 30, pixels: vec![BLACK; 900] };
        overlay.line(&[(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)], 1, WHITE, 8.0);
        let drawn = |x: u32, y: u32| overlay.at(x, y) == WHITE;
        assert_eq!([0, 7, 9, 15, 17, 19].map(|x| drawn(x, 0)), [true, true, false, false, true, true]);
        assert_eq!([2, 5, 11, 13, 19].map(|y| drawn(20, y)), [true, false, false, true, true]);
    }

    #[test]
    fn dashes_leave_gaps_and_a_label_stays_in_the_frame() {
        let mut overlay = plain();
        overlay.dashed_outline(&BoundingBox { x: 4.0, y: 5.0, width: 12.0, height: 8.0 }, RED);
        assert_eq!((overlay.at(5, 5), overlay.at(11, 5), overlay.at(8, 8)), (RED, BLACK, GROUND));
        overlay.dashed_outline(&BoundingBox { x: 1e300, y: f64::NAN, width: 5.0, height: 8.0 }, RED);
        overlay.label_box(&BoundingBox { x: 1e9, y: -1e9, width: 5.0, height: 5.0 }, "a", RED);
        assert_eq!((overlay.at(19, 0), overlay.at(0, 0)), (BLACK, GROUND));
    }
}
