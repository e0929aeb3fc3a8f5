//! The means as text, one row a tracker: what variants of one tracker are compared by.

use super::{Figures, Mean, Robustness};
use crate::evaluate::aligned;

impl Robustness {
    /// One row a tracker, over all recordings, with the correct frames of each folder if there are several. Nothing if nothing
    /// was measured.
    #[must_use]
    pub fn summary(&self) -> String {
        if self.is_empty() {
            return String::new();
        }
        let mut folders: Vec<&str> = Vec::new();
        for folder in self.means.iter().filter_map(|mean| mean.folder.as_deref()) {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
        let mut header = ["tracker", "correct", "standard error"].map(str::to_owned).to_vec();
        header.extend(folders.iter().map(|folder| format!("in {folder}")));
        header.extend(["worst"].into_iter().chain(Figures::LAST_COLUMNS).map(str::to_owned));
        let over_all = self.means.iter().filter(|mean| mean.folder.is_none());
        let lines = std::iter::once(header).chain(over_all.map(|mean| self.summary_of(mean, &folders)));
        aligned(&lines.collect::<Vec<_>>(), 1)
    }

    fn summary_of(&self, over_all: &Mean, folders: &[&str]) -> Vec<String> {
        let of_tracker = || self.means.iter().filter(|mean| mean.tracker == over_all.tracker);
        let in_folder = |folder: &&str| of_tracker().find(|mean| mean.folder.as_deref() == Some(*folder));
        let correct =
            |mean: Option<&Mean>| mean.map_or("-".to_owned(), |mean| format!("{:.3}", mean.figures.mean_correct));
        let error = over_all.standard_error.map_or("-".to_owned(), |error| format!("{:.3}", error.mean_correct));
        let mut line = vec![over_all.tracker.clone(), correct(Some(over_all)), error];
        line.extend(folders.iter().map(|folder| correct(in_folder(folder))));
        line.push(format!("{:.3}", over_all.figures.worst_correct));
        line.extend(over_all.figures.last_cells());
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_stand_side_by_side() {
        let mean = |tracker: &str, folder: Option<&str>, correct| Mean {
            tracker: tracker.to_owned(),
            folder: folder.map(str::to_owned),
            recordings: 2,
            figures: Figures {
                mean_correct: correct,
                worst_correct: 0.125,
                precision: 0.75,
                hidden: 9,
                answered_hidden: 3,
                work_per_frame: Some(1234.4),
                microseconds_per_frame: 55.5,
                ..Figures::default()
            },
            standard_error: None,
        };
        let means = vec![
            mean("smr", None, 0.5),
            mean("smr", Some("tld"), 0.625),
            mean("smr", Some("more"), 0.375),
            mean("without cells", None, 1.0),
            mean("without cells", Some("more"), 1.0),
        ];
        let row = super::super::table::tests::row("smr", "01_david", means[0].figures);
        let results = Robustness { means, recordings: vec![row], ..Robustness::default() };
        let expected = "\
tracker        correct  standard error  in tld  in more  worst  precision  answered/hidden  found/returns  wrong/tracking  tracking/wrong  unsaid/right  work/frame  us/frame
smr              0.500               -   0.625    0.375  0.125      0.750              3/9              -               -               -             -        1234        56
without cells    1.000               -       -    1.000  0.125      0.750              3/9              -               -               -             -        1234        56
";
        assert_eq!(results.summary(), expected);
        assert_eq!(Robustness::default().summary(), "");
    }
}
