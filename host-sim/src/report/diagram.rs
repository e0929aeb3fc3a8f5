//! Lines, words and pictures as a file, SVG or PNG: what diagrams and figures are drawn with.

use super::canvas::{self, Canvas, Dashes, FONT, PAPER, WHITE, coarse, coarse_image, gray_image, pixel};
use super::{Color, encode, pictures};
use crate::sequence::GrayFrame;
use anyhow::{Result, bail};
use embedded_graphics::geometry::Point;
use embedded_graphics::primitives::Rectangle;
use image::imageops::{FilterType, resize};
use image::{Rgb, RgbImage};
use minijinja::value::Serde;
use minijinja::{Environment, context};
use serde::ser::Error as _;
use serde::{Serialize, Serializer};
use std::path::Path;

pub(super) const SIZE: (u32, u32) = (760, 460);
/// How the diagram is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Form {
    Png,
    Svg,
}

impl Form {
    /// By the name of the file.
    ///
    /// # Errors
    /// It ends in neither.
    pub fn of(file: &Path) -> Result<Self> {
        match file.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            _ => bail!("{}: a plot is written as .svg or .png", file.display()),
        }
    }

    /// The file's bytes, of a diagram of the usual size.
    ///
    /// # Errors
    /// The encoder's; no diagram is known that it refuses.
    pub fn draw(self, marks: &[Mark]) -> Result<Vec<u8>> {
        self.draw_sized(SIZE, marks)
    }

    /// The same of any width and height.
    ///
    /// # Errors
    /// As [`Form::draw`].
    pub fn draw_sized(self, size: (u32, u32), marks: &[Mark]) -> Result<Vec<u8>> {
        match self {
            Self::Svg => Ok(svg(size, marks)?.into_bytes()),
            Self::Png => png(size, marks),
        }
    }

    /// What the name of such a file ends in.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Png => "png",
        }
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Stroke {
    Solid,
    /// As thick, with gaps.
    Dashed,
    /// Thin, with short gaps.
    Dotted,
}

/// Pixels of a picture.
pub enum Pixels {
    /// A frame, which may be made smaller or larger.
    Frame(GrayFrame),
    /// Gray levels, of which each stays to be seen.
    Patch { size: (u16, u16), levels: Vec<u8> },
    /// Differences, those that count being green; brighter than they are, as most are small.
    Differences { size: (u16, u16), levels: Vec<u8>, alpha: u16 },
}

/// What is drawn, in either form.
#[derive(Serialize)]
#[serde(tag = "kind")]
pub enum Mark {
    Line {
        points: Vec<(f64, f64)>,
        color: Color,
        stroke: Stroke,
    },
    /// A filled rectangle.
    Area {
        x: f64,
        y: f64,
        width: f64,
        height: f64,
        color: Color,
    },
    /// `x` and `y` are the upper left corner, `width` and `height` what it is stretched to.
    Picture {
        x: f64,
        y: f64,
        width: f64,
        height: f64,
        pixels: Pixels,
    },
    /// `x` is the left end, the middle or the right end, by `place` (0, 0.5, 1); `y` is the middle.
    Words {
        x: f64,
        y: f64,
        place: f64,
        words: String,
        color: Option<Color>,
    },
}

impl Mark {
    pub(super) fn words(x: f64, y: f64, place: f64, words: impl Into<String>, color: Option<Color>) -> Self {
        Self::Words { x, y, place, words: words.into(), color }
    }
}

fn svg((width, height): (u32, u32), marks: &[Mark]) -> Result<String> {
    let mut templates = Environment::new();
    templates.add_template("diagram.svg", include_str!("diagram.svg"))?;
    Ok(templates.get_template("diagram.svg")?.render(context! { width, height, marks => Serde(marks) })?)
}

/// As a URI, and whether it may be smoothed.
impl Serialize for Pixels {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.embedded().map_err(S::Error::custom)?.serialize(serializer)
    }
}

impl Pixels {
    pub(super) const fn size(&self) -> (u16, u16) {
        match self {
            Self::Frame(frame) => (frame.width, frame.height),
            Self::Patch { size, .. } | Self::Differences { size, .. } => *size,
        }
    }

    fn embedded(&self) -> Result<(String, bool)> {
        if let Self::Frame(frame) = self {
            return Ok((encode::data_uri("image/jpeg", &encode::jpeg(frame)?), true));
        }
        Ok((encode::data_uri("image/png", &self.png()?), false))
    }

    pub(super) fn png(&self) -> Result<Vec<u8>> {
        Canvas(self.image()).png()
    }

    fn image(&self) -> RgbImage {
        let (width, height) = self.size();
        RgbImage::from_fn(width.into(), height.into(), |x, y| Rgb(self.color((y * u32::from(width) + x) as usize)))
    }

    fn color(&self, at: usize) -> Color {
        match self {
            Self::Frame(GrayFrame { pixels: levels, .. }) | Self::Patch { levels, .. } => coarse(levels[at]),
            Self::Differences { levels, alpha, .. } => match levels[at] {
                level if u16::from(level) < *alpha => pictures::counting_color(level),
                level => coarse(pictures::gray(level)),
            },
        }
    }

    /// At another size: smooth where it is a frame that does not become a whole number of times as large.
    fn sized(&self, width: u32, height: u32) -> RgbImage {
        let whole = |side: u32, own: u16| side.is_multiple_of(u32::from(own).max(1));
        let sharp = whole(width, self.size().0) && whole(height, self.size().1);
        match self {
            Self::Frame(frame) if !sharp => {
                coarse_image(&resize(&gray_image(frame), width, height, FilterType::Triangle))
            }
            _ => resize(&self.image(), width, height, FilterType::Nearest),
        }
    }
}

fn png((width, height): (u32, u32), marks: &[Mark]) -> Result<Vec<u8>> {
    let mut canvas = Canvas::new(width, height, PAPER);
    for mark in marks {
        match mark {
            Mark::Line { points, color, stroke } => {
                let (thick, dashes) = match stroke {
                    Stroke::Solid => (2, Dashes::NONE),
                    Stroke::Dashed => (2, Dashes::new(6.0, 6.0)),
                    Stroke::Dotted => (1, Dashes::new(3.0, 4.0)),
                };
                canvas::line(&mut canvas, points, thick, *color, dashes);
            }
            Mark::Words { x, y, place, words, color } => {
                let left = x - place * f64::from(canvas::width_of(words));
                let top = y - f64::from(FONT.character_size.height / 2);
                canvas.text(pixel(left), pixel(top), words, color.unwrap_or(WHITE), FONT);
            }
            Mark::Area { x, y, width, height, color } => {
                let corners = (Point::new(pixel(*x), pixel(*y)), Point::new(pixel(x + width), pixel(y + height)));
                canvas.fill(&Rectangle::with_corners(corners.0, corners.1 - Point::new_equal(1)), *color);
            }
            Mark::Picture { x, y, width, height, pixels } => {
                let side = |length: &f64| pixel(*length).max(1).unsigned_abs();
                let place = |at: &f64| pixel(*at).max(0).unsigned_abs();
                canvas.picture(place(x), place(y), &pixels.sized(side(width), side(height)));
            }
        }
    }
    canvas.png()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_files_are_refused() {
        assert_eq!(Form::of(Path::new("a.png")).unwrap(), Form::Png);
        assert!(Form::of(Path::new("a.gif")).unwrap_err().to_string().contains("a.gif: a plot is written as"));
    }
}
