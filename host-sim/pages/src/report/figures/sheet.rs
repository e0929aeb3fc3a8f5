//! SVG elements of a figure: text, lines, frames with boxes, patches and plots.

use super::frames::{METHODS, SAD, SMR, compared};
use crate::colors::{Color, TRUTH, WHITE, css};
use crate::encode::{GOOD, data_uri, jpeg};
use crate::report::difference;
use crate::report::film::{FilmedRecording, Still};
use crate::report::trackers::color_of_method;
use anyhow::Result;
use minijinja::HtmlEscape;

pub(super) const WIDTH: f64 = 760.0;
pub(super) const GAP: f64 = 20.0;
/// Line spacing of text, in units of the SVG.
pub(super) const LINE: f64 = 22.0;
/// Top of the content, below the title and one more line.
pub(super) const TOP: f64 = 2.0 * GAP + LINE;

pub(super) const SOLID: &str = r#"stroke-width="2""#;
pub(super) const DASHED: &str = r#"stroke-width="2" stroke-dasharray="6""#;
pub(super) const DOTTED: &str = r#"stroke-dasharray="3 4""#;
/// Strokes of SMR and SAD. If their boxes are identical, SMR's solid line shows between the dashes of SAD.
pub(super) const STROKES: [&str; 2] = [SOLID, DASHED];

pub(super) type Pair = (f64, f64);

pub(super) struct Sheet(Vec<String>);

/// A plot as wide as the figure, whose y axis starts at 0.
pub(super) struct Plot {
    pub top: f64,
    pub bottom: f64,
    /// Values at the left and the right end of the x axis.
    pub across: Pair,
    /// Value at the top of the y axis.
    pub most: f64,
}

impl Plot {
    pub const LEFT: f64 = GAP + 60.0;
    pub const RIGHT: f64 = WIDTH - GAP;

    pub fn x(&self, value: f64) -> f64 {
        let part = (value - self.across.0) / (self.across.1 - self.across.0).max(f64::MIN_POSITIVE);
        Self::LEFT + (Self::RIGHT - Self::LEFT) * part.clamp(0.0, 1.0)
    }

    pub fn y(&self, value: f64) -> f64 {
        self.bottom - (self.bottom - self.top) * (value / self.most).clamp(0.0, 1.0)
    }
}

impl Sheet {
    pub fn new(title: &str) -> Self {
        let mut sheet = Self(Vec::new());
        sheet.words((GAP, GAP), "start", title, WHITE);
        sheet
    }

    pub fn svg(self, height: f64) -> String {
        let (paper, marks) = (rgb(css::PAPER.dark), self.0.join("\n"));
        format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:.0}" font-family="system-ui, sans-serif" font-size="14">
<rect width="100%" height="100%" fill="{paper}"/>
{marks}
</svg>
"#
        )
    }

    /// Writes text with its `anchor` (start, middle, end) at `x`, vertically centred on `y`.
    pub fn words(&mut self, (x, y): Pair, anchor: &str, words: &str, color: Color) {
        let (y, color, words) = (y + 5.0, rgb(color), HtmlEscape(words));
        self.0.push(format!(r#"<text x="{x:.1}" y="{y:.1}" text-anchor="{anchor}" fill="{color}">{words}</text>"#));
    }

    pub fn line(&mut self, points: &[Pair], color: Color, stroke: &str) {
        let points = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ");
        self.0.push(format!(r#"<polyline points="{points}" fill="none" stroke="{}" {stroke}/>"#, rgb(color)));
    }

    pub fn area(&mut self, at: Pair, size: Pair, look: &str) {
        self.0.push(format!("<rect {} {look}/>", place(at, size)));
    }

    fn image(&mut self, at: Pair, within: Pair, look: &str, uri: &str) {
        let place = place(at, within);
        self.0.push(format!(r#"<image {place} preserveAspectRatio="xMinYMin"{look} href="{uri}"/>"#));
    }

    /// Draws a PNG without smoothing, so that single pixels stay visible.
    pub fn patch(&mut self, at: Pair, within: Pair, png: &[u8]) {
        self.image(at, within, r#" style="image-rendering:pixelated""#, &data_uri("image/png", png));
    }

    pub fn legend(&mut self, truth: bool) {
        let all = [("SMR", color_of(SMR), SOLID), ("SAD", color_of(SAD), DASHED), ("truth", TRUTH, DOTTED)];
        for (place, (name, color, stroke)) in all[..2 + usize::from(truth)].iter().rev().enumerate() {
            let right = Plot::RIGHT - 88.0 * place as f64;
            self.words((right, GAP), "end", name, *color);
            self.line(&[(right - 70.0, GAP), (right - 40.0, GAP)], *color, stroke);
        }
    }

    /// Draws the frame and a margin of padding, with all boxes. The box of a lost target is dotted.
    pub fn frame(&mut self, film: &FilmedRecording, still: &Still, at: Pair, size: Pair, margin: u16) -> Result<()> {
        let margin = f64::from(margin);
        let (width, height) = (f64::from(still.frame.width), f64::from(still.frame.height));
        let scale = size.0 / (width + 2.0 * margin);
        self.area(at, size, r##"fill="#000""##);
        let corner = (at.0 + margin * scale, at.1 + margin * scale);
        self.image(corner, (width * scale, height * scale), "", &data_uri("image/jpeg", &jpeg(&still.frame, GOOD)?));
        let answers = &film.moments[still.index].reports;
        let boxes = (0..).zip(&still.observations).map(|(method, observation)| {
            let stroke = if answers[method].target.is_none() { DOTTED } else { STROKES[method] };
            (observation.bbox, color_of(method), stroke)
        });
        let truth = film.truth_at(still.index).map(|truth| (truth, TRUTH, DOTTED));
        for (bbox, color, stroke) in boxes.chain(truth) {
            let x = |x: f64| ((x + margin) * scale).clamp(0.0, size.0);
            let y = |y: f64| ((y + margin) * scale).clamp(0.0, size.1);
            let (left, top) = (x(bbox.x), y(bbox.y));
            let inner = (x(bbox.x + bbox.width) - left, y(bbox.y + bbox.height) - top);
            let look = format!(r#"fill="none" stroke="{}" {stroke}"#, rgb(color));
            self.area((at.0 + left, at.1 + top), inner, &look);
        }
        Ok(())
    }

    /// Draws numbered frames in a row, with SMR's templates below. Returns the frames' left ends and the row's bottom.
    pub fn strip(&mut self, film: &FilmedRecording, stills: &[&Still], margin: u16) -> Result<(Vec<f64>, f64)> {
        const PATCH: Pair = (120.0, 96.0);
        let size = tile(film, COLUMN, margin);
        let lefts: Vec<f64> = (0..stills.len()).map(|place| GAP + place as f64 * (COLUMN + GAP)).collect();
        for (&left, still) in lefts.iter().zip(stills) {
            self.words((left, 2.0 * GAP + 8.0), "start", &(still.index + 1).to_string(), WHITE);
            self.frame(film, still, (left, TOP), size, margin)?;
            let seen = &compared(still, SMR)?.difference;
            self.patch((left, TOP + size.1 + GAP), PATCH, &difference::patch(&seen.template)?);
        }
        Ok((lefts, TOP + size.1 + GAP + PATCH.1))
    }

    /// Draws the grid, tick labels and axis titles of a plot; `names` are the titles of the x and the y axis.
    pub fn plot(&mut self, (top, height): Pair, across: Pair, most: f64, names: [&str; 2], digits: usize) -> Plot {
        let plot = Plot { top, bottom: top + height, across, most };
        for value in (0..=4).map(|part| most * f64::from(part) / 4.0) {
            let y = plot.y(value);
            self.line(&[(Plot::LEFT, y), (Plot::RIGHT, y)], css::RULE.dark, DOTTED);
            self.words((Plot::LEFT - 8.0, y), "end", &format!("{value:.digits$}"), WHITE);
        }
        let step = nice((across.1 - across.0) / 7.0);
        let first = (across.0 / step).ceil();
        let ticks = (0..).map(|at| (first + f64::from(at)) * step).take_while(|value| *value <= across.1);
        for value in ticks {
            let x = plot.x(value);
            self.line(&[(x, plot.bottom), (x, plot.bottom + 5.0)], WHITE, "");
            self.words((x, plot.bottom + 16.0), "middle", &format!("{value:.0}"), WHITE);
        }
        self.words((Plot::RIGHT, plot.bottom + 38.0), "end", names[0], WHITE);
        self.words((Plot::LEFT, top - 16.0), "start", names[1], WHITE);
        plot
    }

    /// Shades the frames of a plot in which the target is hidden.
    pub fn hidden(&mut self, plot: &Plot, spans: &[(usize, usize)]) {
        for &(first, last) in spans {
            let (from, to) = (plot.x(first as f64 + 0.5), plot.x(last as f64 + 1.5));
            self.shade((from, plot.top), ((to - from).max(2.0), plot.bottom - plot.top));
        }
    }

    pub fn shade(&mut self, at: Pair, size: Pair) {
        self.area(at, size, r##"fill="#fff" fill-opacity="0.15""##);
    }

    /// Draws the values of frames from `first` on, with a gap where a value is missing. A value without neighbours is a short line.
    pub fn curve(&mut self, plot: &Plot, first: usize, values: &[Option<f64>], method: usize) {
        let points: Vec<_> =
            (first..).zip(values).map(|(at, value)| Some((plot.x(at as f64), plot.y((*value)?)))).collect();
        for run in points.split(Option::is_none).filter(|run| !run.is_empty()) {
            let mut run: Vec<Pair> = run.iter().flatten().copied().collect();
            if let [(x, y)] = run[..] {
                run = vec![(x - 3.0, y), (x + 3.0, y)];
            }
            self.line(&run, color_of(method), STROKES[method]);
        }
    }
}

pub(super) const COLUMN: f64 = (WIDTH - 5.0 * GAP) / 4.0;

/// Returns the size of a frame with a margin of padding, scaled so that its longer side is `longest`.
pub(super) fn tile(film: &FilmedRecording, longest: f64, margin: u16) -> Pair {
    let (width, height) = (f64::from(film.size.0 + 2 * margin), f64::from(film.size.1 + 2 * margin));
    let scale = longest / width.max(height).max(1.0);
    (width * scale, height * scale)
}

pub(super) fn color_of(method: usize) -> Color {
    color_of_method(METHODS[method])
}

fn place((x, y): Pair, (width, height): Pair) -> String {
    format!(r#"x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}""#)
}

fn rgb([red, green, blue]: Color) -> String {
    format!("rgb({red},{green},{blue})")
}

/// Rounds up to 1, 2, 5, 10, 20, ..., for the distance between ticks or the end of an axis.
pub(super) fn nice(value: f64) -> f64 {
    let unit = 10_f64.powf(value.max(1.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|times| times * unit).find(|&nice| nice >= value).unwrap_or(10.0 * unit)
}
