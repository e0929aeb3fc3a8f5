//! The results as text: recordings, then the means.

use super::{Figures, Mean, Robustness};
use crate::{Layout, NOTHING, cell, header};

/// A title, and what stands below it.
type Column = (&'static str, fn(&Figures) -> String);

/// The columns of figures.
const COLUMNS: [Column; 13] = [
    ("correct", |of| cell(Some(of.mean_correct), 3)),
    ("worst", |of| cell(Some(of.worst_correct), 3)),
    ("correct@0.5", |of| cell(Some(of.mean_correct_50), 3)),
    ("F", |of| cell(Some(of.f), 3)),
    ("mean IoU", |of| cell(Some(of.mean_iou), 3)),
    ("precision", |of| cell(Some(of.precision), 3)),
    ("answered/hidden", |of| part(of.answered_hidden, of.hidden)),
    ("found/returns", |of| part(of.found_again, of.returns)),
    ("wrong/tracking", |of| part(of.tracking_wrong, of.tracking)),
    ("tracking/wrong", |of| part(of.tracking_wrong, of.wrong)),
    ("unsaid/right", |of| part(of.right_unsaid, of.right)),
    ("work/frame", |of| cell(of.work_per_frame, 0)),
    ("us/frame", |of| cell(Some(of.microseconds_per_frame), 0)),
];

/// Of those of the figures that trackers are compared by.
pub(super) const TITLES: &str = "correct|correct@0.5|F";

fn part(part: usize, all: usize) -> String {
    if all == 0 { NOTHING.to_owned() } else { format!("{part}/{all}") }
}

impl Robustness {
    /// Of each method its recordings, then the means over them if there are several. Nothing if nothing was measured.
    pub fn table(&self, layout: Layout) -> String {
        if self.is_empty() {
            return String::new();
        }
        let titles = COLUMNS.map(|(title, _)| title.to_owned());
        let mut lines = vec![header("tracker|sequence|starts").into_iter().chain(titles).collect()];
        let line = |tracker: &str, what: &str, starts: String, figures: &Figures| {
            let names = [tracker.to_owned(), what.to_owned(), starts].into_iter();
            names.chain(COLUMNS.map(|(_, text)| text(figures))).collect::<Vec<_>>()
        };
        for (index, row) in self.recordings.iter().enumerate() {
            lines.push(line(&row.tracker, &row.sequence, row.starts.len().to_string(), &row.figures));
            let last = self.recordings.get(index + 1).is_none_or(|next| next.tracker != row.tracker);
            let means = self.means.iter().filter(|mean| last && mean.tracker == row.tracker);
            for mean in means.filter(|mean| mean.recordings > 1 || mean.folder.is_some()) {
                let folder = mean.folder.as_ref().map_or(String::new(), |folder| format!(" in {folder}"));
                let what = format!("mean of {}{folder}", mean.recordings);
                lines.push(line(&mean.tracker, &what, String::new(), &mean.figures));
                lines.extend(mean.standard_error_line());
            }
        }
        layout.table(&lines, 2)
    }
}

impl Mean {
    /// Below the means that it is of.
    fn standard_error_line(&self) -> Option<Vec<String>> {
        let empty = || Some(String::new());
        let mut errors = self.standard_error.iter().flatten().map(|&error| cell(Some(error), 3));
        let names = [Some(self.tracker.clone()), Some("  standard error".to_owned()), empty()];
        let figures = [errors.next(), empty(), errors.next(), errors.next()];
        names.into_iter().chain(figures).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::Row;
    use super::super::starts::Start;
    use super::*;
    use crate::{MethodKind, Origin, Score};
    use smr_core::Rect;
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
        let start = Start { name: "given".to_owned(), frame: 0, target: Rect::new(1, 2, 3, 4) };
        let start = (start, Score { visible: 4, correct: 2, ..Score::default() });
        let folder = PathBuf::from("tld");
        Row {
            origin: Origin::new(MethodKind::Smr, serde_json::Map::new()),
            tracker: tracker.to_owned(),
            sequence: sequence.to_owned(),
            path: PathBuf::from(sequence),
            folder,
            figures,
            starts: vec![start; 5],
        }
    }

    fn mean(tracker: &str, folder: Option<&str>, recordings: usize, figures: Figures) -> Mean {
        Mean {
            tracker: tracker.to_owned(),
            origin: Origin::new(MethodKind::Smr, serde_json::Map::new()),
            folder: folder.map(str::to_owned),
            recordings,
            figures,
            standard_error: (recordings > 1).then(|| vec![0.1, 0.2, 0.3]),
        }
    }

    fn results() -> Robustness {
        let counted = figures(0.75, 10, Some(123_456.0));
        let uncounted = figures(2.0 / 3.0, 0, None);
        let recordings = [("smr", "01_david", counted), ("smr", "Man", counted), ("sad", "01_david", uncounted)];
        let means = vec![
            mean("smr", None, 2, counted),
            mean("smr", Some("tld"), 1, counted),
            mean("smr", Some("more"), 1, uncounted),
            mean("sad", None, 1, uncounted),
            mean("sad", Some("more"), 1, uncounted),
        ];
        let recordings = recordings.map(|(tracker, name, figures)| row(tracker, name, figures)).to_vec();
        Robustness { recordings, means, ..Robustness::default() }
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
smr      mean of 1 in more            0.667  0.250        0.250  0.500     0.500      1.000                -              -               -               -             -           -        12
sad      01_david                5    0.667  0.250        0.250  0.500     0.500      1.000                -              -               -               -             -           -        12
sad      mean of 1 in more            0.667  0.250        0.250  0.500     0.500      1.000                -              -               -               -             -           -        12
";
        assert_eq!(results().table(Layout::Text), expected);
        assert_eq!(Robustness::default().table(Layout::Text), "");
    }

    #[test]
    fn json_has_recordings_with_their_starts_and_means() {
        let json = serde_json::to_value(results().tables()).unwrap();
        let recording = &json["measured"][0];
        assert_eq!((&recording["tracker"], &recording["mean_correct"]), (&"smr".into(), &0.75.into()));
        assert_eq!(json["starts"].as_array().unwrap().len(), 3 * 5);
        assert_eq!((&json["starts"][0]["x"], &json["starts"][0]["correct"]), (&1.0.into(), &2.into()));
        assert!(json["measured"][2]["work_per_frame"].is_null());
        assert!(json["means"][0]["folder"].is_null());
        assert_eq!((&json["means"][1]["folder"], &json["means"][1]["recordings"]), (&"tld".into(), &1.into()));
        assert_eq!(json["means"][0]["mean_correct_standard_error"], 0.1);
        assert!(json["means"][1]["mean_correct_standard_error"].is_null());
    }
}
