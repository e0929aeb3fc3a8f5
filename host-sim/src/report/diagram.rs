//! Lines, words and pictures as a file, SVG or PNG: what diagrams and figures are drawn with.

use super::escaped::escaped;
use super::picture::{Canvas, WHITE, full_palette, ink};
use super::{Color, color_of, encode, font, pictures};
use crate::sequence::{GrayFrame, resized};
use anyhow::{Result, bail};
use smr_core::State;
use std::fmt::Write as _;
use std::path::Path;

pub(super) const SIZE: (u32, u32) = (760, 460);
/// What the lines are drawn in.
pub(super) const LEFT: f64 = 70.0;
pub(super) const RIGHT: f64 = 640.0;
pub(super) const TOP: f64 = 44.0;
pub(super) const BOTTOM: f64 = 400.0;
pub(super) const GRID: Color = color_of(State::Tracking);

/// How the diagram is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Svg,
    Png,
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

fn svg((width, height): (u32, u32), marks: &[Mark]) -> Result<String> {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"14\"><rect width=\"{width}\" height=\"{height}\" fill=\"#181818\"/>\n"
    );
    let hex = |[r, g, b]: Color| format!("#{r:02x}{g:02x}{b:02x}");
    for mark in marks {
        // Writing to a String cannot fail.
        let _ = match mark {
            Mark::Line { points, color, stroke } => {
                let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
                let (dashes, width) = match stroke {
                    Stroke::Solid => ("", 2),
                    Stroke::Dashed => (" stroke-dasharray=\"6 6\"", 2),
                    Stroke::Dotted => (" stroke-dasharray=\"3 4\"", 1),
                };
                let (points, color) = (points.join(" "), hex(*color));
                writeln!(
                    svg,
                    "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"{dashes}/>"
                )
            }
            Mark::Words { x, y, place, words, color } => {
                let anchor = if *place == 0.0 {
                    "start"
                } else if *place == 1.0 {
                    "end"
                } else {
                    "middle"
                };
                let (y, color, words) = (y + 5.0, hex(color.unwrap_or([255; 3])), escaped(words));
                writeln!(
                    svg,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{color}\">{words}</text>"
                )
            }
            Mark::Area { x, y, width, height, color } => {
                let color = hex(*color);
                writeln!(
                    svg,
                    "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{color}\"/>"
                )
            }
            Mark::Picture { x, y, width, height, pixels } => {
                let (href, smooth) = pixels.embedded()?;
                let sharp = if smooth { "" } else { " style=\"image-rendering:pixelated\"" };
                writeln!(
                    svg,
                    "<image x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
                     preserveAspectRatio=\"none\"{sharp} href=\"{href}\"/>"
                )
            }
        };
    }
    Ok(svg + "</svg>\n")
}

impl Pixels {
    pub(super) const fn size(&self) -> (u16, u16) {
        match self {
            Self::Frame(frame) => (frame.width, frame.height),
            Self::Patch { size, .. } | Self::Differences { size, .. } => *size,
        }
    }

    /// As a URI, and whether it may be smoothed.
    fn embedded(&self) -> Result<(String, bool)> {
        if let Self::Frame(frame) = self {
            return Ok((encode::data_uri("image/jpeg", &encode::jpeg(frame)?), true));
        }
        let (width, height) = self.size();
        let inks = self.inks((width.into(), height.into()))?;
        let bytes = encode::png((width.into(), height.into()), &inks, &full_palette())?;
        Ok((encode::data_uri("image/png", &bytes), false))
    }

    /// Row by row, in the palette of a canvas, at another size.
    fn inks(&self, (width, height): (u32, u32)) -> Result<Vec<u8>> {
        let own = self.size();
        let own = (u32::from(own.0), u32::from(own.1));
        let smooth = !width.is_multiple_of(own.0.max(1)) || !height.is_multiple_of(own.1.max(1));
        if let (Self::Frame(frame), true) = (self, smooth) {
            let sized = resized(frame.clone(), width.try_into()?, height.try_into()?);
            return Ok(sized.pixels.into_iter().map(|gray| gray / 2).collect());
        }
        let nearest = |at: u32| ((at / width * own.1 / height) * own.0 + at % width * own.0 / width) as usize;
        Ok((0..width * height).map(|at| self.ink(nearest(at))).collect())
    }

    fn ink(&self, at: usize) -> u8 {
        match self {
            Self::Frame(frame) => frame.pixels[at] / 2,
            Self::Patch { levels, .. } => levels[at] / 2,
            Self::Differences { levels, alpha, .. } => match levels[at] {
                level if u16::from(level) < *alpha => ink(pictures::counting_color(level)),
                level => pictures::gray(level.min(pictures::BRIGHTEST)) / 2,
            },
        }
    }
}

fn png(size: (u32, u32), marks: &[Mark]) -> Result<Vec<u8>> {
    let mut canvas = Canvas::new(size.0, size.1);
    for mark in marks {
        match mark {
            Mark::Line { points, color, stroke } => line(&mut canvas, points, ink(*color), *stroke),
            Mark::Words { x, y, place, words, color } => {
                let left = x - place * f64::from(Canvas::width_of(words));
                let top = y - f64::from(font::HEIGHT);
                canvas.text(pixel(left), pixel(top), words, color.map_or(WHITE, ink));
            }
            Mark::Area { x, y, width, height, color } => {
                let rows = pixel(*y)..pixel(y + height);
                let columns = || pixel(*x)..pixel(x + width);
                rows.flat_map(|y| columns().map(move |x| (x, y))).for_each(|(x, y)| canvas.set(x, y, ink(*color)));
            }
            Mark::Picture { x, y, width, height, pixels } => {
                let (left, top, sides) = (pixel(*x), pixel(*y), (pixel(*width).max(1), pixel(*height).max(1)));
                for (at, ink) in (0..).zip(pixels.inks(sides)?) {
                    canvas.set(left + at % sides.0, top + at / sides.0, ink);
                }
            }
        }
    }
    encode::png(canvas.size(), canvas.pixels(), &full_palette())
}

/// Dashes go on around the corners.
fn line(canvas: &mut Canvas, points: &[(f64, f64)], ink: u8, stroke: Stroke) {
    let mut drawn = 0;
    for ends in points.windows(2) {
        drawn += straight(canvas, ends[0], ends[1], ink, stroke, drawn);
    }
}

/// A straight line, two pixels thick; dotted, it is thin. `before` so many steps were drawn; tells how many these are.
fn straight(canvas: &mut Canvas, from: (f64, f64), to: (f64, f64), ink: u8, stroke: Stroke, before: u32) -> u32 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
    for step in 0..=pixel(steps) {
        let gap = match stroke {
            Stroke::Solid => false,
            Stroke::Dashed => (before + step) % 12 >= 6,
            Stroke::Dotted => (before + step) % 6 >= 3,
        };
        if gap {
            continue;
        }
        let along = f64::from(step) / steps;
        let (x, y) = (pixel(from.0 + dx * along), pixel(from.1 + dy * along));
        canvas.set(x, y, ink);
        if stroke != Stroke::Dotted {
            let second = if dx.abs() < dy.abs() { (x + 1, y) } else { (x, y + 1) };
            canvas.set(second.0, second.1, ink);
        }
    }
    pixel(steps)
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
fn pixel(value: f64) -> u32 {
    value.round() as u32
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
