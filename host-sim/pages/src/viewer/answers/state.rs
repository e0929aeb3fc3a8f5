//! The targets, their segments and the log of changes, which the thread of trackers and the routes share.

use super::super::model::{Lock, Target, TargetSpan};
use super::change_log::ChangeLog;
use super::segment::{AnsweredFrame, Key, Segment, Task, planned};
use anyhow::{Result, bail, ensure};
use smr_evaluation::{Origin, Variant};
use smr_recordings::{FrameNumber, check_gone, checked_name};
use std::cmp::Reverse;
use std::collections::{HashMap, VecDeque};
use std::ops::Range;

/// Largest number of unused segments (answers from one lock to the next) for undo; [`SPARE_ROWS`] limits their rows.
const SPARE: usize = 24;
const SPARE_ROWS: usize = 1 << 18;

pub struct State {
    pub targets: Vec<Target>,
    pub variant: Variant,
    /// All tracker settings used so far, so that switching back finds the earlier answers.
    pub settings_used: Vec<Origin>,
    pub settings_index: usize,
    pub segments: HashMap<Key, Segment>,
    pub changes: u64,
    pub log: ChangeLog,
    /// Last frame of the recording, once reading has reached its end.
    pub end: Option<usize>,
    /// Latest frame of a lock behind the end that the user has been told.
    pub told_beyond: usize,
    pub seen: usize,
    pub damaged: Option<usize>,
    /// Frame being tracked, and the speed in frames a second.
    pub at: Option<(usize, f64)>,
    pub stopped: bool,
}

impl State {
    pub fn plan(&self) -> impl Iterator<Item = (Key, usize)> + '_ {
        self.targets.iter().flat_map(|target| planned(target, self.settings_index))
    }

    /// Returns the segments that lack answers, except those that failed or ran out of frames.
    pub fn tasks(&self) -> Vec<Task> {
        let last = self.end.unwrap_or(usize::MAX);
        let task = |(key, end): (Key, usize)| {
            let segment = self.segments.get(&key)?;
            let next = segment.next();
            (!segment.failed && !segment.starved && next < end && next <= last).then_some(Task { key, next })
        };
        self.plan().filter_map(task).collect()
    }

    pub fn rows(
        &self,
        TargetSpan { target, from, to }: TargetSpan,
    ) -> impl Iterator<Item = (usize, AnsweredFrame)> + '_ {
        let target = self.targets.iter().find(move |one| one.id == target);
        let plan = target.into_iter().flat_map(|target| planned(target, self.settings_index));
        plan.filter_map(|(key, end)| Some((self.segments.get(&key)?, end)))
            .flat_map(move |(segment, end)| segment.answers(segment.places(from, end.min(to.saturating_add(1)))))
    }

    /// Returns the rows that changed after log position `since`: (target id, segment, index range in its `rows`).
    pub fn changed(&self, since: u64) -> impl Iterator<Item = (u32, &Segment, Range<usize>)> {
        self.plan().filter_map(move |(key, end)| {
            let segment = self.segments.get(&key)?;
            let places = segment.rows.partition_point(|(at, _)| *at <= since)..segment.places(0, end).end;
            (!places.is_empty()).then_some((key.target, segment, places))
        })
    }

    /// Makes pages load the answers in `part` again, by new log positions. All later answers in the same segment also
    /// get new positions, because positions must ascend within a segment.
    pub fn renew_positions(&mut self, part: TargetSpan) {
        self.log.void(part);
        let Self { targets, segments, log, settings_index, .. } = self;
        let Some(target) = targets.iter().find(|one| one.id == part.target) else { return };
        for (key, _) in planned(target, *settings_index).filter(|(key, _)| key.lock.0 <= part.to) {
            let Some(segment) = segments.get_mut(&key) else { continue };
            let places = segment.places(part.from, usize::MAX);
            segment.rows.range_mut(places).for_each(|row| row.0 = log.next());
        }
    }

    pub fn frames(&self, known: Option<usize>) -> Option<usize> {
        known.map(|known| known.max(self.seen)).or(self.end)
    }

    /// Validates targets and sorts their locks. A new lock before frame `oldest`, the first that is kept, is an error.
    pub fn checked(&self, mut targets: Vec<Target>, known: Option<usize>, oldest: usize) -> Result<Vec<Target>> {
        for target in &mut targets {
            target.locks.sort_by_key(|lock| lock.frame);
            if !target.name.is_empty() {
                checked_name(&target.name)?;
            }
            let name = &target.name;
            for (at, lock) in target.locks.iter().enumerate() {
                let Lock { frame, .. } = lock;
                ensure!(
                    lock.rect().is_none_or(|rect| !rect.is_empty()),
                    "the box of {name} in frame {frame} has no pixels"
                );
                let last = self.frames(known).unwrap_or(FrameNumber::MAX);
                // A session saved while the recording was longer may contain locks behind the present end.
                let is_known = self.targets.iter().any(|one| one.id == target.id && one.locks.contains(lock));
                ensure!(is_known || (1..=last).contains(frame), "there is no frame {frame}: expected 1 to {last}");
                let twice = at > 0 && target.locks[at - 1].frame == *frame;
                ensure!(!twice, "{name} has two boxes in frame {frame}: expected one");
            }
            check_gone(name, target.locks.iter().map(|lock| (lock.frame, lock.bbox.is_some())))?;
            // A lock that already has a segment is not new: usually, the frame was read while the source still kept it.
            let late = planned(target, self.settings_index)
                .find(|(key, _)| key.lock.0 < oldest && !self.segments.contains_key(key));
            if let Some((Key { lock: (frame, _), .. }, _)) = late {
                let all = known.unwrap_or(0);
                bail!("frame {frame} of {all}: trackers can go back to frame {oldest} only: lock in a newer frame");
            }
        }
        for (at, target) in targets.iter().enumerate() {
            let Target { id, name, .. } = target;
            ensure!(targets[..at].iter().all(|one| one.id != *id), "two targets have the id {id}: expected one");
            let is_free = targets[..at].iter().all(|one| one.name != *name);
            ensure!(is_free, "two targets are called {name}: give one of them another name");
        }
        Ok(targets)
    }

    /// Adds missing segments and lets segments that ran out of frames try again. Of the unused segments, keeps only
    /// those used last, as [`SPARE`] and [`SPARE_ROWS`] allow.
    pub fn arrange(&mut self) {
        self.changes += 1;
        let plan: Vec<Key> = self.plan().map(|(key, _)| key).collect();
        for key in plan {
            let new = || Segment { first: key.lock.0, rows: VecDeque::new(), failed: false, starved: false, used: 0 };
            let segment = self.segments.entry(key).or_insert_with(new);
            (segment.used, segment.starved) = (self.changes, false);
        }
        let unused = self.segments.iter().filter(|(_, segment)| segment.used < self.changes);
        let mut spare: Vec<Key> = unused.map(|(key, _)| *key).collect();
        spare.sort_unstable_by_key(|key| Reverse(self.segments[key].used));
        let mut rows = 0;
        for (count, key) in spare.into_iter().enumerate() {
            rows += self.segments[&key].rows.len();
            if count >= SPARE || rows > SPARE_ROWS {
                self.segments.remove(&key);
            }
        }
    }
}
