//! What was measured, as one matrix: contestants down, sequences across. Everything that is printed comes from here.

use super::configs::ORIGIN;
use super::means::{Named, errors};
use super::protocol::Figure;
use super::tables::{Table, TableName, Tables, columns, error_of};
use super::{Contestant, Evaluation, Origin, Score, published};
use anyhow::Result;
use serde::Serialize;

/// The scores of every contestant on every sequence.
pub struct Results {
    pub(super) sequences: Vec<Column>,
    pub(super) lines: Vec<Line>,
}

/// A sequence.
pub(super) struct Column {
    pub name: String,
    pub visible: usize,
}

/// A contestant and its scores, one for each sequence; `None` where it has none.
pub(super) struct Line {
    pub contestant: Contestant,
    pub scores: Vec<Option<Score>>,
}

/// What marks a figure of ours.
pub(super) const MEASURED: &str = "measured";

/// The means over recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Means {
    pub recordings: usize,
    #[serde(flatten)]
    pub mean: Named,
    #[serde(flatten, serialize_with = "errors")]
    pub standard_error: Option<Named>,
}

impl Line {
    /// `None` of fewer than two recordings; each of them counts alike.
    pub fn means(&self) -> Option<Means> {
        let fractions =
            |score: &Score| Named(with_mean().map(|figure| (figure.key, (figure.of)(score).unwrap_or(0.0))).collect());
        let scores: Vec<Named> = self.scores.iter().flatten().map(fractions).collect();
        let standard_error = Some(Named::standard_error(&scores)?);
        Some(Means { recordings: scores.len(), mean: Named::mean(&scores), standard_error })
    }
}

fn with_mean() -> impl Iterator<Item = &'static Figure> {
    Score::FIGURES.iter().filter(|figure| figure.has_mean)
}

/// Figures of a tracker, or of another one's result file.
#[derive(Serialize)]
struct Row<'a, T> {
    tracker: &'a str,
    /// Not of means.
    sequence: Option<&'a str>,
    #[serde(flatten)]
    figures: T,
    /// Not of figures that come from elsewhere.
    #[serde(flatten)]
    origin: Option<&'a Origin>,
}

impl Line {
    fn row<'a, T>(&'a self, sequence: Option<&'a str>, figures: T) -> Row<'a, T> {
        let Contestant { name, origin } = &self.contestant;
        Row { tracker: name, sequence, figures, origin: origin.as_ref() }
    }
}

/// Of the paper nothing else is known.
#[derive(Serialize)]
struct Printed {
    correct: u16,
}

/// The columns between two others, which are names.
fn around(first: &str, between: impl Iterator<Item = String>, last: &str) -> Vec<String> {
    columns(first).into_iter().chain(between).chain(columns(last)).collect()
}

impl Results {
    /// The tables of what is measured.
    pub const TABLES: &[TableName] = &[TableName::Measured, TableName::Means, TableName::Printed];

    /// Methods stand first, in the order in which they were asked for; then the files of others, in natural order.
    pub fn new(evaluations: &[Evaluation]) -> Self {
        let column = |e: &Evaluation| Column { name: e.sequence.clone(), visible: e.visible };
        let line = |contestant: Contestant| {
            let of = |e: &Evaluation| e.scores.iter().find(|(who, _)| *who == contestant).map(|&(_, score)| score);
            Line { scores: evaluations.iter().map(of).collect(), contestant }
        };
        Self {
            sequences: evaluations.iter().map(column).collect(),
            lines: contestants(evaluations).into_iter().map(line).collect(),
        }
    }

    /// True if nobody has a score.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// All scores, contestant by contestant; the means over recordings of all that have several; the paper's Table 2, as far as its sequences
    /// are here.
    pub fn tables(&self) -> Result<Tables> {
        let measured = around("tracker,sequence", Score::FIGURES.iter().map(|figure| figure.key.to_owned()), ORIGIN);
        let figures = with_mean().flat_map(|figure| [figure.key.to_owned(), error_of(figure.key)]);
        let means = around("tracker,recordings", figures, ORIGIN);
        Ok(Tables(vec![
            Table::new(TableName::Measured, measured, &self.measured())?,
            Table::new(TableName::Means, means, &self.means())?,
            Table::new(TableName::Printed, columns("tracker,sequence,correct"), &self.printed())?,
        ]))
    }

    fn measured(&self) -> Vec<Row<'_, &Score>> {
        let rows = self.lines.iter().flat_map(|line| {
            let scores = self.sequences.iter().zip(&line.scores);
            scores.filter_map(|(sequence, score)| Some(line.row(Some(&sequence.name), score.as_ref()?)))
        });
        rows.collect()
    }

    fn means(&self) -> Vec<Row<'_, Means>> {
        self.lines.iter().filter_map(|line| Some(line.row(None, line.means()?))).collect()
    }

    fn printed(&self) -> Vec<Row<'_, Printed>> {
        let rows = published::TABLE.iter().flat_map(|row| {
            self.sequences.iter().filter_map(|Column { name, .. }| {
                let figures = Printed { correct: row.correct(name)? };
                Some(Row { tracker: row.tracker, sequence: Some(name), figures, origin: None })
            })
        });
        rows.collect()
    }
}

/// Everyone who has a score on one sequence at least.
fn contestants(evaluations: &[Evaluation]) -> Vec<Contestant> {
    let mut all: Vec<Contestant> = Vec::new();
    for (contestant, _) in evaluations.iter().flat_map(|e| &e.scores) {
        if !all.contains(contestant) {
            all.push(contestant.clone());
        }
    }
    // The sort is stable: methods, being equal here, keep their order.
    all.sort_by(|a, b| match (&a.origin, &b.origin) {
        (None, None) => natord::compare(&a.name, &b.name),
        (a, b) => a.is_none().cmp(&b.is_none()),
    });
    all
}
