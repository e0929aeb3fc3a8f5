use super::*;
use crate::viewer::LiveState;
use anyhow::anyhow;
use smr_core::paper;
use smr_evaluation::MethodKind;
use smr_recordings::{Frames, synthetic};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

const FRAMES: usize = 60;

#[derive(Default)]
struct Scene {
    read: AtomicUsize,
    damaged: Option<usize>,
    /// If set, the source acts as a camera whose trackers are busy: it yields only every N-th frame.
    every: Option<usize>,
    oldest: AtomicUsize,
    /// Count of frames that the source reports; 0: unknown. `given` is the last frame that it yields; 0: `FRAMES`.
    known: usize,
    given: AtomicUsize,
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

    fn picture(&self, _number: usize) -> Option<Arc<Vec<u8>>> {
        None
    }

    fn live(&self) -> Option<LiveState> {
        self.every.map(|_| LiveState::default())
    }
}

fn lock(frame: usize) -> Lock {
    Lock::new(frame, synthetic::truth(frame - 1).unwrap().to_rect())
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
        let followed = Arc::new(Followed::new(variant(MethodKind::Paper), targets, &scene).unwrap());
        let scene = Arc::new(scene);
        let (of, from) = (Arc::clone(&followed), Arc::clone(&scene));
        thread::spawn(move || of.run(from.as_ref()));
        Self { followed, scene, position: 0 }
    }

    fn heard(&mut self) -> (Vec<String>, Vec<(u32, usize, Row)>) {
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

    fn part(&self, part: TargetSpan) -> Vec<(u32, usize, Row)> {
        self.followed.part(part).0.into_iter().map(|(frame, row)| (part.target, frame, row)).collect()
    }

    fn try_set(&self, targets: Vec<Target>) -> Result<u64> {
        self.followed.set_targets(targets, None, self.scene.as_ref())
    }

    fn set(&mut self, targets: Vec<Target>) -> Vec<(u32, usize, Row)> {
        self.try_set(targets).unwrap();
        self.heard().1
    }

    fn refused(&self, targets: Vec<Target>) -> String {
        self.try_set(targets).unwrap_err().to_string()
    }

    fn frames(&self) -> Option<usize> {
        self.followed.known(self.scene.as_ref()).frames
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.followed.stop();
    }
}

/// Returns the answers of a tracker that reads all frames in order and is locked anew in each of `frames`.
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
    let (_, rows) = running.heard();
    assert_eq!(rows.len(), FRAMES + FRAMES - 4);
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[1]));
    assert_eq!(answered(&running, 1), expected(MethodKind::Paper, &[5, 30]));
    let quality = |at: usize| rows.iter().find(|row| (row.0, row.1) == (1, at)).unwrap().2.quality;
    assert!(quality(1).is_some() && quality(2).is_none());
    assert_eq!((running.frames(), running.followed.reached(None)), (Some(FRAMES), (FRAMES, None)));
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
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[1, 20, 40]));
    // Removing the lock in frame 20 restores stored answers: only frames 20 to 39 change; nothing is tracked again.
    let reads = running.scene.read.load(Ordering::SeqCst);
    let rows = running.set(vec![target(1, &[1, 40]), target(2, &[2])]);
    assert_eq!((rows.len(), rows[0].1, rows[19].1), (20, 20, 39));
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[1, 40]));
    running.set(vec![target(1, &[1, 20, 40]), target(2, &[2])]);
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[1, 20, 40]));
    assert_eq!(running.scene.read.load(Ordering::SeqCst), reads, "nothing is read again");
    assert_eq!(running.set(vec![target(2, &[2])]).len(), 0);
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[2]));
}

#[test]
fn a_target_that_is_gone_has_no_answers_until_its_next_box() {
    let gone = |frames: &[usize]| {
        let mut gone = target(1, frames);
        gone.locks[1].bbox = None;
        gone
    };
    let mut running = Running::start(Scene::default(), vec![target(1, &[1])]);
    running.heard();
    let reads = running.scene.read.load(Ordering::SeqCst);
    let rows = running.set(vec![gone(&[1, 20, 40])]);
    assert_eq!(rows.iter().map(|row| row.1).collect::<Vec<_>>(), (40..=FRAMES).collect::<Vec<_>>());
    let both = [&expected(MethodKind::Paper, &[1])[..19], &expected(MethodKind::Paper, &[40])].concat();
    assert_eq!(answered(&running, 0), both);
    assert_eq!(running.scene.read.load(Ordering::SeqCst), reads + 1, "one read, from its next box on");
    running.set(vec![gone(&[1, 20])]);
    assert_eq!((answered(&running, 0).len(), running.followed.reached(None)), (19, (FRAMES, None)));
    running.set(vec![target(1, &[1])]);
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[1]), "undo");
    let lock = |text| serde_json::from_str::<Lock>(text);
    assert!(lock(r#"{"frame":2,"box":null}"#).unwrap().bbox.is_none() && lock(r#"{"frame":2}"#).is_err());
}

#[test]
fn trackers_of_many_locks_are_not_kept_and_what_needs_one_again_begins_anew() {
    let dense: Vec<usize> = (1..=20).collect();
    let mut running = Running::start(Scene::default(), vec![target(1, &dense)]);
    running.heard();
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &dense));
    running.set(vec![target(1, &[1, 15])]);
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[1, 15]));
}

#[test]
fn other_trackers_follow_all_again() {
    let mut running = Running::start(Scene { known: FRAMES, ..Scene::default() }, vec![target(1, &[3])]);
    running.heard();
    let position = running.position;
    running.followed.set_variant(variant(MethodKind::Robust));
    running.heard();
    assert_eq!(running.followed.wait_for_changes(position, Duration::ZERO).void, [TargetSpan::all(1)]);
    assert_eq!(answered(&running, 0), expected(MethodKind::Robust, &[3]));
    let reads = running.scene.read.load(Ordering::SeqCst);
    running.followed.set_variant(variant(MethodKind::Paper));
    assert_eq!(running.heard().1.len(), FRAMES - 2, "the answers of before are there at once");
    assert_eq!(running.scene.read.load(Ordering::SeqCst), reads);
}

#[test]
fn what_cannot_be_is_refused_and_nothing_changes() {
    let running = Running::start(Scene { known: FRAMES, ..Scene::default() }, vec![]);
    let mut empty = target(1, &[1]);
    empty.locks[0].bbox = Some((1, 1, 0, 5));
    let mut late = target(1, &[1]);
    late.locks[0].frame = FRAMES + 1;
    let (mut never, mut again) = (target(1, &[4]), target(1, &[1, 4, 9]));
    never.locks[0].bbox = None;
    again.locks[1..].iter_mut().for_each(|lock| lock.bbox = None);
    for (targets, said) in [
        (vec![never], "1 is gone in frame 4 before its first box: expected a box in an earlier frame"),
        (vec![again], "1 is gone from frame 4 on, and again in frame 9: expected a box between"),
        (vec![empty], "the box of 1 in frame 1 has no pixels"),
        (vec![target(1, &[4, 4])], "1 has two boxes in frame 4: expected one"),
        (vec![late], "there is no frame 61: expected 1 to 60"),
        (vec![target(3, &[1]), target(3, &[2])], "two targets have the id 3: expected one"),
    ] {
        assert_eq!(running.refused(targets), said);
    }
    assert!(running.followed.targets().is_empty());
}

#[test]
fn a_box_that_is_refused_and_damage_are_said_and_concern_only_who_waited() {
    let mut outside = target(1, &[1]);
    outside.locks[0].bbox = Some((-500, 1, 24, 28));
    let scene = Scene { damaged: Some(21), known: FRAMES, ..Scene::default() };
    let mut running = Running::start(scene, vec![outside, target(2, &[1])]);
    let (said, _) = running.heard();
    assert!(said.len() == 2 && said[0].starts_with("frame 1: the box -500,"), "{said:?}");
    assert_eq!(said[1], "frame 21 is damaged");
    assert_eq!((answered(&running, 0).len(), answered(&running, 1).len()), (0, 20));
    assert_eq!((running.frames(), running.followed.reached(None)), (Some(FRAMES), (20, None)));
    assert_eq!(running.followed.silent(), [(1, 1, 1), (2, 1, 21)]);
    running.set(vec![target(2, &[1, 30])]);
    assert_eq!(answered(&running, 0).len(), 20 + FRAMES - 29);
    assert_eq!(running.followed.silent(), [(2, 1, 21)], "the answers from frame 30 on are whole");
}

#[test]
fn the_end_of_a_read_is_not_the_end_of_the_recording() {
    for known in [0, FRAMES] {
        let scene = Scene { known, given: 20.into(), ..Scene::default() };
        let mut running = Running::start(scene, vec![target(1, &[5])]);
        let (said, _) = running.heard();
        assert!(said.iter().all(|said| said.starts_with("there is no frame after 20")) && said.len() == 1, "{said:?}");
        assert_eq!(answered(&running, 0).len(), 16);
        assert_eq!(running.frames(), Some(known).filter(|&known| known > 0));
        running.scene.given.store(FRAMES, Ordering::SeqCst);
        running.set(vec![target(1, &[5]), target(2, &[50])]);
        assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[5]), "a later read goes further");
        assert_eq!(answered(&running, 1), expected(MethodKind::Paper, &[50]));
    }
    // If a recording grows, tracking continues once the source knows more frames.
    let mut running = Running::start(Scene { given: 20.into(), ..Scene::default() }, vec![target(1, &[1])]);
    running.heard();
    assert_eq!(running.frames(), Some(20));
    running.scene.given.store(FRAMES, Ordering::SeqCst);
    running.followed.learns(Some(FRAMES));
    running.heard();
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[1]));
}

/// The length of a recording may be known only once it has been read, or its frames have been counted.
#[test]
fn a_lock_behind_the_end_is_said_once_the_length_is_known() {
    let behind = |id, frame| Target { locks: vec![lock(1), Lock { frame, ..lock(1) }], ..target(id, &[]) };
    let mut running = Running::start(Scene::default(), vec![behind(1, 99), behind(2, 200)]);
    running.heard();
    assert_eq!(running.followed.reached(None), (FRAMES, None));
    let beyond = |known| running.followed.beyond(known);
    let said = |last: usize| Some(format!("there is no frame 200 for 2: expected 1 to {last}"));
    assert_eq!((beyond(None), beyond(Some(FRAMES))), (said(FRAMES), None));
    let followed = Followed::new(variant(MethodKind::Paper), vec![behind(1, 99)], &Scene::default()).unwrap();
    assert_eq!([None, Some(0), Some(99)].map(|known| followed.beyond(known)), [None, None, None]);
    assert_eq!(followed.beyond(Some(98)), Some("there is no frame 99 for 1: expected 1 to 98".to_owned()));
}

#[test]
fn a_page_asks_for_many_answers_by_parts() {
    let targets: Vec<_> = (1..=4).map(|id| target(id, &[1])).collect();
    let mut running = Running::start(Scene::default(), targets);
    let (_, rows) = running.heard();
    assert_eq!(rows.len(), 4 * FRAMES, "each answer once");
    let all = running.followed.wait_for_changes(0, Duration::ZERO);
    assert_eq!((all.rows.len(), all.changed.len(), all.position), (0, 4, running.position));
    running.followed.tell(|log| log.log_progress(7));
    let next = running.followed.wait_for_changes(all.position, Duration::ZERO);
    assert_eq!((all.made.len(), next.made, next.changed.len()), (0, vec![7], 0), "each change is told once");
    assert_eq!(all.changed[3], TargetSpan { target: 4, from: 1, to: FRAMES });
    let (rows, to) = running.followed.part(TargetSpan { target: 4, from: 50, to: usize::MAX });
    assert_eq!((rows.len(), rows[0].0, to), (FRAMES - 49, 50, usize::MAX));
    // A page that has not polled for long reloads everything.
    for turn in 0..1100 {
        running.try_set(vec![target(1, if turn % 2 == 0 { &[1, 30] } else { &[1] }), target(2, &[1])]).unwrap();
    }
    running.heard();
    let anew = running.followed.wait_for_changes(all.position, Duration::ZERO);
    assert!((anew.void, anew.rows.len()) == (vec![TargetSpan::all(1), TargetSpan::all(2)], 0));
    assert_eq!(anew.changed.iter().map(|part| running.part(*part).len()).sum::<usize>(), 2 * FRAMES);
}

#[test]
fn a_camera_restores_what_was_and_goes_on_from_what_it_keeps() {
    let scene = Scene { every: Some(1), known: FRAMES, given: 20.into(), ..Scene::default() };
    let mut running = Running::start(scene, vec![target(1, &[1]), target(2, &[2])]);
    running.heard();
    running.set(vec![target(1, &[1, 15])]);
    running.scene.oldest.store(30, Ordering::SeqCst);
    running.scene.given.store(40, Ordering::SeqCst);
    // Undo restores the earlier answers; tracking continues at the oldest kept frame.
    running.set(vec![target(1, &[1]), target(2, &[2])]);
    let frames = |at: usize| answered(&running, at).iter().map(|(frame, _)| *frame).collect::<Vec<_>>();
    let expected: Vec<_> = (1..=20).chain(30..=40).collect();
    assert_eq!((frames(0), frames(1)), (expected.clone(), expected[1..].to_vec()));
    assert_eq!(
        running.refused(vec![target(1, &[3])]),
        "frame 3 of 60: trackers can go back to frame 30 only: lock in a newer frame"
    );
    // After a change of method, only targets locked in a frame that is no longer kept fail.
    running.followed.set_variant(variant(MethodKind::Robust));
    let (said, _) = running.heard();
    assert!(said.iter().any(|said| said.starts_with("frame 1 is not kept any more")), "{said:?}");
    running.set(vec![target(1, &[1]), target(2, &[2]), target(3, &[35])]);
    assert_eq!([0, 1, 2].map(|at| answered(&running, at).len()), [0, 0, 6]);
    running.followed.set_variant(variant(MethodKind::Paper));
    running.heard();
    assert_eq!(answered(&running, 0).len(), expected.len());
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
    for (old, new, part) in [
        (&[1, 9][..], &[1, 9][..], None),
        (&[], &[3], Some((3, usize::MAX))),
        (&[1, 9], &[1, 5, 9], Some((5, 8))),
        (&[1, 5, 9], &[1, 9], Some((5, 8))),
        (&[1, 9], &[1], Some((9, usize::MAX))),
        (&[2, 9], &[1, 9], Some((1, 8))),
    ] {
        assert_eq!(differing(&locks(old), &locks(new)), part, "{old:?} {new:?}");
    }
    let mut moved = locks(&[1, 5, 9]);
    moved[1].bbox = None;
    assert_eq!(differing(&locks(&[1, 5, 9]), &moved), Some((5, 8)));
}
