//! What `host-sim track` prints of a target in a frame: a line of text, of CSV or of JSON.

use anyhow::Result;
use clap::ValueEnum;
use serde::Serialize;
use smr_core::{Quality, Rect};
use smr_evaluation::{Evidence, Origin, Report, name_of};
use smr_recordings::BoundingBox;
use smr_recordings::boxes::Form;

/// What a line holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// x1,y1,x2,y2; NaN,NaN,NaN,NaN if the target is lost, or in frames before its box
    Tld,
    /// x,y,width,height, the first pixel being 1; NaN,NaN,NaN,NaN if it is lost
    Otb,
    /// x,y,width,height; 0 if it is lost
    Vot,
    /// Names in the first line, then frame, box, state and the figures behind it; empty where there are none. With names of targets the
    /// first column is the target. Frames before its box have no line
    Csv,
}

const CSV_NAMES: &str = "frame,x,y,width,height,state,confidence,ratio,runner_up_ratio,alpha,scale,work\n";

/// One frame as JSON. The boxes are null when the target is lost; what the method does not know is null, too.
#[derive(Serialize)]
struct JsonLine<'a> {
    #[serde(flatten)]
    origin: &'a Origin,
    #[serde(skip_serializing_if = "Option::is_none")]
    target: Option<&'a str>,
    /// As the recording counts it: the first is 1.
    frame: usize,
    state: &'static str,
    /// In whole pixels.
    #[serde(rename = "box")]
    bbox: Option<Whole>,
    /// In pixels and fractions of them.
    fine: Option<BoundingBox>,
    confidence: Option<f64>,
    ratio: Option<f64>,
    runner_up_ratio: Option<f64>,
    alpha: Option<u16>,
    scale: Option<f64>,
    found_again: Option<bool>,
    work: Option<u32>,
    /// Of the frame that was locked on: how well the target can be told from what lies beside it, 0 to 1.
    quality: Option<f64>,
}

#[derive(Serialize)]
struct Whole {
    x: i32,
    y: i32,
    width: u16,
    height: u16,
}

impl From<Rect> for Whole {
    fn from(Rect { x, y, width, height }: Rect) -> Self {
        Self { x, y, width, height }
    }
}

pub struct Printer {
    /// `None`: JSON.
    pub format: Option<Format>,
    pub origin: Origin,
    /// Lines of CSV begin with the target's name.
    pub is_named: bool,
}

pub struct Answer<'a> {
    pub target: Option<&'a str>,
    /// As the recording counts it.
    pub frame: usize,
    /// `None` before the target's first box.
    pub report: Option<&'a Report>,
    /// In a frame that the target was locked on.
    pub quality: Option<Quality>,
}

impl Printer {
    /// What stands before the first line.
    pub fn head(&self) -> String {
        let target = if self.is_named { "target," } else { "" };
        if self.format == Some(Format::Csv) { format!("{target}{CSV_NAMES}") } else { String::new() }
    }

    /// A line with its end; nothing where the form has no line.
    pub fn line(&self, answer: &Answer<'_>) -> Result<String> {
        let form = match self.format {
            Some(Format::Tld) => Form::Tld,
            Some(Format::Otb) => Form::Otb,
            Some(Format::Vot) => Form::Vot,
            Some(Format::Csv) => return Ok(self.csv(answer)),
            None => return self.json(answer),
        };
        Ok(form.line(answer.report.and_then(|report| report.target).as_ref()) + "\n")
    }

    fn csv(&self, answer: &Answer<'_>) -> String {
        let name = answer.target.filter(|_| self.is_named).map_or(String::new(), |name| format!("{name},"));
        answer.report.map_or(String::new(), |report| format!("{name}{}\n", csv_line(answer.frame, report)))
    }

    fn json(&self, answer: &Answer<'_>) -> Result<String> {
        let &Answer { target, frame, report: Some(report), quality } = answer else { return Ok(String::new()) };
        let evidence = report.evidence.as_ref();
        let line = serde_json::to_string(&JsonLine {
            origin: &self.origin,
            target,
            frame,
            state: name_of(report.state),
            bbox: report.bbox.map(Whole::from),
            fine: report.target,
            confidence: evidence.map(|evidence| rounded(evidence.confidence)),
            ratio: evidence.map(|evidence| rounded(evidence.ratio)),
            runner_up_ratio: evidence.and_then(|evidence| evidence.runner_up_ratio).map(rounded),
            alpha: evidence.and_then(|evidence| evidence.alpha),
            scale: evidence.map(|evidence| rounded(evidence.scale)),
            found_again: evidence.map(|evidence| evidence.found_again),
            work: report.work,
            quality: quality.map(|quality| rounded(f64::from(quality.value()) / f64::from(u16::MAX))),
        })?;
        Ok(line + "\n")
    }
}

fn csv_line(frame: usize, report: &Report) -> String {
    let field = |value: Option<String>| value.unwrap_or_default();
    let target = report.target.map(|BoundingBox { x, y, width, height }| format!("{x},{y},{width},{height}"));
    let evidence = report.evidence.as_ref();
    let figure =
        |figure: fn(&Evidence) -> Option<f64>| field(evidence.and_then(figure).map(|value| rounded(value).to_string()));
    [
        frame.to_string(),
        target.unwrap_or_else(|| ",,,".to_owned()),
        name_of(report.state).to_owned(),
        figure(|evidence| Some(evidence.confidence)),
        figure(|evidence| Some(evidence.ratio)),
        figure(|evidence| evidence.runner_up_ratio),
        figure(|evidence| evidence.alpha.map(f64::from)),
        figure(|evidence| Some(evidence.scale)),
        field(report.work.map(|work| work.to_string())),
    ]
    .join(",")
}

/// To six digits: more than the 1/65535 that a ratio is made of needs.
fn rounded(ratio: f64) -> f64 {
    (ratio * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::{State, paper};
    use smr_evaluation::{Configs, MethodKind, Variant};

    fn printer(format: Option<Format>, method: MethodKind) -> Printer {
        let origin = Variant::new(method, &Configs::from(paper::Config::paper())).origin();
        Printer { format, origin, is_named: false }
    }

    fn line(format: Option<Format>, method: MethodKind, report: &Report) -> String {
        let answer = Answer { target: None, frame: 7, report: Some(report), quality: None };
        printer(format, method).line(&answer).unwrap()
    }

    /// What stands first in every line.
    fn head(method: &str) -> String {
        format!(r#"{{"version":"{}","method":"{method}","options":{{}},"frame":7,"#, env!("CARGO_PKG_VERSION"))
    }

    #[test]
    fn a_found_target() {
        let bbox = Rect::new(-2, 5, 10, 20);
        let report = Report { state: State::Leaving, ..Report::locked(bbox) };
        let text = |format| line(Some(format), MethodKind::Sad, &report);
        assert_eq!(text(Format::Tld), "-2,5,8,25\n");
        assert_eq!(text(Format::Otb), "-1,6,10,20\n");
        assert_eq!(text(Format::Vot), "-2,5,10,20\n");
        let csv = text(Format::Csv);
        assert_eq!(
            (csv.as_str(), csv.matches(',').count()),
            ("7,-2,5,10,20,leaving,,,,,,\n", CSV_NAMES.matches(',').count())
        );
        let expected = r#""state":"leaving","box":{"x":-2,"y":5,"width":10,"height":20},"#;
        let fine = r#""fine":{"x":-2.0,"y":5.0,"width":10.0,"height":20.0},"#;
        let nothing = r#""confidence":null,"ratio":null,"runner_up_ratio":null,"alpha":null,"scale":null,"#;
        let end = "\"found_again\":null,\"work\":null,\"quality\":null}\n";
        assert_eq!(line(None, MethodKind::Sad, &report), [&head("sad"), expected, fine, nothing, end].concat());
    }

    #[test]
    fn a_lost_target() {
        let evidence = Evidence {
            confidence: 0.0,
            ratio: 2.0 / 3.0,
            runner_up_ratio: Some(0.5),
            alpha: Some(13),
            scale: 1.0,
            found_again: false,
        };
        let (state, evidence) = (State::Lost, Some(evidence));
        let report = Report { target: None, bbox: None, state, evidence, work: Some(9) };
        let text = |format| line(Some(format), MethodKind::Smr, &report);
        assert_eq!(text(Format::Tld), "NaN,NaN,NaN,NaN\n");
        assert_eq!(text(Format::Vot), "0\n");
        assert_eq!(text(Format::Csv), "7,,,,,lost,0,0.666667,0.5,13,1,9\n");
        let expected = r#""state":"lost","box":null,"fine":null,"confidence":0.0,"ratio":0.666667,"#;
        let rest = r#""runner_up_ratio":0.5,"alpha":13,"scale":1.0,"found_again":false,"work":9,"quality":null}"#;
        assert_eq!(line(None, MethodKind::Smr, &report), [&head("smr"), expected, rest, "\n"].concat());
    }

    #[test]
    fn lines_of_several_targets_have_names() {
        let report = Report::locked(Rect::new(1, 2, 3, 4));
        let named = |format| Printer { is_named: true, ..printer(format, MethodKind::Robust) };
        let of = |report| Answer { target: Some("car"), frame: 120, report, quality: None };
        let csv = named(Some(Format::Csv));
        assert_eq!(csv.head(), format!("target,{CSV_NAMES}"));
        assert_eq!(csv.line(&of(Some(&report))).unwrap(), "car,120,1,2,3,4,tracking,,,,,,\n");
        assert!(named(None).line(&of(Some(&report))).unwrap().contains(r#""target":"car","frame":120,"#));
    }

    #[test]
    fn before_the_first_box_only_forms_with_a_line_a_frame_have_one() {
        let of = |format| {
            printer(format, MethodKind::Robust).line(&Answer { target: None, frame: 1, report: None, quality: None })
        };
        assert_eq!(of(Some(Format::Tld)).unwrap(), "NaN,NaN,NaN,NaN\n");
        assert_eq!((of(Some(Format::Csv)).unwrap(), of(None).unwrap()), (String::new(), String::new()));
    }
}
