//! How much it takes to lose a target: methods, or variants of one, run over recordings from several starts each, and what that comes to.
//!
//! - `starts`: where runs start.
//! - `recording`: a recording in memory.
//! - `figures`: what runs come to.
//! - `paired`: what one method is better by than another.
//! - `calibration`: what a reported ratio says of the chance to be right.
//! - `table`: the results as text.
//!
//! Each run is scored by the protocol of the recordings, from the frame in which it starts: its answers are normalised by its
//! own start and the truth of that frame, and the frame of the start counts.

mod calibration;
mod figures;
mod paired;
pub(super) mod recording;
mod starts;
mod table;

pub use calibration::Bin;
pub use figures::Figures;
pub use paired::Former;
pub use starts::Starts;

use super::configs::ORIGIN;
use super::means::{Named, errors};
use super::run::lock;
use super::tables::{Table, TableName, Tables, columns, error_of};
use super::{Origin, Variant};
use anyhow::{Context, Error, Result};
use calibration::Calibration;
use figures::{HEADLINE, RunFigures, Spent};
use paired::Paired;
use rayon::prelude::*;
use recording::Recording;
use serde::Serialize;
use smr_recordings::{BoundingBox, Sequence};
use starts::Start;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The tables of what is measured.
pub const TABLES: &[TableName] =
    &[TableName::Measured, TableName::Starts, TableName::Means, TableName::Paired, TableName::Calibration];

/// How far it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// So many frames more will come.
    Expected(u64),
    /// A frame is done.
    Done,
}

/// What was measured.
#[derive(Default)]
pub struct Robustness {
    /// Method by method, each with its recordings in the order in which they were given.
    recordings: Vec<Row>,
    /// Of each method: over all recordings, then, if they lie in several folders, by folder.
    means: Vec<Mean>,
    /// What each method is better by than another one, if that was asked for.
    paired: Vec<Paired>,
    /// Of each method that reports a ratio.
    calibration: Vec<Bin>,
    /// Why some are missing.
    pub failures: Vec<Error>,
}

impl Robustness {
    /// True if there is no result at all.
    pub fn is_empty(&self) -> bool {
        self.recordings.is_empty()
    }

    /// All of it for JSON and CSV. Starts come in the order of the rows of `measured` that they
    /// belong to.
    pub fn tables(&self) -> Result<Tables> {
        let figures = || Figures::NAMES.iter().map(|name| (*name).to_owned());
        let errors = || HEADLINE.map(error_of);
        let origin = || columns(ORIGIN);
        let of = |first: &str, rest: Vec<String>| [columns(first), rest].concat();
        let measured = of("tracker,sequence,folder,starts", figures().chain(origin()).collect());
        let means = of("tracker,folder,recordings", figures().chain(errors()).chain(origin()).collect());
        let compared = HEADLINE.iter().flat_map(|name| [(*name).to_owned(), error_of(name)]).collect();
        let starts = columns("tracker,sequence,folder,start,frame,x,y,width,height,visible,correct");
        Ok(Tables(vec![
            Table::new(TableName::Measured, measured, &self.recordings)?,
            Table::new(TableName::Starts, starts, &self.starts())?,
            Table::new(TableName::Means, means, &self.means)?,
            Table::new(TableName::Paired, of("tracker,against,recordings", compared), &self.paired)?,
            Table::new(TableName::Calibration, columns("tracker,from,to,frames,correct"), &self.calibration)?,
        ]))
    }

    fn starts(&self) -> Vec<StartOf<'_>> {
        self.recordings.iter().flat_map(StartOf::all).collect()
    }
}

/// A method on a recording.
#[derive(Clone, Debug, Serialize)]
struct Row {
    #[serde(flatten)]
    origin: Origin,
    tracker: String,
    sequence: String,
    /// The folder that the recording lies in, among others.
    #[serde(serialize_with = "as_name")]
    folder: PathBuf,
    #[serde(flatten)]
    figures: Figures,
    #[serde(skip)]
    calibration: Calibration,
    #[serde(serialize_with = "how_many")]
    starts: Vec<StartRow>,
}

/// A start, with what it is of.
#[derive(Serialize)]
struct StartOf<'a> {
    tracker: &'a str,
    sequence: &'a str,
    #[serde(serialize_with = "as_name")]
    folder: &'a Path,
    #[serde(flatten)]
    start: &'a StartRow,
}

impl StartOf<'_> {
    fn all(row: &Row) -> Vec<StartOf<'_>> {
        let of_row = |start| StartOf { tracker: &row.tracker, sequence: &row.sequence, folder: &row.folder, start };
        row.starts.iter().map(of_row).collect()
    }
}

/// A folder is called by its last name: paths differ from machine to machine.
fn as_name<S: serde::Serializer>(folder: &impl AsRef<Path>, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.serialize_str(&name_of(folder.as_ref()))
}

fn how_many<S: serde::Serializer>(starts: &[StartRow], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    starts.len().serialize(serializer)
}

fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}

/// A method on a recording from one start.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct StartRow {
    start: String,
    /// The frame that was locked on; the first is 1.
    frame: usize,
    #[serde(flatten)]
    bbox: BoundingBox,
    visible: usize,
    correct: usize,
}

/// A method on several recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Mean {
    tracker: String,
    #[serde(flatten)]
    origin: Origin,
    /// Where the recordings lie; `None` if they are all.
    folder: Option<String>,
    recordings: usize,
    #[serde(flatten)]
    figures: Figures,
    /// Of the means over recordings; `None` of a single one.
    #[serde(flatten, serialize_with = "errors")]
    standard_error: Option<Named>,
}

/// When recordings in memory have so many bytes, no more are read before these are measured.
const ENOUGH_BYTES: u64 = recording::MOST_BYTES;

/// Runs every variant, each of a name of its own, from every start on the recordings at `paths`, which `open` opens.
///
/// Recordings, variants and starts are all spread over the threads that there are. A recording is decoded once and kept in
/// memory, where it may have 1 GiB; others are kept with it until there is as much.
pub fn measure(
    paths: &[PathBuf],
    open: impl Fn(&Path) -> Result<Sequence> + Sync,
    variants: &[Variant],
    starts: Starts,
    progress: &(impl Fn(Progress) + Sync),
) -> Robustness {
    let (mut rows, mut failures) = (Vec::new(), Vec::new());
    let mut held = Vec::new();
    let mut parts = paths.chunks(rayon::current_num_threads()).peekable();
    while let Some(part) = parts.next() {
        let read: Vec<_> = part.par_iter().map(|path| Case::read(path, &open, starts)).collect();
        for case in read {
            match case {
                Ok(case) => held.push(case),
                Err(error) => failures.push(error),
            }
        }
        let bytes: u64 = held.iter().map(|case: &Case| case.recording.bytes()).sum();
        if bytes >= ENOUGH_BYTES || parts.peek().is_none() {
            for row in run_all(&held, variants, progress) {
                match row {
                    Ok(row) => rows.push(row),
                    Err(error) => failures.push(error),
                }
            }
            held.clear();
        }
    }
    let place = |row: &Row| variants.iter().position(|variant| variant.name == row.tracker);
    rows.sort_by_key(place);
    let (means, calibration) = (means(&rows, variants), calibration(&rows, variants));
    Robustness { recordings: rows, means, paired: Vec::new(), calibration, failures }
}

/// A recording and the starts in it.
struct Case {
    recording: Recording,
    folder: PathBuf,
    starts: Vec<Start>,
}

impl Case {
    fn read(path: &Path, open: impl Fn(&Path) -> Result<Sequence>, starts: Starts) -> Result<Self> {
        let recording = Recording::read(open(path)?, recording::MOST_BYTES)?;
        Ok(Self { starts: starts.of(&recording)?, recording, folder: folder_of(path) })
    }

    fn row(&self, variant: &Variant, runs: &[RunFigures]) -> Row {
        let start = |(start, run): (&Start, &RunFigures)| StartRow {
            start: start.name.clone(),
            frame: start.frame + 1,
            bbox: start.target.into(),
            visible: run.score.visible,
            correct: run.score.correct,
        };
        Row {
            origin: variant.origin(),
            tracker: variant.name.clone(),
            sequence: self.recording.name.clone(),
            folder: self.folder.clone(),
            figures: Figures::over_starts(runs),
            calibration: Calibration::total(runs.iter().map(|run| &run.calibration)),
            starts: self.starts.iter().zip(runs).map(start).collect(),
        }
    }
}

/// One row for each recording and variant. A variant that fails from one start has no row: it would be of fewer starts.
fn run_all(cases: &[Case], variants: &[Variant], progress: &(impl Fn(Progress) + Sync)) -> Vec<Result<Row>> {
    let pairs: Vec<(&Case, &Variant)> =
        cases.iter().flat_map(|case| variants.iter().map(move |variant| (case, variant))).collect();
    let jobs: Vec<_> =
        pairs.iter().flat_map(|&(case, variant)| case.starts.iter().map(move |start| (case, variant, start))).collect();
    let expected: usize = jobs.iter().map(|(case, _, start)| case.recording.frames.len() - start.frame).sum();
    progress(Progress::Expected(expected as u64));
    // Runs are of very different length: one at a time is what a thread takes.
    let runs = jobs.par_iter().with_max_len(1).map(|&(case, variant, start)| {
        let done = run(&case.recording, variant, start, || progress(Progress::Done));
        done.with_context(|| format!("{}: {}: start {}", case.recording.name, variant.name, start.name))
    });
    let mut runs = runs.collect::<Vec<_>>().into_iter();
    let row = |&(case, variant): &(&Case, &Variant)| {
        // All of them are taken before the first failure is looked at.
        let of_case: Vec<_> = runs.by_ref().take(case.starts.len()).collect();
        Ok(case.row(variant, &of_case.into_iter().collect::<Result<Vec<_>>>()?))
    };
    pairs.iter().map(row).collect()
}

/// `variant` from `start` to the end of the recording.
fn run(recording: &Recording, variant: &Variant, start: &Start, progress: impl Fn()) -> Result<RunFigures> {
    let mut method = variant.build()?;
    let mut answers = vec![Some(BoundingBox::from(start.target))];
    let (mut states, mut confidences) = (vec![None], vec![None]);
    let mut spent = Spent { work: Some(0), ..Spent::default() };
    let mut frames = (1..).zip(&recording.frames).skip(start.frame);
    if let Some((number, first)) = frames.next() {
        lock(method.as_mut(), &first.frame(), start.target).with_context(|| format!("frame {number}"))?;
        progress();
    }
    for (number, frame) in frames {
        let frame = frame.frame();
        let begin = Instant::now();
        let report = method.update(&frame);
        let time = begin.elapsed();
        let report = report.with_context(|| format!("frame {number}"))?;
        spent.updates += 1;
        spent.time += time;
        spent.work = spent.work.zip(report.work).map(|(sum, more)| sum + u64::from(more));
        answers.push(report.target);
        states.push(Some(report.state));
        confidences.push(report.evidence.map(|evidence| evidence.confidence));
        progress();
    }
    RunFigures::new(&answers, &states, &confidences, &recording.truth[start.frame..], spent)
}

/// Where the recordings lie that belong together with the one at `path`.
fn folder_of(path: &Path) -> PathBuf {
    if smr_recordings::BUILT_IN.iter().any(|name| path == Path::new(name)) {
        return PathBuf::from("built in");
    }
    let absolute = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    absolute.parent().map_or_else(PathBuf::new, Path::to_owned)
}

fn means(rows: &[Row], variants: &[Variant]) -> Vec<Mean> {
    let mut folders: Vec<&Path> = Vec::new();
    for row in rows {
        if !folders.contains(&row.folder.as_path()) {
            folders.push(&row.folder);
        }
    }
    // Of one folder the mean is that of all.
    let split = if folders.len() > 1 { folders.as_slice() } else { &[] };
    let groups = || std::iter::once(None).chain(split.iter().map(|&folder| Some(folder)));
    let mean = |variant: &Variant, folder: Option<&Path>| {
        let belongs = |row: &&Row| row.tracker == variant.name && folder.is_none_or(|folder| row.folder == folder);
        let parts: Vec<Figures> = rows.iter().filter(belongs).map(|row| row.figures).collect();
        (!parts.is_empty()).then(|| Mean {
            tracker: variant.name.clone(),
            origin: variant.origin(),
            folder: folder.map(|folder| label(folder, &folders)),
            recordings: parts.len(),
            figures: Figures::over_recordings(&parts),
            standard_error: Named::standard_error(&parts.iter().map(Figures::headline).collect::<Vec<_>>()),
        })
    };
    variants.iter().flat_map(|variant| groups().filter_map(move |folder| mean(variant, folder))).collect()
}

/// The bins of each variant over all its rows.
fn calibration(rows: &[Row], variants: &[Variant]) -> Vec<Bin> {
    let bins = |variant: &Variant| {
        let own = rows.iter().filter(|row| row.tracker == variant.name);
        Calibration::total(own.map(|row| &row.calibration)).bins(&variant.name)
    };
    variants.iter().flat_map(bins).collect()
}

/// The folder's name; where two have the same one, the whole path.
fn label(folder: &Path, all: &[&Path]) -> String {
    let alike = all.iter().filter(|other| other.file_name() == folder.file_name()).count();
    match folder.file_name() {
        Some(name) if alike == 1 => name.to_string_lossy().into_owned(),
        _ => folder.display().to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MethodKind;
    use smr_core::paper::Config;
    use std::num::NonZeroUsize;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// A target that moves by two pixels a frame; hidden, says the truth, in the third.
    fn sequence() -> Sequence {
        let mut sequence = crate::tests::sequence();
        sequence.truth.iter_mut().for_each(|truth| truth[2] = None);
        sequence
    }

    fn measured(paths: &[&str], open: impl Fn(&Path) -> Result<Sequence> + Sync, starts: Starts) -> Robustness {
        let paths: Vec<PathBuf> = paths.iter().map(PathBuf::from).collect();
        let configs = Config::paper().into();
        let variants = [MethodKind::Smr, MethodKind::Sad].map(|kind| Variant::new(kind, &configs));
        let (expected, done) = (AtomicU64::new(0), AtomicU64::new(0));
        let result = measure(&paths, open, &variants, starts, &|progress| {
            match progress {
                Progress::Expected(frames) => expected.fetch_add(frames, Ordering::Relaxed),
                Progress::Done => done.fetch_add(1, Ordering::Relaxed),
            };
        });
        if result.failures.is_empty() {
            assert_eq!(expected.into_inner(), done.into_inner());
        }
        result
    }

    #[test]
    fn every_method_runs_from_every_start() {
        let every = Starts::Every(NonZeroUsize::MIN);
        let result = measured(&["a/moving"], |_| Ok(sequence()), every);
        assert_eq!(result.recordings.len(), 2);
        for row in &result.recordings {
            let starts: Vec<_> =
                row.starts.iter().map(|start| (start.frame, start.bbox.x, start.visible, start.correct)).collect();
            assert_eq!(starts, [(1, 4.0, 3, 3), (2, 6.0, 2, 2)], "{}", row.tracker);
            let figures = row.figures;
            assert_eq!((figures.mean_correct, figures.worst_correct, figures.mean_iou), (1.0, 1.0, 1.0));
            // Seven answers, two of them while hidden.
            assert_eq!((figures.precision, figures.answered_hidden, figures.hidden), (5.0 / 7.0, 2, 2));
            assert_eq!(figures.work_per_frame.is_some(), row.tracker == "smr");
        }
        let near = measured(&["a/moving"], |_| Ok(sequence()), Starts::Near);
        let names: Vec<_> = near.recordings[0].starts.iter().map(|start| start.start.as_str()).collect();
        assert_eq!(names, ["given", "x+2", "y+2", "0.95", "1.05"]);
    }

    #[test]
    fn means_are_over_all_and_by_folder() {
        let paths = ["here/one", "there/two", "here/three"];
        let result = measured(&paths, |_| Ok(sequence()), Starts::Every(NonZeroUsize::MIN));
        let groups: Vec<_> =
            result.means.iter().map(|mean| (mean.tracker.as_str(), mean.folder.as_deref(), mean.recordings)).collect();
        let expected = |tracker| [(tracker, None, 3), (tracker, Some("here"), 2), (tracker, Some("there"), 1)];
        assert_eq!(groups, [expected("smr"), expected("sad")].concat());
        let one_folder = measured(&paths[..1], |_| Ok(sequence()), Starts::Every(NonZeroUsize::MIN));
        assert_eq!(one_folder.means.len(), 2);
    }

    #[test]
    fn folders_of_one_name_are_told_apart() {
        let folders = [Path::new("a/tld"), Path::new("b/tld"), Path::new("b/more")];
        assert_eq!(folders.map(|folder| label(folder, &folders)), ["a/tld", "b/tld", "more"]);
        assert_eq!(folder_of(Path::new(smr_recordings::BUILT_IN[0])), Path::new("built in"));
    }

    #[test]
    fn what_fails_is_named_and_the_rest_is_measured() {
        let open = |path: &Path| match path.to_str() {
            Some("a/bare") => Ok(Sequence { name: "bare".to_owned(), truth: None, ..sequence() }),
            Some("a/outside") => {
                let init = Some("21,6,5,4".parse()?);
                Ok(Sequence { name: "outside".to_owned(), init, ..sequence() })
            }
            _ => Ok(sequence()),
        };
        let result = measured(&["a/bare", "a/moving", "a/outside"], open, Starts::Near);
        let failures: Vec<String> = result.failures.iter().map(|error| format!("{error:#}")).collect();
        let reason = "the box 21,6,5,4 (x,y,width,height) is not wholly inside the frame of 24x20 pixels";
        let expected = ["smr", "sad"].map(|name| format!("outside: {name}: start given: frame 1: {reason}"));
        assert_eq!(failures.len(), 3);
        assert!(failures.iter().any(|failure| failure.starts_with("bare: no ground truth")));
        assert!(expected.iter().all(|line| failures.contains(line)), "{failures:?}");
        assert_eq!(result.recordings.len(), 2);
    }
}
