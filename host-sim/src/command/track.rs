//! `host-sim track`: the target's box in every frame, as it is found.

use super::Outcome;
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use crate::evaluate::{MethodKind, Report, Run};
use crate::output::{Output, print};
use crate::sequence::{BoundingBox, boxes};
use anyhow::{Context, Result};
use serde::Serialize;
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

/// One frame as JSON. `bbox` is null when the target is lost; what the method does not know is null, too.
#[derive(Serialize)]
struct JsonLine {
    /// The first is 1.
    frame: usize,
    state: &'static str,
    bbox: Option<BoundingBox>,
    ratio: Option<f64>,
    runner_up_ratio: Option<f64>,
    alpha: Option<u16>,
}

impl Track {
    pub fn run(self) -> Result<Outcome> {
        self.tracker.check_for(&[self.method])?;
        let method = self.method.build(&self.tracker.configs()?)?;
        let sequence = self.recording.open(&self.sequence)?;
        let mut run = Run::new(method, sequence.start()?);
        let mut file = self.out.as_deref().map(Output::create).transpose()?;
        for (number, frame) in (1..).zip(sequence.frames) {
            let report = run.step(&frame?).with_context(|| sequence.name.clone())?;
            let line = self.line(number, &report)? + "\n";
            match &mut file {
                Some(file) => file.write(line.as_bytes())?,
                // Each line is out before the next frame is read: if that one is bad, nothing is lost.
                None => print(|out| out.write_all(line.as_bytes()))?,
            }
        }
        file.map_or(Ok(()), Output::finish)?;
        Ok(Outcome::Holds)
    }

    fn line(&self, frame: usize, report: &Report) -> Result<String> {
        let bbox = report.target;
        if !self.json {
            return Ok(boxes::tld_line(bbox.as_ref()));
        }
        let evidence = report.evidence.as_ref();
        Ok(serde_json::to_string(&JsonLine {
            frame,
            state: report.state.name(),
            bbox,
            ratio: evidence.map(|evidence| rounded(evidence.ratio)),
            runner_up_ratio: evidence.and_then(|evidence| evidence.runner_up_ratio).map(rounded),
            alpha: evidence.and_then(|evidence| evidence.alpha),
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
    use crate::evaluate::{Evidence, State};
    use clap::Parser;
    use smr_core::Rect;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        track: Track,
    }

    fn line(arguments: &[&str], report: &Report) -> String {
        let line = Line::parse_from([&["track", "SEQ"], arguments].concat());
        line.track.line(7, report).unwrap()
    }

    #[test]
    fn a_found_target() {
        let report = Report {
            target: Some(Rect::new(-2, 5, 10, 20).into()),
            state: State::Leaving,
            evidence: None,
            comparisons: None,
        };
        assert_eq!(line(&[], &report), "-2,5,8,25");
        let expected = r#"{"frame":7,"state":"leaving","bbox":{"x":-2.0,"y":5.0,"width":10.0,"height":20.0},"#;
        let nothing = r#""ratio":null,"runner_up_ratio":null,"alpha":null}"#;
        assert_eq!(line(&["--json"], &report), format!("{expected}{nothing}"));
    }

    #[test]
    fn a_lost_target() {
        let evidence = Some(Evidence { ratio: 2.0 / 3.0, runner_up_ratio: Some(0.5), alpha: Some(13) });
        let report = Report { target: None, state: State::Lost, evidence, comparisons: None };
        assert_eq!(line(&[], &report), "NaN,NaN,NaN,NaN");
        let expected = r#"{"frame":7,"state":"lost","bbox":null,"ratio":0.666667,"runner_up_ratio":0.5,"alpha":13}"#;
        assert_eq!(line(&["--json"], &report), expected);
    }
}
