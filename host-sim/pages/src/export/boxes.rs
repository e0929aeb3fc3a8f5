//! Prints trackers' answers in the formats of host-sim, of toolkits and of annotation tools. A file consists of
//! [`Printer::head`], a [`Printer::line`] for each target in each frame, and [`Printer::foot`].

mod coco;
mod cvat;
#[cfg(test)]
mod round_trip;

use anyhow::Result;
use clap::ValueEnum;
use serde::Serialize;
use smr_core::{Quality, Rect};
use smr_evaluation::{Evidence, MethodAnswer, Origin, name_of};
use smr_recordings::BoundingBox;
use smr_recordings::boxes::Form;
use std::path::Path;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// x1,y1,x2,y2; NaN,NaN,NaN,NaN if the target is lost, or in frames before its box
    Tld,
    /// x,y,width,height, the first pixel being 1; NaN,NaN,NaN,NaN if it is lost
    Otb,
    /// x,y,width,height; 0 if it is lost
    Vot,
    /// x,y,width,height; 0,0,0,0 if it is lost
    Got10k,
    /// MOTChallenge: frame,number of the target,x,y,width,height,confidence,-1,-1,-1, the first pixel being 1; no line if it is lost
    Mot,
    /// Names in the first line, then frame, time in seconds, box, state, the figures behind it, the box's centre and its speed in pixels a second since the
    /// target's frame before (with --pixels-per-metre also in metres); empty where there are none. With names of targets the first column is the target,
    /// of several recordings the second, after the recording. Frames before its box have no line
    Csv,
    /// One object for each frame, as --json
    Json,
    /// COCO, one JSON object: images, annotations (with score and track_id), categories
    Coco,
    /// CVAT XML 1.1 for video: a track for each target, with a key frame in each frame, and outside where it is lost or gone
    Cvat,
}

impl Format {
    /// True if the format says which target a box belongs to.
    pub const fn has_names(self) -> bool {
        matches!(self, Self::Csv | Self::Json | Self::Mot | Self::Coco | Self::Cvat)
    }

    /// The extensions of files with boxes; `txt` is for any format.
    pub const ENDINGS: [&str; 5] = ["txt", "csv", "json", "jsonl", "xml"];

    /// Extensions of the format's files except `txt`, the usual one last.
    pub const fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Csv => &["csv"],
            Self::Json => &["json", "jsonl"],
            Self::Coco => &["json"],
            Self::Cvat => &["xml"],
            Self::Tld | Self::Otb | Self::Vot | Self::Got10k | Self::Mot => &[],
        }
    }

    pub fn is_called(self, file: &Path) -> bool {
        let ending = file.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|ending| self.endings().iter().any(|known| ending.eq_ignore_ascii_case(known)))
    }

    pub fn of_file(file: &Path) -> Option<Self> {
        [Self::Csv, Self::Json, Self::Cvat].into_iter().find(|format| format.is_called(file))
    }
}

/// The recording and its targets, as known before the first frame.
pub struct About {
    pub name: String,
    /// True if the file has several recordings: CSV and JSON then say the recording and the target of each answer.
    pub is_one_of_several: bool,
    pub origin: Origin,
    /// Name of each target; `None` for a single target without a name.
    pub targets: Vec<Option<String>>,
    /// File names of the frames, if the recording is a folder of pictures; else empty.
    pub images: Vec<String>,
    /// True if CSV has columns in metres.
    pub has_metres: bool,
    /// Pixels of a metre across and down; `None` if no length in the picture is known, which leaves the columns empty.
    pub pixels_per_metre: Option<(f64, f64)>,
}

impl About {
    fn label(&self, target: usize) -> &str {
        self.targets.get(target).and_then(Option::as_deref).unwrap_or("target")
    }
}

pub struct Answer<'a> {
    /// Index in [`About::targets`].
    pub target: usize,
    pub frame: usize,
    /// Time of the frame in seconds, if known.
    pub time: Option<f64>,
    pub size: (u16, u16),
    /// `None` before the target's first box, and while the target is gone.
    pub report: Option<&'a MethodAnswer>,
    /// Suitability of the target for tracking; `None` except in a frame in which the tracker locks on.
    pub quality: Option<Quality>,
}

pub struct Printer {
    format: Format,
    about: About,
    coco: coco::Images,
    cvat: cvat::Tracks,
    /// The time and the centre of each target in its last frame; `None` without a time or a box.
    former: Vec<Option<(f64, (f64, f64))>>,
}

impl Printer {
    pub fn new(format: Format, about: About) -> Self {
        let targets = about.targets.len();
        let (coco, cvat) = (coco::Images::default(), cvat::Tracks::new(targets));
        Self { format, about, coco, cvat, former: vec![None; targets] }
    }

    pub fn head(&self) -> String {
        match self.format {
            Format::Csv => {
                let recording = if self.about.is_one_of_several { "recording," } else { "" };
                let metres = if self.about.has_metres { METRE_NAMES } else { "" };
                format!("{recording}{}{CSV_NAMES}{metres}\n", if self.is_named() { "target," } else { "" })
            }
            Format::Coco => coco::head(&self.about),
            _ => String::new(),
        }
    }

    fn is_named(&self) -> bool {
        self.about.is_one_of_several || self.about.targets.iter().any(Option::is_some)
    }

    /// Name of the recording, if the file has several.
    fn recording(&self) -> Option<&str> {
        self.about.is_one_of_several.then_some(&*self.about.name)
    }

    /// Returns the text of an answer; empty if the format has no line for it.
    pub fn line(&mut self, answer: &Answer<'_>) -> Result<String> {
        let form = match self.format {
            Format::Tld => Form::Tld,
            Format::Otb => Form::Otb,
            Format::Vot => Form::Vot,
            Format::Got10k if answer.report.is_none_or(|report| report.target.is_none()) => {
                return Ok("0,0,0,0\n".to_owned());
            }
            Format::Got10k => Form::Vot,
            Format::Mot => return Ok(mot(answer)),
            Format::Csv => {
                let recording = self.recording().map_or(String::new(), |name| csv_text(name) + ",");
                let name =
                    if self.is_named() { self.about.label(answer.target).to_owned() + "," } else { String::new() };
                let way = self.way(answer);
                let line =
                    |report| recording + &name + &csv_line(answer, report, way) + &self.metres(report, way) + "\n";
                return Ok(answer.report.map_or(String::new(), line));
            }
            Format::Json => return self.json(answer),
            Format::Coco => return self.coco.annotation(answer),
            Format::Cvat => {
                self.cvat.add(answer);
                return Ok(String::new());
            }
        };
        Ok(form.line(answer.report.and_then(|report| report.target).as_ref()) + "\n")
    }

    pub fn foot(&self) -> Result<String> {
        match self.format {
            Format::Coco => self.coco.foot(&self.about),
            Format::Cvat => Ok(self.cvat.text(&self.about)),
            _ => Ok(String::new()),
        }
    }

    /// Returns the way of the target's centre since its frame before; `None` if one of both frames has no box or no time.
    /// Times are those that are printed: a browser knows no finer ones, and its speeds are the same.
    fn way(&mut self, answer: &Answer<'_>) -> Option<Way> {
        let time = answer.time.map(rounded);
        let present = time.zip(answer.report.and_then(|report| report.target).map(|target| target.centre()));
        let former = std::mem::replace(self.former.get_mut(answer.target)?, present);
        let ((before, from), (now, to)) = former.zip(present)?;
        let (right, down) = (to.0 - from.0, to.1 - from.1);
        (now > before).then_some(Way { right, down, seconds: now - before })
    }

    /// Returns the columns in metres, each with a comma before it; empty if there are none.
    fn metres(&self, report: &MethodAnswer, way: Option<Way>) -> String {
        if !self.about.has_metres {
            return String::new();
        }
        let scale = self.about.pixels_per_metre;
        let centre = scale.zip(report.target.map(|target| target.centre()));
        let place = |((across, down), (x, y)): ((f64, f64), (f64, f64))| {
            format!("{},{}", rounded(x / across), rounded(y / down))
        };
        let speed = scale.zip(way).map(|(scale, way)| way.speed(scale));
        format!(",{},{}", centre.map_or_else(|| ",".to_owned(), place), speed.unwrap_or_default())
    }

    fn json(&self, answer: &Answer<'_>) -> Result<String> {
        let &Answer { target, frame, time, report: Some(report), quality, .. } = answer else {
            return Ok(String::new());
        };
        let evidence = report.evidence.as_ref();
        let line = serde_json::to_string(&JsonLine {
            recording: self.recording(),
            origin: &self.about.origin,
            target: self.is_named().then(|| self.about.label(target)),
            frame,
            time: time.map(rounded),
            state: name_of(report.state),
            bbox: report.bbox.map(|Rect { x, y, width, height }| Whole { x, y, width, height }),
            fine: report.target,
            confidence: evidence.map(|evidence| rounded(evidence.confidence)),
            ratio: evidence.map(|evidence| rounded(evidence.ratio)),
            runner_up_ratio: evidence.and_then(|evidence| evidence.runner_up_ratio).map(rounded),
            alpha: evidence.and_then(|evidence| evidence.alpha),
            identity: evidence.and_then(|evidence| evidence.identity).map(rounded),
            scale: evidence.map(|evidence| rounded(evidence.scale)),
            found_again: evidence.map(|evidence| evidence.found_again),
            work: report.work,
            quality: quality.map(|quality| rounded(f64::from(quality.value()) / f64::from(u16::MAX))),
        })?;
        Ok(line + "\n")
    }
}

const CSV_NAMES: &str = "frame,time,x,y,width,height,state,confidence,ratio,runner_up_ratio,alpha,identity,scale,work,centre_x,centre_y,speed";
const METRE_NAMES: &str = ",centre_x_m,centre_y_m,speed_m_s";

/// The way of a centre in pixels, and the time that it took.
#[derive(Clone, Copy)]
struct Way {
    right: f64,
    down: f64,
    seconds: f64,
}

impl Way {
    /// Returns the speed as CSV, in units of which each has these numbers of pixels across and down.
    fn speed(self, (across, down): (f64, f64)) -> String {
        rounded((self.right / across).hypot(self.down / down) / self.seconds).to_string()
    }
}

/// One answer as JSON. Boxes are null if the target is lost, and values that the method does not compute are null.
#[derive(Serialize)]
struct JsonLine<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<&'a str>,
    #[serde(flatten)]
    origin: &'a Origin,
    #[serde(skip_serializing_if = "Option::is_none")]
    target: Option<&'a str>,
    frame: usize,
    time: Option<f64>,
    state: &'static str,
    #[serde(rename = "box")]
    bbox: Option<Whole>,
    fine: Option<BoundingBox>,
    confidence: Option<f64>,
    ratio: Option<f64>,
    runner_up_ratio: Option<f64>,
    alpha: Option<u16>,
    identity: Option<f64>,
    scale: Option<f64>,
    found_again: Option<bool>,
    work: Option<u32>,
    /// Suitability of the target for tracking, 0 (looks like its surroundings) to 1 (differs clearly); null except in a
    /// frame in which the tracker locks on.
    quality: Option<f64>,
}

#[derive(Serialize)]
struct Whole {
    x: i32,
    y: i32,
    width: u16,
    height: u16,
}

/// Formats a line of MOTChallenge (arXiv:1603.00831): frames, targets and pixels count from 1; an unknown value is -1.
fn mot(&Answer { target, frame, report, .. }: &Answer<'_>) -> String {
    let Some((report, BoundingBox { x, y, width, height })) = report.and_then(|report| Some((report, report.target?)))
    else {
        return String::new();
    };
    let (number, confidence) = (target + 1, score(report));
    format!("{frame},{number},{},{},{width},{height},{confidence},-1,-1,-1\n", x + 1.0, y + 1.0)
}

/// Returns the confidence; 1 for a box that the user gave, or from a method that computes no confidence.
fn score(report: &MethodAnswer) -> f64 {
    report.confidence().map_or(1.0, rounded)
}

/// Returns a text as a field of CSV (RFC 4180): in quotes, if it has a comma or a quote.
fn csv_text(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

fn csv_line(answer: &Answer<'_>, report: &MethodAnswer, way: Option<Way>) -> String {
    let field = |value: Option<String>| value.unwrap_or_default();
    let target = report.target.map(|BoundingBox { x, y, width, height }| format!("{x},{y},{width},{height}"));
    let centre = report.target.map(|target| target.centre());
    let figure = |figure: fn(&Evidence) -> Option<f64>| {
        field(report.evidence.as_ref().and_then(figure).map(|value| rounded(value).to_string()))
    };
    let fields = [
        answer.frame.to_string(),
        field(answer.time.map(|time| rounded(time).to_string())),
        target.unwrap_or_else(|| ",,,".to_owned()),
        name_of(report.state).to_owned(),
        figure(|evidence| Some(evidence.confidence)),
        figure(|evidence| Some(evidence.ratio)),
        figure(|evidence| evidence.runner_up_ratio),
        figure(|evidence| evidence.alpha.map(f64::from)),
        figure(|evidence| evidence.identity),
        figure(|evidence| Some(evidence.scale)),
        field(report.work.map(|work| work.to_string())),
        centre.map_or_else(|| ",".to_owned(), |(x, y)| format!("{x},{y}")),
        field(way.map(|way| way.speed((1.0, 1.0)))),
    ];
    fields.join(",")
}

/// Rounds to six decimals: a microsecond for times, a micrometre, and finer than a ratio's resolution of 1/65535. Zero has
/// no sign.
pub(crate) fn rounded(number: f64) -> f64 {
    (number * 1e6).round() / 1e6 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::PixelsPerMetre;
    use smr_core::{State, paper};
    use smr_evaluation::{Configs, MethodKind, Variant};
    use smr_recordings::annotations::{self, Labelled};

    fn printer(format: Format, method: MethodKind, targets: &[Option<&str>]) -> Printer {
        let origin = Variant::new(method, &Configs::from(paper::Config::paper())).origin();
        let targets = targets.iter().map(|name| name.map(str::to_owned)).collect();
        let name = "a & b".to_owned();
        let about = About {
            name,
            is_one_of_several: false,
            origin,
            targets,
            images: Vec::new(),
            has_metres: false,
            pixels_per_metre: None,
        };
        Printer::new(format, about)
    }

    fn answer(target: usize, frame: usize, report: Option<&MethodAnswer>) -> Answer<'_> {
        Answer { target, frame, time: None, size: (320, 240), report, quality: None }
    }

    #[test]
    fn each_format_has_its_line() {
        let found = MethodAnswer { state: State::Leaving, ..MethodAnswer::locked(Rect::new(-2, 5, 10, 20)) };
        let evidence = Evidence {
            confidence: 0.0,
            ratio: 2.0 / 3.0,
            runner_up_ratio: Some(0.5),
            alpha: Some(13),
            identity: Some(0.75),
            scale: 1.0,
            found_again: false,
        };
        let lost =
            MethodAnswer { target: None, bbox: None, state: State::Lost, evidence: Some(evidence), work: Some(9) };
        let json = |method: &str, rest: &str| {
            let version = env!("CARGO_PKG_VERSION");
            format!(r#"{{"version":"{version}","method":"{method}","options":{{}},"frame":7,"time":null,{rest}}}"#)
                + "\n"
        };
        let json_found = json(
            "sad",
            r#""state":"leaving","box":{"x":-2,"y":5,"width":10,"height":20},"fine":{"x":-2.0,"y":5.0,"width":10.0,"height":20.0},"confidence":null,"ratio":null,"runner_up_ratio":null,"alpha":null,"identity":null,"scale":null,"found_again":null,"work":null,"quality":null"#,
        );
        let json_lost = json(
            "paper",
            r#""state":"lost","box":null,"fine":null,"confidence":0.0,"ratio":0.666667,"runner_up_ratio":0.5,"alpha":13,"identity":0.75,"scale":1.0,"found_again":false,"work":9,"quality":null"#,
        );
        // Before the target's first box, some formats print the line of a lost target; the others print nothing.
        for (format, of_found, of_lost, before) in [
            (Format::Tld, "-2,5,8,25\n", "NaN,NaN,NaN,NaN\n", "NaN,NaN,NaN,NaN\n"),
            (Format::Otb, "-1,6,10,20\n", "NaN,NaN,NaN,NaN\n", "NaN,NaN,NaN,NaN\n"),
            (Format::Vot, "-2,5,10,20\n", "0\n", "0\n"),
            (Format::Got10k, "-2,5,10,20\n", "0,0,0,0\n", "0,0,0,0\n"),
            (Format::Mot, "7,1,-1,6,10,20,1,-1,-1,-1\n", "", ""),
            (Format::Csv, "7,,-2,5,10,20,leaving,,,,,,,,3,15,\n", "7,,,,,,lost,0,0.666667,0.5,13,0.75,1,9,,,\n", ""),
            (Format::Json, &json_found, &json_lost, ""),
        ] {
            let line = |method, report| printer(format, method, &[None]).line(&answer(0, 7, report)).unwrap();
            let lines = [(MethodKind::Sad, Some(&found)), (MethodKind::Paper, Some(&lost)), (MethodKind::Robust, None)];
            let lines = lines.map(|(method, report)| line(method, report));
            assert_eq!(lines, [of_found, of_lost, before], "{format:?}");
        }
        for format in [Format::Coco, Format::Cvat] {
            assert_eq!(printer(format, MethodKind::Robust, &[None]).line(&answer(0, 1, None)).unwrap(), "");
        }
        assert_eq!(CSV_NAMES.matches(',').count(), 16);
    }

    #[test]
    fn lines_of_several_targets_have_names() {
        let report = MethodAnswer::locked(Rect::new(1, 2, 3, 4));
        let named = |format| printer(format, MethodKind::Robust, &[Some("man"), Some("car")]);
        let of = Answer { time: Some(4.8), ..answer(1, 120, Some(&report)) };
        assert_eq!(named(Format::Csv).head(), format!("target,{CSV_NAMES}\n"));
        assert_eq!(named(Format::Csv).line(&of).unwrap(), "car,120,4.8,1,2,3,4,tracking,,,,,,,,2.5,4,\n");
        assert!(named(Format::Json).line(&of).unwrap().contains(r#""target":"car","frame":120,"time":4.8,"#));
        assert_eq!(named(Format::Mot).line(&of).unwrap(), "120,2,2,3,3,4,1,-1,-1,-1\n");
    }

    #[test]
    fn lines_of_several_recordings_begin_with_the_recording() {
        let report = MethodAnswer::locked(Rect::new(1, 2, 3, 4));
        let line = |format, name: &str, target| {
            let mut printer = printer(format, MethodKind::Robust, &[target]);
            printer.about = About { name: name.to_owned(), is_one_of_several: true, ..printer.about };
            (printer.head(), printer.line(&answer(0, 7, Some(&report))).unwrap())
        };
        let (head, named) = line(Format::Csv, "day 1, \"cage\"", Some("car"));
        assert_eq!(head, format!("recording,target,{CSV_NAMES}\n"));
        assert_eq!(named, "\"day 1, \"\"cage\"\"\",car,7,,1,2,3,4,tracking,,,,,,,,2.5,4,\n");
        // A target without a name has one here, so that all lines have the same columns.
        assert_eq!(line(Format::Csv, "a", None), (head, "a,target,7,,1,2,3,4,tracking,,,,,,,,2.5,4,\n".to_owned()));
        let (_, json) = line(Format::Json, "a", None);
        assert!(
            json.starts_with("{\"recording\":\"a\",\"version\":") && json.contains("\"target\":\"target\",\"frame\":7"),
            "{json}"
        );
    }

    #[test]
    fn speed_is_the_way_of_the_centre_over_the_time_between_two_frames_with_a_box() {
        let seen = |x, y, width| MethodAnswer::locked(Rect::new(x, y, width, 4));
        let lost = MethodAnswer { target: None, bbox: None, state: State::Lost, ..seen(0, 0, 1) };
        let mut csv = printer(Format::Csv, MethodKind::Robust, &[Some("a"), Some("b")]);
        // The centre of a box that grows to both sides stays: 3 right and 4 down are 5 pixels.
        for (target, time, report, expected) in [
            (0, Some(1.0), Some(seen(10, 10, 4)), "12,12,"),
            (1, Some(1.0), Some(seen(0, 0, 4)), "2,2,"),
            (0, Some(1.04), Some(seen(12, 14, 6)), "15,16,125"),
            (1, Some(1.04), None, ""),
            (0, Some(1.04), Some(seen(12, 14, 6)), "15,16,"),
            (0, Some(1.08), Some(seen(11, 14, 8)), "15,16,0"),
            (1, Some(1.08), Some(seen(0, 0, 4)), "2,2,"),
            (0, Some(1.12), Some(lost), ",,"),
            (0, Some(1.16), Some(seen(11, 14, 8)), "15,16,"),
            (0, None, Some(seen(12, 14, 8)), "16,16,"),
            (0, Some(1.24), Some(seen(12, 14, 8)), "16,16,"),
        ] {
            let line = csv.line(&Answer { time, ..answer(target, 7, report.as_ref()) }).unwrap();
            let last = line.trim_end().rsplitn(4, ',').take(3).collect::<Vec<_>>();
            assert_eq!(last.into_iter().rev().collect::<Vec<_>>().join(","), expected, "{line}");
        }
    }

    #[test]
    fn a_known_length_adds_columns_in_metres() {
        let mut csv = printer(Format::Csv, MethodKind::Robust, &[None]);
        // Frames of half the width: there are 10 pixels a metre across and 20 down.
        csv.about.has_metres = true;
        csv.about.pixels_per_metre = "20".parse::<PixelsPerMetre>().ok().map(|metre| metre.resized((0.5, 1.0)));
        assert_eq!(csv.head(), format!("{CSV_NAMES},centre_x_m,centre_y_m,speed_m_s\n"));
        let seen = |x, y| MethodAnswer::locked(Rect::new(x, y, 4, 4));
        let lost = MethodAnswer { target: None, bbox: None, state: State::Lost, ..seen(0, 0) };
        // 3 m to the right and 4 m down in half a second.
        for (time, report, expected) in [
            (1.0, seen(8, 0), "10,2,,1,0.1,"),
            (1.5, seen(38, 80), "40,82,170.880075,4,4.1,10"),
            (2.0, lost, ",,,,,"),
            (2.5, seen(-5, -2), "-3,0,,-0.3,0,"),
        ] {
            let line = csv.line(&Answer { time: Some(time), ..answer(0, 7, Some(&report)) }).unwrap();
            assert!(line.ends_with(&format!(",{expected}\n")), "{line}");
        }
        // Of another recording in the table, no length is known.
        csv.about.pixels_per_metre = None;
        let line = csv.line(&answer(0, 7, Some(&seen(8, 0)))).unwrap();
        assert!(line.ends_with(",10,2,,,,\n"), "{line}");
    }

    /// Returns the text of three frames: `man` is visible in the first and the third, `car` from the second on.
    fn text(format: Format) -> String {
        let mut printer = printer(format, MethodKind::Robust, &[Some("man"), Some("car")]);
        let seen = MethodAnswer::locked(Rect::new(1, 2, 30, 40));
        let lost = MethodAnswer { target: None, bbox: None, state: State::Lost, ..seen };
        let mut text = printer.head();
        for (frame, man, car) in [(1, seen, None), (2, lost, Some(&seen)), (3, seen, Some(&seen))] {
            text += &printer.line(&answer(0, frame, Some(&man))).unwrap();
            text += &printer.line(&answer(1, frame, car)).unwrap();
        }
        text + &printer.foot().unwrap()
    }

    #[test]
    fn coco_is_one_object_with_ids_that_fit() {
        let coco: serde_json::Value = serde_json::from_str(&text(Format::Coco)).unwrap();
        assert_eq!(coco["categories"][1], serde_json::json!({"id": 2, "name": "car", "supercategory": ""}));
        let image = serde_json::json!({"id": 3, "file_name": "frame_000002.png", "width": 320, "height": 240});
        assert_eq!((coco["images"].as_array().unwrap().len(), &coco["images"][2]), (3, &image));
        let of = |key: &str| -> Vec<u64> {
            coco["annotations"].as_array().unwrap().iter().map(|annotation| annotation[key].as_u64().unwrap()).collect()
        };
        assert_eq!((of("id"), of("image_id")), (vec![1, 2, 3, 4], vec![1, 2, 3, 3]));
        assert_eq!((of("category_id"), of("iscrowd")), (vec![1, 2, 1, 2], vec![0; 4]));
        let last = &coco["annotations"][3];
        assert_eq!(
            (&last["bbox"], &last["area"]),
            (&serde_json::json!([1.0, 2.0, 30.0, 40.0]), &serde_json::json!(1200.0))
        );
    }

    #[test]
    fn cvat_comes_back_as_what_was_drawn() {
        let seen = MethodAnswer::locked(Rect::new(1, 2, 30, 40));
        let evidence = Evidence {
            confidence: 0.5,
            ratio: 0.5,
            runner_up_ratio: None,
            alpha: None,
            identity: None,
            scale: 1.0,
            found_again: false,
        };
        let answered = MethodAnswer { evidence: Some(evidence), ..seen };
        let lost = MethodAnswer { target: None, bbox: None, state: State::Lost, ..answered };
        let mut cvat = printer(Format::Cvat, MethodKind::Robust, &[None]);
        for (frame, report) in [Some(seen), Some(answered), Some(lost), None, None, Some(seen)].iter().enumerate() {
            cvat.line(&answer(0, frame + 1, report.as_ref())).unwrap();
        }
        let of = Labelled { name: "", size: (320, 240), frames: None };
        let read = annotations::parse(cvat.foot().unwrap().as_bytes(), &of).unwrap();
        assert_eq!(read[0].rects().unwrap(), [(1, seen.bbox), (4, None), (6, seen.bbox)]);
    }

    #[test]
    fn cvat_has_a_track_for_each_target_that_is_outside_while_it_is_lost() {
        let cvat = text(Format::Cvat);
        assert!(cvat.contains("<name>a &amp; b</name>") && cvat.contains("<size>3</size>"), "{cvat}");
        let (man, car) = cvat.split_once(r#"<track id="1" label="car""#).unwrap();
        let frames = |track: &str, outside: u8| {
            let boxes = track.lines().filter(|line| line.contains(&format!(r#"outside="{outside}""#)));
            boxes.map(|line| line.split('"').nth(1).unwrap().parse().unwrap()).collect::<Vec<u32>>()
        };
        assert_eq!((frames(man, 0), frames(man, 1)), (vec![0, 2], vec![1]), "{cvat}");
        assert_eq!((frames(car, 0), frames(car, 1)), (vec![1, 2], vec![]), "{cvat}");
        assert!(car.contains(r#"xtl="1.00" ytl="2.00" xbr="31.00" ybr="42.00""#), "{cvat}");
    }
}
