//! Paired differences of methods on the same recordings, because recordings differ by far more than methods do.

use super::figures::HEADLINE;
use crate::Tables;
use crate::means::{means, standard_errors};
use crate::table::{Head, Table, TableName};
use anyhow::{Context, Result, anyhow, ensure};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;
use smr_files::input::{self, Kind};
use std::path::Path;

const KIND: Kind = Kind { expected: "what `host-sim eval --robustness --json` writes", most: 64 };

/// An earlier measurement, with which a new one is compared.
#[derive(Debug)]
pub struct Former {
    name: String,
    recordings: Vec<FormerRow>,
}

#[derive(Clone, Debug, Deserialize)]
struct FormerRow {
    tracker: String,
    sequence: String,
    folder: String,
    mean_correct: f64,
    mean_correct_50: f64,
    f: f64,
    #[serde(rename = "starts")]
    count: usize,
    #[serde(skip)]
    starts: Vec<FormerStart>,
}

#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
struct FormerStart {
    start: String,
    frame: usize,
    /// Frames of the run with a visible target: other frames (`--every`, `--frames`) give another number.
    visible: usize,
}

/// Tables of a measurement, earlier or new. `starts` begins with all starts of the first row of `measured`, then has
/// those of the second row, and so on.
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

/// A file that an earlier version of `host-sim` wrote, with `recordings` in place of the tables.
#[derive(Deserialize)]
struct Nested {
    #[serde(rename = "recordings")]
    _recordings: Vec<IgnoredAny>,
}

impl Former {
    /// Reads a file that `eval --robustness --json` wrote; an error if it is unreadable or of another kind.
    pub fn read(file: &Path) -> Result<Self> {
        let text = input::text(file, &KIND).with_context(|| format!("cannot read {}", file.display()))?;
        let name = file.display().to_string();
        let read = serde_json::from_str(&text);
        let tables: FormerTables = read.map_err(|error: serde_json::Error| {
            if serde_json::from_str::<Nested>(&text).is_ok() {
                return anyhow!("{name}: an earlier version of host-sim wrote it: measure again with this one");
            }
            anyhow!("{name}: line {}: expected {} in this version", error.line(), KIND.expected)
        })?;
        let mut recordings = tables.rows();
        // The name of the paper tracker in files of earlier versions.
        recordings.iter_mut().filter(|row| row.tracker == "smr").for_each(|row| row.tracker = "paper".to_owned());
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

/// Returns the table of mean differences. Each method is compared with the method of the same name in `former`; if that
/// is missing, with the first method of `former`; or, if `former` itself is `None`, with the first method of `tables`.
/// Errors: `former` was measured from other starts or in other frames, or shares no recording with `tables`.
pub(super) fn table(tables: &Tables, former: Option<&Former>) -> Result<Table> {
    let names =
        Head::list(&[("", "paired difference"), ("tracker", ""), ("against", ""), ("recordings", "recordings")]);
    let for_people = HEADLINE.iter().map(|(_, title)| Head::new("", title, 3)).collect();
    let mut table =
        Table::new(TableName::Paired, 1, [names, Head::with_errors(HEADLINE.map(|(key, _)| key)), for_people].concat());

    let rows = serde_json::from_value::<FormerTables>(serde_json::to_value(tables)?)?.rows();
    let before = former.map_or(&rows, |former| &former.recordings);
    let Some(first) = before.first() else { return Ok(table) };
    let mut is_paired = false;
    for own in rows.chunk_by(|a, b| a.tracker == b.tracker) {
        let tracker = own[0].tracker.as_str();
        let is_there = former.is_some() && before.iter().any(|row| row.tracker == tracker);
        let counterpart = if is_there { tracker } else { &first.tracker };
        if former.is_none() && tracker == counterpart {
            continue;
        }
        let mut differences = Vec::new();
        for row in own {
            let is_its = |their: &&FormerRow| their.tracker == counterpart && their.is_of(row);
            let Some(their) = before.iter().find(is_its) else { continue };
            let from = former.map_or("", |former| &former.name);
            ensure!(
                their.starts == row.starts,
                "{from}: {} was measured from other starts, or in other frames",
                row.sequence
            );
            differences.push(row.minus(their));
        }
        if differences.is_empty() {
            continue;
        }
        is_paired = true;
        let against = former.map_or(counterpart.to_owned(), |former| format!("{counterpart} in {}", former.name));
        let (mean, error) = (means(&differences), standard_errors(&differences));
        let both = (0..mean.len()).flat_map(|at| [Some(mean[at]), error.as_ref().map(|error| error[at])]);
        let label = format!("{tracker} - {against}");
        let names = vec![label.into(), tracker.into(), against.into(), differences.len().into()];
        let words = mean.iter().map(|value| format!("{value:+.3}").into()).collect();
        table.row([names, both.map(Value::from).collect(), words].concat());
        if let Some(error) = error {
            let mut names = vec![Value::from(""); 4 + 2 * HEADLINE.len()];
            names[0] = "  standard error".into();
            table.remark([names, error.into_iter().map(Value::from).collect()].concat());
        }
    }
    let nothing = former.filter(|_| !is_paired && !rows.is_empty());
    nothing.map_or(Ok(table), |former| Err(anyhow!("{}: it has none of these recordings", former.name)))
}

#[cfg(test)]
mod tests {
    use super::super::figures::Figures;
    use super::super::tests::{row, variants};
    use super::super::{Measurement, without_pairs};
    use super::*;
    use crate::{Layout, Variant};
    use std::fs;

    fn of<'a>(variant: &'a Variant, correct: [f64; 3]) -> Vec<Measurement<'a>> {
        let figures = |correct| Figures {
            mean_correct: correct,
            mean_correct_50: correct / 2.0,
            f: correct,
            ..Figures::default()
        };
        ["a", "b", "c"].into_iter().zip(correct).map(|(name, correct)| row(variant, name, figures(correct))).collect()
    }

    /// The second method is better by 0.1, 0.3, -0.1 in the recordings: mean 0.1, standard error sqrt(0.08 / 2 / 3).
    fn measured(variants: &[Variant]) -> Vec<Measurement<'_>> {
        [of(&variants[0], [0.2, 0.5, 0.8]), of(&variants[1], [0.3, 0.8, 0.7])].into_iter().flatten().collect()
    }

    const EXPECTED: &str = "\
paired difference  recordings  correct  correct@0.5       F
sad - paper                 3   +0.100       +0.050  +0.100
  standard error                 0.115        0.058   0.115
";

    fn compared(rows: &[Measurement<'_>], former: Option<&Former>) -> Result<Tables> {
        let table = table(&without_pairs(rows, &variants()), former)?;
        Ok(Tables { tables: vec![table], ..Tables::default() })
    }

    #[test]
    fn differences_by_hand() {
        let variants = variants();
        let tables = compared(&measured(&variants), None).unwrap();
        assert_eq!(tables.text(Layout::Text), EXPECTED);
        assert_eq!(compared(&[], None).unwrap().text(Layout::Text), "");
        let json = serde_json::to_value(tables).unwrap();
        let paired = &json["paired"][0];
        assert_eq!(
            (&paired["tracker"], &paired["against"], &paired["recordings"]),
            (&"sad".into(), &"paper".into(), &3.into())
        );
        assert!((paired["mean_correct_standard_error"].as_f64().unwrap() - 0.115_470).abs() < 1e-6);
    }

    fn written(rows: &[Measurement<'_>]) -> Former {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("former.json");
        fs::write(&file, serde_json::to_string(&without_pairs(rows, &variants())).unwrap()).unwrap();
        Former { name: "FILE".to_owned(), ..Former::read(&file).unwrap() }
    }

    #[test]
    fn a_file_is_compared_with_by_name_else_with_its_first() {
        let variants = variants();
        let (paper, sad) = (of(&variants[0], [0.2, 0.5, 0.8]), of(&variants[1], [0.3, 0.8, 0.7]));
        let text = compared(&sad, Some(&written(&paper))).unwrap().text(Layout::Text);
        // The name of the file makes the first column wider by two characters.
        let wider = EXPECTED.replace("sad - paper      ", "sad - paper in FILE");
        let wider =
            wider.replace("paired difference", "paired difference  ").replace("standard error", "standard error  ");
        assert_eq!(text, wider);
        // The earlier file has a method of the same name, `sad`, with equal figures.
        let same = compared(&sad, Some(&written(&measured(&variants)))).unwrap().text(Layout::Text);
        assert!(same.contains("\nsad - sad in FILE           3   +0.000       +0.000  +0.000\n"), "{same}");
    }

    #[test]
    fn what_cannot_be_paired_is_named() {
        let variants = variants();
        let error = |former: &[Measurement<'_>]| {
            format!("{:#}", compared(&measured(&variants), Some(&written(former))).err().unwrap())
        };
        let mut other = measured(&variants);
        other[1].starts.pop();
        assert_eq!(error(&other), "FILE: b was measured from other starts, or in other frames");
        let mut other = measured(&variants);
        other[1].starts[0].1.visible += 1;
        assert_eq!(error(&other), "FILE: b was measured from other starts, or in other frames");
        let mut other = measured(&variants);
        other.iter_mut().for_each(|row| row.sequence.push('x'));
        assert_eq!(error(&other), "FILE: it has none of these recordings");

        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("former.json");
        let later = "expected what `host-sim eval --robustness --json` writes in this version";
        let earlier = "an earlier version of host-sim wrote it: measure again with this one";
        for (text, why) in [
            ("", later),
            ("{\"measured\": [{}], \"starts\": []}", later),
            ("{\"recordings\": [{\"tracker\": \"paper\", \"starts\": []}]}", earlier),
            ("{\"measured\": [], \"starts\": []}", "there is no recording in it"),
        ] {
            fs::write(&file, text).unwrap();
            let error = format!("{:#}", Former::read(&file).unwrap_err());
            assert!(error.contains("former.json: ") && error.ends_with(why), "{error}");
        }
    }
}
