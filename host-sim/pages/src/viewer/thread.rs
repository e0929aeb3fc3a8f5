//! The thread that runs the viewer's trackers. It reads from the earliest frame that lacks an answer; after a lock in an
//! earlier frame, it starts again there. If frames end or fail, segments that need later frames wait for the next change.

use super::answers::{AnsweredFrame, Followed, Key, State, Task};
use super::source::Source;
use anyhow::{Error, Result};
use smr_core::Quality;
use smr_evaluation::{Follower, MethodAnswer, Variant};
use smr_files::messages;
use smr_recordings::{Damaged, Frame, GrayFrame};
use std::collections::HashMap;
use std::sync::PoisonError;
use std::time::Instant;

/// Longest run of unneeded frames that is read and discarded; a longer one is skipped by a seek.
const READ_THROUGH: usize = 100;
/// Largest number of trackers in memory, one for each lock; beyond it, trackers whose answers are complete are dropped.
const MAX_TRACKERS: usize = if cfg!(test) { 8 } else { 64 };
/// Largest number of answers per segment of a camera: five minutes at 60 frames a second.
const MAX_LIVE_ROWS: usize = 18_000;

impl Followed {
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
                        let row = AnsweredFrame { report, shown, quality, time };
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
    ) -> Result<Option<(MethodAnswer, Option<Quality>)>> {
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
