//! What one method is better by than another, recording by recording: the recordings differ by far more than methods do, and a
//! paired difference does not contain that.

use super::Robustness;
use super::figures::HEADLINE;
use super::table::TITLES;
use crate::means::{means, standard_errors};
use crate::tables::{Columns, with_errors};
use crate::{Layout, cell, header};
use anyhow::{Context, Result, anyhow, bail, ensure};
use serde::Deserialize;
use serde::de::IgnoredAny;
use smr_recordings::input;
use std::path::Path;

/// The mean over recordings of the difference between two methods.
pub(super) struct Paired {
    tracker: String,
    /// What it is set against.
    against: String,
    /// Those that both were measured on.
    recordings: usize,
    /// Of each of the figures of the headline.
    difference: Vec<f64>,
    /// Of the difference; `None` of a single recording.
    standard_error: Option<Vec<f64>>,
}

/// For programs.
pub(super) fn columns<'a>() -> Columns<'a, Paired> {
    let names = Columns::new(&[
        ("tracker", "", |row: &Paired| row.tracker.as_str().into()),
        ("against", "", |row| row.against.as_str().into()),
        ("recordings", "", |row| row.recordings.into()),
    ]);
    names.each(with_errors(HEADLINE), |row, place| match place % 2 {
        0 => row.difference[place / 2].into(),
        _ => row.standard_error.as_ref().map(|error| error[place / 2]).into(),
    })
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

/// The tables that are read. The starts come in the order of the rows that they belong to.
#[derive(Deserialize)]
struct FormerTables {
    measured: Vec<FormerRow>,
    starts: Vec<FormerStart>,
}

impl FormerTables {
    fn rows(self) -> Vec<FormerRow> {
        let mut starts = self.starts.into_iter();
        let with_starts = |row: FormerRow| FormerRow { starts: starts.by_ref().take(row.count).collect(), ..row };
        self.measured.into_iter().map(with_starts).collect()
    }
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
        let tables: FormerTables = read.map_err(|error: serde_json::Error| {
            if serde_json::from_str::<Nested>(&text).is_ok() {
                return anyhow!("{name}: an earlier version of host-sim wrote it: measure again with this one");
            }
            anyhow!("{name}: line {}: expected {} in this version", error.line(), input::FORMER.expected)
        })?;
        let recordings = tables.rows();
        ensure!(!recordings.is_empty(), "{name}: there is no recording in it");
        Ok(Self { name, recordings })
    }
}

impl FormerRow {
    fn is_of(&self, row: &Self) -> bool {
        self.sequence == row.sequence && self.folder == row.folder
    }

    fn minus(&self, other: &Self) -> Vec<f64> {
        let figures = |row: &Self| [row.mean_correct, row.mean_correct_50, row.f];
        figures(self).iter().zip(figures(other)).map(|(own, other)| own - other).collect()
    }
}

impl Robustness {
    /// Sets every method against the one of its name in `former`, else against the first there; without it, against the first method here.
    /// Errors: What was before is from other starts, or on no recording that is here.
    pub fn compare(&mut self, former: Option<&Former>) -> Result<()> {
        let rows = serde_json::from_value::<FormerTables>(serde_json::to_value(self.tables())?)?.rows();
        let before = former.map_or(&rows, |former| &former.recordings);
        let Some(first) = before.first() else { return Ok(()) };
        self.paired.clear();
        for tracker in trackers(&rows) {
            let same = former.is_some() && before.iter().any(|row| row.tracker == tracker);
            let counterpart = if same { tracker } else { &first.tracker };
            if former.is_none() && tracker == counterpart {
                continue;
            }
            let theirs: Vec<&FormerRow> = before.iter().filter(|row| row.tracker == counterpart).collect();
            let mut differences = Vec::new();
            for row in rows.iter().filter(|row| row.tracker == tracker) {
                let Some(their) = theirs.iter().find(|their| their.is_of(row)) else { continue };
                let from = former.map_or("", |former| &former.name);
                ensure!(their.starts == row.starts, "{from}: {} was measured from other starts", row.sequence);
                differences.push(row.minus(their));
            }
            if differences.is_empty() {
                continue;
            }
            self.paired.push(Paired {
                tracker: tracker.to_owned(),
                against: former.map_or(counterpart.to_owned(), |former| format!("{counterpart} in {}", former.name)),
                recordings: differences.len(),
                difference: means(&differences),
                standard_error: standard_errors(&differences),
            });
        }
        match former {
            Some(former) if self.paired.is_empty() && !rows.is_empty() => {
                bail!("{}: there is none of these recordings in it", former.name)
            }
            _ => Ok(()),
        }
    }

    /// The differences as text; nothing if there is none.
    pub fn paired_table(&self, layout: Layout) -> String {
        if self.paired.is_empty() {
            return String::new();
        }
        let mut lines = vec![header(&format!("paired difference|recordings|{TITLES}"))];
        for Paired { tracker, against, recordings, difference, standard_error } in &self.paired {
            let names = [format!("{tracker} - {against}"), recordings.to_string()].into_iter();
            lines.push(names.chain(difference.iter().map(|value| format!("{value:+.3}"))).collect());
            if let Some(error) = standard_error {
                let names = ["  standard error".to_owned(), String::new()].into_iter();
                lines.push(names.chain(error.iter().map(|&error| cell(Some(error), 3))).collect());
            }
        }
        layout.table(&lines, 1)
    }
}

fn trackers(rows: &[FormerRow]) -> Vec<&str> {
    let mut all: Vec<&str> = Vec::new();
    for row in rows {
        if !all.contains(&row.tracker.as_str()) {
            all.push(&row.tracker);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::Row;
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
        measured.compare(None).unwrap();
        assert_eq!(measured.paired_table(Layout::Text), EXPECTED);
        assert_eq!(Robustness::default().paired_table(Layout::Text), "");
        let json = serde_json::to_value(measured.tables()).unwrap();
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
        fs::write(&file, serde_json::to_string(&of.tables()).unwrap()).unwrap();
        Former { name: "FILE".to_owned(), ..Former::read(&file).unwrap() }
    }

    #[test]
    fn a_file_is_compared_with_by_name_else_with_its_first() {
        let mut now = measured();
        now.recordings.retain(|row| row.tracker == "robust");
        let mut former = measured();
        former.recordings.retain(|row| row.tracker == "smr");
        now.compare(Some(&written(&former))).unwrap();
        assert_eq!(
            now.paired_table(Layout::Text),
            EXPECTED
                .replace("robust - smr     ", "robust - smr in FILE")
                .replace("paired difference  ", "paired difference     ")
                .replace("  standard error  ", "  standard error     ")
        );
        // Its own name is there, and nothing has changed.
        now.compare(Some(&written(&measured()))).unwrap();
        assert_eq!((now.paired[0].against.as_str(), now.paired[0].difference.iter().sum()), ("robust in FILE", 0.0));
        assert_eq!(now.paired[0].recordings, 3);
    }

    #[test]
    fn what_cannot_be_paired_is_named() {
        let error = |former: &Robustness| format!("{:#}", measured().compare(Some(&written(former))).unwrap_err());
        let mut other = measured();
        other.recordings[1].starts.pop();
        assert_eq!(error(&other), "FILE: b was measured from other starts");
        let mut other = measured();
        other.recordings.iter_mut().for_each(|row| row.sequence.push('x'));
        assert_eq!(error(&other), "FILE: there is none of these recordings in it");

        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("former.json");
        let later = "expected what `host-sim eval --robustness --json` writes in this version";
        let earlier = "an earlier version of host-sim wrote it: measure again with this one";
        for (text, why) in [
            ("", later),
            ("{\"measured\": [{}], \"starts\": []}", later),
            ("{\"recordings\": [{\"tracker\": \"smr\", \"starts\": []}]}", earlier),
            ("{\"measured\": [], \"starts\": []}", "there is no recording in it"),
        ] {
            fs::write(&file, text).unwrap();
            let error = format!("{:#}", Former::read(&file).unwrap_err());
            assert!(error.contains("former.json: ") && error.ends_with(why), "{error}");
        }
    }
}
