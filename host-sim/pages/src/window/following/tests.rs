use super::*;
use crate::window::{LiveState, Numbered};
use anyhow::anyhow;
use smr_core::paper;
use smr_evaluation::MethodKind;
use smr_recordings::synthetic;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

const FRAMES: usize = 60;

/// The first frames of the built-in recording, and how many were read.
#[derive(Default)]
struct Scene {
    read: AtomicUsize,
    /// A frame that cannot be read.
    damaged: Option<usize>,
    /// A camera gives only each of these numbers: the others came while the trackers were busy.
    every: Option<usize>,
}

impl Source for Scene {
    fn known(&self) -> Known {
        Known::default()
    }

    fn gray_from(&self, number: usize) -> Result<Numbered> {
        let read = AtomicUsize::new(0);
        let (damaged, every) = (self.damaged, self.every.unwrap_or(1));
        self.read.fetch_add(1, Ordering::SeqCst);
        Ok(Box::new((number..=FRAMES).filter(move |at| (at - number).is_multiple_of(every)).map(move |at| {
            read.fetch_add(1, Ordering::SeqCst);
            if damaged == Some(at) {
                Err(anyhow!("frame {at} is damaged"))
            } else {
                Ok((at, None, synthetic::frame(at - 1)))
            }
        })))
    }

    fn picture(&self, _number: usize) -> Option<Arc<Vec<u8>>> {
        None
    }

    fn live(&self) -> Option<LiveState> {
        self.every.map(|_| LiveState {
            oldest: 1,
            newest: FRAMES,
            dropped: 0,
            latency_ms: 0.0,
            rate: 0.0,
            has_ended: false,
        })
    }
}

fn lock(frame: usize) -> Lock {
    let Rect { x, y, width, height } = synthetic::truth(frame - 1).unwrap().to_rect().unwrap();
    Lock { frame, bbox: (x, y, width, height) }
}

fn target(id: u32, frames: &[usize]) -> Target {
    Target { id, name: id.to_string(), locks: frames.iter().map(|&frame| lock(frame)).collect() }
}

fn variant(kind: MethodKind) -> Variant {
    Variant::new(kind, &paper::Config::camera().into())
}

struct Running {
    followed: Arc<Followed>,
    scene: Arc<Scene>,
    position: u64,
}

impl Running {
    fn start(scene: Scene, targets: Vec<Target>) -> Self {
        let (followed, scene) = (Arc::new(Followed::new(variant(MethodKind::Smr), targets)), Arc::new(scene));
        let (of, from) = (Arc::clone(&followed), Arc::clone(&scene));
        thread::spawn(move || of.run(from.as_ref()));
        Self { followed, scene, position: 0 }
    }

    /// All that is told until nothing is left to follow.
    fn heard(&mut self) -> (Vec<Item>, Vec<(u32, usize, Row)>) {
        let (mut items, mut rows) = (Vec::new(), Vec::new());
        loop {
            let is_done = self.followed.reached().1.is_none();
            let (more, position, with) = self.followed.heard(self.position, Duration::from_millis(20));
            if is_done && more.is_empty() {
                return (items, rows);
            }
            self.position = position;
            items.extend(more);
            rows.extend(with);
        }
    }

    fn set(&mut self, targets: Vec<Target>) -> Vec<(u32, usize, Row)> {
        self.followed.set_targets(targets, Some(FRAMES)).unwrap();
        self.heard().1
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.followed.stop();
    }
}

/// What a command that reads the frames in order answers.
fn expected(kind: MethodKind, frames: &[usize]) -> Vec<(usize, Report)> {
    let starts = frames.iter().map(|&frame| (frame, lock(frame).rect())).collect();
    let mut follower = Follower::new(variant(kind).build().unwrap(), starts);
    let answer = |number| Some((number, follower.step(number, &synthetic::frame(number - 1)).unwrap()?));
    (1..=FRAMES).filter_map(answer).collect()
}

fn answered(running: &Running, at: usize) -> Vec<(usize, Report)> {
    running.followed.rows()[at].1.iter().map(|(frame, row)| (*frame, row.report)).collect()
}

#[test]
fn answers_are_those_of_a_run_in_order() {
    let mut running = Running::start(Scene::default(), vec![target(1, &[1]), target(2, &[5, 30])]);
    let (items, rows) = running.heard();
    assert_eq!(rows.len(), FRAMES + FRAMES - 4);
    assert_eq!(answered(&running, 0), expected(MethodKind::Smr, &[1]));
    assert_eq!(answered(&running, 1), expected(MethodKind::Smr, &[5, 30]));
    assert!(rows[0].2.quality.is_some() && rows[2].2.quality.is_none());
    assert_eq!((running.followed.last(), running.followed.reached()), (Some(FRAMES), (FRAMES, None)));
    assert!(items.contains(&Item::Frames));
    assert_eq!(running.scene.read.load(Ordering::SeqCst), 1);
}

#[test]
fn a_correction_is_followed_again_alone_and_undone_at_once() {
    let mut running = Running::start(Scene::default(), vec![target(1, &[1]), target(2, &[2])]);
    running.heard();
    let rows = running.set(vec![target(1, &[1, 20, 40]), target(2, &[2])]);
    assert_eq!(
        rows.iter().map(|row| (row.0, row.1)).collect::<Vec<_>>(),
        (20..=60).map(|frame| (1, frame)).collect::<Vec<_>>()
    );
    assert_eq!(answered(&running, 0), expected(MethodKind::Smr, &[1, 20, 40]));
    // Only the part between its neighbours: frames 20 to 39.
    let reads = running.scene.read.load(Ordering::SeqCst);
    let rows = running.set(vec![target(1, &[1, 40]), target(2, &[2])]);
    assert_eq!((rows.len(), rows[0].1, rows[19].1), (20, 20, 39));
    assert_eq!(answered(&running, 0), expected(MethodKind::Smr, &[1, 40]));
    running.set(vec![target(1, &[1, 20, 40]), target(2, &[2])]);
    assert_eq!(answered(&running, 0), expected(MethodKind::Smr, &[1, 20, 40]));
    assert_eq!(running.scene.read.load(Ordering::SeqCst), reads, "nothing is read again");
    assert_eq!(running.set(vec![target(2, &[2])]).len(), 0);
    assert_eq!(answered(&running, 0), expected(MethodKind::Smr, &[2]));
}

#[test]
fn other_trackers_follow_all_again() {
    let mut running = Running::start(Scene::default(), vec![target(1, &[3])]);
    running.heard();
    running.followed.set_variant(variant(MethodKind::Robust));
    let (items, _) = running.heard();
    assert!(items.contains(&Item::Clear { target: 1, from: 1, to: usize::MAX }));
    assert_eq!(answered(&running, 0), expected(MethodKind::Robust, &[3]));
}

#[test]
fn what_cannot_be_is_refused_and_nothing_changes() {
    let running = Running::start(Scene::default(), vec![]);
    let mut empty = target(1, &[1]);
    empty.locks[0].bbox.2 = 0;
    let set = |target: Target| running.followed.set_targets(vec![target], Some(FRAMES)).unwrap_err().to_string();
    assert_eq!(set(empty), "the box of 1 in frame 1 has no pixels");
    assert_eq!(set(target(1, &[4, 4])), "1 has two boxes in frame 4: expected one");
    let mut late = target(1, &[1]);
    late.locks[0].frame = FRAMES + 1;
    assert_eq!(set(late), "there is no frame 61: expected 1 to 60");
    assert!(running.followed.targets().is_empty());
}

#[test]
fn a_box_that_is_refused_and_damage_are_said() {
    let mut outside = target(1, &[1]);
    outside.locks[0].bbox.0 = -500;
    let scene = Scene { damaged: Some(21), ..Scene::default() };
    let mut running = Running::start(scene, vec![outside, target(2, &[1])]);
    let (items, _) = running.heard();
    let said: Vec<_> =
        items.iter().filter_map(|item| if let Item::Said(said) = item { Some(said) } else { None }).collect();
    assert!(said.len() == 2 && said[0].starts_with("frame 1: the box -500,"), "{said:?}");
    assert_eq!(said[1], "frame 21 is damaged");
    assert_eq!((answered(&running, 0).len(), answered(&running, 1).len()), (0, 20));
    assert_eq!(running.followed.last(), Some(20));
}

#[test]
fn frames_of_a_camera_may_be_dropped() {
    let mut running = Running::start(Scene { every: Some(3), ..Scene::default() }, vec![target(1, &[1])]);
    let (_, rows) = running.heard();
    assert_eq!(rows.iter().map(|row| row.1).collect::<Vec<_>>(), (1..=FRAMES).step_by(3).collect::<Vec<_>>());
    assert_eq!(answered(&running, 0).len(), FRAMES / 3);
}

#[test]
fn what_differs_between_two_lists_of_locks() {
    let locks = |frames: &[usize]| frames.iter().map(|&frame| lock(frame)).collect::<Vec<_>>();
    let part = |old: &[usize], new: &[usize]| differing(&locks(old), &locks(new));
    assert_eq!(part(&[1, 9], &[1, 9]), None);
    assert_eq!(part(&[], &[3]), Some((3, usize::MAX)));
    assert_eq!(part(&[1, 9], &[1, 5, 9]), Some((5, 8)));
    assert_eq!(part(&[1, 5, 9], &[1, 9]), Some((5, 8)));
    assert_eq!(part(&[1, 9], &[1]), Some((9, usize::MAX)));
    assert_eq!(part(&[2, 9], &[1, 9]), Some((1, 8)));
    let mut moved = locks(&[1, 5, 9]);
    moved[1].bbox.0 += 1;
    assert_eq!(differing(&locks(&[1, 5, 9]), &moved), Some((5, 8)));
}
