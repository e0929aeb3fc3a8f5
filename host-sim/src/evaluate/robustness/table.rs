//! The results as text: recordings first, then the means.

use super::standard_error::Headline;
use super::{Figures, Robustness};
use crate::evaluate::aligned;

const NOTHING: &str = "-";

impl Robustness {
    /// Of each method its recordings, then the means over them if there are several. Nothing if nothing was measured.
    #[must_use]
    pub fn table(&self) -> String {
        if self.is_empty() {
            return String::new();
        }
        let header = ["tracker", "sequence", "starts", "correct", "worst", "correct@0.5", "F", "mean IoU"];
        let header = header.into_iter().chain(Figures::LAST_COLUMNS);
        let mut lines = vec![header.map(String::from).collect::<Vec<_>>()];
        for (index, row) in self.recordings.iter().enumerate() {
            lines.push(line(&row.tracker, &row.sequence, &row.starts.len().to_string(), &row.figures));
            let last = self.recordings.get(index + 1).is_none_or(|next| next.tracker != row.tracker);
            let means = self.means.iter().filter(|mean| last && mean.tracker == row.tracker);
            for mean in means.filter(|mean| mean.recordings > 1 || mean.folder.is_some()) {
                let folder = mean.folder.as_ref().map_or(String::new(), |folder| format!(" in {folder}"));
                let what = format!("mean of {}{folder}", mean.recordings);
                lines.push(line(&mean.tracker, &what, "", &mean.figures));
                lines.extend(mean.standard_error.map(|error| standard_error(&mean.tracker, error)));
            }
        }
        aligned(&lines, 2)
    }
}

fn line(tracker: &str, what: &str, starts: &str, figures: &Figures) -> Vec<String> {
    let mut line = [tracker, what, starts].map(str::to_owned).to_vec();
    let fractions = [figures.mean_correct, figures.worst_correct, figures.mean_correct_50, figures.f, figures.mean_iou];
    line.extend(fractions.map(|fraction| format!("{fraction:.3}")));
    line.extend(figures.last_cells());
    line
}

/// Below the means that it is of.
fn standard_error(tracker: &str, error: Headline) -> Vec<String> {
    let [correct, correct_50, f] = error.values().map(|error| format!("{error:.3}"));
    let empty = String::new;
    vec![tracker.to_owned(), "  standard error".to_owned(), empty(), correct, empty(), correct_50, f]
}

impl Figures {
    /// What tables of figures end with.
    pub(super) const LAST_COLUMNS: [&str; 8] = [
        "precision",
        "answered/hidden",
        "found/returns",
        "wrong/tracking",
        "tracking/wrong",
        "unsaid/right",
        "work/frame",
        "us/frame",
    ];

    pub(super) fn last_cells(&self) -> [String; 8] {
        let of = |part: usize, all: usize| if all == 0 { NOTHING.to_owned() } else { format!("{part}/{all}") };
        let (of_hidden, of_returns) = (of(self.answered_hidden, self.hidden), of(self.found_again, self.returns));
        let work = self.work_per_frame.map_or(NOTHING.to_owned(), |work| format!("{work:.0}"));
        [
            format!("{:.3}", self.precision),
            of_hidden,
            of_returns,
            of(self.tracking_wrong, self.tracking),
            of(self.tracking_wrong, self.wrong),
            of(self.right_unsaid, self.right),
            work,
            format!("{:.0}", self.microseconds_per_frame),
        ]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::calibration::Calibration;
    use super::super::{Mean, Row, StartRow};
    use super::*;
    use crate::evaluate::{MethodKind, Origin};
    use std::path::PathBuf;

    fn figures(correct: f64, hidden: usize, work: Option<f64>) -> Figures {
        Figures {
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
        }
    }

    pub fn row(tracker: &str, sequence: &str, figures: Figures) -> Row {
        let start =
            StartRow { start: "given".to_owned(), frame: 1, bbox: "1,2,3,4".parse().unwrap(), visible: 4, correct: 2 };
        let folder = PathBuf::from("tld");
        Row {
            origin: Origin::new(MethodKind::Smr, serde_json::Map::new()),
            tracker: tracker.to_owned(),
            sequence: sequence.to_owned(),
            folder,
            figures,
            calibration: Calibration::default(),
            starts: vec![start; 5],
        }
    }

    fn results() -> Robustness {
        let counted = figures(0.75, 10, Some(123_456.0));
        let uncounted = figures(2.0 / 3.0, 0, None);
        let mean = |tracker: &str, folder: Option<&str>, recordings, figures| Mean {
            tracker: tracker.to_owned(),
            folder: folder.map(str::to_owned),
            recordings,
            figures,
            standard_error: (recordings > 1).then_some(Headline { mean_correct: 0.1, mean_correct_50: 0.2, f: 0.3 }),
        };
        Robustness {
            recordings: vec![
                row("smr", "01_david", counted),
                row("smr", "Man", counted),
                row("sad", "01_david", uncounted),
            ],
            means: vec![
                mean("smr", None, 2, counted),
                mean("smr", Some("tld"), 1, counted),
                mean("smr", Some("more"), 1, counted),
                mean("sad", None, 1, uncounted),
            ],
            ..Robustness::default()
        }
    }

    #[test]
    fn recordings_then_means() {
        let expected = "\
tracker  sequence           starts  correct  worst  correct@0.5      F  mean IoU  precision  answered/hidden  found/returns  wrong/tracking  tracking/wrong  unsaid/right  work/frame  us/frame
smr      01_david                5    0.750  0.250        0.250  0.500     0.500      1.000             5/10            1/2            2/20             2/5          1/10      123456        12
smr      Man                     5    0.750  0.250        0.250  0.500     0.500      1.000             5/10            1/2            2/20             2/5          1/10      123456        12
smr      mean of 2                    0.750  0.250        0.250  0.500     0.500      1.000             5/10            1/2            2/20             2/5          1/10      123456        12
smr        standard error             0.100               0.200  0.300
smr      mean of 1 in tld             0.750  0.250        0.250  0.500     0.500      1.000             5/10            1/2            2/20             2/5          1/10      123456        12
smr      mean of 1 in more            0.750  0.250        0.250  0.500     0.500      1.000             5/10            1/2            2/20             2/5          1/10      123456        12
sad      01_david                5    0.667  0.250        0.250  0.500     0.500      1.000                -              -               -               -             -           -        12
";
        assert_eq!(results().table(), expected);
        assert_eq!(Robustness::default().table(), "");
    }

    #[test]
    fn json_has_recordings_with_their_starts_and_means() {
        let json = serde_json::to_value(results()).unwrap();
        let recording = &json["recordings"][0];
        assert_eq!((&recording["tracker"], &recording["mean_correct"]), (&"smr".into(), &0.75.into()));
        assert_eq!(recording["starts"].as_array().unwrap().len(), 5);
        assert_eq!(recording["starts"][0]["correct"], 2);
        assert!(json["recordings"][2]["work_per_frame"].is_null());
        assert!(json["means"][0]["folder"].is_null());
        assert_eq!((&json["means"][1]["folder"], &json["means"][1]["recordings"]), (&"tld".into(), &1.into()));
    }
}
