use super::*;
use crate::viewer::model::Lock;
use crate::viewer::test_viewer::{FRAMES, Running, Scene, answered, expected, lock, target, variant};
use smr_evaluation::MethodKind;
use std::sync::atomic::Ordering;

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
