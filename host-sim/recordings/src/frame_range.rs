//! Cuts a recording to a range of its frames, with their boxes.

use crate::frame_number::FrameNumber;
use crate::sequence::Sequence;
use anyhow::{Context, Result, anyhow, ensure};
use std::fmt;
use std::str::FromStr;

/// A range of frame numbers from 1, both ends included. Text form: `20..80`, `20..` or `..80`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    first: usize,
    /// Last frame; `None` for the end of the recording.
    last: Option<usize>,
}

impl FrameRange {
    pub const ALL: Self = Self { first: 1, last: None };

    pub const fn from(first: FrameNumber) -> Self {
        Self { first: first.get(), last: None }
    }

    /// Renumbers the range so that frame `first` becomes 1; a start or end before that frame becomes 1 too.
    pub fn counted_from(&self, first: usize) -> Self {
        let shifted = |number: usize| (number + 1).saturating_sub(first).max(1);
        Self { first: shifted(self.first), last: self.last.map(shifted) }
    }

    /// Moves the start to frame `first`, if the range starts at frame 1.
    pub fn begun_at(self, first: FrameNumber) -> Self {
        Self { first: if self.first == 1 { first.get() } else { self.first }, ..self }
    }

    pub const fn first(&self) -> usize {
        self.first
    }

    pub const fn last(&self) -> Option<usize> {
        self.last
    }

    pub fn length_of(&self, length: usize) -> usize {
        length.min(self.last.unwrap_or(length)).saturating_sub(self.first - 1)
    }

    /// Returns the part of `entries` in the range; `entries` has one entry per frame.
    pub fn of<T>(&self, mut entries: Vec<T>) -> Vec<T> {
        entries.truncate(self.last.unwrap_or(usize::MAX));
        entries.drain(..entries.len().min(self.first - 1));
        entries
    }
}

impl FromStr for FrameRange {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let expected = "expected frames like 20..80, 20.. or ..80; the first is 1";
        let (first, last) = text.split_once("..").context(expected)?;
        let number = |text: &str| text.parse().ok().map(FrameNumber::get).context(expected);
        let first = if first.is_empty() { 1 } else { number(first)? };
        let last = if last.is_empty() { None } else { Some(number(last)?) };
        ensure!(last.is_none_or(|last| last >= first), "{expected}, the smaller one first");
        Ok(Self { first, last })
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..", self.first)?;
        self.last.map_or(Ok(()), |last| write!(f, "{last}"))
    }
}

impl Sequence {
    /// Cuts the recording to `range`. A range from frame 1 keeps the start box; any other range starts from the ground
    /// truth of its first frame, if there is one. The ground truth begins with frame `truth_from`, which is not behind
    /// the range's first frame. `option` is the command-line option to name in errors.
    pub fn part(mut self, range: FrameRange, truth_from: usize, option: &str) -> Self {
        let truth = self.truth.map(|truth| range.counted_from(truth_from).of(truth));
        let init = if range.first == 1 { self.init } else { truth.as_ref().and_then(|truth| *truth.first()?) };
        let length = self.length.map(|length| range.length_of(length));
        let (first, last, mut number) = (range.first, range.last.unwrap_or(usize::MAX), 0);
        let place = format!("{}: there is no frame {first} ({option})", self.name);
        let frames = std::iter::from_fn(move || {
            while number < last {
                number += 1;
                match self.frames.next() {
                    Some(Ok(_)) if number < first => {}
                    None if number <= first => {
                        let length = number - 1;
                        number = usize::MAX;
                        return Some(Err(anyhow!("{place}: expected 1 to {length}")));
                    }
                    next => return next,
                }
            }
            None
        });
        Self { frames: Box::new(frames), length, first, truth, init, ..self }
    }
}

/// Returns an error text if ground truth has more or fewer boxes than frames; `None` if the counts agree.
pub fn misfit(frames: usize, boxes: usize) -> Option<String> {
    let mend = if boxes < frames {
        "say which frame the first box is of (--truth-from N), or read only the frames that have boxes (--frames A..B)"
    } else {
        "expected a box a frame: is it the ground truth of another recording?"
    };
    (boxes != frames)
        .then(|| format!("there are {frames} frames, but the ground truth has {boxes} boxes for them: {mend}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in::synthetic;

    fn range(text: &str) -> FrameRange {
        text.parse().unwrap()
    }

    fn synthetic_part(text: &str) -> Sequence {
        synthetic::sequence().part(range(text), 1, "--frames")
    }

    #[test]
    fn ranges_as_they_are_typed() {
        for (text, printed) in [("3..7", "3..7"), ("3..", "3.."), ("..7", "1..7"), ("..", "1.."), ("4..4", "4..4")] {
            assert_eq!(range(text).to_string(), printed);
        }
        for refused in ["", "3", "3-7", "0..4", "7..3", "a..", "..0", "1...3", "-1..3"] {
            let error = refused.parse::<FrameRange>().unwrap_err().to_string();
            assert!(error.starts_with("expected frames like 20..80"), "{refused}: {error}");
        }
    }

    #[test]
    fn frames_and_boxes_stay_together() {
        let part = synthetic_part("11..15");
        let truth: Vec<_> = (10..15).map(synthetic::truth).collect();
        assert_eq!((part.length, part.init, part.truth), (Some(5), truth[0], Some(truth)));
        let numbered = (11..).zip(synthetic::frames().skip(10).take(5));
        assert!(part.frames.map(Result::unwrap).map(|frame| (frame.number, frame.gray)).eq(numbered));

        let whole = synthetic_part("..");
        assert_eq!((whole.length, whole.init), (Some(synthetic::LENGTH), synthetic::truth(0)));
        assert_eq!(whole.frames.count(), synthetic::LENGTH);
        let rest = synthetic_part(&format!("{}..9999", synthetic::LENGTH));
        assert_eq!((rest.length, rest.frames.count()), (Some(1), 1));
    }
}
