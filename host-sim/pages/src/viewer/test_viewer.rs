//! A viewer without a page, for tests: its thread follows targets in a scene of a few frames.

use super::answers::{AnsweredFrame, Followed};
use super::model::{Lock, Target, TargetSpan};
use super::source::{Known, LiveState, Source};
use super::spans::Spans;
use anyhow::{Result, anyhow};
use smr_core::paper;
use smr_evaluation::{Follower, MethodAnswer, MethodKind, Variant};
use smr_recordings::{Frame, Frames, synthetic};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

pub const FRAMES: usize = 60;

#[derive(Default)]
pub struct Scene {
    pub read: AtomicUsize,
    pub damaged: Option<usize>,
    /// If set, the source acts as a camera whose trackers are busy: it yields only every N-th frame.
    pub every: Option<usize>,
    pub oldest: AtomicUsize,
    /// Count of frames that the source reports; 0: unknown. `given` is the last frame that it yields; 0: `FRAMES`.
    pub known: usize,
    pub given: AtomicUsize,
}

impl Source for Scene {
    fn known(&self) -> Known {
        Known { frames: Some(self.known).filter(|&known| known > 0), times: Vec::new() }
    }

    fn oldest(&self) -> usize {
        self.oldest.load(Ordering::SeqCst).max(1)
    }

    fn gray_from(&self, number: usize) -> Result<Frames> {
        let read = AtomicUsize::new(0);
        let (damaged, every) = (self.damaged, self.every.unwrap_or(1));
        self.read.fetch_add(1, Ordering::SeqCst);
        let last = Some(self.given.load(Ordering::SeqCst)).filter(|&given| given > 0).unwrap_or(FRAMES);
        Ok(Box::new((number..=last).filter(move |at| (at - number).is_multiple_of(every)).map(move |at| {
            read.fetch_add(1, Ordering::SeqCst);
            if damaged == Some(at) {
                Err(anyhow!("frame {at} is damaged"))
            } else {
                Ok(Frame::new(at, None, synthetic::frame(at - 1)))
            }
        })))
    }

    fn image(&self, _number: usize) -> Option<Arc<Vec<u8>>> {
        None
    }

    fn live(&self) -> Option<LiveState> {
        self.every.map(|_| LiveState::default())
    }
}

pub fn lock(frame: usize) -> Lock {
    Lock::new(frame, synthetic::truth(frame - 1).unwrap().to_rect())
}

pub fn target(id: u32, frames: &[usize]) -> Target {
    let locks = frames.iter().map(|&frame| lock(frame)).collect();
    Target { id, name: id.to_string(), locks, hidden: Spans::default(), checked: Spans::default() }
}

pub fn variant(kind: MethodKind) -> Variant {
    Variant::new(kind, &paper::Config::camera().into())
}

pub struct Running {
    pub followed: Arc<Followed>,
    pub scene: Arc<Scene>,
    pub position: u64,
}

impl Running {
    pub fn start(scene: Scene, targets: Vec<Target>) -> Self {
        let followed = Arc::new(Followed::new(variant(MethodKind::Paper), targets, &scene).unwrap());
        let scene = Arc::new(scene);
        let (of, from) = (Arc::clone(&followed), Arc::clone(&scene));
        thread::spawn(move || of.run(from.as_ref()));
        Self { followed, scene, position: 0 }
    }

    pub fn heard(&mut self) -> (Vec<String>, Vec<(u32, usize, AnsweredFrame)>) {
        let (mut said, mut rows) = (Vec::new(), Vec::new());
        loop {
            let is_done = self.followed.reached(None).1.is_none();
            let heard = self.followed.wait_for_changes(self.position, Duration::from_millis(20));
            if is_done && heard.position == self.position {
                return (said, rows);
            }
            self.position = heard.position;
            said.extend(heard.messages);
            let part = |part: &TargetSpan| self.part(*part);
            rows.extend(if heard.rows.is_empty() { heard.changed.iter().flat_map(part).collect() } else { heard.rows });
        }
    }

    pub fn part(&self, part: TargetSpan) -> Vec<(u32, usize, AnsweredFrame)> {
        self.followed.part(part).0.into_iter().map(|(frame, row)| (part.target, frame, row)).collect()
    }

    pub fn try_set(&self, targets: Vec<Target>) -> Result<u64> {
        self.followed.set_targets(targets, None, self.scene.as_ref())
    }

    pub fn set(&mut self, targets: Vec<Target>) -> Vec<(u32, usize, AnsweredFrame)> {
        self.try_set(targets).unwrap();
        self.heard().1
    }

    pub fn refused(&self, targets: Vec<Target>) -> String {
        self.try_set(targets).unwrap_err().to_string()
    }

    pub fn frames(&self) -> Option<usize> {
        self.followed.known(self.scene.as_ref()).frames
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.followed.stop();
    }
}

/// Returns the answers of a tracker that reads all frames in order and is locked anew in each of `frames`.
pub fn expected(kind: MethodKind, frames: &[usize]) -> Vec<(usize, MethodAnswer)> {
    let starts = frames.iter().map(|&frame| (frame, lock(frame).rect())).collect();
    let mut follower = Follower::new(variant(kind).build().unwrap(), starts);
    let answer = |number| Some((number, follower.step(number, &synthetic::frame(number - 1)).unwrap()?));
    (1..=FRAMES).filter_map(answer).collect()
}

pub fn answered(running: &Running, at: usize) -> Vec<(usize, MethodAnswer)> {
    running.followed.rows()[at].1.iter().map(|(frame, row)| (*frame, row.report)).collect()
}
