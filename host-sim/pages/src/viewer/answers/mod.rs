//! The answers of all targets: a [`Segment`] holds a target's answers from one lock (a box that the user drew) to the
//! next. A correction creates one segment; unused segments are kept for undo.

mod change_log;
mod segment;
mod state;

pub use segment::AnsweredFrame;
pub(super) use segment::{Key, Task};
pub(super) use state::State;

use super::lock;
use super::model::{Target, TargetSpan, differing};
use super::source::{Known, Source};
use super::spans::Spans;
use anyhow::{Context, Result, ensure};
use change_log::ChangeLog;
use segment::Segment;
use smr_evaluation::Variant;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

const PORTION: usize = if cfg!(test) { 100 } else { 5000 };

pub struct Followed {
    state: Mutex<State>,
    pub(super) changed: Condvar,
}

/// Changes of targets, answers, messages, files and frames after a position in the change log, for a page that polls.
pub(super) struct Changes {
    pub position: u64,
    /// Frame ranges whose answers the page discards before it stores `rows`.
    pub void: Vec<TargetSpan>,
    pub changed: Vec<TargetSpan>,
    /// New answers; empty if there are too many: the page then requests the ranges in `changed`.
    pub rows: Vec<(u32, usize, AnsweredFrame)>,
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

    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    pub(super) fn change<T>(&self, act: impl FnOnce(&mut State) -> T) -> T {
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

    pub fn rows(&self) -> Vec<(Target, Vec<(usize, AnsweredFrame)>)> {
        let state = self.state();
        state.targets.iter().map(|target| (target.clone(), state.rows(TargetSpan::all(target.id)).collect())).collect()
    }

    /// Returns at most [`PORTION`] answers of a frame range, and the last frame that they cover.
    pub(super) fn part(&self, part: TargetSpan) -> (Vec<(usize, AnsweredFrame)>, usize) {
        let rows: Vec<_> = self.state().rows(part).take(PORTION).collect();
        let to = rows.last().filter(|_| rows.len() == PORTION).map_or(part.to, |(frame, _)| *frame);
        (rows, to)
    }

    /// Replaces the targets, tracks only changed frame ranges again, and returns the new revision; `revision` is the
    /// latest that the page has seen. Errors: A box without pixels, two locks of a target in one frame, a "gone" lock
    /// before a target's first box or directly after another "gone" lock, a new lock in a frame that does not exist or
    /// is no longer kept, an invalid name, two targets with one id or name, or targets that another page has changed.
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

    /// Records that the user has looked at a target in these frames. No page is told: answers stay the same. Errors: There
    /// is no such target.
    pub(super) fn checks(&self, target: u32, frames: Spans) -> Result<()> {
        let mut state = self.state();
        let of = state.targets.iter_mut().find(|one| one.id == target);
        of.with_context(|| format!("there is no target {target}: it was removed"))?.checked.add(frames);
        Ok(())
    }

    pub(super) fn set_variant(&self, variant: Variant) {
        self.change(|state| {
            let origin = variant.origin();
            if origin != state.variant.origin() {
                // Nobody has looked at the boxes that are still to come.
                state.targets.iter_mut().for_each(|target| target.checked = Spans::default());
            }
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

    /// Returns the last frame up to `frames` that the user has looked at and that is still to be followed.
    pub(super) fn awaited(&self, frames: usize) -> Option<usize> {
        let state = self.state();
        let ends: HashMap<Key, usize> = state.plan().collect();
        let last = |Task { key, next }: Task| {
            let target = state.targets.iter().find(|target| target.id == key.target)?;
            target.checked.last_to(frames.min(ends[&key] - 1)).filter(|last| *last >= next)
        };
        state.tasks().into_iter().filter(|_| !state.stopped).filter_map(last).max()
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

    /// Returns the count of frames and their times, as far as the source or the tracking thread knows them.
    pub(super) fn known(&self, source: &dyn Source) -> Known {
        let known = source.known();
        let state = self.state();
        let frames = state.frames(known.frames).filter(|_| source.live().is_none());
        Known { frames: frames.or(known.frames), ..known }
    }
}

#[cfg(test)]
mod tests;
