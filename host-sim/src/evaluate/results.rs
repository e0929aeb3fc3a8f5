//! What was measured, as one matrix: contestants down, sequences across. Everything that is printed comes from here.

use super::means::{mean, standard_error};
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

/// What marks a mean over recordings.
const MEAN: &str = "mean";

/// The figures that have a mean over recordings; each recording counts alike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Fractions {
    pub precision: f64,
    pub recall: f64,
    pub f: f64,
    pub mean_iou: f64,
    pub otb_auc: f64,
    pub otb_precision: f64,
    pub vot_f: f64,
}

impl Fractions {
    fn of(score: &Score) -> [f64; 7] {
        let (otb, vot) = (score.otb.unwrap_or_default(), score.vot.unwrap_or_default());
        let tld = [score.precision, score.recall, score.f, score.mean_iou];
        [tld[0], tld[1], tld[2], tld[3], otb.otb_auc, otb.otb_precision, vot.vot_f]
    }

    fn from_values([precision, recall, f, mean_iou, otb_auc, otb_precision, vot_f]: [f64; 7]) -> Self {
        Self { precision, recall, f, mean_iou, otb_auc, otb_precision, vot_f }
    }

    pub(super) const fn values(self) -> [f64; 7] {
        [self.precision, self.recall, self.f, self.mean_iou, self.otb_auc, self.otb_precision, self.vot_f]
    }
}

/// The means over recordings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Means {
    pub recordings: usize,
    pub mean: Fractions,
    pub standard_error: Fractions,
}

impl Line {
    /// `None` of fewer than two recordings.
    pub fn means(&self) -> Option<Means> {
        let scores: Vec<[f64; 7]> = self.scores.iter().flatten().map(Fractions::of).collect();
        let column = |figure: usize| scores.iter().map(|score| score[figure]).collect::<Vec<_>>();
        let over = |of: fn(&[f64]) -> f64| Fractions::from_values(std::array::from_fn(|figure| of(&column(figure))));
        (scores.len() > 1).then(|| Means {
            recordings: scores.len(),
            mean: over(mean),
            standard_error: over(|values| standard_error(values).unwrap_or(0.0)),
        })
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
    #[must_use]
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
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// All scores, contestant by contestant; then the paper's Table 2, as far as its sequences are here; then the means
    /// over recordings of all that have several.
    #[must_use]
    pub fn rows(&self) -> Vec<Row<'_>> {
        self.measured().into_iter().chain(self.printed()).chain(self.means()).collect()
    }

    fn means(&self) -> impl Iterator<Item = Row<'_>> {
        self.lines.iter().filter_map(|line| {
            let (origin, tracker, score) =
                (line.contestant.origin(), line.contestant.name(), Figures::Mean(line.means()?));
            Some(Row { origin, tracker, source: MEAN, sequence: None, score })
        })
    }

    /// All scores, contestant by contestant.
    #[must_use]
    pub fn measured(&self) -> Vec<Row<'_>> {
        let rows = self.lines.iter().flat_map(|line| {
            let scores = self.sequences.iter().zip(&line.scores);
            scores.filter_map(|(sequence, score)| {
                let (tracker, sequence) = (line.contestant.name(), Some(sequence.name.as_str()));
                let score = Figures::Measured(score.as_ref()?);
                Some(Row { origin: line.contestant.origin(), tracker, source: MEASURED, sequence, score })
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
    all.sort_by(|a, b| match (a, b) {
        (Contestant::File(a), Contestant::File(b)) => natord::compare(a, b),
        (a, b) => matches!(a, Contestant::File(_)).cmp(&matches!(b, Contestant::File(_))),
    });
    all
}
