//! `host-sim report`: a recording as people look at it, a page or a picture.

use super::Outcome;
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use crate::evaluate::{MethodKind, Results, Variant};
use crate::output::{Output, print};
use crate::report::{self, Choice, Film};
use crate::sequence::Sequence;
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use std::fs;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Report {
    /// The recording
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// Who is shown; several are separated by commas. The states are those of the first
    #[arg(long, value_enum, value_delimiter = ',', default_value = "smr,sad")]
    method: Vec<MethodKind>,
    /// Write one HTML page: to this file if it ends in .html, else into this folder, under the recording's name
    #[arg(long, value_name = "DIR|FILE.html", required_unless_present = "png")]
    out: Option<PathBuf>,
    /// Write the film strip alone, as one picture
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Show these frames; the first is 1 [default: 9 to 16 evenly spaced ones, and each in which the state changes]
    #[arg(long, value_name = "N,N,...", value_delimiter = ',')]
    frames: Vec<NonZeroUsize>,
    /// Print a JSON object instead of a line for each file
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

/// A file that was written.
#[derive(serde::Serialize)]
struct Written {
    file: PathBuf,
    bytes: usize,
}

impl Report {
    pub fn run(self) -> Result<Outcome> {
        let methods = self.tracker.variants(&self.method)?;
        let sequence = self.recording.open(&self.sequence)?;
        let page = self.out.as_ref().map(|out| File::create(page_file(out, &sequence.name)?)).transpose()?;
        let png = self.png.clone().map(File::create).transpose()?;
        let film = self.watch(sequence, &methods)?;
        let mut files = Vec::new();
        if let Some(file) = page {
            files.push(file.write(report::page(&film)?.as_bytes())?);
        }
        if let Some(file) = png {
            files.push(file.write(&report::picture(&film)?)?);
        }
        let text = if self.json { json(&film, &files)? } else { lines(&film, &files) };
        print(|out| out.write_all(text.as_bytes()))?;
        Ok(Outcome::Holds)
    }

    fn watch(&self, sequence: Sequence, methods: &[Variant]) -> Result<Film> {
        let progress = progress(sequence.length);
        let film = report::watch(sequence, methods, self.choice(), || progress.inc(1));
        progress.finish_and_clear();
        film
    }

    fn choice(&self) -> Choice {
        if self.frames.is_empty() {
            return Choice::Spread;
        }
        Choice::Listed(self.frames.iter().map(|number| number.get() - 1).collect())
    }
}

/// The file of the page; the folder that it is in is made if it is not there.
fn page_file(out: &Path, name: &str) -> Result<PathBuf> {
    let is_page = out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html"));
    let (folder, file) = match is_page {
        true => (out.parent().unwrap_or(Path::new("")), out.to_owned()),
        false => (out, out.join(format!("{name}.html"))),
    };
    if !folder.as_os_str().is_empty() {
        fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    Ok(file)
}

/// A file that will be written.
struct File {
    name: PathBuf,
    output: Output,
}

impl File {
    fn create(name: PathBuf) -> Result<Self> {
        Ok(Self { output: Output::create(&name)?, name })
    }

    fn write(mut self, bytes: &[u8]) -> Result<Written> {
        self.output.write(bytes)?;
        self.output.finish()?;
        Ok(Written { file: self.name, bytes: bytes.len() })
    }
}

fn lines(film: &Film, files: &[Written]) -> String {
    let (frames, shown) = (film.moments.len(), film.shown().len());
    let line = |Written { file, bytes }: &Written| {
        format!("{}: {frames} frames, {shown} shown, {} kB\n", file.display(), bytes.div_ceil(1000))
    };
    files.iter().map(line).collect()
}

fn json(film: &Film, files: &[Written]) -> Result<String> {
    let evaluation = film.evaluation()?;
    let results = Results::new(evaluation.as_slice());
    let object = serde_json::json!({
        "methods": film.methods.iter().map(Variant::origin).collect::<Vec<_>>(),
        "sequence": film.name,
        "frames": film.moments.len(),
        "shown": film.shown(),
        "changes_left_out": film.changes_left_out,
        "files": files,
        "scores": results.measured(),
    });
    Ok(serde_json::to_string_pretty(&object)? + "\n")
}

/// A bar on a terminal, nothing elsewhere.
fn progress(length: Option<usize>) -> ProgressBar {
    let bar = length.map_or_else(ProgressBar::new_spinner, |length| ProgressBar::new(length as u64));
    match ProgressStyle::with_template("{wide_bar} {pos}/{len} frames {eta}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        report: Report,
    }

    fn run(arguments: &[&str]) -> Result<Outcome> {
        Line::try_parse_from([&["report", "synthetic"], arguments].concat())?.report.run()
    }

    /// The README shows it; this is how it is made anew:
    /// `host-sim report synthetic --frames 41,106,171,190,200,232 --png host-sim/assets/synthetic.png`
    #[test]
    fn the_picture_of_the_readme_is_what_the_command_makes() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("synthetic.png");
        run(&["--frames", "41,106,171,190,200,232", "--png", file.to_str().unwrap()]).unwrap();
        let (made, kept) = (fs::read(file).unwrap(), include_bytes!("../../assets/synthetic.png"));
        assert!(made == kept, "assets/synthetic.png is another picture: make it anew, see above");
        assert!(kept.len() < 200_000, "{} bytes", kept.len());
    }

    #[test]
    fn a_folder_gets_a_page_of_the_recordings_name() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new").join("folder");
        run(&["--frames", "1,2", "--out", out.to_str().unwrap()]).unwrap();
        let page = fs::read_to_string(out.join("synthetic.html")).unwrap();
        let file = out.join("again.html");
        run(&["--frames", "2,1,2", "--out", file.to_str().unwrap()]).unwrap();
        assert!(page == fs::read_to_string(file).unwrap(), "the same page every time");
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(run(&[]).unwrap_err().to_string().contains("--out"));
        assert!(run(&["--out", "x.html", "--frames", "0"]).unwrap_err().to_string().contains("--frames"));
        let folder = tempfile::tempdir().unwrap();
        let error = format!("{:#}", File::create(folder.path().to_owned()).err().unwrap());
        assert!(error.starts_with(&format!("cannot write {}", folder.path().display())), "{error}");
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = format!("{:#}", page_file(&file, "name").unwrap_err());
        assert!(error.starts_with(&format!("cannot make the folder {}", file.display())), "{error}");
    }
}
