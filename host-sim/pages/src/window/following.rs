//! Following: the answers of each target, and the thread that finds them.
//!
//! A target is locked in one or more frames. From each lock to the next one it is followed in one go: a [`Segment`]. A new correction makes one new
//! segment; the others keep their answers. Segments that are no longer wanted are kept for a while, so that undo is at once.
//!
//! The thread begins at the earliest frame that lacks an answer and reads on: a pass. All segments that wait for the frame that it is at are
//! asked. If a lock in an earlier frame comes meanwhile, it goes back there; the others wait until it is at their frame again. A pass whose
//! frames end or fail concerns the segments that waited for its next frame, and nobody else: they are tried again after a change.

use super::news::{News, Part};
use super::{Known, Source, lock};
use anyhow::{Error, Result, bail, ensure};
use serde::{Deserialize, Serialize};
use smr_core::{Quality, Rect};
use smr_evaluation::{Follower, Origin, Report, Variant};
use smr_recordings::{BoundingBox, GrayFrame, checked_name, messages};
use std::cmp::Reverse;
use std::collections::{HashMap, VecDeque};
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
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

impl Target {
    /// True of a target that shares nothing but the id: two pages have given it.
    fn is_another(&self, other: &Self) -> bool {
        self.id == other.id
            && self.name != other.name
            && !other.locks.is_empty()
            && !self.locks.iter().any(|lock| other.locks.contains(lock))
    }
}

impl Lock {
    fn rect(&self) -> Rect {
        let (x, y, width, height) = self.bbox;
        Rect { x, y, width, height }
    }
}

/// The answer for a target in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub report: Report,
    /// The box, or the last one if the target is lost.
    pub shown: BoundingBox,
    /// Only in a frame that the target was locked on.
    pub quality: Option<Quality>,
    /// Seconds at which a frame of a camera came.
    pub time: Option<f64>,
}

/// Identifies a segment: its target, its lock, and the settings of the tracker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Key {
    target: u32,
    lock: (usize, Rect),
    /// Index of the trackers' settings in [`State::editions`].
    edition: usize,
}

struct Segment {
    /// The frame of the first row: the lock's, or a later one of a camera.
    first: usize,
    /// A row for each frame, with the position of its last change, which grows from row to row; `None` of a frame that was dropped.
    rows: VecDeque<(u64, Option<Row>)>,
    /// True if the tracker refused a frame, or a camera does not keep the lock's: nothing follows.
    failed: bool,
    /// True if a pass ended before the frame that it waits for.
    in_vain: bool,
    /// The last change of the targets in which one asked for it.
    used: u64,
}

impl Segment {
    /// The first frame without an answer.
    fn next(&self) -> usize {
        self.first + self.rows.len()
    }

    /// The places of the rows of the frames from `from` on and before `end`.
    fn places(&self, from: usize, end: usize) -> Range<usize> {
        let place = |frame: usize| frame.saturating_sub(self.first).min(self.rows.len());
        place(from)..place(end).max(place(from))
    }

    /// The answers at these places, each with its frame.
    fn answers(&self, places: Range<usize>) -> impl Iterator<Item = (usize, Row)> + '_ {
        let first = self.first + places.start;
        (first..).zip(self.rows.range(places)).filter_map(|(frame, (_, row))| Some((frame, (*row)?)))
    }
}

/// The most segments that are kept for undo and redo beside those in use, and the most rows of them.
const SPARE: usize = 24;
const SPARE_ROWS: usize = 1 << 18;
/// The most answers in one reply.
const PORTION: usize = if cfg!(test) { 100 } else { 5000 };
/// A gap of at most this many frames is read; a longer one is skipped by a seek.
const READ_THROUGH: usize = 100;
/// The most rows that a segment of a camera keeps: five minutes of 60 frames a second.
const MOST_LIVE_ROWS: usize = 18_000;

struct State {
    targets: Vec<Target>,
    variant: Variant,
    /// All settings that were in use. Who goes back to one finds its answers.
    editions: Vec<Origin>,
    edition: usize,
    segments: HashMap<Key, Segment>,
    /// Counts the changes of the targets.
    changes: u64,
    news: News,
    /// The number of the last frame: it was read, and the recording is known to have no more.
    end: Option<usize>,
    /// The highest number of a frame that was read.
    seen: usize,
    /// The frame that is followed, and the number of frames a second.
    at: Option<(usize, f64)>,
    stopped: bool,
}

/// The targets of a window and their answers.
pub struct Followed {
    state: Mutex<State>,
    changed: Condvar,
}

/// A piece of work: a segment, and the frame that it waits for.
#[derive(Clone, Copy)]
struct Task {
    key: Key,
    next: usize,
}

impl Task {
    /// The tracker is locked.
    const fn has_begun(&self) -> bool {
        self.next > self.key.lock.0
    }
}

impl State {
    /// The segments that the targets ask for, each with its end.
    fn plan(&self) -> impl Iterator<Item = (Key, usize)> + '_ {
        self.targets.iter().flat_map(|target| planned(target, self.edition))
    }

    /// Returns the segments that lack answers and can get them.
    fn tasks(&self) -> Vec<Task> {
        let last = self.end.unwrap_or(usize::MAX);
        let task = |(key, end): (Key, usize)| {
            let segment = self.segments.get(&key)?;
            let next = segment.next();
            (!segment.failed && !segment.in_vain && next < end && next <= last).then_some(Task { key, next })
        };
        self.plan().filter_map(task).collect()
    }

    /// The answers of a target from one frame to another, in order.
    fn rows(&self, Part { target, from, to }: Part) -> impl Iterator<Item = (usize, Row)> + '_ {
        let target = self.targets.iter().find(move |one| one.id == target);
        let plan = target.into_iter().flat_map(|target| planned(target, self.edition));
        plan.filter_map(|(key, end)| Some((self.segments.get(&key)?, end)))
            .flat_map(move |(segment, end)| segment.answers(segment.places(from, end.min(to.saturating_add(1)))))
    }

    /// The rows that changed behind the position `since`, up to the position `to`: their target, segment and places.
    fn changed(&self, since: u64, to: u64) -> impl Iterator<Item = (u32, &Segment, Range<usize>)> {
        self.plan().filter_map(move |(key, end)| {
            let segment = self.segments.get(&key)?;
            let place = |position: u64| segment.rows.partition_point(|(at, _)| *at <= position);
            let places = place(since)..place(to).min(segment.places(0, end).end);
            (!places.is_empty()).then_some((key.target, segment, places))
        })
    }

    /// Marks all answers from `part.from` on as new. Rows behind `part.to` are marked too, so that positions still grow; no target shows them.
    fn tell_again(&mut self, part: Part) {
        self.news.void(part);
        let Self { targets, segments, news, edition, .. } = self;
        let Some(target) = targets.iter().find(|one| one.id == part.target) else { return };
        for (key, _) in planned(target, *edition).filter(|(key, _)| key.lock.0 <= part.to) {
            let Some(segment) = segments.get_mut(&key) else { continue };
            let places = segment.places(part.from, usize::MAX);
            segment.rows.range_mut(places).for_each(|row| row.0 = news.next());
        }
    }

    /// Returns the number of frames, if known.
    fn frames(&self, known: Option<usize>) -> Option<usize> {
        known.map(|known| known.max(self.seen)).or(self.end)
    }

    /// The targets with their locks in order, if all can be followed. A camera keeps the frames from `oldest` on.
    fn checked(&self, mut targets: Vec<Target>, known: Option<usize>, oldest: usize) -> Result<Vec<Target>> {
        for target in &mut targets {
            target.locks.sort_by_key(|lock| lock.frame);
            if !target.name.is_empty() {
                checked_name(&target.name)?;
            }
            let name = &target.name;
            for (at, Lock { frame, bbox: (.., width, height) }) in target.locks.iter().enumerate() {
                ensure!(*width > 0 && *height > 0, "the box of {name} in frame {frame} has no pixels");
                let last = self.frames(known).unwrap_or(usize::MAX);
                ensure!((1..=last).contains(frame), "there is no frame {frame}: expected 1 to {last}");
                let twice = at > 0 && target.locks[at - 1].frame == *frame;
                ensure!(!twice, "{name} has two boxes in frame {frame}: expected one");
            }
            // A segment that was followed already needs no old frame.
            let late =
                planned(target, self.edition).find(|(key, _)| key.lock.0 < oldest && !self.segments.contains_key(key));
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

    /// Makes the segments that are missing, lets all be tried again, and drops those that no target has asked for longest.
    fn arrange(&mut self) {
        self.changes += 1;
        let plan: Vec<Key> = self.plan().map(|(key, _)| key).collect();
        for key in plan {
            let new = || Segment { first: key.lock.0, rows: VecDeque::new(), failed: false, in_vain: false, used: 0 };
            let segment = self.segments.entry(key).or_insert_with(new);
            (segment.used, segment.in_vain) = (self.changes, false);
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

/// The segments of a target, each with its end.
fn planned(target: &Target, edition: usize) -> impl Iterator<Item = (Key, usize)> + '_ {
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

/// Changes behind a position.
pub(super) struct Heard {
    pub position: u64,
    /// The answers of these parts are void, unless they come again.
    pub void: Vec<Part>,
    /// The parts that have new answers.
    pub changed: Vec<Part>,
    /// The answers; empty if the page is to ask for them.
    pub rows: Vec<(u32, usize, Row)>,
    pub said: Vec<String>,
    pub made: Vec<u32>,
    /// True if the number of frames or their times changed.
    pub frames: bool,
    /// The targets and the number of their last change, if they changed.
    pub targets: Option<(Vec<Target>, u64)>,
}

impl Followed {
    pub fn new(variant: Variant, targets: Vec<Target>) -> Self {
        let state = State {
            targets,
            editions: vec![variant.origin()],
            variant,
            edition: 0,
            segments: HashMap::new(),
            changes: 0,
            news: News::default(),
            end: None,
            seen: 0,
            at: None,
            stopped: false,
        };
        let followed = Self { state: Mutex::new(state), changed: Condvar::new() };
        followed.state().arrange();
        followed
    }

    fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    /// Changes something and wakes all who wait for it.
    fn change<T>(&self, act: impl FnOnce(&mut State) -> T) -> T {
        let done = act(&mut self.state());
        self.changed.notify_all();
        done
    }

    pub fn targets(&self) -> Vec<Target> {
        self.state().targets.clone()
    }

    /// The targets, and the number of their last change.
    pub(super) fn revision(&self) -> (Vec<Target>, u64) {
        let state = self.state();
        (state.targets.clone(), state.news.targets)
    }

    pub fn variant(&self) -> Variant {
        self.state().variant.clone()
    }

    /// The answers of each target, in the order of the frames.
    pub fn rows(&self) -> Vec<(Target, Vec<(usize, Row)>)> {
        let state = self.state();
        state.targets.iter().map(|target| (target.clone(), state.rows(Part::all(target.id)).collect())).collect()
    }

    /// A portion of the answers of a part, and the last frame of it that they reach.
    pub(super) fn part(&self, part: Part) -> (Vec<(usize, Row)>, usize) {
        let rows: Vec<_> = self.state().rows(part).take(PORTION).collect();
        let to = rows.last().filter(|_| rows.len() == PORTION).map_or(part.to, |(frame, _)| *frame);
        (rows, to)
    }

    /// Follows these targets from now on; only what changed is followed again. `revision` is the change that they are made from, where the page
    /// names it. Returns that of these.
    /// Errors: A box without pixels, two locks of a target in one frame, a frame that there is not or that a camera does not keep, or targets
    /// that another page has changed meanwhile.
    pub(super) fn set_targets(&self, targets: Vec<Target>, revision: Option<u64>, source: &dyn Source) -> Result<u64> {
        let (known, oldest) = (source.known().frames, source.oldest());
        self.change(|state| {
            let targets = state.checked(targets, known, oldest)?;
            let others = match revision {
                Some(revision) => revision != state.news.targets,
                // The first list takes the place of the one that the window began with.
                None => {
                    state.news.targets > 0
                        && targets.iter().any(|one| state.targets.iter().any(|other| one.is_another(other)))
                }
            };
            ensure!(!others, "another page has changed the targets meanwhile: look at them, and do it again");
            if targets == state.targets {
                state.arrange();
                return Ok(state.news.targets);
            }
            let old = std::mem::replace(&mut state.targets, targets);
            state.arrange();
            state.news.targets = state.news.next();
            let part = |target: &Target| {
                let before = old.iter().find(|one| one.id == target.id).map_or(&[][..], |one| &one.locks);
                let (from, to) = differing(before, &target.locks)?;
                Some(Part { target: target.id, from, to })
            };
            let changed: Vec<_> = state.targets.iter().filter_map(part).collect();
            changed.into_iter().for_each(|part| state.tell_again(part));
            Ok(state.news.targets)
        })
    }

    /// Follows all by these trackers.
    pub(super) fn set_variant(&self, variant: Variant) {
        self.change(|state| {
            let origin = variant.origin();
            state.edition = state.editions.iter().position(|one| *one == origin).unwrap_or(state.editions.len());
            if state.edition == state.editions.len() {
                state.editions.push(origin);
            }
            state.variant = variant;
            state.arrange();
            let all: Vec<_> = state.targets.iter().map(|target| Part::all(target.id)).collect();
            all.into_iter().for_each(|part| state.tell_again(part));
        });
    }

    pub(super) fn stop(&self) {
        self.change(|state| state.stopped = true);
    }

    /// Tries again what ended too early: more is known of the source.
    pub(super) fn learns(&self, known: Option<usize>) {
        self.change(|state| {
            if known > state.end {
                state.end = None;
                state.segments.values_mut().for_each(|segment| segment.in_vain = false);
            }
            state.news.frames = state.news.next();
        });
    }

    /// Tells that a file that is made for the user has progressed.
    pub(super) fn makes(&self, id: u32) {
        self.change(|state| state.news.makes(id));
    }

    /// Waits for something behind `since`, but not longer than `patience`. If `asks`, the page asks for the answers where there are more than a
    /// portion of them; otherwise a portion comes, and the position is that behind it.
    pub(super) fn heard(&self, since: u64, patience: Duration, asks: bool) -> Heard {
        let mut state = self.state();
        let begin = Instant::now();
        while state.news.end() <= since {
            let Some(left) = patience.checked_sub(begin.elapsed()) else { break };
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        let news = &state.news;
        let heard = since;
        // A page that was away for long begins anew.
        let since = if news.remembers(since) { since.min(news.end()) } else { 0 };
        let first = state.changed(since, u64::MAX).map(|(_, segment, places)| segment.rows[places.start].0).min();
        let position = match first.filter(|_| !asks) {
            // Behind a shorter portion, parts would be void that are not remembered.
            Some(first) => news.end().min((first - 1 + PORTION as u64).max(news.forgotten)),
            None => news.end(),
        };
        let is_told = |at: u64| heard < at && at <= position;
        let changed: Vec<_> = state.changed(since, position).collect();
        let is_short = changed.iter().map(|(.., places)| places.len()).sum::<usize>() <= PORTION;
        let rows = |(target, segment, places): &(u32, &Segment, Range<usize>)| {
            let target = *target;
            segment.answers(places.clone()).map(move |(frame, row)| (target, frame, row)).collect::<Vec<_>>()
        };
        let part = |(target, segment, places): &(u32, &Segment, Range<usize>)| Part {
            target: *target,
            from: segment.first + places.start,
            to: segment.first + places.end - 1,
        };
        Heard {
            position,
            void: if news.remembers(heard) {
                news.voided(is_told)
            } else {
                state.targets.iter().map(|target| Part::all(target.id)).collect()
            },
            rows: if is_short || !asks { changed.iter().flat_map(rows).collect() } else { Vec::new() },
            changed: changed.iter().map(part).collect(),
            said: news.said(is_told),
            made: news.made(is_told),
            frames: is_told(news.frames),
            targets: is_told(news.targets).then(|| (state.targets.clone(), news.targets)),
        }
    }

    /// The number of the last frame before the first that lacks an answer. While targets are followed, also the frame that is read, and the number
    /// of frames a second.
    pub(super) fn reached(&self) -> (usize, Option<(usize, f64)>) {
        let state = self.state();
        let open = state.tasks().iter().map(|task| task.next - 1).min();
        let at = open.map(|reached| state.at.unwrap_or((reached, 0.0)));
        let done = || state.plan().filter_map(|(key, end)| Some(state.segments.get(&key)?.next().min(end) - 1)).max();
        (open.or_else(done).unwrap_or(0), at)
    }

    /// The number of the last frame before the first that lacks an answer of a target.
    pub fn answered(&self) -> usize {
        self.reached().0
    }

    /// Follows what there is to follow, until [`Self::stop`].
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

    /// The number of frames and their times, as far as the source or this thread knows them.
    pub(super) fn known(&self, source: &dyn Source) -> Known {
        let known = source.known();
        let state = self.state();
        let frames = state.frames(known.frames).filter(|_| source.live().is_none());
        Known { frames: frames.or(known.frames), ..known }
    }
}

/// The thread that reads frames and asks the trackers of the segments that wait for them.
struct Following<'a> {
    followed: &'a Followed,
    source: &'a dyn Source,
    is_live: bool,
    trackers: HashMap<Key, Follower>,
}

impl Following<'_> {
    /// Waits for work. Returns the frame to begin at; `None` when it is over.
    fn wait(&self) -> Option<usize> {
        let mut state = self.followed.state();
        loop {
            if state.stopped {
                return None;
            }
            let oldest = self.source.oldest();
            // After the lock, a tracker may skip frames of a camera.
            let (late, tasks): (Vec<Task>, _) =
                state.tasks().into_iter().partition(|task| task.next < oldest && !task.has_begun());
            for Task { key, next } in late {
                state.news.say(format!("frame {next} is not kept any more: lock in frame {oldest} or a newer one"));
                state.segments.entry(key).and_modify(|segment| segment.failed = true);
                self.followed.changed.notify_all();
            }
            if let Some(start) = tasks.iter().map(|task| task.next.max(oldest)).min() {
                return Some(start);
            }
            state = self.followed.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Reads on from a frame for as long as somebody waits for the next one. If the frames end before that: the number of the last one, and
    /// the error that ended them.
    fn pass(&mut self, start: usize) -> Option<(usize, Option<Error>)> {
        let frames = match self.source.gray_from(start) {
            Ok(frames) => frames,
            Err(error) => return Some((start - 1, Some(error))),
        };
        let (mut last, mut pace) = (start - 1, Pace::new());
        for frame in frames {
            match frame {
                Ok((number, time, frame)) => {
                    last = number;
                    if !self.frame(number, time, &frame, pace.next()) {
                        return None;
                    }
                }
                Err(error) => return Some((last, Some(error))),
            }
        }
        Some((last, None))
    }

    /// The frames of a pass from `start` on ended behind `last`. That is the recording's end only if it knows of no more.
    fn ended(&self, start: usize, last: usize, error: Option<&Error>) {
        let known = self.source.known().frames;
        self.followed.change(|state| {
            for Task { key, .. } in state.tasks().into_iter().filter(|task| task.next <= last + 1) {
                state.segments.entry(key).and_modify(|segment| segment.in_vain = true);
            }
            if let Some(error) = error {
                state.news.say(messages::of(error));
            } else if known.map_or(start == 1, |all| last >= all) {
                state.end = Some(last);
            } else if !state.stopped {
                let of = known.map_or(String::new(), |all| format!(" of {all}"));
                state.news.say(format!(
                    "there is no frame after {last}{of}: is the file still being written? Any change tries again."
                ));
            }
            state.news.frames = state.news.next();
        });
    }

    /// Asks the trackers that wait for this frame. False if another frame than the next one is to be read.
    fn frame(&mut self, number: usize, time: Option<f64>, frame: &GrayFrame, rate: f64) -> bool {
        let (followed, is_live) = (self.followed, self.is_live);
        let (mut due, variant) = {
            let state = followed.state();
            (state.tasks(), state.variant.clone())
        };
        due.retain(|task| task.next == number || is_live && task.has_begun() && task.next < number);
        let answers: Vec<_> =
            due.into_iter().map(|task| (task, self.answer(task.key, number, frame, &variant))).collect();
        followed.change(|state| {
            let State { segments, news, .. } = state;
            for (task, answer) in answers {
                let Some(segment) = segments.get_mut(&task.key).filter(|segment| segment.next() == task.next) else {
                    continue;
                };
                match answer {
                    Ok(Some((report, quality))) => {
                        let before = segment.rows.iter().rev().find_map(|(_, row)| Some((*row)?.shown));
                        let shown = report.target.or(before).unwrap_or_else(|| task.key.lock.1.into());
                        let row = Row { report, shown, quality, time };
                        segment.rows.extend((task.next..number).map(|_| (news.end(), None)));
                        segment.rows.push_back((news.next(), Some(row)));
                        if is_live && segment.rows.len() > MOST_LIVE_ROWS {
                            segment.rows.pop_front();
                            segment.first += 1;
                        }
                    }
                    Ok(None) => {}
                    Err(error) => {
                        segment.failed = true;
                        news.say(messages::of(&error));
                    }
                }
            }
            self.trackers.retain(|key, _| segments.contains_key(key));
            state.at = Some((number, rate));
            state.seen = state.seen.max(number);
            state.end = state.end.filter(|&end| number <= end);
            let tasks = state.tasks();
            !state.stopped
                && !tasks.is_empty()
                && (is_live && tasks.iter().all(|task| task.next >= number || task.has_begun())
                    || tasks.iter().all(|task| task.next > number)
                        && tasks.iter().any(|task| task.next <= number + READ_THROUGH))
        })
    }

    /// The answer of a segment's tracker, which is made in the frame of the lock, and there also the quality of the target.
    fn answer(
        &mut self,
        key: Key,
        number: usize,
        frame: &GrayFrame,
        variant: &Variant,
    ) -> Result<Option<(Report, Option<Quality>)>> {
        let locks = number == key.lock.0;
        if locks {
            self.trackers.insert(key, Follower::new(variant.build()?, vec![key.lock]));
        }
        let Some(tracker) = self.trackers.get_mut(&key) else { return Ok(None) };
        let report = tracker.step(number, frame)?;
        Ok(report.map(|report| (report, tracker.quality().filter(|_| locks))))
    }
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

#[cfg(test)]
mod tests;
