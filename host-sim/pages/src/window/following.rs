//! Following: which frames are answered for which target, and the thread that does it.
//!
//! A target is locked in one or more frames. From each lock to the next one it is followed in one go: a [`Segment`]. A new correction makes one new
//! segment; the others keep their answers. Segments that are no longer wanted are kept for a while, so that undo is at once.
//!
//! The thread begins at the earliest frame that lacks an answer and reads on. All segments that wait for the frame that it is at are
//! asked. If a lock in an earlier frame comes meanwhile, it goes back there; the others wait until it is at their frame again.

use super::news::{Item, News};
use super::{Known, Source};
use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};
use smr_core::{Quality, Rect};
use smr_evaluation::{Follower, Report, Variant};
use smr_recordings::{BoundingBox, GrayFrame, messages};
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A target as the page knows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Given by the page, never used for another target.
    pub id: u32,
    pub name: String,
    pub locks: Vec<Lock>,
}

/// A box that the target is locked on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lock {
    pub frame: usize,
    /// Left, top, width and height in whole pixels.
    #[serde(rename = "box")]
    pub bbox: (i32, i32, u16, u16),
}

impl Lock {
    fn rect(&self) -> Rect {
        let (x, y, width, height) = self.bbox;
        Rect { x, y, width, height }
    }
}

/// What is known of a target in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub report: Report,
    /// The box, or the last one if the target is lost.
    pub shown: BoundingBox,
    /// In a frame that the target was locked on.
    pub quality: Option<Quality>,
    /// Of a camera: when the frame came, in seconds.
    pub time: Option<f64>,
}

/// Identifies a segment: its target, its lock, and the settings of the tracker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Key {
    target: u32,
    lock: (usize, Rect),
    /// Counts the changes of the trackers' settings.
    edition: u32,
}

struct Segment {
    key: Key,
    /// One for each frame from the lock on; `None` of a frame that was dropped.
    rows: VecDeque<Option<Row>>,
    /// The number of older rows that were dropped.
    gone: usize,
    /// The tracker refused a frame: nothing follows.
    failed: bool,
}

impl Segment {
    /// The first frame without an answer.
    fn next(&self) -> usize {
        self.key.lock.0 + self.gone + self.rows.len()
    }

    fn row(&self, frame: usize) -> Option<Row> {
        *self.rows.get(frame.checked_sub(self.key.lock.0 + self.gone)?)?
    }
}

/// The segments that are kept for undo and redo, beside those in use.
const SPARE: usize = 24;
/// A gap of at most this many frames is read; a longer one is skipped by a seek.
const READ_THROUGH: usize = 100;
/// The most rows that a segment of a camera keeps: five minutes of 60 frames a second.
const MOST_LIVE_ROWS: usize = 18_000;

struct State {
    targets: Vec<Target>,
    variant: Variant,
    edition: u32,
    segments: Vec<Segment>,
    news: News,
    /// The number of the last frame, once it was read.
    last: Option<usize>,
    /// The frame that is followed, and how many a second.
    at: Option<(usize, f64)>,
    stopped: bool,
}

/// The targets of a window and their answers.
pub struct Followed {
    state: Mutex<State>,
    changed: Condvar,
}

/// A piece of work: a segment, the frame that it waits for, and the frame where another one takes over.
#[derive(Clone, Copy)]
struct Task {
    key: Key,
    next: usize,
    end: usize,
}

impl State {
    /// The segments that the targets ask for, each with its end.
    fn plan(&self) -> impl Iterator<Item = (Key, usize)> + '_ {
        self.targets.iter().flat_map(|target| planned(target, self.edition))
    }

    fn segment(&self, key: Key) -> Option<&Segment> {
        self.segments.iter().find(|segment| segment.key == key)
    }

    fn segment_mut(&mut self, key: Key) -> Option<&mut Segment> {
        self.segments.iter_mut().find(|segment| segment.key == key)
    }

    /// What is not answered yet.
    fn tasks(&self) -> Vec<Task> {
        let last = self.last.unwrap_or(usize::MAX);
        let task = |(key, end): (Key, usize)| {
            let (next, failed) = self.segment(key).map_or((key.lock.0, false), |one| (one.next(), one.failed));
            (!failed && next < end && next <= last).then_some(Task { key, next, end })
        };
        self.plan().filter_map(task).collect()
    }

    fn row(&self, target: u32, frame: usize) -> Option<Row> {
        let target = self.targets.iter().find(|one| one.id == target)?;
        let (key, _) = planned(target, self.edition).find(|(key, end)| (key.lock.0..*end).contains(&frame))?;
        self.segment(key)?.row(frame)
    }

    /// The frames of a target that have answers, in order.
    fn rows(&self, target: &Target) -> Vec<(usize, Row)> {
        let of = |(key, end): (Key, usize)| {
            let segment = self.segment(key);
            let rows = segment.into_iter().flat_map(|one| {
                let first = one.key.lock.0 + one.gone;
                (first..).zip(&one.rows).filter_map(|(frame, row)| Some((frame, (*row)?)))
            });
            rows.take_while(move |(frame, _)| *frame < end)
        };
        planned(target, self.edition).flat_map(of).collect()
    }

    /// Tells the page again what is true of a target in these frames.
    fn tell_again(&mut self, target: u32, from: usize, to: usize) {
        self.news.add(Item::Clear { target, from, to });
        let Some(one) = self.targets.iter().find(|one| one.id == target) else { return };
        for (frame, _) in self.rows(one) {
            if (from..=to).contains(&frame) {
                self.news.add(Item::Row { target, frame });
            }
        }
    }

    /// Makes the segments that are missing, and drops the oldest of those that no target asks for.
    fn arrange(&mut self) {
        let plan: Vec<Key> = self.plan().map(|(key, _)| key).collect();
        for &key in &plan {
            match self.segments.iter().position(|segment| segment.key == key) {
                // The list is in the order of use.
                Some(at) => {
                    let segment = self.segments.remove(at);
                    self.segments.push(segment);
                }
                None => self.segments.push(Segment { key, rows: VecDeque::new(), gone: 0, failed: false }),
            }
        }
        let spare = self.segments.len().saturating_sub(plan.len() + SPARE);
        self.segments.drain(..spare);
    }

    fn everything(&self) -> Vec<Item> {
        let rows = |target: &Target| {
            let id = target.id;
            let cleared = Item::Clear { target: id, from: 1, to: usize::MAX };
            let rows: Vec<_> = self.rows(target);
            std::iter::once(cleared).chain(rows.into_iter().map(move |(frame, _)| Item::Row { target: id, frame }))
        };
        std::iter::once(Item::Frames).chain(self.targets.iter().flat_map(rows)).collect()
    }
}

/// The segments of a target, each with its end.
fn planned(target: &Target, edition: u32) -> impl Iterator<Item = (Key, usize)> + '_ {
    target.locks.iter().enumerate().map(move |(at, lock)| {
        let end = target.locks.get(at + 1).map_or(usize::MAX, |next| next.frame);
        (Key { target: target.id, lock: (lock.frame, lock.rect()), edition }, end)
    })
}

/// The first and the last frame in which two lists of locks ask for different answers.
fn differing(old: &[Lock], new: &[Lock]) -> Option<(usize, usize)> {
    let same = old.iter().zip(new).take_while(|(old, new)| old == new).count();
    let (old, new) = (&old[same..], &new[same..]);
    let from = old.iter().chain(new).map(|lock| lock.frame).min()?;
    let behind = old.iter().rev().zip(new.iter().rev()).take_while(|(old, new)| old == new).count();
    Some((from, if behind == 0 { usize::MAX } else { new[new.len() - behind].frame - 1 }))
}

impl Followed {
    pub fn new(variant: Variant, targets: Vec<Target>) -> Self {
        let state = State {
            targets,
            variant,
            edition: 0,
            segments: Vec::new(),
            news: News::default(),
            last: None,
            at: None,
            stopped: false,
        };
        let followed = Self { state: Mutex::new(state), changed: Condvar::new() };
        followed.state().arrange();
        followed
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn targets(&self) -> Vec<Target> {
        self.state().targets.clone()
    }

    pub fn variant(&self) -> Variant {
        self.state().variant.clone()
    }

    /// The answers of each target, in the order of the frames.
    pub fn rows(&self) -> Vec<(Target, Vec<(usize, Row)>)> {
        let state = self.state();
        state.targets.iter().map(|target| (target.clone(), state.rows(target))).collect()
    }

    /// Follows these targets from now on; only what changed is followed again.
    /// Errors: A box without pixels, two locks of a target in one frame, or a frame that there is not.
    pub(super) fn set_targets(&self, mut targets: Vec<Target>, frames: Option<usize>) -> Result<()> {
        for target in &mut targets {
            target.locks.sort_by_key(|lock| lock.frame);
            for (at, Lock { frame, bbox: (.., width, height) }) in target.locks.iter().enumerate() {
                let name = &target.name;
                ensure!(*width > 0 && *height > 0, "the box of {name} in frame {frame} has no pixels");
                let last = frames.unwrap_or(usize::MAX);
                ensure!((1..=last).contains(frame), "there is no frame {frame}: expected 1 to {last}");
                let twice = at > 0 && target.locks[at - 1].frame == *frame;
                ensure!(!twice, "{name} has two boxes in frame {frame}: expected one");
            }
        }
        let mut state = self.state();
        let old = std::mem::replace(&mut state.targets, targets);
        state.arrange();
        let part = |target: &Target| {
            let before = old.iter().find(|one| one.id == target.id).map_or(&[][..], |one| &one.locks);
            Some((target.id, differing(before, &target.locks)?))
        };
        let changed: Vec<_> = state.targets.iter().filter_map(part).collect();
        for (target, (from, to)) in changed {
            state.tell_again(target, from, to);
        }
        drop(state);
        self.changed.notify_all();
        Ok(())
    }

    /// Follows all again by other trackers.
    pub(super) fn set_variant(&self, variant: Variant) {
        let mut state = self.state();
        state.variant = variant;
        state.edition += 1;
        state.segments.clear();
        state.arrange();
        let ids: Vec<u32> = state.targets.iter().map(|target| target.id).collect();
        for target in ids {
            state.tell_again(target, 1, usize::MAX);
        }
        drop(state);
        self.changed.notify_all();
    }

    pub(super) fn stop(&self) {
        self.state().stopped = true;
        self.changed.notify_all();
    }

    pub(super) fn tell(&self, item: Item) {
        self.state().news.add(item);
        self.changed.notify_all();
    }

    /// Waits for something behind `position`, but not longer than `patience`. Returns the items, the position behind them, and the rows that they name.
    pub(super) fn heard(&self, position: u64, patience: Duration) -> (Vec<Item>, u64, Vec<(u32, usize, Row)>) {
        let mut state = self.state();
        let begin = Instant::now();
        while state.news.end() <= position {
            let Some(left) = patience.checked_sub(begin.elapsed()) else { break };
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        let (items, end) = state.news.since(position);
        let row = |item: &Item| match *item {
            Item::Row { target, frame } => state.row(target, frame).map(|row| (target, frame, row)),
            _ => None,
        };
        let rows = items.iter().filter_map(row).collect();
        (items, end, rows)
    }

    /// How far all targets are followed: the number of the last frame before the first that lacks an answer. While they are followed, also
    /// the frame that is read, and how many a second.
    pub(super) fn reached(&self) -> (usize, Option<(usize, f64)>) {
        let state = self.state();
        let open = state.tasks().iter().map(|task| task.next - 1).min();
        let at = open.map(|reached| state.at.unwrap_or((reached, 0.0)));
        let done = || state.plan().filter_map(|(key, end)| Some(state.segment(key)?.next().min(end) - 1)).max();
        (open.or_else(done).unwrap_or(0), at)
    }

    /// The number of the last frame, once it was read.
    pub(super) fn last(&self) -> Option<usize> {
        self.state().last
    }

    /// Follows what there is to follow, until [`Self::stop`].
    pub(super) fn run(&self, source: &dyn Source) {
        let mut trackers: HashMap<Key, Follower> = HashMap::new();
        while let Some(start) = self.wait() {
            let mut last = None;
            match source.gray_from(start) {
                Err(error) => self.ends(start - 1, Some(&error)),
                Ok(frames) => {
                    let mut pace = Pace::new();
                    let mut goes_on = true;
                    for frame in frames {
                        match frame {
                            Ok((number, time, frame)) => {
                                last = Some(number);
                                goes_on = self.frame((number, time), &frame, &mut trackers, source, pace.next());
                            }
                            Err(error) => {
                                self.ends(last.unwrap_or(start - 1), Some(&error));
                                goes_on = false;
                            }
                        }
                        if !goes_on {
                            break;
                        }
                    }
                    if goes_on {
                        self.ends(last.unwrap_or(start - 1), None);
                    }
                }
            }
            self.state().at = None;
        }
    }

    /// Waits for work. Returns the frame to begin at; `None` when it is over.
    fn wait(&self) -> Option<usize> {
        let mut state = self.state();
        loop {
            if state.stopped {
                return None;
            }
            if let Some(start) = state.tasks().iter().map(|task| task.next).min() {
                return Some(start);
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Notes that `number` is the last frame: the recording ends there, or cannot be read any further.
    fn ends(&self, number: usize, error: Option<&anyhow::Error>) {
        let mut state = self.state();
        state.last = Some(number);
        if let Some(error) = error {
            state.news.add(Item::Said(messages::of(error)));
        }
        state.news.add(Item::Frames);
        drop(state);
        self.changed.notify_all();
    }

    /// Asks the trackers that wait for this frame. False if another frame than the next one is to be read.
    fn frame(
        &self,
        (number, time): (usize, Option<f64>),
        frame: &GrayFrame,
        trackers: &mut HashMap<Key, Follower>,
        source: &dyn Source,
        rate: f64,
    ) -> bool {
        let is_live = source.live().is_some();
        let (due, variant): (Vec<Task>, Variant) = {
            let state = self.state();
            // After the lock, a tracker may skip frames of a camera.
            let waits =
                |task: &Task| task.next == number || is_live && task.key.lock.0 < task.next && task.next < number;
            let due = state.tasks().into_iter().filter(waits).collect();
            (due, state.variant.clone())
        };
        let answers: Vec<(Task, Result<Option<Answer>>)> =
            due.into_iter().map(|task| (task, answer(task.key, number, frame, trackers, &variant))).collect();
        let mut state = self.state();
        for (task, answer) in answers {
            let target = task.key.target;
            let Some(segment) = state.segment_mut(task.key) else { continue };
            let answered = match answer {
                Ok(Some((report, quality))) => {
                    let before = segment.rows.iter().rev().flatten().next().map(|row| row.shown);
                    let shown = report.target.or(before).unwrap_or_else(|| task.key.lock.1.into());
                    let next = segment.next();
                    segment.rows.extend((next..number).map(|_| None));
                    segment.rows.push_back(Some(Row { report, shown, quality, time }));
                    if is_live && segment.rows.len() > MOST_LIVE_ROWS {
                        segment.rows.pop_front();
                        segment.gone += 1;
                    }
                    Item::Row { target, frame: number }
                }
                Ok(None) => continue,
                Err(error) => {
                    segment.failed = true;
                    Item::Said(messages::of(&error))
                }
            };
            if number < task.end {
                state.news.add(answered);
            }
        }
        trackers.retain(|&key, _| state.segment(key).is_some());
        if state.news.is_full() {
            let now = state.everything();
            state.news.renew(now.into_iter());
        }
        state.at = Some((number, rate));
        let tasks = state.tasks();
        let goes_on = !state.stopped
            && !tasks.is_empty()
            && (is_live && tasks.iter().all(|task| task.next >= number || task.key.lock.0 < task.next)
                || tasks.iter().all(|task| task.next > number)
                    && tasks.iter().any(|task| task.next <= number + READ_THROUGH));
        drop(state);
        self.changed.notify_all();
        goes_on
    }

    pub(super) fn known(&self, source: &dyn Source) -> Known {
        let known = source.known();
        Known { frames: self.last().or(known.frames), ..known }
    }
}

/// What a tracker says of a frame, and of a lock how well the target can be told from what lies beside it.
type Answer = (Report, Option<Quality>);

/// The answer of a segment's tracker, which is made in the frame of the lock.
fn answer(
    key: Key,
    number: usize,
    frame: &GrayFrame,
    trackers: &mut HashMap<Key, Follower>,
    variant: &Variant,
) -> Result<Option<Answer>> {
    let locks = number == key.lock.0;
    if locks {
        trackers.insert(key, Follower::new(variant.build()?, vec![key.lock]));
    }
    let Some(tracker) = trackers.get_mut(&key) else { return Ok(None) };
    let report = tracker.step(number, frame)?;
    Ok(report.map(|report| (report, tracker.quality().filter(|_| locks))))
}

/// Frames a second, over the last half second.
struct Pace {
    begin: Instant,
    frames: u32,
    rate: f64,
}

impl Pace {
    fn new() -> Self {
        Self { begin: Instant::now(), frames: 0, rate: 0.0 }
    }

    fn next(&mut self) -> f64 {
        self.frames += 1;
        let passed = self.begin.elapsed().as_secs_f64();
        if passed > 0.5 {
            *self = Self { rate: f64::from(self.frames) / passed, ..Self::new() };
        }
        self.rate
    }
}

/// Follows `followed` on a thread of its own.
pub(super) fn start(followed: &Arc<Followed>, source: &Arc<dyn Source>) {
    let (followed, source) = (Arc::clone(followed), Arc::clone(source));
    std::thread::spawn(move || followed.run(source.as_ref()));
}

#[cfg(test)]
mod tests;
