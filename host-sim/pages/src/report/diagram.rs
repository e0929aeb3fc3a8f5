//! Lines, words and pictures as a file, SVG or PNG: what figures are drawn with.

use super::canvas::{self, Canvas, Dashes, FONT, pixel};
use super::image::Pixels;
use crate::colors::{Color, PAPER, WHITE};
use anyhow::Result;
use embedded_graphics::geometry::Point;
use embedded_graphics::primitives::Rectangle;
use minijinja::value::Serde;
use minijinja::{Environment, context};
use serde::Serialize;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Stroke {
    Solid,
    /// As thick, with gaps.
    Dashed,
    /// Thin, with short gaps.
    Dotted,
}

/// A mark of a drawing, which becomes SVG or pixels.
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
    pub fn words(x: f64, y: f64, place: f64, words: impl Into<String>, color: Option<Color>) -> Self {
        Self::Words { x, y, place, words: words.into(), color }
    }
}

pub(super) fn svg((width, height): (u32, u32), marks: &[Mark]) -> Result<String> {
    let mut templates = Environment::new();
    templates.add_template("diagram.svg", include_str!("diagram.svg"))?;
    Ok(templates.get_template("diagram.svg")?.render(context! { width, height, marks => Serde(marks) })?)
}

pub(super) fn png((width, height): (u32, u32), marks: &[Mark]) -> Result<Vec<u8>> {
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
                let side = |length: &f64| u16::try_from(pixel(*length).max(1)).unwrap_or(u16::MAX);
                let place = |at: &f64| pixel(*at).max(0).unsigned_abs();
                canvas.picture(place(x), place(y), &pixels.sized(side(width), side(height)));
            }
        }
    }
    canvas.png()
}
