//! What was measured, as one matrix: contestants down, sequences across. Everything that is printed comes from here.

use super::means::Named;
use super::{Contestant, Evaluation, Origin, Score, published};
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
    pub mean: Named,
    pub standard_error: Named,
}

impl Line {
    fn row<'a>(&'a self, source: &'static str, sequence: Option<&'a str>, score: Figures<'a>) -> Row<'a> {
        let Contestant { name, origin } = &self.contestant;
        Row { origin: origin.as_ref(), tracker: name, source, sequence, score }
    }

    /// `None` of fewer than two recordings; each of them counts alike.
    pub fn means(&self) -> Option<Means> {
        let fractions = |score: &Score| {
            let with_mean = Score::FIGURES.iter().filter(|figure| figure.has_mean);
            Named(with_mean.map(|figure| (figure.key, (figure.of)(score).unwrap_or(0.0))).collect())
        };
        let scores: Vec<Named> = self.scores.iter().flatten().map(fractions).collect();
        let (mean, standard_error) = (Named::mean(&scores), Named::standard_error(&scores)?);
        Some(Means { recordings: scores.len(), mean, standard_error })
    }
}

/// One score, or one tracker's means, as JSON.
#[derive(Serialize)]
pub struct Row<'a> {
    /// Not of figures that come from elsewhere.
    #[serde(flatten)]
    origin: Option<&'a Origin>,
    tracker: &'a str,
    /// `measured`, `mean` or `printed`
    source: &'static str,
    /// Not of means.
    #[serde(skip_serializing_if = "Option::is_none")]
    sequence: Option<&'a str>,
    #[serde(flatten)]
    score: Figures<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Figures<'a> {
    Measured(&'a Score),
    Mean(Means),
    /// Of the paper nothing else is known.
    Printed {
        correct: u16,
    },
}

impl Results {
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

    /// All scores, contestant by contestant; then the paper's Table 2, as far as its sequences are here; then the means
    /// over recordings of all that have several.
    pub fn rows(&self) -> Vec<Row<'_>> {
        self.measured().into_iter().chain(self.printed()).chain(self.means()).collect()
    }

    fn means(&self) -> impl Iterator<Item = Row<'_>> {
        self.lines.iter().filter_map(|line| Some(line.row("mean", None, Figures::Mean(line.means()?))))
    }

    /// All scores, contestant by contestant.
    pub fn measured(&self) -> Vec<Row<'_>> {
        let rows = self.lines.iter().flat_map(|line| {
            let scores = self.sequences.iter().zip(&line.scores);
            scores.filter_map(|(sequence, score)| {
                Some(line.row(MEASURED, Some(&sequence.name), Figures::Measured(score.as_ref()?)))
            })
        });
        rows.collect()
    }

    fn printed(&self) -> impl Iterator<Item = Row<'_>> {
        published::TABLE.iter().flat_map(|row| {
            self.sequences.iter().filter_map(|Column { name, .. }| {
                let score = Figures::Printed { correct: row.correct(name)? };
                Some(Row { origin: None, tracker: row.tracker, source: published::SOURCE, sequence: Some(name), score })
            })
        })
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
