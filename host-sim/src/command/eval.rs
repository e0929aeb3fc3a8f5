//! `host-sim eval`: methods, and the published results of others, measured against ground truth, from one start or many.

use super::progress::{Bar, Expected};
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{HostSim, Outcome, from, progress, tell, told};
use anyhow::{Context, Error, Result, bail, ensure};
use clap::CommandFactory;
use rayon::prelude::*;
use smr_evaluation::robustness::{self, Former, Progress, Starts};
use smr_evaluation::{Evaluation, Layout, MethodKind, Results, TableName, Tables, Variant, covered, faults, published};
use smr_recordings::fault::{Fault, Faults};
use smr_recordings::output::complain;
use smr_recordings::{OpenOptions, Resize, Sequence, cleanup, slow, synthetic};
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// As it is called on the command line.
const NAME: &str = "eval";

#[derive(Debug, clap::Args)]
pub struct Eval {
    /// Recordings with ground truth beside them, or folders of such recordings
    #[arg(value_name = "PATH", required_unless_present = "covered")]
    paths: Vec<PathBuf>,
    /// What is measured; several are separated by commas [default: smr]
    ///
    /// If all recordings are those of the paper's table, and no option changes the start or the tracker, the default is everything:
    /// both readings of the paper, the robust tracker, the baselines, and the results of other trackers (--compare).
    #[arg(long, value_enum, value_delimiter = ',')]
    method: Vec<MethodKind>,
    /// Also score other trackers' results, trackers/*.txt beside a recording
    ///
    /// One line x1,y1,x2,y2 for each frame, NaN for no answer. A file that ends early has no answer from there on; lines after the
    /// last frame are ignored.
    #[arg(long, conflicts_with_all = ["resize", "frames"])]
    compare: bool,
    /// Run from 5 starts: the given box, 2 pixels to the right, 2 down, and scaled by 0.95 and 1.05 about its centre
    ///
    /// A changed box is rounded to whole pixels, and what lies outside the frame is cut off. The columns are:
    /// correct: correct frames over visible ones, mean over the starts; worst: the same from the worst start; correct@0.5: the same
    /// where IoU must be above 0.5; F: the harmonic mean of precision and correct; mean IoU: where there is an answer and the
    /// target is visible; precision: correct answers over all answers, also those while the target is hidden; answered/hidden:
    /// answers while the target is hidden; found/returns: how often the target came back, and how often a correct answer followed
    /// within 50 frames; wrong/tracking and tracking/wrong: frames that were called `tracking` although the target was hidden or IoU
    /// at most 0.25, over all that were called so, and over all wrong frames; unsaid/right: frames that were not called `tracking`
    /// although the box was right; work/frame: comparisons or products of an update, at most; us/frame: its time.
    ///
    /// Then come means over recordings with their standard errors, means over each folder, and of several methods the paired
    /// differences to the first. A recording is held in memory, with at most 1 GiB of frames.
    #[arg(long, conflicts_with = "compare")]
    robustness: bool,
    /// With --robustness: in place of the 5, start at every N-th frame in which the target is visible
    ///
    /// Each run goes from the box of the ground truth, cut to the frame, to the end of the recording. The last frame is no start.
    #[arg(long, value_name = "N", requires = "robustness", conflicts_with_all = ["init", "inclusive"], value_parser = from::<NonZeroUsize>(1))]
    starts_every: Option<NonZeroUsize>,
    /// With --robustness: run from the given box alone, in place of the 5
    #[arg(long, requires = "robustness", conflicts_with = "starts_every")]
    single_start: bool,
    /// With --robustness: print paired differences to what was measured before: a file that the same command wrote with --json
    ///
    /// Each tracker is compared with the one of its name in the file, or else with the first in the file. Without this option, each
    /// is compared with the first method.
    #[arg(long, value_name = "FILE", requires = "robustness")]
    against: Option<PathBuf>,
    /// Put faults of the camera, or changes of light, into the recordings, and measure what the trackers do; several are separated by
    /// commas, `all` and `light` are lists [default methods: smr,robust]
    ///
    /// NAME:N is one of dropped:N (every second of 2 N frames never comes), repeated:N (the frame before comes N times more), torn:N (the
    /// lower part of N frames is that of the frame before), black:N, white:N (N frames), columns:N (N columns are stuck), bits:N (a bit is
    /// wrong in N of 1000 pixels), gain:N (pixels times N hundredths), noise:N (standard deviation N), origin:N (the picture is N pixels too
    /// far to the right and N / 2 too low), gap:N (no frame comes for N). Those that are not of N frames last 10.
    ///
    /// Changes of light last 150 frames: light:N (N hundredths as bright, with noise of one gray level), dusk:N (the same, reached within
    /// 100 frames), night:N (the same as light:N, but already at the lock), fog:N (N hundredths of the contrast, around gray 110), gamma:N (a
    /// power of N hundredths), offset:N (N gray levels brighter).
    ///
    /// Each fault is put in at up to 8 places of a recording, each a run of its own: locked on the ground truth 10 frames before it, watched
    /// for 50 frames after it. Of the runs whose box was right (IoU > 0.25) before the fault: the states during it, in how many
    /// of its frames the box was right, how many were right again and after how many frames, how many were right at the end, and in how many of all frames from the fault on *tracking* was said and
    /// wrong. `none` are the same runs without a fault. What is random is the same each time.
    #[arg(long, value_name = "NAME:N|all|light", value_delimiter = ',', conflicts_with_all = ["compare", "robustness", "init", "inclusive"])]
    fault: Vec<Faults>,
    /// Cover the lens in the middle of each recording for 300 frames, and measure what the trackers do [default methods: smr,robust]
    ///
    /// From the middle of a recording on come 300 frames that are black, white, gray (128), noise, or a frozen frame of another scene: the first
    /// frame of another recording of the list, resized (of the built-in `synthetic` if there is no other). Then the recording goes on where it was
    /// interrupted. The recordings are those that are given, and five that are generated: a dark, a bright, a textured, a smooth and a
    /// noisy target. Of each tracker and cover: recordings; those in which the box was right (IoU > 0.25) in the frame before; how many of the
    /// 300 frames it called *tracking* in the median and in the worst recording, and in how many recordings more than 2; in how many it was
    /// *lost* by frame 30; in how many of those that were right before it was right again within 10 frames. What misses one of these is
    /// named. What is random is the same each time.
    #[arg(long, conflicts_with_all = ["compare", "robustness", "fault", "init", "inclusive"])]
    covered: bool,
    #[command(flatten)]
    tables: TableOptions,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

/// The form of the tables: words, JSON or CSV.
#[derive(Debug, clap::Args)]
struct TableOptions {
    /// Print JSON instead of tables: an object with the tables of --part, each an array of flat objects
    ///
    /// All objects of a table have the same keys, and a key has values of one type; what is not known is null. The options of a tracker are a
    /// text, itself JSON.
    #[arg(long)]
    json: bool,
    /// The form of the tables
    #[arg(long, value_enum, default_value_t, conflicts_with = "json")]
    format: Layout,
    /// With --format csv: which table of --json [default: measured]
    #[arg(long, value_enum, conflicts_with = "json")]
    part: Option<TableName>,
}

impl TableOptions {
    /// Errors: --part without CSV, or of a table that is not one of `known`.
    fn check(&self, known: &[TableName]) -> Result<()> {
        let Some(part) = self.part else { return Ok(()) };
        ensure!(self.format == Layout::Csv, "--part chooses a table of --format csv: expected both");
        let names = || known.iter().map(|name| name.text()).collect::<Vec<_>>().join(", ");
        ensure!(known.contains(&part), "--part {}: expected one of {}", part.text(), names());
        Ok(())
    }

    /// Prints `tables` as JSON or CSV, or what `words` says.
    fn print(&self, tables: &Tables, words: impl FnOnce(Layout) -> String) -> Result<()> {
        let text = match self.format {
            Layout::Csv => tables.csv(self.part.unwrap_or(TableName::Measured)).context("there is no such table")?,
            layout => words(layout),
        };
        tell(self.json, tables, |_, out| out.write_all(text.as_bytes()))
    }
}

impl Eval {
    pub fn run(mut self) -> Result<Outcome> {
        self.tables.check(self.known_tables())?;
        if (!self.fault.is_empty() || self.covered) && self.method.is_empty() {
            self.method = faults::METHODS.to_vec();
        }
        let variants = self.variants()?;
        for variant in &variants {
            // A configuration that cannot be used is no fault of a recording: it is said once, here.
            variant.build()?;
        }
        if self.robustness {
            return self.measure_robustness(&variants);
        }
        if !self.fault.is_empty() {
            return self.measure_faults(&variants);
        }
        if self.covered {
            return self.measure_covered(&variants);
        }

        let found = self.recording.find(&self.paths)?;
        // The paper's recordings have the paper's table, with all that can stand in it.
        let table = self.says_nothing() && found.iter().all(|path| is_published(path));
        let variants = if table { Variant::all() } else { variants };
        let (mut evaluations, mut failures) = (Vec::new(), Vec::new());
        for evaluation in self.evaluate(&found, &variants, self.compare || table) {
            match evaluation {
                Ok(mut evaluation) => {
                    // A run that was stopped is no failure.
                    failures.append(&mut evaluation.failures);
                    failures.retain(|_| !cleanup::is_stopped());
                    evaluations.push(evaluation);
                }
                Err(error) => failures.push(error),
            }
        }
        evaluations.retain(|evaluation| !evaluation.scores.is_empty());
        let failed = count_failures(failures, evaluations.is_empty())?;
        say_what_to_know(&evaluations);
        let results = Results::new(&evaluations);
        self.tables.print(&results.tables(), |layout| results.text(layout))?;
        end(failed)
    }

    /// Those that are printed as JSON.
    const fn known_tables(&self) -> &'static [TableName] {
        if self.robustness {
            robustness::TABLES
        } else if self.covered {
            covered::TABLES
        } else if self.fault.is_empty() {
            Results::TABLES
        } else {
            faults::TABLES
        }
    }

    /// What is asked for; SMR if nothing is.
    fn variants(&self) -> Result<Vec<Variant>> {
        self.tracker.variants(if self.method.is_empty() { &[MethodKind::Smr] } else { &self.method })
    }

    /// True if no option tells what is to be measured.
    fn says_nothing(&self) -> bool {
        self.method.is_empty() && self.tracker.says_nothing() && self.recording.says_nothing_of_start()
    }

    fn measure_robustness(&self, variants: &[Variant]) -> Result<Outcome> {
        let former = self.against.as_deref().map(Former::read).transpose()?;
        let starts = match self.starts_every {
            Some(every) => Starts::Every(every),
            None if self.single_start => Starts::Given,
            None => Starts::Near,
        };
        let found = self.recording.find(&self.paths)?;
        let bar = progress::bar(NAME, Some(0));
        let expected = Expected::of(&bar, found.len());
        cleanup::stop_first();
        let progress = |progress| match progress {
            Progress::Expected { frames, recordings } => expected.add(frames, recordings),
            Progress::Done => bar.inc(),
        };
        let open = |path: &Path| self.recording.open(path);
        let mut robustness = robustness::measure(&found, open, variants, starts, &progress);
        bar.clear();
        say_if_stopped();
        let failed = count_failures(std::mem::take(&mut robustness.failures), robustness.is_empty())?;
        robustness.compare(former.as_ref())?;
        self.tables.print(&robustness.tables(), |layout| {
            let mut parts = vec![robustness.table(layout), robustness.paired_table(layout)];
            parts.retain(|part| !part.is_empty());
            parts.join("\n")
        })?;
        end(failed)
    }

    fn measure_faults(&self, variants: &[Variant]) -> Result<Outcome> {
        let mut list: Vec<Fault> = Vec::new();
        for fault in self.fault.iter().flat_map(|faults| &faults.0) {
            if !list.contains(fault) {
                list.push(*fault);
            }
        }
        let (mut all, mut failures) = (faults::Results::default(), Vec::new());
        // One recording after the other is in memory; its runs are spread over the threads that there are.
        let found = self.recording.find(&self.paths)?;
        let recordings = found.len();
        let bar = progress::of("faults", Some(recordings), "recordings");
        cleanup::stop_first();
        for path in found {
            match self.recording.open(&path).and_then(|sequence| faults::measure(sequence, variants, &list)) {
                Ok(measured) => all.add(measured),
                _ if cleanup::is_stopped() => break,
                Err(error) => failures.push(error),
            }
            bar.inc();
        }
        bar.clear();
        say_if_stopped();
        let failed = count_failures(failures, recordings == 1)?;
        self.tables.print(&all.tables(), |layout| all.text(layout))?;
        end(failed)
    }

    fn measure_covered(&self, variants: &[Variant]) -> Result<Outcome> {
        let found = self.recording.find(&self.paths)?;
        let generated = slow::sequences();
        let bar = progress::of("covered", Some(found.len() + generated.len()), "recordings");
        let measure = |sequence: Result<Sequence>, other: &Path| {
            let measured = sequence.and_then(|sequence| self.cover(sequence, other, variants));
            bar.inc();
            measured
        };
        // The scene half the list away: neighbours by name are often of the same one.
        let other = |number: usize| match found.len() {
            0 | 1 => Path::new(synthetic::NAME),
            length => &found[(number + length / 2) % length],
        };
        let given = found.par_iter().enumerate();
        let given = given.map(|(number, path)| measure(self.recording.open(path), other(number)));
        let generated = generated.into_par_iter().map(|sequence| measure(Ok(sequence), Path::new(synthetic::NAME)));
        let measured: Vec<_> = given.collect::<Vec<_>>().into_iter().chain(generated.collect::<Vec<_>>()).collect();
        bar.clear();
        let failed = say_what_failed(measured.iter().filter_map(|measured| measured.as_ref().err()));
        let runs = measured.into_iter().flatten().flatten().collect();
        let results = covered::Results::of(runs, variants);
        self.tables.print(&results.tables(), |layout| results.text(layout))?;
        end(failed)
    }

    /// One recording under all covers; the frame of the other scene is brought to its size.
    fn cover(&self, mut sequence: Sequence, other: &Path, variants: &[Variant]) -> Result<Vec<covered::Counts>> {
        let name = &sequence.name;
        let first = sequence.frames.next().with_context(|| format!("{name} holds no frame"))??;
        let mut other = smr_recordings::open(other, &OpenOptions::default())?
            .resized(Resize::To(first.gray.width, first.gray.height))?
            .0;
        let other = other.frames.next().with_context(|| format!("{} holds no frame", other.name))??;
        sequence.frames = Box::new(std::iter::once(Ok(first)).chain(sequence.frames));
        covered::measure(sequence, &other.gray, variants)
    }

    /// Recordings run in parallel, each on one thread; the results come in the order of `paths`.
    fn evaluate(&self, paths: &[PathBuf], variants: &[Variant], compare: bool) -> Vec<Result<Evaluation>> {
        let bar = progress::bar(NAME, Some(0));
        let expected = Expected::of(&bar, paths.len());
        cleanup::stop_first();
        let one = |path: &PathBuf| {
            let is_begun = !cleanup::is_stopped();
            let evaluation = is_begun.then(|| self.evaluate_one(path, variants, compare, (&bar, &expected)))?;
            Some(evaluation).filter(|evaluation| evaluation.is_ok() || !cleanup::is_stopped())
        };
        let evaluations = paths.par_iter().filter_map(one).collect();
        bar.clear();
        say_if_stopped();
        evaluations
    }

    fn evaluate_one(
        &self,
        path: &Path,
        variants: &[Variant],
        compare: bool,
        (bar, expected): (&Bar, &Expected<'_>),
    ) -> Result<Evaluation> {
        let mut sequence = self.recording.open(path)?;
        if let Some(frames) = self.recording.frames() {
            // What is published is of all frames: under this name there is nothing.
            sequence.name = format!("{} {frames}", sequence.name);
        }
        expected.add(sequence.truth.as_ref().map_or(0, |truth| truth.len() as u64), 1);
        let files = if compare { smr_evaluation::result_files(path)? } else { Vec::new() };
        smr_evaluation::evaluate(sequence, variants, &files, || bar.inc())
    }
}

/// Prints the failures and returns their number.
/// Errors: the only thing that was asked for has failed.
fn count_failures(mut failures: Vec<Error>, all: bool) -> Result<usize> {
    if all && failures.len() == 1 { Err(failures.remove(0)) } else { Ok(say_what_failed(&failures)) }
}

/// One line on standard error for everything that could not be measured; how many there are.
fn say_what_failed<'a>(errors: impl IntoIterator<Item = &'a Error>) -> usize {
    let command = HostSim::command().find_subcommand(NAME).cloned().unwrap_or_default();
    let say = |error: &Error| {
        cleanup::yield_to_signal();
        complain(&format!("error: {}", told(error, &command)));
    };
    errors.into_iter().map(say).count()
}

/// The outcome of a command of which so many parts failed.
/// Errors: one part or more failed.
fn end(failed: usize) -> Result<Outcome> {
    if let Some(signal) = cleanup::stopped_by() {
        return Ok(Outcome::Stopped(signal));
    }
    if failed > 0 {
        bail!("{failed} of what was asked for could not be measured (see above); results are of the rest");
    }
    Ok(Outcome::Holds)
}

/// True if the paper's table has the recording at `path`.
fn is_published(path: &Path) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(published::is_known)
}

fn say_if_stopped() {
    if cleanup::is_stopped() {
        complain("stopped: the results are those of the recordings that were done");
    }
}

fn say_what_to_know(evaluations: &[Evaluation]) {
    for note in evaluations.iter().flat_map(|evaluation| &evaluation.notes) {
        complain(&format!("note: {note}"));
    }
}
