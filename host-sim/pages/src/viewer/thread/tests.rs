use crate::viewer::test_viewer::{FRAMES, Running, Scene, answered, expected, target, variant};
use smr_evaluation::MethodKind;
use std::sync::atomic::Ordering;

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
fn trackers_of_many_locks_are_not_kept_and_what_needs_one_again_begins_anew() {
    let dense: Vec<usize> = (1..=20).collect();
    let mut running = Running::start(Scene::default(), vec![target(1, &dense)]);
    running.heard();
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &dense));
    running.set(vec![target(1, &[1, 15])]);
    assert_eq!(answered(&running, 0), expected(MethodKind::Paper, &[1, 15]));
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
