//! How much it takes to lose a target: methods, or variants of one, run over recordings from several starts each, and what that comes to.
//!
//! - `starts`: where runs start.
//! - `figures`: what runs come to.
//! - `paired`: what one method is better by than another.
//! - `table`: the results as text.
//!
//! Each run is scored by the protocol of the recordings, from the frame in which it starts: its answers are normalised by its
//! own start and the truth of that frame, and the frame of the start counts.

mod figures;
mod paired;
mod starts;
mod table;

pub use figures::Figures;
pub use paired::Former;
pub use starts::Starts;

use super::means::standard_errors;
use super::run::{Intervention, MOST_BYTES, Recording};
use super::tables::{Columns, TableName, Tables, error_of};
use super::{Origin, Score, Variant};
use anyhow::{Context, Error, Result};
use figures::{HEADLINE, RunFigures};
use paired::Paired;
use rayon::prelude::*;
use smr_recordings::{Sequence, cleanup};
use starts::Start;
use std::fs;
use std::path::{Path, PathBuf};

pub const TABLES: &[TableName] = &[TableName::Measured, TableName::Starts, TableName::Means, TableName::Paired];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// So many frames more will come, of so many recordings.
    Expected {
        frames: u64,
        recordings: usize,
    },
    Done,
}

#[derive(Default)]
pub struct Robustness {
    /// Method by method, each with its recordings in the order in which they were given.
    recordings: Vec<Row>,
    /// Of each method: over all recordings, then, if they lie in several folders, by folder.
    means: Vec<Mean>,
    /// What each method is better by than another one, if that was asked for.
    paired: Vec<Paired>,
    pub failures: Vec<Error>,
}

impl Robustness {
    pub fn is_empty(&self) -> bool {
        self.recordings.is_empty()
    }

    /// All of it for JSON and CSV. Starts come in the order of the rows of `measured` that they
    /// belong to.
    pub fn tables(&self) -> Tables {
        let starts: Vec<_> =
            self.recordings.iter().flat_map(|row| row.starts.iter().map(move |start| (row, start))).collect();
        Tables(vec![
            Row::columns().table(TableName::Measured, &self.recordings),
            start_columns().table(TableName::Starts, &starts),
            Mean::columns().table(TableName::Means, &self.means),
            paired::columns().table(TableName::Paired, &self.paired),
        ])
    }
}

/// A method on a recording.
#[derive(Clone)]
struct Row {
    origin: Origin,
    tracker: String,
    sequence: String,
    /// Of the recording.
    path: PathBuf,
    /// The folder that the recording lies in, among others.
    folder: PathBuf,
    figures: Figures,
    /// Where it was started, and what it made of it.
    starts: Vec<(Start, Score)>,
}

impl Row {
    fn columns<'a>() -> Columns<'a, Self> {
        let names = Columns::new(&[
            ("tracker", "", |row: &Self| row.tracker.as_str().into()),
            ("sequence", "", |row| row.sequence.as_str().into()),
            ("folder", "", |row| name_of(&row.folder).into()),
            ("starts", "", |row| row.starts.len().into()),
        ]);
        names.and(Figures::columns(), |row| Some(&row.figures)).and(Origin::columns(), |row| Some(&row.origin))
    }
}

/// Frames count from 1.
fn start_columns<'a>() -> Columns<'a, (&'a Row, &'a (Start, Score))> {
    type Of<'a> = (&'a Row, &'a (Start, Score));
    Columns::new(&[
        ("tracker", "", |of: &Of<'a>| of.0.tracker.as_str().into()),
        ("sequence", "", |of| of.0.sequence.as_str().into()),
        ("folder", "", |of| name_of(&of.0.folder).into()),
        ("start", "", |of| of.1.0.name.as_str().into()),
        ("frame", "", |of| (of.1.0.frame + 1).into()),
        ("x", "", |of| f64::from(of.1.0.target.x).into()),
        ("y", "", |of| f64::from(of.1.0.target.y).into()),
        ("width", "", |of| f64::from(of.1.0.target.width).into()),
        ("height", "", |of| f64::from(of.1.0.target.height).into()),
        ("visible", "", |of| of.1.1.visible.into()),
        ("correct", "", |of| of.1.1.correct.into()),
    ])
}

/// A folder is called by its last name: paths differ from machine to machine.
fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}

/// A method on several recordings.
struct Mean {
    tracker: String,
    origin: Origin,
    /// Where the recordings lie; `None` if they are all.
    folder: Option<String>,
    recordings: usize,
    figures: Figures,
    /// Of the means over recordings of the figures of the headline; `None` of a single one.
    standard_error: Option<Vec<f64>>,
}

impl Mean {
    fn columns<'a>() -> Columns<'a, Self> {
        let names = Columns::new(&[
            ("tracker", "", |mean: &Self| mean.tracker.as_str().into()),
            ("folder", "", |mean| mean.folder.as_deref().into()),
            ("recordings", "", |mean| mean.recordings.into()),
        ]);
        let figures = names.and(Figures::columns(), |mean| Some(&mean.figures));
        let errors = figures
            .each(HEADLINE.map(error_of), |mean, place| mean.standard_error.as_ref().map(|error| error[place]).into());
        errors.and(Origin::columns(), |mean| Some(&mean.origin))
    }
}

/// When recordings in memory have so many bytes, no more are read before these are measured.
const ENOUGH_BYTES: u64 = MOST_BYTES;

/// Runs every variant, each of a name of its own, from every start on the recordings at `paths`, which `open` opens.
///
/// Recordings, variants and starts are all spread over the threads that there are. A recording is decoded once and kept in
/// memory, where it may have 1 GiB; others are kept with it until there is as much. If a signal asks to stop, it is of the rows that are
/// whole.
pub fn measure(
    paths: &[PathBuf],
    open: impl Fn(&Path) -> Result<Sequence> + Sync,
    variants: &[Variant],
    starts: Starts,
    progress: &(impl Fn(Progress) + Sync),
) -> Robustness {
    let (mut rows, mut failures, mut held) = (Vec::new(), Vec::new(), Vec::new());
    let mut parts = paths.chunks(rayon::current_num_threads()).peekable();
    while let Some(part) = parts.next()
        && !cleanup::is_stopped()
    {
        let read: Vec<_> = part.par_iter().map(|path| Case::read(path, &open, starts)).collect();
        separate(read, &mut held, &mut failures);
        let bytes: u64 = held.iter().map(|case: &Case| case.recording.bytes()).sum();
        if bytes >= ENOUGH_BYTES || parts.peek().is_none() {
            let pairs = held.iter().flat_map(|case| variants.iter().map(move |variant| (case, variant)));
            let pairs: Vec<_> = pairs.collect();
            let frames = pairs.iter().map(|(case, _)| case.frames_to_run()).sum();
            progress(Progress::Expected { frames, recordings: held.len() });
            separate(run_all(&pairs, progress), &mut rows, &mut failures);
            held.clear();
        }
    }
    let place = |row: &Row| {
        let path = paths.iter().position(|path| *path == row.path);
        (variants.iter().position(|variant| variant.name == row.tracker), path)
    };
    rows.sort_by_key(place);
    Robustness { means: means(&rows, variants), recordings: rows, paired: Vec::new(), failures }
}

/// Those that are good, and the failures of the others.
fn separate<T>(results: Vec<Result<T>>, good: &mut Vec<T>, failures: &mut Vec<Error>) {
    results.into_iter().for_each(|result| match result {
        Ok(one) => good.push(one),
        Err(error) => failures.push(error),
    });
}

/// A recording and the starts in it.
struct Case {
    recording: Recording,
    path: PathBuf,
    starts: Vec<Start>,
}

impl Case {
    fn read(path: &Path, open: impl Fn(&Path) -> Result<Sequence>, starts: Starts) -> Result<Self> {
        let recording = Recording::read(open(path)?, MOST_BYTES)?;
        Ok(Self { starts: starts.of(&recording)?, recording, path: path.to_owned() })
    }

    /// By one variant, from all starts.
    fn frames_to_run(&self) -> u64 {
        self.starts.iter().map(|start| (self.recording.frames.len() - start.frame) as u64).sum()
    }

    fn row(&self, variant: &Variant, runs: &[RunFigures]) -> Row {
        Row {
            origin: variant.origin(),
            tracker: variant.name.clone(),
            sequence: self.recording.name.clone(),
            path: self.path.clone(),
            folder: folder_of(&self.path),
            figures: Figures::over_starts(runs),
            starts: self.starts.iter().cloned().zip(runs.iter().map(|run| run.score)).collect(),
        }
    }
}

/// One row for each recording and variant. A variant that fails from one start has no row: it would be of fewer starts. Nor has one that was
/// stopped.
fn run_all(pairs: &[(&Case, &Variant)], progress: &(impl Fn(Progress) + Sync)) -> Vec<Result<Row>> {
    // Runs are of very different length: one at a time is what a thread takes.
    let row = |&(case, variant): &(&Case, &Variant)| {
        let Recording { name, frames, truth, .. } = &case.recording;
        let run = |start: &Start| {
            let from = (start.frame, start.target);
            let done = || progress(Progress::Done);
            let run = case.recording.run(variant, from, frames.len(), Intervention::None, done);
            let figures = run.and_then(|run| RunFigures::new(&run, &truth[start.frame..]));
            figures.with_context(|| format!("{name}: {}: start {}", variant.name, start.name))
        };
        let runs: Vec<_> = case.starts.par_iter().with_max_len(1).map(run).collect();
        Ok(case.row(variant, &runs.into_iter().collect::<Result<Vec<_>>>()?))
    };
    let of_whole = |pair| Some(row(pair)).filter(|row| row.is_ok() || !cleanup::is_stopped());
    pairs.par_iter().with_max_len(1).filter_map(of_whole).collect()
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
            standard_error: standard_errors(&parts.iter().map(Figures::headline).collect::<Vec<_>>()),
        })
    };
    variants.iter().flat_map(|variant| groups().filter_map(move |folder| mean(variant, folder))).collect()
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
                Progress::Expected { frames, .. } => expected.fetch_add(frames, Ordering::Relaxed),
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
                row.starts.iter().map(|(at, score)| (at.frame, at.target.x, score.visible, score.correct)).collect();
            assert_eq!(starts, [(0, 4, 3, 3), (1, 6, 2, 2)], "{}", row.tracker);
            let figures = row.figures;
            assert_eq!((figures.mean_correct, figures.worst_correct, figures.mean_iou), (1.0, 1.0, 1.0));
            // Seven answers, two of them while hidden.
            assert_eq!((figures.precision, figures.answered_hidden, figures.hidden), (5.0 / 7.0, 2, 2));
            assert_eq!(figures.work_per_frame.is_some(), row.tracker == "smr");
        }
        let near = measured(&["a/moving"], |_| Ok(sequence()), Starts::Near);
        let names: Vec<_> = near.recordings[0].starts.iter().map(|(start, _)| start.name.as_str()).collect();
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
