//! Which frames of a recording are shown, decided while they pass: how many there will be need not be known.

use std::collections::BTreeSet;

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Evenly spaced ones, and those in which the state changes.
    Spread,
    /// These; the first is 0.
    Listed(BTreeSet<usize>),
}

/// With one more, every other of the evenly spaced frames is dropped: 9 to 16 are left of a long recording.
const MOST_SPREAD: usize = 16;

/// A tracker at its limits changes its state again and again: more than these are counted, not shown.
const MOST_CHANGES: usize = 24;

/// What is kept of the frames to show, and nothing of the others.
pub(super) struct Reel<T> {
    choice: Choice,
    /// Evenly spaced frames are those whose index this divides.
    every: usize,
    changes: usize,
    kept: Vec<Kept<T>>,
}

struct Kept<T> {
    index: usize,
    changed: bool,
    /// Not for its even place alone.
    stays: bool,
    still: T,
}

impl<T> Reel<T> {
    pub fn new(choice: Choice) -> Self {
        Self { choice, every: 1, changes: 0, kept: Vec::new() }
    }

    /// Frame `index`, in which the state has `changed` or not; `still` is called if it is to be kept.
    pub fn offer(&mut self, index: usize, changed: bool, still: impl FnOnce() -> T) {
        self.changes += usize::from(changed);
        let (spread, stays) = match &self.choice {
            Choice::Listed(frames) => (false, frames.contains(&index)),
            Choice::Spread => (index.is_multiple_of(self.every), changed && self.changes <= MOST_CHANGES),
        };
        if spread || stays {
            self.kept.push(Kept { index, changed, stays, still: still() });
            self.thin_out();
        }
    }

    /// What was kept, and how many changes of state there was no room for.
    pub fn into_stills(self) -> (Vec<T>, usize) {
        let shown = self.kept.iter().filter(|kept| kept.changed).count();
        let left_out = if self.choice == Choice::Spread { self.changes - shown } else { 0 };
        (self.kept.into_iter().map(|kept| kept.still).collect(), left_out)
    }

    fn thin_out(&mut self) {
        let spread = self.kept.iter().filter(|kept| kept.index.is_multiple_of(self.every)).count();
        if self.choice == Choice::Spread && spread > MOST_SPREAD {
            self.every *= 2;
            self.kept.retain(|kept| kept.stays || kept.index.is_multiple_of(self.every));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(choice: Choice, length: usize, changes: &[usize]) -> (Vec<usize>, usize) {
        let mut reel = Reel::new(choice);
        (0..length).for_each(|index| reel.offer(index, changes.contains(&index), || index));
        reel.into_stills()
    }

    #[test]
    fn frames_are_evenly_spaced_however_many_there_are() {
        for length in 1..2000 {
            let (frames, _) = shown(Choice::Spread, length, &[]);
            let steps: BTreeSet<usize> = frames.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(steps.len() <= 1, "{length}: {frames:?}");
            assert!((length.min(9)..=16).contains(&frames.len()), "{length}: {frames:?}");
            assert_eq!(frames[0], 0);
        }
    }

    #[test]
    fn changes_of_state_stay() {
        let (frames, left_out) = shown(Choice::Spread, 240, &[168, 177, 199]);
        assert!([168, 177, 199].iter().all(|change| frames.contains(change)), "{frames:?}");
        assert_eq!((frames.len(), left_out), (15 + 3, 0));
    }

    #[test]
    fn no_recording_is_kept_as_a_whole() {
        let all: Vec<usize> = (0..5000).collect();
        let (frames, left_out) = shown(Choice::Spread, 5000, &all);
        assert!(frames.len() <= MOST_SPREAD + MOST_CHANGES, "{}", frames.len());
        assert_eq!(frames.len() + left_out, 5000, "each is shown or counted");
    }

    #[test]
    fn listed_frames_and_no_others() {
        let choice = Choice::Listed([3, 7, 100].into());
        assert_eq!(shown(choice, 20, &[1, 7]), (vec![3, 7], 0));
    }
}
