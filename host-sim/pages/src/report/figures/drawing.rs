//! Parts of a figure: frames with boxes, patches, words and lines.

use crate::colors::{Color, SAD, SHADE, SMR, TRUTH, color_of_method};
use crate::report::axes::Axes;
use crate::report::canvas::width_of;
use crate::report::diagram::{self, Mark, Stroke};
use crate::report::difference::Difference;
use crate::report::film::{Film, Still};
use crate::report::image::Pixels;
use anyhow::Result;
use smr_recordings::BoundingBox;

/// All figures are so wide.
pub(super) const WIDTH: f64 = 760.0;
/// Around and between.
pub(super) const GAP: f64 = 20.0;
/// From one line of words to the next.
pub(super) const LINE: f64 = 22.0;

pub struct Sheet {
    pub size: (u32, u32),
    marks: Vec<Mark>,
}

impl Sheet {
    /// As high as need be; its title stands above.
    pub(super) fn new(height: f64, title: &str) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
        let size = (WIDTH as u32, height.ceil() as u32);
        let mut sheet = Self { size, marks: Vec::new() };
        sheet.words(GAP, GAP, 0.0, title, None);
        sheet
    }

    pub fn svg(&self) -> Result<String> {
        diagram::svg(self.size, &self.marks)
    }

    pub fn png(&self) -> Result<Vec<u8>> {
        diagram::png(self.size, &self.marks)
    }

    pub(super) fn words(&mut self, x: f64, y: f64, place: f64, words: &str, color: Option<Color>) {
        self.marks.push(Mark::words(x, y, place, words, color));
    }

    pub(super) fn line(&mut self, points: Vec<(f64, f64)>, color: Color, stroke: Stroke) {
        self.marks.push(Mark::Line { points, color, stroke });
    }

    /// Lines with their numbers, and what they count: across, then up.
    pub(super) fn axes(&mut self, axes: &Axes, names: (&str, &str), digits: usize) {
        let step = nice((axes.across.1 - axes.across.0) / 7.0);
        let first = (axes.across.0 / step).ceil();
        let across = (0..).map(|at| (first + f64::from(at)) * step).take_while(|value| *value <= axes.across.1);
        let up = (0..=4).map(|part| axes.up.1 * f64::from(part) / 4.0);
        self.marks.extend(axes.grid(
            across.map(|value| (value, format!("{value:.0}"))),
            up.map(|value| (value, format!("{value:.digits$}"))),
        ));
        self.words(axes.right, axes.bottom + 38.0, 1.0, names.0, None);
        self.words(axes.left, axes.top - 16.0, 0.0, names.1, None);
    }

    /// Frames in which the target is hidden.
    pub(super) fn hidden(&mut self, axes: &Axes, spans: &[(usize, usize)]) {
        for &(first, last) in spans {
            let (from, to) = (axes.x(first as f64 + 0.5), axes.x(last as f64 + 1.5));
            self.shade(from, axes.top, (to - from).max(2.0), axes.bottom - axes.top);
        }
    }

    /// The values of frames, the first being `first`; a gap where there is none.
    pub(super) fn curve(&mut self, axes: &Axes, first: usize, values: &[Option<f64>], color: Color, stroke: Stroke) {
        let points = (first..).zip(values).map(|(frame, value)| Some((frame as f64, (*value)?)));
        self.marks.extend(axes.curve(points, color, stroke));
    }

    /// A line of words that tells who has which color, from the right end.
    pub(super) fn legend(&mut self, y: f64, truth: bool) {
        let mut x = WIDTH - GAP;
        let truth = truth.then_some(("truth", TRUTH, Stroke::Dotted));
        for (name, color, stroke) in
            truth.into_iter().chain([("SAD", SAD, Stroke::Dashed), ("SMR", SMR, Stroke::Solid)])
        {
            self.words(x, y, 1.0, name, Some(color));
            x -= f64::from(width_of(name)) + 6.0;
            self.line(vec![(x - 30.0, y), (x, y)], color, stroke);
            x -= 30.0 + GAP;
        }
    }

    /// The frame with all boxes, and so much of the padding; tells its size.
    pub(super) fn tile(&mut self, film: &Film, still: &Still, at: (f64, f64), within: f64, margin: u16) -> (f64, f64) {
        let (width, height) = (f64::from(still.frame.width), f64::from(still.frame.height));
        let margin = f64::from(margin);
        let scale = within / (width + 2.0 * margin).max(height + 2.0 * margin).max(1.0);
        let whole = ((width + 2.0 * margin) * scale, (height + 2.0 * margin) * scale);
        let origin = (at.0 + margin * scale, at.1 + margin * scale);
        self.marks.push(Mark::Area { x: at.0, y: at.1, width: whole.0, height: whole.1, color: [0; 3] });
        let pixels = Pixels::Frame(still.frame.clone());
        let (width, height) = (width * scale, height * scale);
        self.marks.push(Mark::Picture { x: origin.0, y: origin.1, width, height, pixels });
        let corners = |of: &BoundingBox| {
            let x = |x: f64| (origin.0 + x * scale).clamp(at.0, at.0 + whole.0 - 1.0);
            let y = |y: f64| (origin.1 + y * scale).clamp(at.1, at.1 + whole.1 - 1.0);
            let (left, right, top, bottom) = (x(of.x), x(of.x + of.width), y(of.y), y(of.y + of.height));
            vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)]
        };
        for (place, (method, sight)) in film.methods.iter().zip(&still.sights).enumerate() {
            // Dashes let an equal box below be seen.
            let stroke = if place == 0 { Stroke::Solid } else { Stroke::Dashed };
            let lost = film.moments[still.index].reports[place].target.is_none();
            let stroke = if lost { Stroke::Dotted } else { stroke };
            self.line(corners(&sight.bbox), color_of_method(method.kind), stroke);
        }
        if let Some(truth) = film.truth_at(still.index) {
            self.line(corners(&truth), TRUTH, Stroke::Dotted);
        }
        whole
    }

    /// Pixels that each stay to be seen; tells their size in the figure.
    pub(super) fn patch(&mut self, pixels: Pixels, at: (f64, f64), within: (f64, f64)) -> (f64, f64) {
        let size = pixels.size();
        let size = (f64::from(size.0), f64::from(size.1));
        let scale = fit(size, within);
        let (width, height) = (size.0 * scale, size.1 * scale);
        self.marks.push(Mark::Picture { x: at.0, y: at.1, width, height, pixels });
        (width, height)
    }

    pub(super) fn shade(&mut self, x: f64, y: f64, width: f64, height: f64) {
        self.marks.push(Mark::Area { x, y, width, height, color: SHADE });
    }
}

/// Axes as wide as a figure.
pub(super) fn wide(top: f64, height: f64, across: (f64, f64), up: (f64, f64)) -> Axes {
    Axes { left: GAP + 60.0, right: WIDTH - GAP, top, bottom: top + height, across, up }
}

/// Pixels of the template of a difference.
pub(super) fn template(difference: &Difference) -> Pixels {
    Pixels::Patch { size: difference.size, levels: difference.template.clone() }
}

/// Scale at which a picture fits `within`. It is whole from 1 on, so that all pixels have one size.
fn fit((width, height): (f64, f64), within: (f64, f64)) -> f64 {
    let scale = (within.0 / width.max(1.0)).min(within.1 / height.max(1.0));
    if scale >= 1.0 { scale.floor() } else { scale }
}

/// The next of 1, 2, 5, 10, 20, ... that is not below.
pub(super) fn nice(value: f64) -> f64 {
    let unit = 10_f64.powf(value.max(1.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|times| times * unit).find(|&nice| nice >= value).unwrap_or(10.0 * unit)
}
