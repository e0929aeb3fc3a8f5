//! Success and precision plots over thresholds, as SVG that needs no script.

use super::Color;
use super::data::css;
use super::escaped::escaped;
use crate::evaluate::{Curves, FARTHEST, NEAR, STEPS};
use std::fmt::Write as _;

const LEFT: f64 = 44.0;
const TOP: f64 = 26.0;
const WIDTH: f64 = 430.0;
const HEIGHT: f64 = 250.0;

/// One line: who, in which color, and how good.
pub(super) struct Line {
    pub title: String,
    pub color: Color,
    pub curves: Curves,
}

/// Both plots, side by side where there is room, each with its lines named by area, the largest first.
pub(super) fn plots(lines: &[Line]) -> String {
    let success = Plot {
        title: "Success: visible frames with an IoU above",
        axis: "IoU",
        most: 1.0,
        step: 0.2,
        values: |curves| &curves.success,
        area: Curves::auc,
        mark: None,
    };
    let precision = Plot {
        title: "Precision: visible frames within a distance",
        axis: "centre error in pixels",
        most: FARTHEST as f64,
        step: 10.0,
        values: |curves| &curves.precision,
        area: Curves::precision_area,
        mark: Some(NEAR as f64),
    };
    format!("<div class=\"plots\">{}{}</div>\n", success.draw(lines), precision.draw(lines))
}

struct Plot {
    title: &'static str,
    axis: &'static str,
    most: f64,
    step: f64,
    values: fn(&Curves) -> &Vec<f64>,
    area: fn(&Curves) -> f64,
    mark: Option<f64>,
}

impl Plot {
    fn draw(&self, lines: &[Line]) -> String {
        let (right, bottom) = (LEFT + WIDTH, TOP + HEIGHT);
        let x = |value: f64| LEFT + WIDTH * value / self.most;
        let y = |part: f64| bottom - HEIGHT * part;
        let mut svg = String::new();
        for tenths in (0..=10).step_by(2) {
            let part = f64::from(tenths) / 10.0;
            let y = y(part);
            svg += &format!("<path class=\"grid\" d=\"M{LEFT} {y:.1}H{right}\"/>");
            svg += &format!("<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{part}</text>", LEFT - 6.0, y + 4.0);
        }
        let marks = (0..).map(|step| f64::from(step) * self.step).take_while(|&value| value <= self.most + 1e-9);
        for value in marks {
            let digits = usize::from(self.most <= 1.0);
            svg += &format!(
                "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{value:.digits$}</text>",
                x(value),
                bottom + 16.0
            );
        }
        if let Some(mark) = self.mark {
            svg += &format!("<path class=\"threshold\" d=\"M{:.1} {TOP}V{bottom}\"/>", x(mark));
        }
        let mut ordered: Vec<&Line> = lines.iter().collect();
        ordered.sort_by(|a, b| (self.area)(&b.curves).total_cmp(&(self.area)(&a.curves)));
        for line in ordered.iter().rev() {
            let values = (self.values)(&line.curves);
            let last = values.len().saturating_sub(1).max(1) as f64;
            let mut path = String::new();
            for (at, &part) in values.iter().enumerate() {
                let letter = if at == 0 { 'M' } else { 'L' };
                // Writing to a String cannot fail.
                let _ = write!(path, "{letter}{:.1} {:.1}", x(at as f64 / last * self.most), y(part));
            }
            let (color, title) = (css(line.color), escaped(&line.title));
            svg += &format!("<path class=\"line\" style=\"--c:{color}\" d=\"{path}\"><title>{title}</title></path>");
        }
        let legend: String = ordered
            .iter()
            .map(|line| {
                let (color, title, area) = (css(line.color), escaped(&line.title), (self.area)(&line.curves));
                format!("<li><span class=\"dash\" style=\"--c:{color}\"></span>{title} <b>{area:.3}</b></li>")
            })
            .collect();
        format!(
            "<figure><svg class=\"plot\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}, {} thresholds\">\
             <text class=\"title\" x=\"{LEFT}\" y=\"14\">{}</text>{svg}\
             <text x=\"{right}\" y=\"{}\" text-anchor=\"end\">{}</text></svg>\
             <figcaption>Area under the line:<ul class=\"legend\">{legend}</ul></figcaption></figure>",
            right + 14.0,
            bottom + 40.0,
            self.title,
            if self.most > 1.0 { FARTHEST + 1 } else { STEPS + 1 },
            self.title,
            bottom + 34.0,
            self.axis
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_area_is_named_first() {
        let line = |title: &str, part: f64| Line {
            title: title.to_owned(),
            color: [1, 2, 3],
            curves: Curves { success: vec![part; STEPS + 1], precision: vec![part; FARTHEST + 1] },
        };
        let svg = plots(&[line("<low>", 0.25), line("high", 0.75)]);
        let first = svg.find("high <b>0.750</b>").unwrap();
        assert!(first < svg.find("&lt;low&gt; <b>0.250</b>").unwrap());
        assert_eq!(svg.matches("class=\"line\"").count(), 4);
        assert!(!svg.contains("NaN"));
    }
}
