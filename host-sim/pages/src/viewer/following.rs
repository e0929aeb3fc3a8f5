//! Runs the viewer's trackers in a thread and stores their answers: a [`Segment`] holds a target's answers from one
//! lock (a box that the user drew) to the next. A correction creates one segment; unused segments are kept for undo.
//!
//! The thread reads from the earliest frame that lacks an answer; after a lock in an earlier frame, it starts again
//! there. If frames end or fail, segments that need later frames wait for the next change.

use super::change_log::{ChangeLog, TargetSpan};
use super::{Known, Source, lock};
use anyhow::{Error, Result, bail, ensure};
use serde::{Deserialize, Serialize};
use smr_core::{Quality, Rect};
use smr_evaluation::{Follower, Origin, Report, Variant};
use smr_files::messages;
use smr_recordings::{BoundingBox, Damaged, Frame, FrameNumber, GrayFrame, check_gone, checked_name};
use std::cmp::Reverse;
use std::collections::{HashMap, VecDeque};
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Identifier assigned by the page, never reused for another target.
    pub id: u32,
    pub name: String,
    pub locks: Vec<Lock>,
}

/// A frame in which the user drew the target's box, or from which on the target is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lock {
    pub frame: usize,
    /// Left, top, width and height in whole pixels; `None`: the target is gone until its next box.
    #[serde(rename = "box", deserialize_with = "Option::deserialize")]
    pub bbox: Option<(i32, i32, u16, u16)>,
}

impl Target {
    /// Numbers targets from 1. Errors: A box has no pixels.
    pub fn numbered(given: Vec<smr_recordings::Target>) -> Result<Vec<Self>> {
        let target = |(id, given): (u32, smr_recordings::Target)| {
            let locks = given.rects()?.into_iter().map(|(frame, rect)| Lock::new(frame, rect)).collect();
            Ok(Self { id, name: given.name.unwrap_or_else(|| "target".to_owned()), locks })
        };
        (1..).zip(given).map(target).collect()
    }

    /// True if two pages gave the same id to different targets, which share neither name nor lock.
    fn is_another(&self, other: &Self) -> bool {
        self.id == other.id
            && self.name != other.name
            && !other.locks.is_empty()
            && !self.locks.iter().any(|lock| other.locks.contains(lock))
    }
}

impl Lock {
    pub fn new(frame: usize, rect: Option<Rect>) -> Self {
        Self { frame, bbox: rect.map(|Rect { x, y, width, height }| (x, y, width, height)) }
    }

    pub fn rect(&self) -> Option<Rect> {
        self.bbox.map(|(x, y, width, height)| Rect { x, y, width, height })
    }
}

/// Returns an error if the box of a lock is not wholly inside frames of this width and height; empty boxes pass.
pub fn check_inside<'a>(locks: impl IntoIterator<Item = &'a Lock>, (width, height): (u16, u16)) -> Result<()> {
    let frame = Rect { x: 0, y: 0, width, height };
    for (rect, number) in locks.into_iter().filter_map(|lock| Some((lock.rect()?, lock.frame))) {
        let Rect { x, y, width: wide, height: high } = rect;
        ensure!(
            rect.is_empty() || rect.intersection(frame) == rect,
            "the box {x},{y},{wide},{high} in frame {number} is not wholly inside {width}x{height} pixels"
        );
    }
    Ok(())
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub report: Report,
    /// Box to draw: the answer's, or the last known one if the target is lost.
    pub shown: BoundingBox,
    /// Suitability of the target for tracking; only in the frame of a lock.
    pub quality: Option<Quality>,
    /// Time of the frame in seconds, if known.
    pub time: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Key {
    target: u32,
    lock: (usize, Rect),
    settings_index: usize,
}

struct Segment {
    /// Frame of the first row: the lock's frame, or a later one after a camera's old rows were dropped.
    first: usize,
    /// (position in [`ChangeLog`], row) of each frame from `first` on; positions ascend. `None`: dropped frame.
    rows: VecDeque<(u64, Option<Row>)>,
    /// True if the tracker refused a frame, or a camera no longer keeps the lock's frame. No answers follow.
    failed: bool,
    /// True if the frames ended before the one that this segment needs next.
    starved: bool,
    /// Value of [`State::changes`] when a target last used this segment.
    used: u64,
}

impl Segment {
    fn next(&self) -> usize {
        self.first + self.rows.len()
    }

    /// Returns the indices in `rows` of the frames `from..end`.
    fn places(&self, from: usize, end: usize) -> Range<usize> {
        let place = |frame: usize| frame.saturating_sub(self.first).min(self.rows.len());
        place(from)..place(end).max(place(from))
    }

    fn answers(&self, places: Range<usize>) -> impl Iterator<Item = (usize, Row)> + '_ {
        let first = self.first + places.start;
        (first..).zip(self.rows.range(places)).filter_map(|(frame, (_, row))| Some((frame, (*row)?)))
    }
}

/// Largest number of unused segments (answers from one lock to the next) for undo; [`SPARE_ROWS`] limits their rows.
const SPARE: usize = 24;
const SPARE_ROWS: usize = 1 << 18;
const PORTION: usize = if cfg!(test) { 100 } else { 5000 };
/// Longest run of unneeded frames that is read and discarded; a longer one is skipped by a seek.
const READ_THROUGH: usize = 100;
/// Largest number of trackers in memory, one for each lock; beyond it, trackers whose answers are complete are dropped.
const MAX_TRACKERS: usize = if cfg!(test) { 8 } else { 64 };
/// Largest number of answers per segment of a camera: five minutes at 60 frames a second.
const MAX_LIVE_ROWS: usize = 18_000;

struct State {
    targets: Vec<Target>,
    variant: Variant,
    /// All tracker settings used so far, so that switching back finds the earlier answers.
    settings_used: Vec<Origin>,
    settings_index: usize,
    segments: HashMap<Key, Segment>,
    changes: u64,
    log: ChangeLog,
    /// Last frame of the recording, once reading has reached its end.
    end: Option<usize>,
    /// Latest frame of a lock behind the end that the user has been told.
    told_beyond: usize,
    seen: usize,
    damaged: Option<usize>,
    /// Frame being tracked, and the speed in frames a second.
    at: Option<(usize, f64)>,
    stopped: bool,
}

pub struct Followed {
    state: Mutex<State>,
    changed: Condvar,
}

/// A segment that lacks answers, and the next frame that it needs.
#[derive(Clone, Copy)]
struct Task {
    key: Key,
    next: usize,
}

impl Task {
    const fn has_begun(&self) -> bool {
        self.next > self.key.lock.0
    }
}

impl State {
    fn plan(&self) -> impl Iterator<Item = (Key, usize)> + '_ {
        self.targets.iter().flat_map(|target| planned(target, self.settings_index))
    }

    /// Returns the segments that lack answers, except those that failed or ran out of frames.
    fn tasks(&self) -> Vec<Task> {
        let last = self.end.unwrap_or(usize::MAX);
        let task = |(key, end): (Key, usize)| {
            let segment = self.segments.get(&key)?;
            let next = segment.next();
            (!segment.failed && !segment.starved && next < end && next <= last).then_some(Task { key, next })
        };
        self.plan().filter_map(task).collect()
    }

    fn rows(&self, TargetSpan { target, from, to }: TargetSpan) -> impl Iterator<Item = (usize, Row)> + '_ {
        let target = self.targets.iter().find(move |one| one.id == target);
        let plan = target.into_iter().flat_map(|target| planned(target, self.settings_index));
        plan.filter_map(|(key, end)| Some((self.segments.get(&key)?, end)))
            .flat_map(move |(segment, end)| segment.answers(segment.places(from, end.min(to.saturating_add(1)))))
    }

    /// Returns the rows that changed after log position `since`: (target id, segment, index range in its `rows`).
    fn changed(&self, since: u64) -> impl Iterator<Item = (u32, &Segment, Range<usize>)> {
        self.plan().filter_map(move |(key, end)| {
            let segment = self.segments.get(&key)?;
            let places = segment.rows.partition_point(|(at, _)| *at <= since)..segment.places(0, end).end;
            (!places.is_empty()).then_some((key.target, segment, places))
        })
    }

    /// Makes pages load the answers in `part` again, by new log positions. All later answers in the same segment also
    /// get new positions, because positions must ascend within a segment.
    fn renew_positions(&mut self, part: TargetSpan) {
        self.log.void(part);
        let Self { targets, segments, log, settings_index, .. } = self;
        let Some(target) = targets.iter().find(|one| one.id == part.target) else { return };
        for (key, _) in planned(target, *settings_index).filter(|(key, _)| key.lock.0 <= part.to) {
            let Some(segment) = segments.get_mut(&key) else { continue };
            let places = segment.places(part.from, usize::MAX);
            segment.rows.range_mut(places).for_each(|row| row.0 = log.next());
        }
    }

    fn frames(&self, known: Option<usize>) -> Option<usize> {
        known.map(|known| known.max(self.seen)).or(self.end)
    }

    /// Validates targets and sorts their locks. A new lock before frame `oldest`, the first that is kept, is an error.
    fn checked(&self, mut targets: Vec<Target>, known: Option<usize>, oldest: usize) -> Result<Vec<Target>> {
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
        let twice = (1..targets.len()).find(|&at| targets[..at].iter().any(|one| one.id == targets[at].id));
        if let Some(at) = twice {
            bail!("two targets have the id {}: expected one", targets[at].id);
        }
        Ok(targets)
    }

    /// Adds missing segments and lets segments that ran out of frames try again. Of the unused segments, keeps only
    /// those used last, as [`SPARE`] and [`SPARE_ROWS`] allow.
    fn arrange(&mut self) {
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

/// Returns the segments of a target, each with its exclusive end frame: the frame of the next lock.
fn planned(target: &Target, settings_index: usize) -> impl Iterator<Item = (Key, usize)> + '_ {
    target.locks.iter().enumerate().filter_map(move |(at, lock)| {
        let end = target.locks.get(at + 1).map_or(usize::MAX, |next| next.frame);
        Some((Key { target: target.id, lock: (lock.frame, lock.rect()?), settings_index }, end))
    })
}

/// Returns the first and the last frame of the range in which a target's answers can differ between the lists of locks
/// `old` and `new`; `None` if the lists are equal.
fn differing(old: &[Lock], new: &[Lock]) -> Option<(usize, usize)> {
    let same = old.iter().zip(new).take_while(|(old, new)| old == new).count();
    let (old, new) = (&old[same..], &new[same..]);
    let from = old.iter().chain(new).map(|lock| lock.frame).min()?;
    let behind = old.iter().rev().zip(new.iter().rev()).take_while(|(old, new)| old == new).count();
    Some((from, if behind == 0 { usize::MAX } else { new[new.len() - behind].frame - 1 }))
}

/// Changes of targets, answers, messages, files and frames after a position in the change log, for a page that polls.
pub(super) struct Changes {
    pub position: u64,
    /// Frame ranges whose answers the page discards before it stores `rows`.
    pub void: Vec<TargetSpan>,
    pub changed: Vec<TargetSpan>,
    /// New answers; empty if there are too many: the page then requests the ranges in `changed`.
    pub rows: Vec<(u32, usize, Row)>,
    pub messages: Vec<String>,
    pub made: Vec<u32>,
    /// True if the number of frames or their times changed.
    pub frames: bool,
    /// All targets and their revision, if they changed.
    pub targets: Option<(Vec<Target>, u64)>,
}

impl Followed {
    /// Validates the targets and plans their segments.
    /// Errors: A target is invalid. For a camera, frame numbers are not checked, because its frames are still to come.
    pub fn new(variant: Variant, targets: Vec<Target>, source: &dyn Source) -> Result<Self> {
        let mut state = State {
            targets: Vec::new(),
            settings_used: vec![variant.origin()],
            variant,
            settings_index: 0,
            segments: HashMap::new(),
            changes: 0,
            log: ChangeLog::default(),
            end: None,
            told_beyond: 0,
            seen: 0,
            damaged: None,
            at: None,
            stopped: false,
        };
        // The length may be known a moment later: `beyond` then says that a box lies behind the last frame.
        state.targets = state.checked(targets, None, usize::from(source.live().is_none()))?;
        state.arrange();
        Ok(Self { state: Mutex::new(state), changed: Condvar::new() })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    fn change<T>(&self, act: impl FnOnce(&mut State) -> T) -> T {
        let done = act(&mut self.state());
        self.changed.notify_all();
        done
    }

    pub fn targets(&self) -> Vec<Target> {
        self.state().targets.clone()
    }

    /// Returns the targets and their revision: the log position of their last change.
    pub(super) fn revision(&self) -> (Vec<Target>, u64) {
        let state = self.state();
        (state.targets.clone(), state.log.targets)
    }

    pub fn variant(&self) -> Variant {
        self.state().variant.clone()
    }

    pub fn rows(&self) -> Vec<(Target, Vec<(usize, Row)>)> {
        let state = self.state();
        state.targets.iter().map(|target| (target.clone(), state.rows(TargetSpan::all(target.id)).collect())).collect()
    }

    /// Returns at most [`PORTION`] answers of a frame range, and the last frame that they cover.
    pub(super) fn part(&self, part: TargetSpan) -> (Vec<(usize, Row)>, usize) {
        let rows: Vec<_> = self.state().rows(part).take(PORTION).collect();
        let to = rows.last().filter(|_| rows.len() == PORTION).map_or(part.to, |(frame, _)| *frame);
        (rows, to)
    }

    /// Replaces the targets, tracks only changed frame ranges again, and returns the new revision; `revision` is the
    /// latest that the page has seen. Errors: A box without pixels, two locks of a target in one frame, a "gone" lock
    /// before a target's first box or directly after another "gone" lock, a new lock in a frame that does not exist or
    /// is no longer kept, an invalid name, two targets with one id, or targets that another page has changed.
    pub(super) fn set_targets(&self, targets: Vec<Target>, revision: Option<u64>, source: &dyn Source) -> Result<u64> {
        let (known, oldest) = (source.known().frames, source.oldest());
        self.change(|state| {
            let targets = state.checked(targets, known, oldest)?;
            let others = match revision {
                Some(revision) => revision != state.log.targets,
                // A page without a revision may replace the initial targets, but not targets that another page has set.
                None => {
                    state.log.targets > 0
                        && targets.iter().any(|one| state.targets.iter().any(|other| one.is_another(other)))
                }
            };
            ensure!(!others, "another page has changed the targets meanwhile: look at them, and do it again");
            if targets == state.targets {
                state.arrange();
                return Ok(state.log.targets);
            }
            let old = std::mem::replace(&mut state.targets, targets);
            state.arrange();
            state.log.targets = state.log.next();
            let part = |target: &Target| {
                let before = old.iter().find(|one| one.id == target.id).map_or(&[][..], |one| &one.locks);
                let (from, to) = differing(before, &target.locks)?;
                Some(TargetSpan { target: target.id, from, to })
            };
            let changed: Vec<_> = state.targets.iter().filter_map(part).collect();
            changed.into_iter().for_each(|part| state.renew_positions(part));
            Ok(state.log.targets)
        })
    }

    pub(super) fn set_variant(&self, variant: Variant) {
        self.change(|state| {
            let origin = variant.origin();
            state.settings_index =
                state.settings_used.iter().position(|one| *one == origin).unwrap_or(state.settings_used.len());
            if state.settings_index == state.settings_used.len() {
                state.settings_used.push(origin);
            }
            state.variant = variant;
            state.arrange();
            let all: Vec<_> = state.targets.iter().map(|target| TargetSpan::all(target.id)).collect();
            all.into_iter().for_each(|part| state.renew_positions(part));
        });
    }

    pub(super) fn stop(&self) {
        self.change(|state| state.stopped = true);
    }

    /// Records that the source knows more frames, and retries segments that ran out of frames.
    pub(super) fn learns(&self, known: Option<usize>) {
        self.change(|state| {
            if known > state.end {
                state.end = None;
                state.segments.values_mut().for_each(|segment| segment.starved = false);
            }
            state.log.frames = state.log.next();
        });
    }

    pub(super) fn tell(&self, tell: impl FnOnce(&mut ChangeLog)) {
        self.change(|state| tell(&mut state.log));
    }

    /// Returns, once, a message about the latest lock behind the end of a recording, whose length may be known only
    /// after its boxes were accepted. `known` is the count of frames, if known.
    pub(super) fn beyond(&self, known: Option<usize>) -> Option<String> {
        let mut state = self.state();
        let last = state.frames(known).filter(|&last| last > 0)?;
        let locks = state.targets.iter().flat_map(|target| target.locks.iter().map(|lock| (lock.frame, &target.name)));
        let (frame, name) = locks.max().filter(|&(frame, _)| frame > last && frame != state.told_beyond)?;
        let line = format!("there is no frame {frame} for {name}: expected 1 to {last}");
        state.told_beyond = frame;
        Some(line)
    }

    /// Waits at most `patience` for changes after `since`. If over [`PORTION`] answers changed, returns their ranges.
    pub(super) fn wait_for_changes(&self, since: u64, patience: Duration) -> Changes {
        let mut state = self.state();
        let begin = Instant::now();
        while state.log.end() <= since {
            let Some(left) = patience.checked_sub(begin.elapsed()) else { break };
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        let log = &state.log;
        let heard = since;
        // If the log no longer covers what the page has missed, the page reloads everything.
        let (is_remembered, all) = (log.remembers(since), state.targets.iter());
        let since = if is_remembered { since.min(log.end()) } else { 0 };
        let (void, messages, made) = log.after(heard);
        let changed: Vec<_> = state.changed(since).collect();
        let is_short = changed.iter().map(|(.., places)| places.len()).sum::<usize>() <= PORTION;
        let rows = |(target, segment, places): &(u32, &Segment, Range<usize>)| {
            let target = *target;
            segment.answers(places.clone()).map(move |(frame, row)| (target, frame, row)).collect::<Vec<_>>()
        };
        let part = |(target, segment, places): &(u32, &Segment, Range<usize>)| TargetSpan {
            target: *target,
            from: segment.first + places.start,
            to: segment.first + places.end - 1,
        };
        Changes {
            position: log.end(),
            void: if is_remembered { void } else { all.map(|target| TargetSpan::all(target.id)).collect() },
            rows: if is_short { changed.iter().flat_map(rows).collect() } else { Vec::new() },
            changed: changed.iter().map(part).collect(),
            messages,
            made,
            frames: heard < log.frames,
            targets: (heard < log.targets).then(|| (state.targets.clone(), log.targets)),
        }
    }

    /// Returns the last frame up to which all answers exist and, while tracking runs, the frame being read and the
    /// speed in frames a second. `known` is the count of frames, if known.
    pub fn reached(&self, known: Option<usize>) -> (usize, Option<(usize, f64)>) {
        let state = self.state();
        let open = state.tasks().iter().map(|task| task.next - 1).min();
        let at = open.map(|reached| state.at.unwrap_or((reached, 0.0)));
        let ends = state.plan().filter_map(|(key, end)| Some(state.segments.get(&key)?.next().min(end) - 1));
        let stays_gone = state.targets.iter().any(|target| target.locks.last().is_some_and(|lock| lock.bbox.is_none()));
        // If a target stays gone after its last lock, it needs no more answers, so all frames count as done.
        let done = || ends.chain(state.frames(known).filter(|_| stays_gone)).max();
        // A lock may lie behind the end.
        let last = state.frames(known).unwrap_or(usize::MAX);
        (open.or_else(done).unwrap_or(0).min(last), at)
    }

    /// Returns the segments whose answers ended early: target, frame of the lock, first frame without an answer. They go
    /// on after a change of the targets or the method at the earliest.
    pub(super) fn silent(&self) -> Vec<(u32, usize, usize)> {
        let state = self.state();
        let ends = |(key, end): (Key, usize)| {
            let segment = state.segments.get(&key)?;
            let next = segment.next();
            let is_whole = next == end || state.end.is_some_and(|last| next == last + 1);
            ((segment.failed || segment.starved) && !is_whole).then_some((key.target, key.lock.0, next))
        };
        state.plan().filter_map(ends).collect()
    }

    /// Returns the last frame before damaged data, for the option `--frames`; `None` if no damage is known, the first
    /// frame is damaged, or a frame after the last intact one has a lock.
    pub fn last_intact(&self) -> Option<usize> {
        let state = self.state();
        let mut locks = state.targets.iter().flat_map(|target| &target.locks);
        state.damaged.filter(|&last| last > 0 && locks.all(|lock| lock.frame <= last))
    }

    /// Reads frames and runs trackers whenever answers are missing, until [`Self::stop`].
    pub(super) fn run(&self, source: &dyn Source) {
        let is_live = source.live().is_some();
        let mut thread = Following { followed: self, source, is_live, trackers: HashMap::new() };
        while let Some(start) = thread.wait() {
            if let Some((last, error)) = thread.pass(start) {
                thread.ended(start, last, error.as_ref());
            }
            self.state().at = None;
        }
    }

    /// Returns the count of frames and their times, as far as the source or the tracking thread knows them.
    pub(super) fn known(&self, source: &dyn Source) -> Known {
        let known = source.known();
        let state = self.state();
        let frames = state.frames(known.frames).filter(|_| source.live().is_none());
        Known { frames: frames.or(known.frames), ..known }
    }
}

struct Following<'a> {
    followed: &'a Followed,
    source: &'a dyn Source,
    is_live: bool,
    trackers: HashMap<Key, Follower>,
}

impl Following<'_> {
    /// Waits until an answer is missing. Returns the frame to start reading at; `None` after [`Followed::stop`].
    fn wait(&self) -> Option<usize> {
        let mut state = self.followed.state();
        loop {
            if state.stopped {
                return None;
            }
            let oldest = self.source.oldest();
            for Task { key, .. } in state.tasks().into_iter().filter(|task| task.has_begun()) {
                // If the tracker of a segment was dropped, the segment starts again from its lock.
                if !self.trackers.contains_key(&key) {
                    state.segments.entry(key).and_modify(|segment| segment.rows.clear());
                }
            }
            // A segment needs its lock's frame to start. Once it has started, its tracker may skip frames of a camera.
            let (late, tasks): (Vec<Task>, _) =
                state.tasks().into_iter().partition(|task| task.next < oldest && !task.has_begun());
            for Task { key, next } in late {
                state.log.say(format!("frame {next} is not kept any more: lock in frame {oldest} or a newer one"));
                state.segments.entry(key).and_modify(|segment| segment.failed = true);
                self.followed.changed.notify_all();
            }
            if let Some(start) = tasks.iter().map(|task| task.next.max(oldest)).min() {
                return Some(start);
            }
            state = self.followed.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Reads frames from `start` on and runs the trackers, as long as an answer in the next frame is missing. If the
    /// frames end earlier, returns the last frame that was read, and the error, if one ended the reading.
    fn pass(&mut self, start: usize) -> Option<(usize, Option<Error>)> {
        let frames = match self.source.gray_from(start) {
            Ok(frames) => frames,
            Err(error) => return Some((start - 1, Some(error))),
        };
        let mut last = start - 1;
        // `rate` is in frames a second, over the last half second.
        let (mut begin, mut count, mut rate) = (Instant::now(), 0.0, 0.0);
        for frame in frames {
            match frame {
                Ok(frame) => {
                    (last, count) = (frame.number, count + 1.0);
                    let passed = begin.elapsed().as_secs_f64();
                    if passed > 0.5 {
                        (begin, count, rate) = (Instant::now(), 0.0, count / passed);
                    }
                    if !self.frame(&frame, rate) {
                        return None;
                    }
                }
                Err(error) => return Some((last, Some(error))),
            }
        }
        Some((last, None))
    }

    /// Handles the end of reading at `last`, which is the recording's end only if the source knows of no more frames.
    fn ended(&self, start: usize, last: usize, error: Option<&Error>) {
        let known = self.source.known().frames;
        self.followed.change(|state| {
            for Task { key, .. } in state.tasks().into_iter().filter(|task| task.next <= last + 1) {
                state.segments.entry(key).and_modify(|segment| segment.starved = true);
            }
            if let Some(error) = error {
                if error.is::<Damaged>() {
                    state.damaged = Some(state.damaged.map_or(last, |before| before.min(last)));
                }
                state.log.say(messages::of(error));
            } else if known.map_or(start == 1, |all| last >= all) {
                state.end = Some(last);
            } else if !state.stopped {
                let of = known.map_or(String::new(), |all| format!(" of {all}"));
                state.log.say(format!(
                    "there is no frame after {last}{of}: is the file still being written? Any change tries again."
                ));
            }
            state.log.frames = state.log.next();
        });
    }

    /// Runs the trackers that need this frame. Returns true if the next frame is to be read.
    fn frame(&mut self, &Frame { number, seconds: time, ref gray, .. }: &Frame, rate: f64) -> bool {
        let (followed, is_live) = (self.followed, self.is_live);
        let (mut due, variant) = {
            let state = followed.state();
            (state.tasks(), state.variant.clone())
        };
        due.retain(|task| task.next == number || is_live && task.has_begun() && task.next < number);
        let answers: Vec<_> =
            due.into_iter().map(|task| (task, self.answer(task.key, number, gray, &variant))).collect();
        followed.change(|state| {
            let State { segments, log, .. } = state;
            for (task, answer) in answers {
                let Some(segment) = segments.get_mut(&task.key).filter(|segment| segment.next() == task.next) else {
                    continue;
                };
                match answer {
                    Ok(Some((report, quality))) => {
                        let before = segment.rows.iter().rev().find_map(|(_, row)| Some((*row)?.shown));
                        let shown = report.target.or(before).unwrap_or_else(|| task.key.lock.1.into());
                        let row = Row { report, shown, quality, time };
                        segment.rows.extend((task.next..number).map(|_| (log.end(), None)));
                        segment.rows.push_back((log.next(), Some(row)));
                        if is_live && segment.rows.len() > MAX_LIVE_ROWS {
                            segment.rows.pop_front();
                            segment.first += 1;
                        }
                    }
                    Ok(None) => {}
                    Err(error) => {
                        segment.failed = true;
                        log.say(messages::of(&error));
                    }
                }
            }
            self.trackers.retain(|key, _| segments.contains_key(key));
            state.at = Some((number, rate));
            state.seen = state.seen.max(number);
            state.end = state.end.filter(|&end| number <= end);
            state.damaged = state.damaged.filter(|&last| number != last + 1);
            let tasks = state.tasks();
            if self.trackers.len() > MAX_TRACKERS && !is_live {
                self.trackers.retain(|key, _| tasks.iter().any(|task| task.key == *key));
            }
            !state.stopped
                && !tasks.is_empty()
                && (is_live && tasks.iter().all(|task| task.next >= number || task.has_begun())
                    || tasks.iter().all(|task| task.next > number)
                        && tasks.iter().any(|task| task.next <= number + READ_THROUGH))
        })
    }

    /// Returns a tracker's report on a frame. In the frame of the lock, builds the tracker first and also returns the
    /// target's quality.
    fn answer(
        &mut self,
        key: Key,
        number: usize,
        frame: &GrayFrame,
        variant: &Variant,
    ) -> Result<Option<(Report, Option<Quality>)>> {
        let locks = number == key.lock.0;
        if locks {
            self.trackers.insert(key, Follower::new(variant.build()?, vec![(number, Some(key.lock.1))]));
        }
        let Some(tracker) = self.trackers.get_mut(&key) else { return Ok(None) };
        let report = tracker.step(number, frame)?;
        Ok(report.map(|report| (report, tracker.quality().filter(|_| locks))))
    }
}

#[cfg(test)]
mod tests;
