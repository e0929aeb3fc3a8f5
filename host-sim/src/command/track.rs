//! `host-sim track`: the target's box in every frame, as it is found.

use super::Outcome;
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use crate::evaluate::{MethodKind, Origin, Report, Run, name_of};
use crate::output::{Output, print};
use crate::sequence::{BoundingBox, boxes};
use anyhow::{Context, Result};
use serde::Serialize;
use smr_core::Rect;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Track {
    /// The recording
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// How the target is followed
    #[arg(long, value_enum, default_value = "smr")]
    method: MethodKind,
    /// Print one JSON object a frame instead of x1,y1,x2,y2
    #[arg(long)]
    json: bool,
    /// Write to this file instead of standard output; if something goes wrong on the way it is not written
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

/// One frame as JSON. The boxes are null when the target is lost; what the method does not know is null, too.
#[derive(Serialize)]
struct JsonLine<'a> {
    #[serde(flatten)]
    origin: &'a Origin,
    /// The first is 1.
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
}

/// A box in whole pixels.
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

impl Track {
    pub fn run(self) -> Result<Outcome> {
        let variant = self.tracker.variant(self.method)?;
        let (method, origin) = (variant.build()?, variant.origin());
        let sequence = self.recording.open(&self.sequence)?;
        let mut run = Run::new(method, sequence.start()?);
        let mut file = self.out.as_deref().map(Output::create).transpose()?;
        for (number, frame) in (1..).zip(sequence.frames) {
            let report = run.step(&frame?).with_context(|| sequence.name.clone())?;
            let line = self.line(number, &report, &origin)? + "\n";
            match &mut file {
                Some(file) => file.write(line.as_bytes())?,
                // Each line is out before the next frame is read: if that one is bad, nothing is lost.
                None => print(|out| out.write_all(line.as_bytes()))?,
            }
        }
        file.map_or(Ok(()), Output::finish)?;
        Ok(Outcome::Holds)
    }

    fn line(&self, frame: usize, report: &Report, origin: &Origin) -> Result<String> {
        if !self.json {
            return Ok(boxes::tld_line(report.target.as_ref()));
        }
        let evidence = report.evidence.as_ref();
        Ok(serde_json::to_string(&JsonLine {
            origin,
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
        })?)
    }
}

/// To six digits: more than the 1/65535 that a ratio is made of needs.
fn rounded(ratio: f64) -> f64 {
    (ratio * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Evidence;
    use clap::Parser;
    use smr_core::State;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        track: Track,
    }

    fn line(arguments: &[&str], report: &Report) -> String {
        let line = Line::parse_from([&["track", "SEQ"], arguments].concat());
        let origin = line.track.tracker.variant(line.track.method).unwrap().origin();
        line.track.line(7, report, &origin).unwrap()
    }

    /// What stands first in every line.
    fn head(method: &str, options: &str) -> String {
        format!(r#"{{"version":"{}","method":"{method}","options":{options},"frame":7,"#, env!("CARGO_PKG_VERSION"))
    }

    #[test]
    fn a_found_target() {
        let bbox = Rect::new(-2, 5, 10, 20);
        let report = Report { state: State::Leaving, ..Report::locked(bbox) };
        assert_eq!(line(&[], &report), "-2,5,8,25");
        let expected = r#""state":"leaving","box":{"x":-2,"y":5,"width":10,"height":20},"#;
        let fine = r#""fine":{"x":-2.0,"y":5.0,"width":10.0,"height":20.0},"#;
        let nothing = r#""confidence":null,"ratio":null,"runner_up_ratio":null,"alpha":null,"scale":null,"#;
        let end = r#""found_again":null,"work":null}"#;
        let head = head("sad", r#"{"window":"9x8"}"#);
        let arguments = ["--json", "--method", "sad", "--window", "9x8"];
        assert_eq!(line(&arguments, &report), [&head, expected, fine, nothing, end].concat());
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
        assert_eq!(line(&[], &report), "NaN,NaN,NaN,NaN");
        let expected = r#""state":"lost","box":null,"fine":null,"confidence":0.0,"ratio":0.666667,"#;
        let rest = r#""runner_up_ratio":0.5,"alpha":13,"scale":1.0,"found_again":false,"work":9}"#;
        assert_eq!(line(&["--json"], &report), [&head("smr", "{}"), expected, rest].concat());
    }
}
