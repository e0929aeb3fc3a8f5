//! A picture under way: letters, lines and outlines by embedded-graphics.

use crate::colors::Color;
use crate::encode;
use anyhow::{Result, ensure};
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{Dimensions, OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::FONT_10X20;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::primitives::{Line, PointsIter, Primitive, PrimitiveStyle, Rectangle};
use embedded_graphics::text::{Baseline, Text};
use embedded_graphics::{Drawable, Pixel};
use smr_recordings::GrayFrame;
use std::convert::Infallible;

pub const FONT: &MonoFont<'_> = &FONT_10X20;

/// A picture in red, green and blue, row by row. What is outside is not drawn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Canvas {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<Color>,
}

/// Pattern of a dashed line, in pixels along it.
#[derive(Clone, Copy)]
pub(crate) struct Dashes {
    pub on: f64,
    pub off: f64,
}

impl Dashes {
    pub const NONE: Self = Self { on: f64::MAX, off: 0.0 };

    pub const fn new(on: f64, off: f64) -> Self {
        Self { on, off }
    }
}

impl Canvas {
    pub fn new(width: u32, height: u32, color: Color) -> Self {
        Self { width, height, pixels: vec![color; width as usize * height as usize] }
    }

    /// A picture with the color of each pixel by its place in the row and its row.
    pub(super) fn from_fn(width: u32, height: u32, color: impl Fn(u32, u32) -> Color) -> Self {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| color(x, y)).collect();
        Self { width, height, pixels }
    }

    pub fn of(frame: &GrayFrame) -> Self {
        let pixels = frame.pixels.iter().map(|&gray| [gray; 3]).collect();
        Self { width: frame.width.into(), height: frame.height.into(), pixels }
    }

    pub fn at(&self, x: u32, y: u32) -> Color {
        self.pixels[(y * self.width + x) as usize]
    }

    /// In another size, by the nearest pixel: whole factors stay sharp.
    pub fn nearest(&self, width: u32, height: u32) -> Self {
        Self::from_fn(width, height, |x, y| self.at(x * self.width / width, y * self.height / height))
    }

    pub(super) fn set(&mut self, x: u32, y: u32, color: Color) {
        if x < self.width && y < self.height {
            self.pixels[(y * self.width + x) as usize] = color;
        }
    }

    pub fn text(&mut self, left: i32, top: i32, text: &str, color: Color, font: &MonoFont<'_>) {
        let style = MonoTextStyle::new(font, rgb(color));
        let Ok(_) = Text::with_baseline(text, Point::new(left, top), style, Baseline::Top).draw(self);
    }

    pub fn fill(&mut self, area: &Rectangle, color: Color) {
        let Ok(()) = self.fill_solid(area, rgb(color));
    }

    pub fn picture(&mut self, left: u32, top: u32, picture: &Self) {
        for (y, x) in (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| (y, x))) {
            self.set(left + x, top + y, picture.at(x, y));
        }
    }

    /// As PNG with a palette of the colors that are there, in which neighbours look alike.
    pub(super) fn png(&self) -> Result<Vec<u8>> {
        let mut palette = self.pixels.clone();
        palette.sort_unstable();
        palette.dedup();
        ensure!(palette.len() <= 256, "a picture of {} colors: expected at most 256", palette.len());
        let index = |pixel: &Color| palette.partition_point(|color| color < pixel).to_le_bytes()[0];
        encode::palette_png((self.width, self.height), &self.pixels.iter().map(index).collect::<Vec<_>>(), &palette)
    }
}

/// A PNG that was written, to be looked at by tests.
#[cfg(test)]
impl Canvas {
    pub fn decoded(png: &[u8]) -> Self {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        let decoded = reader.next_frame(&mut samples).unwrap();
        let pixels = match decoded.color_type {
            png::ColorType::Rgb => samples.as_chunks().0.to_vec(),
            png::ColorType::Grayscale => samples.iter().map(|&gray| [gray; 3]).collect(),
            other => panic!("{other:?}"),
        };
        Self { width: decoded.width, height: decoded.height, pixels }
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.width, self.height)
    }
}

impl DrawTarget for Canvas {
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

    /// Visits only the pixels of the picture: boxes may be far larger.
    fn fill_solid(&mut self, area: &Rectangle, color: Rgb888) -> Result<(), Infallible> {
        let seen = area.intersection(&self.bounding_box());
        self.draw_iter(seen.points().map(|point| Pixel(point, color)))
    }
}

pub(crate) const fn rgb([r, g, b]: Color) -> Rgb888 {
    Rgb888::new(r, g, b)
}

pub(super) fn width_of(text: &str) -> u32 {
    (0..).zip(text.chars()).map(|_| FONT.character_size.width).sum()
}

/// A line through `points`; dashes go on around the corners.
pub(crate) fn line(canvas: &mut Canvas, points: &[(f64, f64)], width: u32, color: Color, dashes: Dashes) {
    let style = PrimitiveStyle::with_stroke(rgb(color), width);
    let mut before = 0.0;
    for ends in points.windows(2) {
        let (from, to) = (ends[0], ends[1]);
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let at = |along: f64| {
            let part = if length > 0.0 { (along - before) / length } else { 0.0 };
            Point::new(pixel(from.0 + (to.0 - from.0) * part), pixel(from.1 + (to.1 - from.1) * part))
        };
        let period = dashes.on + dashes.off;
        let mut dash = (before / period).floor() * period;
        while dash <= before + length {
            let (start, end) = (dash.max(before), (dash + dashes.on - 1.0).min(before + length));
            if start <= end {
                let Ok(()) = Line::new(at(start), at(end)).into_styled(style).draw(canvas);
            }
            dash += period;
        }
        before += length;
    }
}

#[allow(clippy::cast_possible_truncation)] // it saturates
pub(super) fn pixel(place: f64) -> i32 {
    place.round() as i32
}

/// Half of the gray levels are enough for the eye, and noise makes up most of a file.
pub(super) fn coarse(gray: u8) -> Color {
    [gray / 2 * 2 + gray / 128; 3]
}

/// The frame with fewer gray levels.
pub(super) fn coarse_frame(frame: &GrayFrame) -> Canvas {
    let mut canvas = Canvas::of(frame);
    canvas.pixels.iter_mut().for_each(|pixel| *pixel = coarse(pixel[0]));
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::{BLACK, WHITE};

    #[test]
    fn dashes_go_on_around_the_corner() {
        let mut canvas = Canvas::new(30, 30, BLACK);
        line(&mut canvas, &[(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)], 1, WHITE, Dashes::new(8.0, 8.0));
        let drawn = |x: u32, y: u32| canvas.at(x, y) == WHITE;
        assert_eq!([0, 7, 9, 15, 17, 19].map(|x| drawn(x, 0)), [true, true, false, false, true, true]);
        assert_eq!([2, 5, 11, 13, 19].map(|y| drawn(20, y)), [true, false, false, true, true]);
    }

    #[test]
    fn what_lies_outside_is_cut() {
        let mut canvas = Canvas::new(8, 8, BLACK);
        canvas.fill(&Rectangle::new(Point::new(-100_000, 6), Size::new(2_000_000_000, 2_000_000_000)), WHITE);
        assert_eq!(canvas.pixels.iter().filter(|&&pixel| pixel == WHITE).count(), 16);
        canvas.text(-20, 2, "abc", WHITE, FONT);
        assert!(canvas.png().unwrap().starts_with(b"\x89PNG"));
    }
}
