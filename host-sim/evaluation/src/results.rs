//! What was measured, as one matrix: contestants down, sequences across. Everything that is printed comes from here: every score in full, and
//! the paper's Table 2.

use super::layout::{NOTHING, cell, header};
use super::means::{means, standard_errors};
use super::score::Figure;
use super::tables::{Columns, TableName, Tables, with_errors};
use super::{Contestant, Evaluation, Layout, Origin, Score, published};

pub struct Results {
    sequences: Vec<Column>,
    lines: Vec<Line>,
}

struct Column {
    name: String,
    visible: usize,
}

/// A contestant and its scores, one for each sequence; `None` where it has none.
struct Line {
    contestant: Contestant,
    scores: Vec<Option<Score>>,
}

/// Figures that have a mean over recordings: these means, and their standard errors. Of recordings in which the target is never visible
/// they are not known.
struct Means {
    /// With known figures.
    recordings: usize,
    mean: Vec<f64>,
    standard_error: Option<Vec<f64>>,
}

impl Means {
    /// By the place of a figure among those with a mean.
    fn mean(&self, place: usize) -> Option<f64> {
        self.mean.get(place).copied()
    }

    fn standard_error(&self, place: usize) -> Option<f64> {
        self.standard_error.as_ref()?.get(place).copied()
    }
}

impl Line {
    /// `None` of fewer than two recordings; each of them counts alike.
    fn means(&self) -> Option<Means> {
        let fractions = |score: &Score| with_mean().map(|figure| (figure.of)(score).unwrap_or(0.0)).collect();
        let known = self.scores.iter().flatten().filter(|score| score.visible > 0);
        let known: Vec<Vec<f64>> = known.map(fractions).collect();
        (self.scores.iter().flatten().count() > 1).then(|| Means {
            recordings: known.len(),
            mean: means(&known),
            standard_error: standard_errors(&known),
        })
    }
}

fn with_mean() -> impl Iterator<Item = &'static Figure> {
    Score::FIGURES.iter().filter(|figure| figure.has_mean)
}

/// The figures that are printed for people.
fn titled() -> impl Iterator<Item = &'static Figure> {
    Score::FIGURES.iter().filter(|figure| !figure.title.is_empty())
}

impl Results {
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

    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// All scores, contestant by contestant; the means over recordings of all that have several; the paper's Table 2, as far as its sequences
    /// are here.
    pub fn tables(&self) -> Tables {
        type Of<'a, T> = (&'a Contestant, T);
        let measured = Columns::new(&[
            ("tracker", "", |row: &Of<'_, (&Column, &Score)>| row.0.name.as_str().into()),
            ("sequence", "", |row| row.1.0.name.as_str().into()),
        ]);
        let keys = Score::FIGURES.iter().map(|figure| figure.key.to_owned());
        let measured = measured.each(keys, |row, place| Score::FIGURES[place].value(row.1.1));
        let measured = measured.and(Origin::columns(), |row| row.0.origin.as_ref());
        let means = Columns::new(&[
            ("tracker", "", |row: &Of<'_, Means>| row.0.name.as_str().into()),
            ("recordings", "", |row| row.1.recordings.into()),
        ]);
        let means = means.each(with_errors(with_mean().map(|figure| figure.key)), |(_, means), place| {
            [Means::mean, Means::standard_error][place % 2](means, place / 2).into()
        });
        let means = means.and(Origin::columns(), |row| row.0.origin.as_ref());
        let printed = Columns::new(&[
            ("tracker", "", |row: &(&str, &Column, u16)| row.0.into()),
            ("sequence", "", |row| row.1.name.as_str().into()),
            ("correct", "", |row| row.2.into()),
        ]);
        let of_paper = |row: &'static published::Row| {
            self.sequences.iter().filter_map(|column| Some((row.tracker, column, row.correct(&column.name)?)))
        };
        let scores = self.lines.iter().flat_map(|line| {
            let scores = self.sequences.iter().zip(&line.scores);
            scores.filter_map(|(column, score)| Some((&line.contestant, (column, score.as_ref()?))))
        });
        let of_means: Vec<_> = self.lines.iter().filter_map(|line| Some((&line.contestant, line.means()?))).collect();
        let of_paper: Vec<_> = published::TABLE.iter().flat_map(of_paper).collect();
        Tables(vec![
            measured.table(TableName::Measured, &scores.collect::<Vec<_>>()),
            means.table(TableName::Means, &of_means),
            printed.table(TableName::Printed, &of_paper),
        ])
    }

    /// All that there is, as text or Markdown. Nothing if nobody has a score.
    pub fn text(&self, layout: Layout) -> String {
        if self.is_empty() {
            return String::new();
        }
        format!("{}\n{}", self.details(layout), self.correct_frames(layout))
    }

    /// Every score in full, contestant by contestant; of several a total over all frames, the mean over recordings, and
    /// its standard error.
    fn details(&self, layout: Layout) -> String {
        let mut lines = vec![header("tracker|sequence")];
        lines[0].extend(titled().map(|figure| figure.title.to_owned()));
        for line in &self.lines {
            let mut add = |what: &str, figure: &dyn Fn(&Figure) -> String| {
                let names = [&line.contestant.name, what].map(str::to_owned).into_iter();
                lines.push(names.chain(titled().map(figure)).collect());
            };
            let of = |score: Score| move |figure: &Figure| cell((figure.of)(&score), figure.digits);
            for (sequence, &score) in self.sequences.iter().zip(&line.scores) {
                score.into_iter().for_each(|score| add(&sequence.name, &of(score)));
            }
            let Some(means) = line.means() else { continue };
            add("total", &of(Score::total(line.scores.iter().flatten())));
            let mean = format!("mean of {}", means.recordings);
            let values: [fn(&Means, usize) -> _; 2] = [Means::mean, Means::standard_error];
            for (what, value) in [mean.as_str(), "  standard error"].into_iter().zip(values) {
                add(what, &|figure| {
                    let place = with_mean().position(|other| other.key == figure.key);
                    place.map_or(String::new(), |place| cell(value(&means, place), figure.digits))
                });
            }
        }
        layout.table(&lines, 2)
    }

    /// The paper's Table 2 if one of its sequences is here, and correct frames as they were measured: contestants down,
    /// sequences across.
    fn correct_frames(&self, layout: Layout) -> String {
        let mut header = header("correct frames|source");
        header.extend(self.sequences.iter().map(|sequence| format!("{} /{}", sequence.name, sequence.visible)));
        let mut lines = vec![header];
        lines.extend(self.published());
        lines.extend(self.lines.iter().map(correct_frames));
        layout.table(&lines, 2)
    }

    /// The rows of the paper, if one of its sequences is here.
    fn published(&self) -> Vec<Vec<String>> {
        if !self.sequences.iter().any(|sequence| published::is_known(&sequence.name)) {
            return Vec::new();
        }
        let cell = |correct: Option<u16>| correct.map_or(NOTHING.to_owned(), |correct| correct.to_string());
        let line = |row: &published::Row| {
            let cells = self.sequences.iter().map(|sequence| cell(row.correct(&sequence.name)));
            [row.tracker, published::SOURCE].map(str::to_owned).into_iter().chain(cells).collect()
        };
        published::TABLE.iter().map(line).collect()
    }
}

fn correct_frames(of: &Line) -> Vec<String> {
    let mut line = vec![of.contestant.name.clone(), "measured".to_owned()];
    line.extend(of.scores.iter().map(|score| score.map_or(NOTHING.to_owned(), |score| score.correct.to_string())));
    line
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MethodKind;
    use serde_json::Map;

    fn evaluation(sequence: &str, scores: &[(Contestant, usize)]) -> Evaluation {
        let score = |correct: usize| {
            let mut boxes = vec![None; 4];
            boxes[..correct].fill(Some("1,2,3,4".parse().unwrap()));
            Score::with_confidence(&boxes, &[None; 4], &[Some("1,2,3,4".parse().unwrap()); 4]).unwrap()
        };
        let scores = scores.iter().map(|(who, correct)| (who.clone(), score(*correct))).collect();
        Evaluation { sequence: sequence.to_owned(), visible: 4, scores, failures: vec![], notes: vec![] }
    }

    fn method(name: &str) -> Contestant {
        Contestant { name: name.to_owned(), origin: Some(Origin::new(MethodKind::Smr, Map::new())) }
    }

    fn results() -> Results {
        let (smr, sad) = (method("smr"), method("sad"));
        let file = |name: &str| Contestant::file(name.to_owned());
        Results::new(&[
            evaluation("mine", &[(smr.clone(), 4), (sad.clone(), 1), (file("t10"), 3)]),
            evaluation("06_car", &[(smr, 2), (sad, 0), (file("t2"), 2), (file("smr"), 1)]),
        ])
    }

    #[test]
    fn every_score_in_full() {
        let expected = "\
tracker  sequence          frames  visible  answered  correct  correct@0.5  precision  recall      F  mean IoU  first failure  OTB AUC  OTB P20  VOT F  threshold
smr      mine                   4        4         4        4            4      1.000   1.000  1.000     1.000              -    0.952    1.000  1.000          -
smr      06_car                 4        4         2        2            2      1.000   0.500  0.667     0.500              3    0.476    0.500  0.667          -
smr      total                  8        8         6        6            6      1.000   0.750  0.857     0.750              -        -        -      -          -
smr      mean of 2                                                              1.000   0.750  0.833     0.750                   0.714    0.750  0.833
smr        standard error                                                       0.000   0.250  0.167     0.250                   0.238    0.250  0.167
sad      mine                   4        4         1        1            1      1.000   0.250  0.400     0.250              2    0.238    0.250  0.400          -
sad      06_car                 4        4         0        0            0      0.000   0.000  0.000     0.000              1    0.000    0.000  0.000          -
sad      total                  8        8         1        1            1      1.000   0.125  0.222     0.125              -        -        -      -          -
sad      mean of 2                                                              0.500   0.125  0.200     0.125                   0.119    0.125  0.200
sad        standard error                                                       0.500   0.125  0.200     0.125                   0.119    0.125  0.200
smr      06_car                 4        4         1        1            1      1.000   0.250  0.400     0.250              2    0.238    0.250  0.400          -
t2       06_car                 4        4         2        2            2      1.000   0.500  0.667     0.500              3    0.476    0.500  0.667          -
t10      mine                   4        4         3        3            3      1.000   0.750  0.857     0.750              4    0.714    0.750  0.857          -
";
        assert_eq!(results().details(Layout::Text), expected);
    }

    #[test]
    fn a_target_that_is_never_visible_enters_no_mean() {
        let unseen = |count: usize| {
            let score = Score::with_confidence(&[Some("1,2,3,4".parse().unwrap())], &[None], &[None]).unwrap();
            let of = |name: String| Evaluation {
                scores: vec![(method("smr"), score)],
                visible: 0,
                ..evaluation(&name, &[])
            };
            (0..count).map(|number| of(format!("unseen{number}"))).collect::<Vec<_>>()
        };
        let means = |all: &[Evaluation]| serde_json::to_value(Results::new(all).tables()).unwrap()["means"].clone();
        let seen = [evaluation("a", &[(method("smr"), 4)]), evaluation("b", &[(method("smr"), 2)])];
        let (alone, both) = (means(&seen), means(&seen.into_iter().chain(unseen(1)).collect::<Vec<_>>()));
        assert_eq!((&alone, &both[0]["recall"]), (&both, &0.75.into()));
        let one: Vec<_> = unseen(1).into_iter().chain([evaluation("a", &[(method("smr"), 4)])]).collect();
        assert_eq!((&means(&one)[0]["recall"], &means(&one)[0]["recordings"]), (&1.0.into(), &1.into()));
        assert!(means(&one)[0]["recall_standard_error"].is_null() && means(&unseen(2))[0]["recall"].is_null());
        let row = Results::new(&unseen(1)).details(Layout::Text).lines().nth(1).unwrap().to_owned();
        assert!(row.ends_with("1        0            0          -       -  -         -              -        -        -      -          -"), "{row}");
    }

    #[test]
    fn the_table_of_the_paper() {
        let expected = "\
correct frames                             source    mine /4  06_car /4
Lim 2004 (incremental subspace)            printed         -        163
Collins 2005 (online feature selection)    printed         -          -
Avidan 2007 (ensemble tracking)            printed         -         10
Babenko 2009 (MIL)                         printed         -         45
Kalal 2010 (forward-backward, MedianFlow)  printed         -        510
SMR, the paper                             printed         -        510
smr                                        measured        4          2
sad                                        measured        1          0
smr                                        measured        -          1
t2                                         measured        -          2
t10                                        measured        3          -
";
        assert_eq!(results().correct_frames(Layout::Text), expected);
        let other = Results::new(&[evaluation("mine", &[(method("smr"), 4)])]);
        assert_eq!(
            other.correct_frames(Layout::Text),
            "correct frames  source    mine /4\nsmr             measured        4\n"
        );
    }

    #[test]
    fn json_has_what_was_measured_and_what_is_printed() {
        let json = serde_json::to_value(results().tables()).unwrap();
        let expected = serde_json::json!({
            "version": env!("CARGO_PKG_VERSION"), "method": "smr", "options": "{}",
            "tracker": "smr", "sequence": "06_car", "frames": 4, "visible": 4, "answered": 2, "correct": 2,
            "correct_50": 2, "precision": 1.0, "recall": 0.5, "f": 2.0 / 3.0, "mean_iou": 0.5, "first_failure": 3,
            "otb_auc": 10.0 / 21.0, "otb_precision": 0.5,
            "vot_f": 2.0 / 3.0, "vot_precision": 1.0, "vot_recall": 0.5, "vot_threshold": null,
        });
        assert_eq!(json["measured"][1], expected);
        assert!(json["measured"][0]["first_failure"].is_null() && json["measured"][6]["options"].is_null());
        // Collins has no figure for the one sequence of the table.
        let rows = |name: &str| json[name].as_array().unwrap().len();
        assert_eq!((rows("measured"), rows("printed"), rows("means")), (7, 5, 2));
        let lim =
            serde_json::json!({ "tracker": "Lim 2004 (incremental subspace)", "sequence": "06_car", "correct": 163 });
        assert_eq!(json["printed"][0], lim);
        // 1 and 1/2: the mean is 3/4, and each is 1/4 from it: sqrt(2 / 16 / 1 / 2).
        let smr = &json["means"][0];
        assert_eq!((&smr["tracker"], &smr["method"], &smr["recordings"]), (&"smr".into(), &"smr".into(), &2.into()));
        assert_eq!((&smr["recall"], &smr["recall_standard_error"]), (&0.75.into(), &0.25.into()));
    }

    #[test]
    fn both_tables_are_printed_if_there_is_a_score() {
        let text = results().text(Layout::Markdown);
        let tables: Vec<&str> = text.split("\n\n").collect();
        assert!(tables[0].starts_with("| tracker | sequence |") && tables[1].starts_with("| correct frames |"));
        assert_eq!((tables.len(), Results::new(&[]).text(Layout::Text)), (2, String::new()));
    }
}
