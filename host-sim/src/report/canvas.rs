//! What pictures are drawn on, with the letters, lines and outlines of embedded-graphics.

use super::{Color, encode};
use crate::sequence::GrayFrame;
use anyhow::{Result, ensure};
use embedded_graphics::Drawable;
use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{Dimensions, OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::FONT_10X20;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::primitives::{Line, PointsIter, Primitive, PrimitiveStyle, Rectangle};
use embedded_graphics::text::{Baseline, Text};
use image::{GrayImage, Luma, RgbImage};
use std::convert::Infallible;

/// The letters of pictures.
pub(crate) const FONT: &MonoFont<'_> = &FONT_10X20;
pub(super) const WHITE: Color = [255; 3];
pub(crate) const BLACK: Color = [0; 3];
/// The ground of diagrams and of sheets.
pub(super) const PAPER: Color = [24; 3];

/// Red, green and blue. What is outside is not drawn.
pub(crate) struct Canvas(pub RgbImage);

/// Which parts of a line are drawn, in pixels along it.
#[derive(Clone, Copy)]
pub(super) struct Dashes {
    pub on: f64,
    pub off: f64,
    /// How long the first gap is.
    pub after: f64,
}

impl Dashes {
    pub const NONE: Self = Self { on: f64::MAX, off: 0.0, after: 0.0 };

    pub const fn new(on: f64, off: f64) -> Self {
        Self { on, off, after: 0.0 }
    }
}

impl Canvas {
    pub fn new(width: u32, height: u32, color: Color) -> Self {
        Self(RgbImage::from_pixel(width, height, image::Rgb(color)))
    }

    /// Writes `text` and tells where it ends.
    pub fn text(&mut self, left: i32, top: i32, text: &str, color: Color, font: &MonoFont<'_>) -> i32 {
        let style = MonoTextStyle::new(font, rgb(color));
        let Ok(end) = Text::with_baseline(text, Point::new(left, top), style, Baseline::Top).draw(self);
        end.x
    }

    pub fn fill(&mut self, area: &Rectangle, color: Color) {
        let Ok(()) = self.fill_solid(area, rgb(color));
    }

    /// Puts `pixels` there.
    pub(super) fn picture(&mut self, left: u32, top: u32, pixels: &RgbImage) {
        image::imageops::replace(&mut self.0, pixels, left.into(), top.into());
    }

    /// As PNG with a palette of the colors that are there, in which neighbours look alike.
    pub(super) fn png(&self) -> Result<Vec<u8>> {
        let mut palette: Vec<Color> = self.0.pixels().map(|pixel| pixel.0).collect();
        palette.sort_unstable();
        palette.dedup();
        ensure!(palette.len() <= 256, "a picture of {} colors: expected at most 256", palette.len());
        let index = |pixel: &image::Rgb<u8>| palette.partition_point(|color| *color < pixel.0).to_le_bytes()[0];
        encode::png(self.0.dimensions(), &self.0.pixels().map(index).collect::<Vec<_>>(), &palette)
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.0.width(), self.0.height())
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            let place = u32::try_from(at.x).ok().zip(u32::try_from(at.y).ok());
            if let Some(pixel) = place.and_then(|(x, y)| self.0.get_pixel_mut_checked(x, y)) {
                pixel.0 = [color.r(), color.g(), color.b()];
            }
        }
        Ok(())
    }

    /// Only what is in the picture is gone through: boxes may be far larger.
    fn fill_solid(&mut self, area: &Rectangle, color: Rgb888) -> Result<(), Infallible> {
        let seen = area.intersection(&self.bounding_box());
        self.draw_iter(seen.points().map(|point| Pixel(point, color)))
    }
}

pub(crate) const fn rgb([r, g, b]: Color) -> Rgb888 {
    Rgb888::new(r, g, b)
}

/// The width of `text` when it is written.
pub(super) fn width_of(text: &str) -> u32 {
    (0..).zip(text.chars()).map(|_| FONT.character_size.width).sum()
}

/// A line through `points`; dashes go on around the corners.
pub(super) fn line<D>(target: &mut D, points: &[(f64, f64)], width: u32, color: Color, dashes: Dashes)
where
    D: DrawTarget<Color = Rgb888, Error = Infallible>,
{
    let style = PrimitiveStyle::with_stroke(rgb(color), width);
    let mut before = -dashes.after;
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
                let Ok(()) = Line::new(at(start), at(end)).into_styled(style).draw(target);
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

pub(crate) fn gray_image(frame: &GrayFrame) -> GrayImage {
    let at = |x: u32, y: u32| frame.pixels[y as usize * usize::from(frame.width) + x as usize];
    GrayImage::from_fn(frame.width.into(), frame.height.into(), |x, y| Luma([at(x, y)]))
}

/// Half of the gray levels are enough for the eye, and noise makes up most of a file.
pub(super) fn coarse(gray: u8) -> Color {
    [gray / 2 * 2 + gray / 128; 3]
}

pub(super) fn coarse_image(gray: &GrayImage) -> RgbImage {
    RgbImage::from_fn(gray.width(), gray.height(), |x, y| image::Rgb(coarse(gray.get_pixel(x, y).0[0])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_go_on_around_the_corner() {
        let mut canvas = Canvas::new(30, 30, BLACK);
        line(&mut canvas, &[(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)], 1, WHITE, Dashes { on: 8.0, off: 8.0, after: 4.0 });
        let drawn = |x: u32, y: u32| canvas.0.get_pixel(x, y).0 == WHITE;
        assert_eq!([0, 3, 5, 11, 13, 19].map(|x| drawn(x, 0)), [false, false, true, true, false, false]);
        assert_eq!([1, 7, 9, 15, 17].map(|y| drawn(20, y)), [true, true, false, false, true]);
    }

    #[test]
    fn what_lies_outside_is_cut() {
        let mut canvas = Canvas::new(8, 8, BLACK);
        canvas.fill(&Rectangle::new(Point::new(-100_000, 6), Size::new(2_000_000_000, 2_000_000_000)), WHITE);
        assert_eq!(canvas.0.pixels().filter(|pixel| pixel.0 == WHITE).count(), 16);
        assert_eq!(canvas.text(-20, 2, "abc", WHITE, FONT), 10);
        assert!(canvas.png().unwrap().starts_with(b"\x89PNG"));
    }
}
