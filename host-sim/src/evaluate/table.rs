//! Results as text: every score in full, and the paper's Table 2.

use super::results::{Line, Results};
use super::{Contestant, Score};
use std::fmt::Write as _;

/// Correct frames of SMR as the paper's Table 2 prints them: published figures, nothing that was measured here.
const PUBLISHED: [(&str, u16); 6] = [
    ("01_david", 761),
    ("02_jumping", 313),
    ("03_pedestrian1", 140),
    ("04_pedestrian2", 236),
    ("05_pedestrian3", 66),
    ("06_car", 510),
];

const NOTHING: &str = "-";

impl Results {
    /// Every score in full, contestant by contestant, each with a total if it has more than one.
    #[must_use]
    pub fn details(&self) -> String {
        let header = [
            "tracker",
            "sequence",
            "frames",
            "visible",
            "answered",
            "correct",
            "correct@0.5",
            "precision",
            "recall",
            "F",
            "mean IoU",
            "first failure",
        ];
        let mut lines = vec![header.map(String::from).to_vec()];
        for line in &self.lines {
            let name = line.contestant.name();
            for (sequence, score) in self.sequences.iter().zip(&line.scores) {
                lines.extend(score.map(|score| details(name, &sequence.name, &score)));
            }
            if line.scores.iter().flatten().count() > 1 {
                lines.push(details(name, "total", &Score::total(line.scores.iter().flatten())));
            }
        }
        aligned(&lines, 2)
    }

    /// The paper's Table 2: correct frames, contestants down, sequences across.
    #[must_use]
    pub fn correct_frames(&self) -> String {
        let mut header = vec!["correct frames".to_owned()];
        header.extend(self.sequences.iter().map(|sequence| format!("{} /{}", sequence.name, sequence.visible)));
        let (files, methods): (Vec<&Line>, Vec<&Line>) =
            self.lines.iter().partition(|line| matches!(line.contestant, Contestant::File(_)));
        let mut lines = vec![header];
        lines.extend(methods.into_iter().map(correct_frames));
        lines.extend(self.published());
        lines.extend(files.into_iter().map(correct_frames));
        aligned(&lines, 1)
    }

    /// The paper's row, if one of its sequences is here. They are known by the names of their folders.
    fn published(&self) -> Option<Vec<String>> {
        let figure = |name: &str| PUBLISHED.iter().find(|(published, _)| *published == name);
        if !self.sequences.iter().any(|sequence| figure(&sequence.name).is_some()) {
            return None;
        }
        let cell = |name: &str| figure(name).map_or(NOTHING.to_owned(), |(_, correct)| correct.to_string());
        let mut line = vec!["SMR, the paper's table (published)".to_owned()];
        line.extend(self.sequences.iter().map(|sequence| cell(&sequence.name)));
        Some(line)
    }
}

fn details(tracker: &str, sequence: &str, score: &Score) -> Vec<String> {
    let counts = [score.frames, score.visible, score.answered, score.correct, score.correct_50];
    let means = [score.precision, score.recall, score.f, score.mean_iou];
    let mut line = vec![tracker.to_owned(), sequence.to_owned()];
    line.extend(counts.map(|count| count.to_string()));
    line.extend(means.map(|mean| format!("{mean:.3}")));
    line.push(score.first_failure.map_or(NOTHING.to_owned(), |frame| frame.to_string()));
    line
}

fn correct_frames(of: &Line) -> Vec<String> {
    let mut line = vec![of.contestant.name().to_owned()];
    line.extend(of.scores.iter().map(|score| score.map_or(NOTHING.to_owned(), |score| score.correct.to_string())));
    line
}

/// The lines as a table: the first `names` columns begin at their left edge, all others end at their right edge.
pub fn aligned(lines: &[Vec<String>], names: usize) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let widest =
        |column: usize| lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| widest(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for line in lines {
        let mut row = String::new();
        for (column, (cell, &width)) in line.iter().zip(&widths).enumerate() {
            let gap = if column == 0 { "" } else { "  " };
            // Writing to a String cannot fail.
            let _ = if column < names { write!(row, "{gap}{cell:width$}") } else { write!(row, "{gap}{cell:>width$}") };
        }
        text.push_str(row.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Evaluation;

    fn evaluation(sequence: &str, scores: &[(Contestant, usize)]) -> Evaluation {
        let score = |correct: usize| {
            let mut boxes = vec![None; 4];
            boxes[..correct].fill(Some("1,2,3,4".parse().unwrap()));
            Score::new(&boxes, &[Some("1,2,3,4".parse().unwrap()); 4]).unwrap()
        };
        let scores = scores.iter().map(|(who, correct)| (who.clone(), score(*correct))).collect();
        Evaluation { sequence: sequence.to_owned(), visible: 4, scores, failures: vec![], notes: vec![] }
    }

    fn results() -> Results {
        let (smr, sad) = (Contestant::Method("smr"), Contestant::Method("sad"));
        let file = |name: &str| Contestant::File(name.to_owned());
        Results::new(&[
            evaluation("mine", &[(smr.clone(), 4), (sad.clone(), 1), (file("t10"), 3)]),
            evaluation("06_car", &[(smr, 2), (sad, 0), (file("t2"), 2), (file("smr"), 1)]),
        ])
    }

    #[test]
    fn every_score_in_full() {
        let expected = "\
tracker  sequence  frames  visible  answered  correct  correct@0.5  precision  recall      F  mean IoU  first failure
smr      mine           4        4         4        4            4      1.000   1.000  1.000     1.000              -
smr      06_car         4        4         2        2            2      1.000   0.500  0.667     0.500              3
smr      total          8        8         6        6            6      1.000   0.750  0.857     0.750              -
sad      mine           4        4         1        1            1      1.000   0.250  0.400     0.250              2
sad      06_car         4        4         0        0            0      0.000   0.000  0.000     0.000              1
sad      total          8        8         1        1            1      1.000   0.125  0.222     0.125              -
smr      06_car         4        4         1        1            1      1.000   0.250  0.400     0.250              2
t2       06_car         4        4         2        2            2      1.000   0.500  0.667     0.500              3
t10      mine           4        4         3        3            3      1.000   0.750  0.857     0.750              4
";
        assert_eq!(results().details(), expected);
    }

    #[test]
    fn the_table_of_the_paper() {
        let expected = "\
correct frames                      mine /4  06_car /4
smr                                       4          2
sad                                       1          0
SMR, the paper's table (published)        -        510
smr                                       -          1
t2                                        -          2
t10                                       3          -
";
        assert_eq!(results().correct_frames(), expected);
        let other = Results::new(&[evaluation("mine", &[(Contestant::Method("smr"), 4)])]);
        assert_eq!(other.correct_frames(), "correct frames  mine /4\nsmr                   4\n");
    }

    #[test]
    fn json_has_the_keys_of_the_protocol_and_nothing_published() {
        let rows = serde_json::to_value(results().rows().collect::<Vec<_>>()).unwrap();
        let expected = serde_json::json!({
            "tracker": "smr", "sequence": "06_car", "frames": 4, "visible": 4, "answered": 2, "correct": 2,
            "correct_50": 2, "precision": 1.0, "recall": 0.5, "f": 2.0 / 3.0, "mean_iou": 0.5, "first_failure": 3,
        });
        assert_eq!(rows[1], expected);
        assert!(rows[0]["first_failure"].is_null());
        assert_eq!(rows.as_array().unwrap().len(), 7);
    }
}
