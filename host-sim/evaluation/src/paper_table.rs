//! Table 2 of the paper as printed; nothing in it was measured here.

pub(super) const SOURCE: &str = "printed";

const SEQUENCES: [&str; 6] = ["01_david", "02_jumping", "03_pedestrian1", "04_pedestrian2", "05_pedestrian3", "06_car"];

/// Number of correct frames of a tracker, for each of `SEQUENCES`; `None` where the paper has no figure.
pub(super) struct PrintedTracker {
    pub tracker: &'static str,
    correct: [Option<u16>; 6],
}

pub(super) const TABLE: [PrintedTracker; 6] = [
    row("Lim 2004 (incremental subspace)", [17, 75, 11, 33, 50, 163]),
    PrintedTracker {
        tracker: "Collins 2005 (online feature selection)",
        correct: [None, Some(313), Some(6), Some(8), Some(5), None],
    },
    row("Avidan 2007 (ensemble tracking)", [94, 44, 22, 118, 53, 10]),
    row("Babenko 2009 (MIL)", [135, 313, 101, 37, 49, 45]),
    row("Kalal 2010 (forward-backward, MedianFlow)", [761, 170, 140, 97, 52, 510]),
    row("SMR, the paper", [761, 313, 140, 236, 66, 510]),
];

const fn row(tracker: &'static str, [a, b, c, d, e, f]: [u16; 6]) -> PrintedTracker {
    PrintedTracker { tracker, correct: [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f)] }
}

impl PrintedTracker {
    pub fn correct(&self, sequence: &str) -> Option<u16> {
        SEQUENCES.iter().zip(self.correct).find(|(known, _)| **known == sequence)?.1
    }
}

pub fn is_known(sequence: &str) -> bool {
    SEQUENCES.contains(&sequence)
}
