//! Axes of a diagram: lines with their numbers, and curves between them.

use super::diagram::{Mark, Stroke};
use crate::colors::{Color, GRID};

pub struct Axes {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    /// The values at the left and at the right end.
    pub across: (f64, f64),
    /// The values at the bottom and at the top.
    pub up: (f64, f64),
}

impl Axes {
    pub fn x(&self, value: f64) -> f64 {
        let span = (self.across.1 - self.across.0).max(f64::MIN_POSITIVE);
        (self.left + (self.right - self.left) * (value - self.across.0) / span).clamp(self.left, self.right)
    }

    pub fn y(&self, value: f64) -> f64 {
        let part = (value - self.up.0) / (self.up.1 - self.up.0);
        (self.bottom - (self.bottom - self.top) * part).clamp(self.top, self.bottom)
    }

    /// A line at each number on the way up, a tick at each below.
    pub fn grid(
        &self,
        across: impl IntoIterator<Item = (f64, String)>,
        up: impl IntoIterator<Item = (f64, String)>,
    ) -> Vec<Mark> {
        let across = across.into_iter().flat_map(|(value, words)| {
            let x = self.x(value);
            let tick = Mark::Area { x: x - 1.0, y: self.bottom, width: 2.0, height: 5.0, color: [150; 3] };
            [tick, Mark::words(x, self.bottom + 16.0, 0.5, words, None)]
        });
        let up = up.into_iter().flat_map(|(value, words)| {
            let y = self.y(value);
            let line =
                Mark::Line { points: vec![(self.left, y), (self.right, y)], color: GRID, stroke: Stroke::Dotted };
            [line, Mark::words(self.left - 8.0, y, 1.0, words, None)]
        });
        up.chain(across).collect()
    }

    /// Lines through neighbouring values. A value without neighbours is a short line of its own.
    pub fn curve(
        &self,
        values: impl IntoIterator<Item = Option<(f64, f64)>>,
        color: Color,
        stroke: Stroke,
    ) -> Vec<Mark> {
        let points: Vec<_> = values.into_iter().map(|value| value.map(|(x, y)| (self.x(x), self.y(y)))).collect();
        let runs = points.split(Option::is_none).filter(|run| !run.is_empty());
        let line = |run: &[Option<(f64, f64)>]| {
            let points = match run[..] {
                [Some((x, y))] => vec![(x - 3.0, y), (x + 3.0, y)],
                _ => run.iter().flatten().copied().collect(),
            };
            Mark::Line { points, color, stroke }
        };
        runs.map(line).collect()
    }
}
