//! Numbers as SVG: those of every frame over time, and the differences of one frame as a histogram.

use super::difference::{BAR, BARS};
use super::film::{Film, Still};
use crate::evaluate::{CORRECT, Evidence, MethodKind, name_of};
use smr_core::State;
use std::fmt::Write as _;

const LEFT: f64 = 44.0;
const WIDTH: f64 = 900.0;
const GAP: f64 = 22.0;
const BAND: f64 = 14.0;
/// Where the band of states begins: above it are the marks of the frames that are shown.
const TOP: f64 = 12.0;

/// One diagram among several over the same frames.
struct Panel {
    title: &'static str,
    height: f64,
    most: f64,
    /// Values with a line across.
    levels: Vec<f64>,
    /// Classes and values of the lines.
    lines: Vec<(&'static str, Vec<Option<f64>>)>,
}

/// What smr and robust decided on, and intersection over union of all methods, over a band of the first one's states.
pub(super) fn over_time(film: &Film, overlaps: Option<Vec<Vec<Option<f64>>>>) -> String {
    let mut panels = decisions(film);
    panels.extend(overlaps.map(|overlaps| Panel {
        title: "IoU",
        height: 120.0,
        most: 1.0,
        levels: vec![0.0, CORRECT, 0.5, 1.0],
        // What is drawn last is on top.
        lines: film.methods.iter().map(|method| method.kind.name()).zip(overlaps).rev().collect(),
    }));
    let axis = Axis { frames: film.moments.len() };
    let bottom = TOP + BAND + panels.iter().map(|panel| GAP + panel.height).sum::<f64>();
    let mut svg =
        format!("<svg class=\"plot\" viewBox=\"0 0 {} {}\" role=\"img\">", LEFT + WIDTH + 12.0, bottom + 20.0);
    svg += &bands(film, &axis, bottom);
    let mut top = TOP + BAND + GAP;
    for panel in &panels {
        svg += &panel.draw(&axis, top);
        top += panel.height + GAP;
    }
    svg + &axis.draw(bottom) + "</svg>"
}

/// Ratio, runner-up and alpha of smr; confidence of robust.
fn decisions(film: &Film) -> Vec<Panel> {
    let mut panels = Vec::new();
    for method in film.all_of(MethodKind::Smr) {
        let runner_up = evidence(film, method, |evidence| evidence.runner_up_ratio);
        let ratio = evidence(film, method, |evidence| Some(evidence.ratio));
        panels.push(Panel::of_one("ratio", vec![("runner-up", runner_up), ("smr", ratio)]));
        panels.push(alphas(evidence(film, method, |evidence| evidence.alpha.map(f64::from))));
    }
    for method in film.all_of(MethodKind::Robust) {
        let confidence = evidence(film, method, |evidence| Some(evidence.confidence));
        panels.push(Panel::of_one("confidence", vec![("robust", confidence)]));
    }
    panels
}

fn evidence(film: &Film, method: usize, value: fn(&Evidence) -> Option<f64>) -> Vec<Option<f64>> {
    film.moments.iter().map(|moment| moment.reports[method].evidence.as_ref().and_then(value)).collect()
}

fn alphas(alphas: Vec<Option<f64>>) -> Panel {
    let most = (alphas.iter().flatten().fold(1.0, |most: f64, &alpha| most.max(alpha)) / 8.0).ceil() * 8.0;
    Panel { title: "alpha", height: 80.0, most, levels: vec![0.0, most / 2.0, most], lines: vec![("alpha", alphas)] }
}

impl Panel {
    /// Of numbers from 0 to 1.
    fn of_one(title: &'static str, lines: Vec<(&'static str, Vec<Option<f64>>)>) -> Self {
        Self { title, height: 150.0, most: 1.0, levels: vec![0.0, 0.5, 1.0], lines }
    }

    fn draw(&self, axis: &Axis, top: f64) -> String {
        let y = |value: f64| top + self.height * (1.0 - value / self.most);
        let mut svg = format!("<text class=\"title\" x=\"{LEFT}\" y=\"{:.1}\">{}</text>", top - 5.0, self.title);
        for &level in &self.levels {
            let y = y(level);
            let right = LEFT + WIDTH;
            svg += &format!("<path class=\"grid\" d=\"M{LEFT} {y:.1}H{right}\"/>");
            svg += &format!("<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{level}</text>", LEFT - 6.0, y + 4.0);
        }
        for (class, values) in &self.lines {
            svg += &format!("<path class=\"line {class}\" d=\"{}\"/>", path(values, |index| axis.x(index), y));
        }
        svg
    }
}

/// Lines through neighbours that there are; one without neighbours is a dot.
fn path(values: &[Option<f64>], x: impl Fn(usize) -> f64, y: impl Fn(f64) -> f64) -> String {
    let mut path = String::new();
    let mut after_a_gap = true;
    for (index, value) in values.iter().enumerate() {
        if let &Some(value) = value {
            let (x, y) = (x(index), y(value));
            // Writing to a String cannot fail.
            let _ = if after_a_gap { write!(path, "M{x:.1} {y:.1}h0") } else { write!(path, "L{x:.1} {y:.1}") };
        }
        after_a_gap = value.is_none();
    }
    path
}

/// The states as a band, each but tracking shaded down to `bottom`, and the marks of the frames that are shown.
fn bands(film: &Film, axis: &Axis, bottom: f64) -> String {
    let mut svg = String::new();
    let mut first = 0;
    for run in film.moments.chunk_by(|a, b| a.first().state == b.first().state) {
        let (left, right) = (axis.edge(first), axis.edge(first + run.len()));
        let (width, name) = (right - left, name_of(run[0].first().state));
        let title = format!("<title>{name}: frames {} to {}</title>", first + 1, first + run.len());
        let rect = |class: &str, height: f64| {
            format!(
                "<rect class=\"{class} {name}\" x=\"{left:.1}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height:.1}\">{title}</rect>"
            )
        };
        svg += &rect("band", BAND);
        if run[0].first().state != State::Tracking {
            svg += &rect("shade", bottom - TOP);
        }
        first += run.len();
    }
    for number in film.shown() {
        let x = axis.x(number - 1);
        svg += &format!("<a href=\"#f{number}\"><path class=\"mark\" d=\"M{x:.1} {TOP}l-4 -9h8z\"/></a>");
    }
    svg
}

/// Frames from left to right.
struct Axis {
    frames: usize,
}

impl Axis {
    /// The middle of a frame; the first has index 0.
    fn x(&self, index: usize) -> f64 {
        self.edge(index) + WIDTH / self.frames as f64 / 2.0
    }

    /// Where a frame begins.
    fn edge(&self, index: usize) -> f64 {
        LEFT + WIDTH * index as f64 / self.frames as f64
    }

    fn draw(&self, bottom: f64) -> String {
        let step = step(self.frames);
        let label = |number: usize| {
            format!(
                "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{number}</text>",
                self.x(number - 1),
                bottom + 15.0
            )
        };
        // The first frame is 1, and the last one is at most so far from a mark.
        std::iter::once(1).chain((step..=self.frames).step_by(step).filter(|&number| number > 1)).map(label).collect()
    }
}

/// 1, 2 or 5 with zeroes: about ten marks in all.
fn step(frames: usize) -> usize {
    let sizes = (0..).flat_map(|zeroes| [1, 2, 5].map(|digit| digit * 10_usize.pow(zeroes)));
    sizes.into_iter().find(|step| frames / step <= 12).unwrap_or(1)
}

/// How many pixels differ by how much: the first method's winner as bars, those of the others as lines, alpha across.
pub(super) fn histogram(film: &Film, still: &Still) -> String {
    let (left, top, width, height) = (34.0, 6.0, 320.0, 110.0);
    let searches = film.methods.iter().zip(still.sights.iter().filter_map(|sight| sight.search.as_ref()));
    let histograms: Vec<_> =
        searches.clone().map(|(method, search)| (method.kind.name(), search.difference.histogram())).collect();
    let alpha = searches.clone().next().and_then(|(_, search)| search.alpha);
    let all = histograms.iter().flat_map(|(_, shares)| shares);
    let most = all.fold(0.0, |most: f64, &share| most.max(share)).max(0.01);
    let x = |bar: f64| left + width * bar / BARS as f64;
    let y = |share: f64| top + height * (1.0 - share / most);
    let bottom = top + height;

    let bars = |shares: &[f64; BARS]| {
        let bars = (0..).zip(shares);
        bars.map(|(bar, &share)| bar_path(x(f64::from(bar)), x(f64::from(bar) + 0.9), y(share), bottom))
            .collect::<String>()
    };
    let steps = |shares: &[f64; BARS]| {
        let steps = (0..).zip(shares);
        steps.map(|(bar, &share)| format!("V{:.1}H{:.1}", y(share), x(f64::from(bar) + 1.0))).collect::<String>()
    };
    let paths: String = (0..)
        .zip(&histograms)
        .map(|(index, (name, shares))| match index {
            0 => format!("<path class=\"bars {name}\" d=\"{}\"/>", bars(shares)),
            _ => format!("<path class=\"line {name}\" d=\"M{left} {bottom}{}V{bottom}\"/>", steps(shares)),
        })
        .collect();
    let threshold = alpha.map_or(String::new(), |alpha| {
        let at = x((f64::from(alpha) / BAR as f64).min(BARS as f64));
        format!(
            "<path class=\"threshold\" d=\"M{at:.1} {top}V{bottom}\"/><text x=\"{:.1}\" y=\"{}\">alpha {alpha}</text>",
            at + 4.0,
            top + 12.0
        )
    });
    let label = |gray: usize| {
        let more = if gray == BAR * BARS { "+" } else { "" };
        let x = x(gray as f64 / BAR as f64);
        format!("<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{gray}{more}</text>", bottom + 13.0)
    };
    let labels: String = (0..=BAR * BARS).step_by(32).map(label).collect();
    format!(
        "<svg class=\"histogram\" viewBox=\"0 0 {} {}\" role=\"img\">\
         <path class=\"grid\" d=\"M{left} {bottom}h{width}M{left} {top}h{width}\"/>\
         {paths}{threshold}\
         <text x=\"{}\" y=\"{}\" text-anchor=\"end\">{:.0}%</text>{labels}</svg>",
        left + width + 16.0,
        bottom + 18.0,
        left - 5.0,
        top + 9.0,
        most * 100.0
    )
}

fn bar_path(left: f64, right: f64, top: f64, bottom: f64) -> String {
    if top >= bottom { String::new() } else { format!("M{left:.1} {bottom}V{top:.1}H{right:.1}V{bottom}z") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_gaps_where_there_is_nothing() {
        let values = [None, Some(1.0), Some(2.0), None, Some(3.0)];
        let path = path(&values, |index| index as f64, |value| value);
        assert_eq!(path, "M1.0 1.0h0L2.0 2.0M4.0 3.0h0");
    }

    #[test]
    fn marks_are_round_and_few() {
        assert_eq!([1, 12, 13, 240, 945, 100_000].map(step), [1, 1, 2, 20, 100, 10_000]);
    }

    #[test]
    fn frames_fill_the_axis() {
        let axis = Axis { frames: 4 };
        assert_eq!((axis.edge(0), axis.edge(4)), (LEFT, LEFT + WIDTH));
        assert_eq!(Axis { frames: 1 }.x(0), LEFT + WIDTH / 2.0);
    }
}
