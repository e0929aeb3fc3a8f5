//! `host-sim report`: recordings as people look at them, on one page.

use super::number::from;
use super::paths::{Places, Taken};
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{Outcome, progress, shell};
use anyhow::{Context, Result, anyhow};
use rayon::prelude::*;
use smr_evaluation::{Evaluation, MethodKind, Results, Variant, result_files};
use smr_pages::report::{self, About, Film, Refusal};
use smr_recordings::output::{Output, complain, print};
use smr_recordings::{BUILT_IN, Sequence, Target, misfit};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// The most megabytes of a page, if nothing else is said.
const BUDGET: NonZeroUsize = NonZeroUsize::new(25).unwrap();

const METHODS: [MethodKind; 2] = [MethodKind::Robust, MethodKind::Smr];

#[derive(Debug, clap::Args)]
pub struct Report {
    /// Recordings, or folders of recordings
    #[arg(value_name = "SEQ|DIR", required = true)]
    paths: Vec<PathBuf>,
    /// The methods to show; several are separated by commas. The states are those of the first [default: robust,smr; without smr if the
    /// box is too large for it]
    #[arg(long, value_enum, value_delimiter = ',')]
    method: Vec<MethodKind>,
    /// Write one HTML page: to this file if it ends in .html, else into this folder, under the recording's name
    ///
    /// It has a player over all frames (keys: space, left, right, home, end), curves with values under the pointer (drag to zoom, with shift to move), and what was compared; scores where
    /// there is ground truth, with other trackers' results (trackers/*.txt beside a recording). It needs no other file and no network.
    #[arg(short, long, value_name = "DIR|FILE.html")]
    out: PathBuf,
    /// The most megabytes for the page: beyond it frames get smaller, down to 320 pixels, then fewer
    #[arg(long, value_name = "MB", default_value_t = BUDGET, value_parser = from::<NonZeroUsize>(1))]
    budget: NonZeroUsize,
    /// Print a JSON object instead of a line for each file
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

#[derive(serde::Serialize)]
struct Written {
    file: PathBuf,
    bytes: usize,
}

impl Report {
    pub fn places(&self) -> Places<'_> {
        Places::of(&self.paths).writes_as("--out", Some(&self.out), Taken::PAGE)
    }

    pub fn run(self) -> Result<Outcome> {
        let methods = self.tracker.variants(if self.method.is_empty() { &METHODS } else { &self.method })?;
        let found = self.recording.find(&self.paths)?;
        let open = |path: &PathBuf| self.recording.open_with_targets(path, false);
        let mut sequences = found.iter().map(open).collect::<Result<Vec<_>>>()?;
        for (sequence, targets) in &sequences {
            let truth = sequence.truth.as_ref().filter(|_| targets.len() == 1);
            let misfit = truth.zip(sequence.length).and_then(|(truth, length)| misfit(length, truth.len()));
            misfit.map_or(Ok(()), |misfit| Err(anyhow!("{}: {misfit}", sequence.name)))?;
        }
        name_apart(&mut sequences);
        let title = if let [(one, _)] = &sequences[..] { one.name.clone() } else { "report".to_owned() };
        let page = page_file(&self.out, &title)?;
        // In a folder the page has the recording's name.
        Places::of(&found).writes("--out", Some(&page)).check()?;
        let output = Output::create(&page)?;
        let mut films = self.watch(&found, sequences, &methods)?;
        for film in &films {
            film.notes.iter().for_each(|note| complain(&format!("note: {}: {note}", film.name)));
        }
        let text = report::page(&mut films, &self.about(&title, &methods)?, self.budget_bytes())?;
        output.end(text.as_bytes())?;
        let files = [Written { file: page, bytes: text.len() }];
        let text = if self.json { json(&films, &methods, &files)? } else { lines(&films, &files) };
        print(|out| out.write_all(text.as_bytes()))?;
        Ok(Outcome::Holds)
    }

    fn watch(
        &self,
        paths: &[PathBuf],
        sequences: Vec<(Sequence, Vec<Target>)>,
        methods: &[Variant],
    ) -> Result<Vec<Film>> {
        let length = sequences.iter().map(|(sequence, _)| sequence.length).sum();
        let name =
            if let [(one, _)] = &sequences[..] { one.name.clone() } else { format!("{} recordings", sequences.len()) };
        let progress = progress::bar(&name, length);
        let budget = Some(self.budget_bytes() / sequences.len());
        // A method that was not asked for is left out instead of being an error.
        let refusal = if self.method.is_empty() { Refusal::LeftOut } else { Refusal::Fails };
        let watch = |(path, (sequence, targets)): (&PathBuf, (Sequence, Vec<Target>))| {
            let (stills, several) = (BTreeSet::new(), targets.len() > 1);
            let mut film = report::watch_all(sequence, targets, methods, refusal, &stills, budget, || progress.inc(1))?;
            // What others answered is of the target with the ground truth.
            if !several && !BUILT_IN.iter().any(|name| path.as_os_str() == *name) {
                film.compare(&result_files(path)?, self.recording.frames_of_truth())?;
            }
            Ok(film)
        };
        let films = paths.par_iter().zip(sequences.into_par_iter()).map(watch).collect();
        progress.finish_and_clear();
        films
    }

    fn budget_bytes(&self) -> usize {
        self.budget.get().saturating_mul(1_000_000)
    }

    /// What the foot of the page says.
    fn about(&self, title: &str, methods: &[Variant]) -> Result<About> {
        let words: Vec<_> = std::iter::once("host-sim".into()).chain(std::env::args_os().skip(1)).collect();
        let origins: Vec<_> = methods.iter().map(Variant::origin).collect();
        Ok(About {
            title: title.to_owned(),
            command_line: shell::line(words.iter().map(OsString::as_os_str)),
            options: serde_json::to_string(&origins)?,
        })
    }
}

/// Recordings of one name in several folders get numbers: each is called something else on the page.
fn name_apart(sequences: &mut [(Sequence, Vec<Target>)]) {
    for at in 1..sequences.len() {
        let (before, rest) = sequences.split_at_mut(at);
        let name = rest[0].0.name.clone();
        let mut number = 1;
        while before.iter().any(|(other, _)| other.name == rest[0].0.name) {
            number += 1;
            rest[0].0.name = format!("{name} ({number})");
        }
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

fn lines(films: &[Film], files: &[Written]) -> String {
    let frames: usize = films.iter().map(|film| film.moments.len()).sum();
    let line = |Written { file, bytes }: &Written| {
        format!("{}: {frames} frames, {} kB\n", file.display(), bytes.div_ceil(1000))
    };
    files.iter().map(line).collect()
}

fn json(films: &[Film], methods: &[Variant], files: &[Written]) -> Result<String> {
    let evaluations: Vec<Option<Evaluation>> = films.iter().map(Film::evaluation).collect::<Result<_>>()?;
    let evaluations: Vec<Evaluation> = evaluations.into_iter().flatten().collect();
    let results = Results::new(&evaluations);
    let recording = |film: &Film| {
        serde_json::json!({
            "sequence": film.name,
            "frames": film.moments.len(),
            "notes": film.notes,
            "pictures": film.pictures(),
        })
    };
    let object = serde_json::json!({
        "methods": methods.iter().map(Variant::origin).collect::<Vec<_>>(),
        "recordings": films.iter().map(recording).collect::<Vec<_>>(),
        "files": files,
        "scores": results.tables(),
    });
    Ok(serde_json::to_string_pretty(&object)? + "\n")
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

    #[test]
    fn a_folder_gets_a_page_of_the_recordings_name() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new").join("folder");
        run(&["--out", out.to_str().unwrap()]).unwrap();
        let page = fs::read_to_string(out.join("synthetic.html")).unwrap();
        assert!(page.len() < 10_000_000, "{} bytes", page.len());
        let file = out.join("again.html");
        run(&["--out", file.to_str().unwrap()]).unwrap();
        assert!(page == fs::read_to_string(file).unwrap(), "the same page every time");
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(run(&[]).unwrap_err().to_string().contains("--out"));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = format!("{:#}", page_file(&file, "name").unwrap_err());
        assert!(error.starts_with(&format!("cannot make the folder {}", file.display())), "{error}");
    }
}
