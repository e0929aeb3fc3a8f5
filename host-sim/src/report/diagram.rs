//! Lines and words as a file, SVG or PNG: what the diagrams are drawn with.

use super::picture::{Canvas, WHITE, ink, palette};
use super::{Color, color_of, encode, font};
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

    /// The file's bytes.
    ///
    /// # Errors
    /// The encoder's; no diagram is known that it refuses.
    pub fn draw(self, marks: &[Mark]) -> Result<Vec<u8>> {
        match self {
            Self::Svg => Ok(svg(marks).into_bytes()),
            Self::Png => png(marks),
        }
    }
}

/// What is drawn, in either form.
pub enum Mark {
    Line {
        points: Vec<(f64, f64)>,
        color: Color,
        dashed: bool,
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

fn svg(marks: &[Mark]) -> String {
    let (width, height) = SIZE;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"14\"><rect width=\"{width}\" height=\"{height}\" fill=\"#181818\"/>\n"
    );
    let hex = |[r, g, b]: Color| format!("#{r:02x}{g:02x}{b:02x}");
    for mark in marks {
        // Writing to a String cannot fail.
        let _ = match mark {
            Mark::Line { points, color, dashed } => {
                let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
                let (dashes, width) = if *dashed { (" stroke-dasharray=\"3 4\"", 1) } else { ("", 2) };
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
                let (y, color) = (y + 5.0, hex(color.unwrap_or([255; 3])));
                writeln!(
                    svg,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{color}\">{words}</text>"
                )
            }
        };
    }
    svg + "</svg>\n"
}

fn png(marks: &[Mark]) -> Result<Vec<u8>> {
    let mut canvas = Canvas::new(SIZE.0, SIZE.1);
    for mark in marks {
        match mark {
            Mark::Line { points, color, dashed } => {
                for ends in points.windows(2) {
                    stroke(&mut canvas, ends[0], ends[1], ink(*color), *dashed);
                }
            }
            Mark::Words { x, y, place, words, color } => {
                let left = x - place * f64::from(Canvas::width_of(words));
                let top = y - f64::from(font::HEIGHT);
                canvas.text(pixel(left), pixel(top), words, color.map_or(WHITE, ink));
            }
        }
    }
    encode::png(canvas.size(), canvas.pixels(), &palette())
}

/// A straight line, two pixels thick; dashed, it is thin.
fn stroke(canvas: &mut Canvas, from: (f64, f64), to: (f64, f64), ink: u8, dashed: bool) {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
    for step in 0..=pixel(steps) {
        if dashed && step % 6 >= 3 {
            continue;
        }
        let along = f64::from(step) / steps;
        let (x, y) = (pixel(from.0 + dx * along), pixel(from.1 + dy * along));
        canvas.set(x, y, ink);
        if !dashed {
            canvas.set(x, y + 1, ink);
        }
    }
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
