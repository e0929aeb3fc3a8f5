//! `host-sim figures`: the paper's five figures of a recording.

use super::number::from;
use super::paths::{Places, Taken};
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{Outcome, progress, say};
use anyhow::{Context, Result, ensure};
use serde::Serialize;
use smr_evaluation::{Origin, Variant};
use smr_pages::report::diagram::Form;
use smr_pages::report::figures::{Figure, METHODS, Plan, Wish};
use smr_pages::report::{Film, Refusal, watch};
use smr_recordings::messages::choice_name;
use smr_recordings::{Colors, FrameRange, Sequence, output};
use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Figures {
    /// The recording
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// The folder for the files; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Only these, by number or name; several are separated by commas
    #[arg(long, value_name = "1..5|NAME", value_delimiter = ',')]
    figure: Vec<Figure>,
    /// The frame of figures 1 and 2; the first is 1 [default: where SMR is farthest ahead of SAD]
    #[arg(long, value_name = "N", value_parser = from::<NonZeroUsize>(1))]
    frame: Option<NonZeroUsize>,
    /// Where the target is hidden, for figure 5 [default: the frames without a box in the ground truth]
    #[arg(long, value_name = "A..B")]
    hidden: Option<FrameRange>,
    /// The formats of the files; several are separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "png,svg")]
    form: Vec<Form>,
    /// Print a JSON object instead of a line for each file
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

#[derive(Serialize)]
struct Report {
    sequence: String,
    methods: Vec<Origin>,
    figures: Vec<Written>,
    /// Figures that the recording has nothing for.
    left_out: Vec<LeftOut>,
}

#[derive(Serialize)]
struct Written {
    figure: usize,
    name: &'static str,
    /// The frames whose pictures are in it; the first is 1.
    frames: Vec<usize>,
    files: Vec<File>,
}

#[derive(Serialize)]
struct File {
    file: PathBuf,
    bytes: usize,
}

#[derive(Serialize)]
struct LeftOut {
    figure: usize,
    why: String,
}

impl Figures {
    pub fn places(&self) -> Places<'_> {
        Places::of([&self.sequence]).writes_as("--out", Some(&self.out), Taken::FOLDER)
    }

    pub fn run(self) -> Result<Outcome> {
        ensure!(
            self.sequence != Path::new("-"),
            "standard input can be read once, and figures need the recording twice: expected a file or a folder"
        );
        let methods = self.tracker.variants(&METHODS)?;
        let film = self.watch(&methods, &BTreeSet::new())?;
        let (plans, left_out) = self.plans(&film)?;
        let shown = plans.iter().flat_map(|plan| plan.frames.iter().copied()).collect();
        let film = self.watch(&methods, &shown)?;
        fs::create_dir_all(&self.out).with_context(|| format!("cannot make the folder {}", self.out.display()))?;
        let figures = plans.iter().map(|plan| self.write(plan, &film)).collect::<Result<_>>()?;
        let methods = methods.iter().map(Variant::origin).collect();
        let report = Report { sequence: film.name, methods, figures, left_out };
        let text = if self.json { serde_json::to_string_pretty(&report)? + "\n" } else { lines(&report) };
        say(|out| out.write_all(text.as_bytes()))?;
        Ok(Outcome::Holds)
    }

    /// What happens in the recording, with the pictures of these frames.
    fn watch(&self, methods: &[Variant], frames: &BTreeSet<usize>) -> Result<Film> {
        // Figures are gray.
        let sequence = Sequence { colors: Colors::None, ..self.recording.open(&self.sequence)? };
        let bar = progress::bar(&sequence.name, sequence.length);
        let film = watch(sequence, methods, Refusal::Fails, frames, None, || bar.inc(1))?;
        bar.finish_and_clear();
        Ok(film)
    }

    /// What can be drawn, and what cannot. What is asked for by name must be.
    fn plans(&self, film: &Film) -> Result<(Vec<Plan>, Vec<LeftOut>)> {
        let wish = Wish { frame: self.frame.map(|frame| frame.get() - 1), hidden: self.hidden };
        if !self.figure.is_empty() {
            let asked: BTreeSet<Figure> = self.figure.iter().copied().collect();
            let plans = asked.into_iter().map(|figure| Plan::new(figure, film, &wish)).collect::<Result<_>>()?;
            return Ok((plans, Vec::new()));
        }
        // A frame or a span that is given must be one of the recording.
        if self.frame.is_some() {
            Plan::new(Figure::Boxes, film, &wish)?;
        }
        if self.hidden.is_some() {
            Plan::new(Figure::Occlusion, film, &wish)?;
        }
        let (mut plans, mut left_out) = (Vec::new(), Vec::new());
        for figure in Figure::ALL {
            match Plan::new(figure, film, &wish) {
                Ok(plan) => plans.push(plan),
                Err(error) => left_out.push(LeftOut { figure: figure.number(), why: format!("{error:#}") }),
            }
        }
        if let (true, Some(first)) = (plans.is_empty(), left_out.first()) {
            anyhow::bail!("{}", first.why);
        }
        Ok((plans, left_out))
    }

    fn write(&self, plan: &Plan, film: &Film) -> Result<Written> {
        let sheet = plan.draw(film)?;
        let mut files = Vec::new();
        for form in self.form.iter().copied() {
            let file = self.out.join(format!("{}.{}", plan.figure, choice_name(&form)));
            let bytes = sheet.file(form)?;
            output::write(&file, &bytes)?;
            files.push(File { file, bytes: bytes.len() });
        }
        let frames = plan.frames.iter().map(|index| index + 1).collect();
        Ok(Written { figure: plan.figure.number(), name: plan.figure.name(), frames, files })
    }
}

fn lines(report: &Report) -> String {
    let frames = |written: &Written| match &written.frames[..] {
        [] => "all frames".to_owned(),
        [frame] => format!("frame {frame}"),
        frames => format!("frames {}", frames.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    };
    let line = |written: &Written, File { file, bytes }: &File| {
        format!("{}: {}, {} kB\n", file.display(), frames(written), bytes.div_ceil(1000))
    };
    let written = report.figures.iter().flat_map(|written| written.files.iter().map(move |file| line(written, file)));
    let left_out = report.left_out.iter().map(|LeftOut { why, .. }| format!("left out: {why}\n"));
    written.chain(left_out).collect()
}
