//! `host-sim track`: the target's box in every frame, as it is found.

use super::film::Film;
use super::number::whole;
use super::places::Places;
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{Outcome, is_closed_pipe, progress};
use crate::evaluate::{Evidence, MethodKind, Origin, Report, Run, name_of};
use crate::output::{Output, print};
use crate::sequence::BoundingBox;
use crate::sequence::boxes::Form;
use anyhow::{Context, Result};
use clap::ValueEnum;
use indicatif::ProgressBar;
use serde::Serialize;
use smr_core::{Quality, Rect};
use std::io::{IsTerminal, Write, stdout};
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Track {
    /// The recording; `-` is Y4M from standard input, answered as it comes
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// How the target is followed
    #[arg(long, value_enum, default_value = "smr")]
    method: MethodKind,
    /// The format of a line
    #[arg(long, value_enum, default_value = "tld")]
    format: Format,
    /// Print one JSON object for each frame instead
    ///
    /// Each has version, method, options (those that were given), frame, state, box (whole pixels), fine (with fractions), confidence, ratio,
    /// runner_up_ratio, alpha, scale, found_again, work and quality. What the method does not know is null; so are both boxes while the target
    /// is lost.
    #[arg(long, conflicts_with = "format")]
    json: bool,
    /// Write to this file instead of standard output; after an error there is no file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Also draw the boxes over the frames: .mp4 (needs ffmpeg), .gif, or a new folder for PNG pictures
    ///
    /// The box is green while the target is tracking, amber when it is uncertain or leaving, and red, at its last place, when it is lost. Ground
    /// truth is white. The text has the number of the frame, the state, and the confidence in hundredths. If the reader of the printed boxes goes
    /// away (`| head`), the video is still finished. A GIF of 640x480 takes 0.2 MB for each frame: --resize 1/2 helps.
    #[arg(long, value_name = "FILE|DIR")]
    video: Option<PathBuf>,
    /// Frames per second of the video
    #[arg(long, value_name = "RATE", default_value = "25", requires = "video", value_parser = whole::<NonZeroU16>(1..=65535))]
    rate: NonZeroU16,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

/// What a line holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// x1,y1,x2,y2; NaN,NaN,NaN,NaN if the target is lost
    Tld,
    /// x,y,width,height, the first pixel being 1; NaN,NaN,NaN,NaN if it is lost
    Otb,
    /// x,y,width,height; 0 if it is lost
    Vot,
    /// Names in the first line, then frame, box, state and the figures behind it; empty where there are none
    Csv,
}

const CSV_NAMES: &str = "frame,x,y,width,height,state,confidence,ratio,runner_up_ratio,alpha,scale,work\n";

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
    /// Of the frame that was locked on: how well the target can be told from what lies beside it, 0 to 1.
    quality: Option<f64>,
}

/// What is said of a target of poor quality.
const POOR: &str = "the target can hardly be told from what lies beside it: expected a box with more texture";

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
    /// What is read and written.
    pub fn places(&self) -> Places<'_> {
        Places::of([&self.sequence]).writes("--out", self.out.as_ref()).writes("--video", self.video.as_ref())
    }

    pub fn run(self) -> Result<Outcome> {
        let variant = self.tracker.variant(self.method)?;
        let (method, origin) = (variant.build()?, variant.origin());
        let mut sequence = self.recording.open(&self.sequence)?;
        let mut run = Run::new(method, sequence.start()?);
        let mut lines = Lines::create(self.out.as_deref(), self.video.is_some())?;
        let truth = sequence.truth.take();
        let patience = self.recording.ffmpeg_patience();
        let film = self.video.as_deref().map(|video| Film::create(video, self.rate, patience, truth));
        let mut film = film.transpose()?;
        // Lines on the same terminal show how far it is.
        let shown = self.out.is_some() || !stdout().is_terminal();
        let bar = if shown { progress::bar(&sequence.name, sequence.length) } else { ProgressBar::hidden() };
        if self.format == Format::Csv {
            lines.write(CSV_NAMES)?;
        }
        for (number, frame) in (1..).zip(sequence.frames) {
            let frame = frame?;
            let report = run.step(&frame).with_context(|| sequence.name.clone())?;
            let quality = run.quality().filter(|_| number == 1);
            if quality.is_some_and(Quality::is_poor) {
                bar.suspend(|| eprintln!("warning: {}: {}", sequence.name, POOR));
            }
            lines.write(&(self.line(number, &report, quality, &origin)? + "\n"))?;
            film.as_mut().map_or(Ok(()), |film| film.frame(&frame, &report))?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        film.map_or(Ok(()), Film::finish)?;
        lines.finish()?;
        Ok(Outcome::Holds)
    }

    fn line(&self, frame: usize, report: &Report, quality: Option<Quality>, origin: &Origin) -> Result<String> {
        if !self.json {
            let form = match self.format {
                Format::Tld => Form::Tld,
                Format::Otb => Form::Otb,
                Format::Vot => Form::Vot,
                Format::Csv => return Ok(csv_line(frame, report)),
            };
            return Ok(form.line(report.target.as_ref()));
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
            quality: quality.map(|quality| rounded(f64::from(quality.value()) / f64::from(u16::MAX))),
        })?)
    }
}

/// Where lines go: each is out before the next frame is read, or all are in a file in the end. If a frame is bad, nothing is lost that was
/// printed before.
enum Lines {
    /// That nobody reads them ends the command, unless it writes something else, too.
    Printed {
        goes_on: bool,
    },
    File(Output),
    /// Nobody reads them any more.
    Unread,
}

impl Lines {
    fn create(file: Option<&Path>, goes_on: bool) -> Result<Self> {
        file.map_or(Ok(Self::Printed { goes_on }), |file| Output::create(file).map(Self::File))
    }

    fn write(&mut self, text: &str) -> Result<()> {
        match self {
            Self::Printed { goes_on } => match print(|out| out.write_all(text.as_bytes())) {
                Err(error) if *goes_on && is_closed_pipe(&error) => *self = Self::Unread,
                printed => printed?,
            },
            Self::File(file) => file.write(text.as_bytes())?,
            Self::Unread => {}
        }
        Ok(())
    }

    fn finish(self) -> Result<()> {
        match self {
            Self::Printed { .. } | Self::Unread => Ok(()),
            Self::File(file) => file.finish(),
        }
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
        line.track.line(7, report, None, &origin).unwrap()
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
        assert_eq!(line(&["--format", "otb"], &report), "-1,6,10,20");
        assert_eq!(line(&["--format", "vot"], &report), "-2,5,10,20");
        let csv = line(&["--format", "csv"], &report);
        assert_eq!(
            (csv.as_str(), csv.matches(',').count()),
            ("7,-2,5,10,20,leaving,,,,,,", CSV_NAMES.matches(',').count())
        );
        let expected = r#""state":"leaving","box":{"x":-2,"y":5,"width":10,"height":20},"#;
        let fine = r#""fine":{"x":-2.0,"y":5.0,"width":10.0,"height":20.0},"#;
        let nothing = r#""confidence":null,"ratio":null,"runner_up_ratio":null,"alpha":null,"scale":null,"#;
        let end = r#""found_again":null,"work":null,"quality":null}"#;
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
        assert_eq!(line(&["--format", "vot"], &report), "0");
        assert_eq!(line(&["--format", "csv"], &report), "7,,,,,lost,0,0.666667,0.5,13,1,9");
        let expected = r#""state":"lost","box":null,"fine":null,"confidence":0.0,"ratio":0.666667,"#;
        let rest = r#""runner_up_ratio":0.5,"alpha":13,"scale":1.0,"found_again":false,"work":9,"quality":null}"#;
        assert_eq!(line(&["--json"], &report), [&head("smr", "{}"), expected, rest].concat());
    }
}
