//! Robustness: runs each tracker from several starts of a recording and averages the figures over the starts.
//!
//! A run is scored by TLD's protocol, from its first frame on. The start box and that frame's truth normalise answers.

mod figures;
mod paired;
mod starts;

pub use paired::Former;
pub use starts::Starts;
pub(crate) use starts::whole;

use super::matrix::{self, Case, Measured, Progress};
use super::means::standard_errors;
use super::table::{Column, Head, Table, TableName, Tables, blank, cells};
use super::{Origin, Score, Variant};
use anyhow::Result;
use figures::{Figures, HEADLINE};
use serde_json::Value;
use smr_recordings::Sequence;
use std::fs;
use std::path::{Path, PathBuf};

struct Measurement<'a> {
    variant: &'a Variant,
    sequence: String,
    /// Folder of the recording. If there are several folders, each tracker gets a mean over each folder's recordings.
    folder: PathBuf,
    figures: Figures,
    starts: Vec<(Case, Score)>,
}

/// Table columns of a start. Frames are numbered from 1.
const START: &[Column<(Case, Score)>] = &[
    ("start", "", 0, |(case, _)| case.name.as_str().into()),
    ("frame", "", 0, |(case, _)| (case.frame + 1).into()),
    ("x", "", 0, |(case, _)| f64::from(case.target.x).into()),
    ("y", "", 0, |(case, _)| f64::from(case.target.y).into()),
    ("width", "", 0, |(case, _)| f64::from(case.target.width).into()),
    ("height", "", 0, |(case, _)| f64::from(case.target.height).into()),
    ("visible", "", 0, |(_, score)| score.visible.into()),
    ("correct", "", 0, |(_, score)| score.correct.into()),
];

/// Runs every variant (names must differ) from every start; compares all with `former`, or else with the first variant.
pub fn measure(
    paths: &[PathBuf],
    open: impl Fn(&Path) -> Result<Sequence> + Sync,
    variants: &[Variant],
    starts: Starts,
    former: Option<&Former>,
    progress: &(dyn Fn(Progress) + Sync),
) -> Measured {
    let (records, failures) = matrix::measure(&starts, paths.len(), |place| open(&paths[place]), variants, progress);
    let rows = records.into_iter().map(|record| {
        let (cases, runs): (Vec<_>, Vec<_>) = record.runs.into_iter().unzip();
        Measurement {
            variant: record.variant,
            sequence: record.sequence,
            folder: folder_of(&paths[record.place]),
            figures: Figures::over_starts(&runs),
            starts: cases.into_iter().zip(runs.iter().map(|run| run.score)).collect(),
        }
    });
    let rows: Vec<Measurement<'_>> = rows.collect();
    let mut tables = without_pairs(&rows, variants);
    let tables = paired::table(&tables, former).map(|paired| {
        tables.tables.push(paired);
        tables
    });
    Measured { tables, failures, notes: Vec::new(), is_empty: rows.is_empty() }
}

/// Returns three tables. First: figures, one row per method and recording. Second: the starts of these rows, row after
/// row. Third: means over all recordings and, if there are several folders, over each folder's recordings.
fn without_pairs(rows: &[Measurement<'_>], variants: &[Variant]) -> Tables {
    let (figures, origin) = (Head::all(Figures::COLUMNS), Head::all(Origin::COLUMNS));
    let names = Head::list(&[("tracker", "tracker"), ("sequence", "sequence"), ("folder", ""), ("starts", "starts")]);
    let mut measured = Table::new(TableName::Measured, 2, [names, figures.clone(), origin.clone()].concat());
    let names = Head::list(&[("tracker", ""), ("sequence", ""), ("folder", "")]);
    let mut starts = Table::new(TableName::Starts, 0, [names, Head::all(START)].concat());
    let names = Head::list(&[("tracker", ""), ("folder", ""), ("recordings", "")]);
    // Text and Markdown show the means as remarks below the measured rows, not as a table.
    let mut figures = figures;
    figures.iter_mut().for_each(Head::hide);
    let errors = HEADLINE.map(|(key, _)| Head::error(key)).to_vec();
    let mut means = Table::new(TableName::Means, 0, [names, figures, errors, origin].concat());

    let mut folders: Vec<&Path> = Vec::new();
    for row in rows {
        if !folders.contains(&row.folder.as_path()) {
            folders.push(&row.folder);
        }
    }
    // A single folder gets no mean of its own, because it would equal the mean of all recordings.
    let split = if folders.len() > 1 { folders.as_slice() } else { &[] };
    for variant in variants {
        let name = || Value::from(variant.name.as_str());
        let origin = cells(Origin::COLUMNS, Some(&variant.origin()));
        let own = || rows.iter().filter(|row| row.variant.name == variant.name);
        for row in own() {
            let names = vec![name(), row.sequence.as_str().into(), name_of(&row.folder).into()];
            let figures = cells(Figures::COLUMNS, Some(&row.figures));
            measured.row([names.clone(), vec![row.starts.len().into()], figures, origin.clone()].concat());
            for start in &row.starts {
                starts.row([names.clone(), cells(START, Some(start))].concat());
            }
        }
        for folder in std::iter::once(None).chain(split.iter().map(|&folder| Some(folder))) {
            let parts = own().filter(|row| folder.is_none_or(|folder| row.folder == folder));
            let parts: Vec<Figures> = parts.map(|row| row.figures).collect();
            if parts.is_empty() {
                continue;
            }
            let label = folder.map(|folder| label(folder, &folders));
            let figures = cells(Figures::COLUMNS, Some(&Figures::over_recordings(&parts)));
            let error = standard_errors(&parts.iter().map(Figures::headline).collect::<Vec<_>>());
            let error_at = |at: usize| Value::from(error.as_ref().map(|error| error[at]));
            let names = vec![name(), label.clone().into(), parts.len().into()];
            let errors = (0..HEADLINE.len()).map(error_at).collect();
            means.row([names, figures.clone(), errors, origin.clone()].concat());
            if parts.len() == 1 && folder.is_none() {
                continue;
            }
            let names = |what: &str| vec![name(), what.into(), Value::Null, blank()];
            let place = label.map_or(String::new(), |folder| format!(" in {folder}"));
            measured.remark([names(&format!("mean of {}{place}", parts.len())), figures].concat());
            if error.is_some() {
                let of_key = |&(key, ..): &Column<Figures>| {
                    HEADLINE.iter().position(|(known, _)| *known == key).map_or(blank(), error_at)
                };
                let errors = Figures::COLUMNS.iter().map(of_key).collect();
                measured.remark([names("  standard error"), errors].concat());
            }
        }
    }
    Tables { tables: vec![measured, starts, means], ..Tables::default() }
}

/// Returns the last component of the path, because whole paths differ from machine to machine.
fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}

/// Returns the folder by which the recording at `path` is grouped with others.
fn folder_of(path: &Path) -> PathBuf {
    if smr_recordings::BUILT_IN.iter().any(|name| path == Path::new(name)) {
        return PathBuf::from("built in");
    }
    let absolute = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    absolute.parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// Returns the folder's name, or its whole path if another folder has the same name.
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
    use crate::{Layout, MethodKind};
    use smr_core::Rect;
    use smr_core::paper::Config;
    use std::sync::atomic::{AtomicU64, Ordering};

    pub fn variants() -> [Variant; 2] {
        [MethodKind::Paper, MethodKind::Sad].map(|kind| Variant::new(kind, &Config::paper().into()))
    }

    pub fn row<'a>(variant: &'a Variant, sequence: &str, figures: Figures) -> Measurement<'a> {
        let target = Rect::new(1, 2, 3, 4);
        let intervention = matrix::Intervention::None;
        let case = Case { name: "given".to_owned(), frame: 0, target, end: 4, intervention };
        let start = (case, Score { visible: 4, correct: 2, ..Score::default() });
        Measurement { variant, sequence: sequence.to_owned(), folder: "a/tld".into(), figures, starts: vec![start; 5] }
    }

    /// A target that moves by two pixels per frame; in the third frame the ground truth marks it as hidden.
    fn sequence() -> Sequence {
        let mut sequence = crate::tests::sequence();
        sequence.truth.iter_mut().for_each(|truth| truth[2] = None);
        sequence
    }

    fn measured(paths: &[&str], open: impl Fn(&Path) -> Result<Sequence> + Sync, starts: &str) -> (Value, Vec<String>) {
        let paths: Vec<PathBuf> = paths.iter().map(PathBuf::from).collect();
        let (expected, done) = (AtomicU64::new(0), AtomicU64::new(0));
        let progress = |progress| {
            match progress {
                Progress::Expected { frames, .. } => expected.fetch_add(frames, Ordering::Relaxed),
                Progress::Done => done.fetch_add(1, Ordering::Relaxed),
            };
        };
        let result = measure(&paths, open, &variants(), starts.parse().unwrap(), None, &progress);
        if result.failures.is_empty() {
            assert_eq!(expected.into_inner(), done.into_inner());
        }
        let failures = result.failures.iter().map(|error| format!("{error:#}")).collect();
        (serde_json::to_value(result.tables.unwrap()).unwrap(), failures)
    }

    fn column<'a>(json: &'a Value, table: &str, keys: &[&str]) -> Vec<Vec<&'a Value>> {
        json[table].as_array().unwrap().iter().map(|row| keys.iter().map(|key| &row[key]).collect()).collect()
    }

    #[test]
    fn every_method_runs_from_every_start() {
        let (json, _) = measured(&["a/moving"], |_| Ok(sequence()), "every:1");
        let figures = column(&json, "measured", &["tracker", "mean_correct", "worst_correct", "mean_iou", "precision"]);
        // Both starts together give seven answers, two of them in the frame that hides the target.
        let expected = |tracker| serde_json::json!([tracker, 1.0, 1.0, 1.0, 5.0 / 7.0]);
        assert_eq!(serde_json::to_value(figures).unwrap(), serde_json::json!([expected("paper"), expected("sad")]));
        let hidden = column(&json, "measured", &["answered_hidden", "hidden"]);
        assert_eq!(serde_json::to_value(hidden).unwrap(), serde_json::json!([[2, 2], [2, 2]]));
        let work: Vec<_> = column(&json, "measured", &["work_per_frame"]).concat();
        assert_eq!((work[0].is_null(), work[1].is_null()), (false, true));
        let starts = column(&json, "starts", &["tracker", "frame", "x", "visible", "correct"]);
        let expected =
            |tracker| [serde_json::json!([tracker, 1, 4.0, 3, 3]), serde_json::json!([tracker, 2, 6.0, 2, 2])];
        assert_eq!(serde_json::to_value(starts).unwrap(), Value::from([expected("paper"), expected("sad")].concat()));
        let (near, _) = measured(&["a/moving"], |_| Ok(sequence()), "5");
        let names: Vec<_> = column(&near, "starts", &["start"]).concat();
        assert_eq!(names[..5], ["given", "x+2", "y+2", "0.95", "1.05"]);
    }

    #[test]
    fn means_are_over_all_and_by_folder() {
        let paths = ["here/one", "there/two", "here/three"];
        let (json, _) = measured(&paths, |_| Ok(sequence()), "every:1");
        let groups = serde_json::to_value(column(&json, "means", &["tracker", "folder", "recordings"])).unwrap();
        let expected = |tracker| {
            [(None, 3), (Some("here"), 2), (Some("there"), 1)]
                .map(|(folder, count)| serde_json::json!([tracker, folder, count]))
        };
        assert_eq!(groups, Value::from([expected("paper"), expected("sad")].concat()));
        let (one_folder, _) = measured(&paths[..1], |_| Ok(sequence()), "every:1");
        assert_eq!(one_folder["means"].as_array().unwrap().len(), 2);
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
        let (json, failures) = measured(&["a/bare", "a/moving", "a/outside"], open, "5");
        let reason = "the box 21,6,5,4 (x,y,width,height) is not wholly inside the frame of 24x20 pixels";
        let expected = ["paper", "sad"].map(|name| format!("outside: {name}: start given: frame 1: {reason}"));
        assert_eq!(failures.len(), 3);
        assert!(failures.iter().any(|failure| failure.starts_with("bare: no ground truth")));
        assert!(expected.iter().all(|line| failures.contains(line)), "{failures:?}");
        assert_eq!(json["measured"].as_array().unwrap().len(), 2);
    }

    #[test]
    fn recordings_then_means() {
        let figures = |correct: f64, hidden: usize, work: Option<f64>| Figures {
            mean_correct: correct,
            worst_correct: 0.25,
            mean_correct_50: 0.25,
            f: 0.5,
            mean_iou: 0.5,
            precision: 1.0,
            hidden,
            answered_hidden: hidden / 2,
            returns: hidden / 5,
            found_again: hidden / 10,
            tracking: hidden * 2,
            tracking_wrong: hidden / 5,
            wrong: hidden / 2,
            right: hidden,
            right_unsaid: hidden / 10,
            work_per_frame: work,
            microseconds_per_frame: 12.4,
        };
        let variants = variants();
        let elsewhere = |row| Measurement { folder: "b/more".into(), ..row };
        let rows = [
            row(&variants[0], "01_david", figures(0.75, 10, Some(123_456.0))),
            row(&variants[0], "Man", figures(0.5, 10, Some(123_456.0))),
            elsewhere(row(&variants[0], "Car", figures(0.25, 20, None))),
            row(&variants[1], "01_david", figures(2.0 / 3.0, 0, None)),
        ];
        let expected = "\
tracker  sequence           starts  correct  worst  correct@0.5      F  mean IoU  precision  answered/hidden  found/returns  wrong/tracking  tracking/wrong  unsaid/right  work/frame  us/frame
paper    01_david                5    0.750  0.250        0.250  0.500     0.500      1.000             5/10            1/2            2/20             2/5          1/10      123456        12
paper    Man                     5    0.500  0.250        0.250  0.500     0.500      1.000             5/10            1/2            2/20             2/5          1/10      123456        12
paper    Car                     5    0.250  0.250        0.250  0.500     0.500      1.000            10/20            2/4            4/40            4/10          2/20           -        12
paper    mean of 3                    0.500  0.250        0.250  0.500     0.500      1.000            20/40            4/8            8/80            8/20          4/40           -        12
paper      standard error             0.144               0.000  0.000
paper    mean of 2 in tld             0.625  0.250        0.250  0.500     0.500      1.000            10/20            2/4            4/40            4/10          2/20      123456        12
paper      standard error             0.125               0.000  0.000
paper    mean of 1 in more            0.250  0.250        0.250  0.500     0.500      1.000            10/20            2/4            4/40            4/10          2/20           -        12
sad      01_david                5    0.667  0.250        0.250  0.500     0.500      1.000                -              -               -               -             -           -        12
sad      mean of 1 in tld             0.667  0.250        0.250  0.500     0.500      1.000                -              -               -               -             -           -        12
";
        let tables = without_pairs(&rows, &variants);
        assert_eq!(tables.text(Layout::Text), expected);
        assert_eq!(without_pairs(&[], &variants).text(Layout::Text), "");
        let json = serde_json::to_value(tables).unwrap();
        let recording = &json["measured"][0];
        assert_eq!((&recording["tracker"], &recording["mean_correct"]), (&"paper".into(), &0.75.into()));
        assert_eq!(json["starts"].as_array().unwrap().len(), 4 * 5);
        assert_eq!((&json["starts"][0]["x"], &json["starts"][0]["correct"]), (&1.0.into(), &2.into()));
        assert!(json["measured"][2]["work_per_frame"].is_null() && json["means"][0]["folder"].is_null());
        assert_eq!((&json["means"][1]["folder"], &json["means"][1]["recordings"]), (&"tld".into(), &2.into()));
        assert_eq!(json["means"][1]["mean_correct_standard_error"], 0.125);
        assert!(json["means"][2]["mean_correct_standard_error"].is_null());
    }
}
