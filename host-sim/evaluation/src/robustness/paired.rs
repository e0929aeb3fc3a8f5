//! What one method is better by than another, recording by recording: the recordings differ by far more than methods do, and a
//! paired difference does not contain that.

use super::figures::HEADLINE;
use super::table::TITLES;
use super::{Robustness, Row, StartRow, name_of};
use crate::means::{Named, errors};
use crate::{Layout, cell, header};
use anyhow::{Context, Result, anyhow, bail, ensure};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use smr_recordings::input;
use std::path::Path;

/// The mean over recordings of the difference between two methods.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Paired {
    tracker: String,
    /// What it is set against.
    against: String,
    /// Those that both were measured on.
    recordings: usize,
    #[serde(flatten)]
    difference: Named,
    /// Of the difference; `None` of a single recording.
    #[serde(flatten, serialize_with = "errors")]
    standard_error: Option<Named>,
}

/// What was measured before, as far as it is compared.
#[derive(Debug)]
pub struct Former {
    name: String,
    recordings: Vec<FormerRow>,
}

/// A tracker on a recording.
#[derive(Clone, Debug, Deserialize)]
struct FormerRow {
    tracker: String,
    sequence: String,
    folder: String,
    mean_correct: f64,
    mean_correct_50: f64,
    f: f64,
    /// How many of the starts are its own.
    #[serde(rename = "starts")]
    count: usize,
    #[serde(skip)]
    starts: Vec<FormerStart>,
}

#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
struct FormerStart {
    start: String,
    frame: usize,
}

/// The tables of the file that are read. The starts come in the order of the rows that they belong to.
#[derive(Deserialize)]
struct FormerTables {
    measured: Vec<FormerRow>,
    starts: Vec<FormerStart>,
}

/// What files of earlier versions had in place of the tables.
#[derive(Deserialize)]
struct Nested {
    #[serde(rename = "recordings")]
    _recordings: Vec<IgnoredAny>,
}

impl Former {
    /// Reads a file that `eval --robustness --json` wrote.
    /// Errors: the file cannot be read, or is of another kind.
    pub fn read(file: &Path) -> Result<Self> {
        let text = input::text(file, &input::FORMER).with_context(|| format!("cannot read {}", file.display()))?;
        let name = file.display().to_string();
        let read = serde_json::from_str(&text);
        let FormerTables { measured, starts } = read.map_err(|error: serde_json::Error| {
            if serde_json::from_str::<Nested>(&text).is_ok() {
                return anyhow!("{name}: an earlier version of host-sim wrote it: measure again with this one");
            }
            anyhow!("{name}: line {}: expected {} in this version", error.line(), input::FORMER.expected)
        })?;
        let mut starts = starts.into_iter();
        let with_starts = |row: FormerRow| FormerRow { starts: starts.by_ref().take(row.count).collect(), ..row };
        let recordings: Vec<FormerRow> = measured.into_iter().map(with_starts).collect();
        ensure!(!recordings.is_empty(), "{name}: there is no recording in it");
        Ok(Self { name, recordings })
    }

    /// The tracker of that name, else the first.
    fn counterpart<'a>(&'a self, tracker: &'a str) -> &'a str {
        let same = self.recordings.iter().any(|row| row.tracker == tracker);
        self.recordings.first().filter(|_| !same).map_or(tracker, |row| &row.tracker)
    }
}

impl From<&Row> for FormerRow {
    fn from(row: &Row) -> Self {
        let start = |start: &StartRow| FormerStart { start: start.start.clone(), frame: start.frame };
        Self {
            tracker: row.tracker.clone(),
            sequence: row.sequence.clone(),
            folder: name_of(&row.folder),
            mean_correct: row.figures.mean_correct,
            mean_correct_50: row.figures.mean_correct_50,
            f: row.figures.f,
            count: row.starts.len(),
            starts: row.starts.iter().map(start).collect(),
        }
    }
}

impl FormerRow {
    fn is_of(&self, row: &Self) -> bool {
        self.sequence == row.sequence && self.folder == row.folder
    }

    fn minus(&self, other: &Self) -> Named {
        let correct = self.mean_correct - other.mean_correct;
        let correct_50 = self.mean_correct_50 - other.mean_correct_50;
        Named(HEADLINE.into_iter().zip([correct, correct_50, self.f - other.f]).collect())
    }
}

impl Robustness {
    /// Sets every method against the first one.
    pub fn compare_with_first(&mut self) {
        let rows: Vec<FormerRow> = self.recordings.iter().map(FormerRow::from).collect();
        let Some(first) = rows.first().map(|row| row.tracker.clone()) else { return };
        let others = trackers(&rows).into_iter().filter(|tracker| *tracker != first);
        let of_first: Vec<&FormerRow> = rows.iter().filter(|row| row.tracker == first).collect();
        self.paired = others.filter_map(|tracker| paired(&rows, tracker, &of_first, &first)).collect();
    }

    /// Sets every method against what was measured before.
    /// Errors: That was from other starts, or on no recording that is here.
    pub fn compare_with(&mut self, former: &Former) -> Result<()> {
        let rows: Vec<FormerRow> = self.recordings.iter().map(FormerRow::from).collect();
        let mut compared = Vec::new();
        for tracker in trackers(&rows) {
            let counterpart = former.counterpart(tracker);
            let theirs: Vec<&FormerRow> = former.recordings.iter().filter(|row| row.tracker == counterpart).collect();
            for row in rows.iter().filter(|row| row.tracker == tracker) {
                let same_starts =
                    theirs.iter().filter(|their| their.is_of(row)).all(|their| their.starts == row.starts);
                ensure!(same_starts, "{}: {} was measured from other starts", former.name, row.sequence);
            }
            let name = format!("{counterpart} in {}", former.name);
            compared.extend(paired(&rows, tracker, &theirs, &name));
        }
        if compared.is_empty() && !rows.is_empty() {
            bail!("{}: there is none of these recordings in it", former.name);
        }
        self.paired = compared;
        Ok(())
    }

    /// The differences as text; nothing if there is none.
    pub fn paired_table(&self, layout: Layout) -> String {
        if self.paired.is_empty() {
            return String::new();
        }
        let mut lines = vec![header(&format!("paired difference|recordings|{TITLES}"))];
        for Paired { tracker, against, recordings, difference, standard_error } in &self.paired {
            let names = [format!("{tracker} - {against}"), recordings.to_string()].into_iter();
            lines.push(names.chain(difference.values().map(|value| format!("{value:+.3}"))).collect());
            if let Some(error) = standard_error {
                let names = ["  standard error".to_owned(), String::new()].into_iter();
                lines.push(names.chain(error.values().map(|error| cell(Some(error), 3))).collect());
            }
        }
        layout.table(&lines, 1)
    }
}

/// Each once, in their order.
fn trackers(rows: &[FormerRow]) -> Vec<&str> {
    let mut all: Vec<&str> = Vec::new();
    for row in rows {
        if !all.contains(&row.tracker.as_str()) {
            all.push(&row.tracker);
        }
    }
    all
}

/// `tracker` against `theirs`, on the recordings that both have.
fn paired(rows: &[FormerRow], tracker: &str, theirs: &[&FormerRow], against: &str) -> Option<Paired> {
    let own = rows.iter().filter(|row| row.tracker == tracker);
    let pair = |row: &FormerRow| {
        let their = theirs.iter().find(|their| their.is_of(row))?;
        Some(row.minus(their))
    };
    let differences: Vec<Named> = own.filter_map(pair).collect();
    (!differences.is_empty()).then(|| Paired {
        tracker: tracker.to_owned(),
        against: against.to_owned(),
        recordings: differences.len(),
        difference: Named::mean(&differences),
        standard_error: Named::standard_error(&differences),
    })
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::row;
    use super::*;
    use crate::robustness::Figures;
    use std::fs;

    fn figures(correct: f64) -> Figures {
        Figures { mean_correct: correct, mean_correct_50: correct / 2.0, f: correct, ..Figures::default() }
    }

    /// Two methods on three recordings, the second better by 0.1, 0.3 and -0.1: mean 0.1, squares 0 + 0.04 + 0.04, and
    /// 0.08 / 2 / 3 = 0.013333 is the square of the standard error.
    fn measured() -> Robustness {
        let of = |tracker: &str, correct: [f64; 3]| {
            ["a", "b", "c"]
                .into_iter()
                .zip(correct)
                .map(|(name, correct)| row(tracker, name, figures(correct)))
                .collect()
        };
        let recordings: [Vec<Row>; 2] = [of("smr", [0.2, 0.5, 0.8]), of("robust", [0.3, 0.8, 0.7])];
        Robustness { recordings: recordings.concat(), ..Robustness::default() }
    }

    const EXPECTED: &str = "\
paired difference  recordings  correct  correct@0.5       F
robust - smr                3   +0.100       +0.050  +0.100
  standard error                 0.115        0.058   0.115
";

    #[test]
    fn differences_by_hand() {
        let mut measured = measured();
        measured.compare_with_first();
        assert_eq!(measured.paired_table(Layout::Text), EXPECTED);
        assert_eq!(Robustness::default().paired_table(Layout::Text), "");
        let json = serde_json::to_value(measured.tables().unwrap()).unwrap();
        let paired = &json["paired"][0];
        assert_eq!(
            (&paired["tracker"], &paired["against"], &paired["recordings"]),
            (&"robust".into(), &"smr".into(), &3.into())
        );
        assert!((paired["mean_correct_standard_error"].as_f64().unwrap() - 0.115_470).abs() < 1e-6);
    }

    /// `of` as it was written by the command.
    fn written(of: &Robustness) -> Former {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("former.json");
        fs::write(&file, serde_json::to_string(&of.tables().unwrap()).unwrap()).unwrap();
        Former { name: "FILE".to_owned(), ..Former::read(&file).unwrap() }
    }

    #[test]
    fn a_file_is_compared_with_by_name_else_with_its_first() {
        let mut now = measured();
        now.recordings.retain(|row| row.tracker == "robust");
        let mut former = measured();
        former.recordings.retain(|row| row.tracker == "smr");
        now.compare_with(&written(&former)).unwrap();
        assert_eq!(
            now.paired_table(Layout::Text),
            EXPECTED
                .replace("robust - smr     ", "robust - smr in FILE")
                .replace("paired difference  ", "paired difference     ")
                .replace("  standard error  ", "  standard error     ")
        );
        // Its own name is there, and nothing has changed.
        now.compare_with(&written(&measured())).unwrap();
        assert_eq!((now.paired[0].against.as_str(), now.paired[0].difference.values().sum()), ("robust in FILE", 0.0));
        assert_eq!(now.paired[0].recordings, 3);
    }

    #[test]
    fn what_cannot_be_paired_is_named() {
        let error = |former: &Robustness| format!("{:#}", measured().compare_with(&written(former)).unwrap_err());
        let mut other = measured();
        other.recordings[1].starts.pop();
        assert_eq!(error(&other), "FILE: b was measured from other starts");
        let mut other = measured();
        other.recordings.iter_mut().for_each(|row| row.sequence.push('x'));
        assert_eq!(error(&other), "FILE: there is none of these recordings in it");

        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("former.json");
        for text in ["", "[]", "{\"measured\": [{}], \"starts\": []}"] {
            fs::write(&file, text).unwrap();
            let error = format!("{:#}", Former::read(&file).unwrap_err());
            assert!(
                error.contains("former.json: line ")
                    && error.contains(": expected what `host-sim eval --robustness --json` writes"),
                "{error}"
            );
        }
        fs::write(&file, "{\"recordings\": [{\"tracker\": \"smr\", \"starts\": []}]}").unwrap();
        let error = Former::read(&file).unwrap_err().to_string();
        assert!(
            error.ends_with("former.json: an earlier version of host-sim wrote it: measure again with this one"),
            "{error}"
        );
        fs::write(&file, "{\"measured\": [], \"starts\": []}").unwrap();
        assert!(Former::read(&file).unwrap_err().to_string().ends_with("there is no recording in it"));
    }
}
