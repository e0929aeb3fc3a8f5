//! `host-sim report`: shows recordings on an HTML page, or draws the paper's figures of one.

use super::names::apart;
use super::paths::{Places, Taken};
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{Outcome, from, make_folder, progress, shell};
use anyhow::{Result, anyhow, bail, ensure};
use rayon::prelude::*;
use smr_evaluation::{Evaluation, MethodKind, Variant, result_files};
use smr_files::output::{Output, complain, print};
use smr_pages::report::figures::{self, Figure, Plan};
use smr_pages::report::{self, About, FilmedRecording, Refusal, Watch};
use smr_recordings::{BUILT_IN, FrameRange, Sequence, Source, Target, misfit, name_of};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Default size limit of a page, in megabytes.
const BUDGET: NonZeroUsize = NonZeroUsize::new(25).unwrap();

const METHODS: [MethodKind; 2] = [MethodKind::Robust, MethodKind::Paper];

#[derive(Debug, clap::Args)]
pub struct Report {
    /// Recordings, or folders of recordings
    #[arg(value_name = "SEQ|DIR", required = true)]
    paths: Vec<PathBuf>,
    /// The methods to show, separated by commas; the page shows the states of the first [default: robust,paper, or robust alone if the box is
    /// too large for paper]
    #[arg(long, value_enum, value_delimiter = ',', requires = "out")]
    method: Vec<MethodKind>,
    /// Write one HTML page: to this file if it ends in .html, else to a file with the recording's name in this folder
    ///
    /// It has a player over all frames (keys: space, left, right, home, end), curves with values under the pointer (drag to zoom, shift and
    /// drag to move), and the templates and differences. If there is ground truth, it also has scores, with other trackers' results
    /// (trackers/*.txt beside a recording). It needs no other file and no network.
    #[arg(short, long, value_name = "DIR|FILE.html")]
    out: Option<PathBuf>,
    /// Size limit of the page in megabytes: frames get smaller, down to 320 pixels, then fewer
    #[arg(long, value_name = "MB", default_value_t = BUDGET, value_parser = from::<NonZeroUsize>(1))]
    budget: NonZeroUsize,
    /// Draw the paper's five figures for one recording, SMR beside SAD, as SVG into this folder
    ///
    /// 1 boxes: both boxes in one frame, with the templates. 2 differences: the differences to the template in the winning box and in the
    /// true box, with histograms. 3 leaving: the target leaves the frame. 4 drift: the centre error in each frame. 5 occlusion: before and
    /// after the target is hidden. Figures 2, 4 and 5 need ground truth. host-sim skips a figure that the recording does not allow, and
    /// says why.
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// With --figures: the frame that figures 1 and 2 show, at least 2 [default: the frame where SMR leads SAD most]
    #[arg(long, value_name = "N", value_parser = from::<NonZeroUsize>(1))]
    frame: Option<NonZeroUsize>,
    /// With --figures: the frames in which the target is hidden, for figure 5 [default: frames without a true box]
    #[arg(long, value_name = "A..B")]
    hidden: Option<FrameRange>,
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
    file: String,
    bytes: usize,
    /// Frames that a figure shows, counted from 1; `None` for a page.
    frames: Option<Vec<usize>>,
}

impl Report {
    pub fn run(self) -> Result<Outcome> {
        let taken = |endings| Some(Taken { endings: [endings, &[]], is_folder: true });
        ensure!(
            self.out.is_some() || self.figures.is_some(),
            "expected --out FILE.html for a page, --figures DIR for the paper's figures, or both"
        );
        let of_figures = [("--frame", self.frame.is_some()), ("--hidden", self.hidden.is_some())];
        if let (None, Some((option, _))) = (&self.figures, of_figures.iter().find(|(_, is_given)| *is_given)) {
            bail!("{option} is for figures: expected --figures DIR with it");
        }
        let places = Places::of(&self.paths).writes("--out", self.out.as_ref(), taken(&["html"]));
        places.writes("--figures", self.figures.as_ref(), taken(&[])).check()?;
        let methods = self.tracker.variants(match &self.out {
            None => &figures::METHODS,
            Some(_) if self.method.is_empty() => &METHODS,
            Some(_) => &self.method,
        })?;
        let found = self.recording.find(&self.paths)?;
        if self.figures.is_some() {
            ensure!(found.len() == 1, "--figures draws one recording: expected one, found {}", found.len());
            ensure!(
                found[0] != Path::new("-"),
                "standard input can be read once, and figures need the recording twice: expected a file or a folder"
            );
        }
        let (films, mut files) = match &self.out {
            Some(out) => self.page(out, &found, &methods)?,
            None => Default::default(),
        };
        let figures = self.figures.as_ref().map(|folder| self.draw(&found[0], folder)).transpose()?;
        let (drawn, left_out) = figures.unwrap_or_default();
        files.extend(drawn);
        let text = if self.json {
            json(&films, &methods, &files, &left_out)?
        } else {
            lines(&films, &files) + &left_out.iter().map(|why| format!("left out: {why}\n")).collect::<String>()
        };
        print(|out| out.write_all(text.as_bytes()))?;
        Ok(Outcome::Holds)
    }

    fn page(&self, out: &Path, found: &[PathBuf], methods: &[Variant]) -> Result<(Vec<FilmedRecording>, Vec<Written>)> {
        let open = |path: &PathBuf| {
            let kept = self.recording.kept(path)?;
            kept.iter().for_each(|kept| kept.tell(&name_of(path), false));
            self.recording.open_with_targets(path, false, kept.as_ref())
        };
        let mut sequences = found.iter().map(open).collect::<Result<Vec<_>>>()?;
        for (sequence, targets) in &sequences {
            let truth = sequence.truth.as_ref().filter(|_| targets.len() == 1);
            let misfit = truth.zip(sequence.length).and_then(|(truth, length)| misfit(length, truth.len()));
            misfit.map_or(Ok(()), |misfit| Err(anyhow!("{}: {misfit}", sequence.name)))?;
        }
        let names = apart(sequences.iter().map(|(sequence, _)| sequence.name.clone()).collect());
        for ((sequence, _), name) in sequences.iter_mut().zip(names) {
            sequence.name = name;
        }
        let title = if let [(one, _)] = &sequences[..] { one.name.clone() } else { "report".to_owned() };
        let page = page_file(out, &title)?;
        // Checks the page's path, not just `--out`: if `--out` is a folder, the page's name is known only here.
        Places::of(found).writes("--out", Some(&page), None).check()?;
        let output = Output::create(&page)?;
        let mut films = self.watch(found, sequences, methods)?;
        for film in &films {
            film.notes.iter().for_each(|note| complain(&format!("note: {}: {note}", film.name)));
        }
        let text = report::page(&mut films, &self.about(&title, methods)?, self.budget_bytes())?;
        output.end(text.as_bytes())?;
        Ok((films, vec![Written { file: page.display().to_string(), bytes: text.len(), frames: None }]))
    }

    /// Draws the paper's figures into `folder`. Returns the files, and the reasons why some figures are left out.
    fn draw(&self, path: &Path, folder: &Path) -> Result<(Vec<Written>, Vec<String>)> {
        let methods = self.tracker.variants(&figures::METHODS)?;
        let watch = |stills: BTreeSet<usize>| {
            // Figures are gray, so colors need not be read.
            let sequence = Sequence { source: Source::Once, ..self.recording.open(path)? };
            let bar = progress::bar(&sequence.name, sequence.length);
            let film = report::watch(sequence, Watch { stills, ..Watch::new(&methods) }, || bar.inc());
            bar.clear();
            film
        };
        let film = watch(BTreeSet::new())?;
        let frame = self.frame.map(|frame| frame.get() - 1);
        let (mut plans, mut left_out) = (Vec::new(), Vec::new());
        for figure in Figure::ALL {
            // The figures `Boxes` and `Occlusion` must be drawn if the user chose their frame or range of frames. Any
            // other figure that cannot be drawn is left out.
            let must = match figure {
                Figure::Boxes => self.frame.is_some(),
                Figure::Occlusion => self.hidden.is_some(),
                _ => false,
            };
            match Plan::new(figure, &film, frame, self.hidden) {
                Ok(plan) => plans.push(plan),
                Err(error) if must => return Err(error),
                Err(error) => left_out.push(format!("{error:#}")),
            }
        }
        if plans.is_empty() {
            bail!("{}", left_out[0]);
        }
        let film = watch(plans.iter().flat_map(|plan| plan.frames.iter().copied()).collect())?;
        make_folder(folder)?;
        let (mut files, mut outputs) = (Vec::new(), Vec::new());
        for plan in &plans {
            let (file, svg) = (folder.join(plan.figure.to_string()), plan.draw(&film)?);
            let mut output = Output::create(&file)?;
            output.write(svg.as_bytes())?;
            output.settle()?;
            outputs.push(output);
            let frames = Some(plan.frames.iter().map(|index| index + 1).collect());
            files.push(Written { file: file.display().to_string(), bytes: svg.len(), frames });
        }
        outputs.into_iter().try_for_each(Output::finish)?;
        Ok((files, left_out))
    }

    fn watch(
        &self,
        paths: &[PathBuf],
        sequences: Vec<(Sequence, Vec<Target>)>,
        methods: &[Variant],
    ) -> Result<Vec<FilmedRecording>> {
        let length = sequences.iter().map(|(sequence, _)| sequence.length).sum();
        let name =
            if let [(one, _)] = &sequences[..] { one.name.clone() } else { format!("{} recordings", sequences.len()) };
        let progress = progress::bar(&name, length);
        let budget = Some(self.budget_bytes() / sequences.len());
        let refusal = if self.method.is_empty() { Refusal::LeftOut } else { Refusal::Fails };
        let watch = |(path, (sequence, targets)): (&PathBuf, (Sequence, Vec<Target>))| {
            let several = targets.len() > 1;
            let what = Watch { targets, refusal, budget, ..Watch::new(methods) };
            let mut film = report::watch(sequence, what, || progress.inc())?;
            // Result files of other trackers describe only one target, the one with ground truth.
            if !several && !BUILT_IN.iter().any(|name| path.as_os_str() == *name) {
                film.compare(&result_files(path)?, self.recording.frames_of_truth())?;
            }
            Ok(film)
        };
        let films = paths.par_iter().zip(sequences.into_par_iter()).map(watch).collect();
        progress.clear();
        films
    }

    fn budget_bytes(&self) -> usize {
        self.budget.get().saturating_mul(1_000_000)
    }

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

/// Returns the path of the page, and creates its folder.
fn page_file(out: &Path, name: &str) -> Result<PathBuf> {
    let is_page = out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html"));
    let file = if is_page { out.to_owned() } else { out.join(format!("{name}.html")) };
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).map_or(Ok(()), make_folder)?;
    Ok(file)
}

fn lines(films: &[FilmedRecording], files: &[Written]) -> String {
    let all: usize = films.iter().map(|film| film.moments.len()).sum();
    let line = |Written { file, bytes, frames }: &Written| {
        let frames = match frames.as_deref() {
            None => format!("{all} frames"),
            Some([]) => "all frames".to_owned(),
            Some([frame]) => format!("frame {frame}"),
            Some(frames) => format!("frames {}", frames.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
        };
        format!("{file}: {frames}, {} kB\n", bytes.div_ceil(1000))
    };
    files.iter().map(line).collect()
}

fn json(films: &[FilmedRecording], methods: &[Variant], files: &[Written], left_out: &[String]) -> Result<String> {
    let evaluations: Vec<Evaluation> =
        films.iter().filter_map(|film| film.evaluation().transpose()).collect::<Result<_>>()?;
    let recording = |film: &FilmedRecording| {
        serde_json::json!({
            "sequence": film.name,
            "frames": film.moments.len(),
            "notes": film.notes,
            "pictures": film.images(),
        })
    };
    let object = serde_json::json!({
        "methods": methods.iter().map(Variant::origin).collect::<Vec<_>>(),
        "recordings": films.iter().map(recording).collect::<Vec<_>>(),
        "files": files,
        "left_out": left_out,
        "scores": Evaluation::tables(&evaluations),
    });
    Ok(serde_json::to_string_pretty(&object)? + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use std::fs;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        report: Report,
    }

    #[test]
    fn a_page_is_the_same_every_time() {
        let folder = tempfile::tempdir().unwrap();
        let pages = ["1.html", "2.html"].map(|name| {
            let out = folder.path().join(name);
            let line = ["report", "synthetic", "--frames", "..30", "--out", out.to_str().unwrap()];
            Line::try_parse_from(line).unwrap().report.run().unwrap();
            fs::read_to_string(out).unwrap()
        });
        assert!(pages[0] == pages[1]);
    }
}
