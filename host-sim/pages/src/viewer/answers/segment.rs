//! A [`Segment`] holds a target's answers from one lock to the next.

use super::super::model::Target;
use smr_core::{Quality, Rect};
use smr_evaluation::MethodAnswer;
use smr_recordings::BoundingBox;
use std::collections::VecDeque;
use std::ops::Range;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnsweredFrame {
    pub report: MethodAnswer,
    /// Box to draw: the answer's, or the last known one if the target is lost.
    pub shown: BoundingBox,
    /// Suitability of the target for tracking; only in the frame of a lock.
    pub quality: Option<Quality>,
    /// Time of the frame in seconds, if known.
    pub time: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key {
    pub target: u32,
    pub lock: (usize, Rect),
    pub settings_index: usize,
}

pub struct Segment {
    /// Frame of the first row: the lock's frame, or a later one after a camera's old rows were dropped.
    pub first: usize,
    /// (position in `ChangeLog`, row) of each frame from `first` on; positions ascend. `None`: dropped frame.
    pub rows: VecDeque<(u64, Option<AnsweredFrame>)>,
    /// True if the tracker refused a frame, or a camera no longer keeps the lock's frame. No answers follow.
    pub failed: bool,
    /// True if the frames ended before the one that this segment needs next.
    pub starved: bool,
    /// Value of `State::changes` when a target last used this segment.
    pub used: u64,
}

impl Segment {
    pub fn next(&self) -> usize {
        self.first + self.rows.len()
    }

    /// Returns the indices in `rows` of the frames `from..end`.
    pub fn places(&self, from: usize, end: usize) -> Range<usize> {
        let place = |frame: usize| frame.saturating_sub(self.first).min(self.rows.len());
        place(from)..place(end).max(place(from))
    }

    pub fn answers(&self, places: Range<usize>) -> impl Iterator<Item = (usize, AnsweredFrame)> + '_ {
        let first = self.first + places.start;
        (first..).zip(self.rows.range(places)).filter_map(|(frame, (_, row))| Some((frame, (*row)?)))
    }
}

/// A segment that lacks answers, and the next frame that it needs.
#[derive(Clone, Copy)]
pub struct Task {
    pub key: Key,
    pub next: usize,
}

impl Task {
    pub const fn has_begun(&self) -> bool {
        self.next > self.key.lock.0
    }
}

/// Returns the segments of a target, each with its exclusive end frame: the frame of the next lock.
pub fn planned(target: &Target, settings_index: usize) -> impl Iterator<Item = (Key, usize)> + '_ {
    target.locks.iter().enumerate().filter_map(move |(at, lock)| {
        let end = target.locks.get(at + 1).map_or(usize::MAX, |next| next.frame);
        Some((Key { target: target.id, lock: (lock.frame, lock.rect()?), settings_index }, end))
    })
}
