//! The promises of both trackers, tested by the same code: partial frames, steps, shared workspaces, motion of the
//! camera, saved targets, misuse.

use belonging::whoever_moves_whatever_is_under_way_goes_on_with_its_own_target;

use super::checksum::Crc;
use super::record::Recorder;
use super::update::Steps;
use super::{
    Answer, ConfigError, LockError, RestoreError, SaveError, Setting, State, Target, Tracker, UpdateError, paper,
    robust,
};
use crate::similarity::Table;
use crate::{FineRect, Frame, Image, Paper, Rect, Robust};
use std::{boxed::Box, collections::BTreeSet, format, string::ToString, vec, vec::Vec};

mod belonging;

type SmallPaper = Paper<1024, 161>;

fn small_paper() -> paper::Config {
    let mut config = paper::Config::camera();
    config.window = paper::Radius { x: 12, y: 12 };
    config.growth = 8;
    // The gate is strict, so that a wrong box becomes a lost target.
    config.gate.tracking = paper::Fraction::new(5, 4);
    config.gate.lead = u16::MAX;
    config
}

const SIZE: (u16, u16) = (160, 120);
const TARGET: Rect = Rect::new(60, 45, 24, 20);

/// A frame with a target of tiles at (`x`, `y`) on a background of weaker tiles.
fn picture(x: i32, y: i32) -> Vec<u8> {
    let hash = |x: i32, y: i32, seed: u32| {
        ((x.cast_unsigned().wrapping_mul(31) ^ y.cast_unsigned().wrapping_mul(57) ^ seed).wrapping_mul(2_654_435_761)
            >> 24) as u8
    };
    let (width, height) = (i32::from(SIZE.0), i32::from(SIZE.1));
    let target = Rect { x, y, ..TARGET };
    let level = |px: i32, py: i32| {
        if target.contains(Rect::new(px, py, 1, 1)) {
            hash((px - x) / 4, (py - y) / 4, 7)
        } else {
            90 + hash(px / 9, py / 9, 3) / 5
        }
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| level(x, y)).collect()
}

fn whole(pixels: &[u8]) -> Frame<'_> {
    Frame::whole(Image::new(pixels, SIZE.0, SIZE.1).unwrap())
}

/// The frame with only the windows of the next update in memory.
fn asked_for<'a, T: Target>(frame: &Frame<'a>, target: &T) -> Frame<'a> {
    let cut = |rect: Rect| frame.patch(rect).unwrap();
    let at = |rect: Rect| (rect.x as u16, rect.y as u16);
    let window = target.window().unwrap();
    let (x, y) = at(window);
    let part = Frame::part(cut(window), x, y, SIZE.0, SIZE.1).unwrap();
    match target.sweep_window() {
        None => part,
        Some(sweep) => part.and_part(cut(sweep), at(sweep).0, at(sweep).1).unwrap(),
    }
}

/// The target is visible, hidden, elsewhere, half outside, and back.
fn frames() -> Vec<Vec<u8>> {
    let mut places = vec![(61, 41), (64, 43), (67, 44)];
    places.extend([(400, 400); 9]);
    places.extend([(15, 60); 14]);
    places.extend([(9, 60), (2, 61), (-8, 61), (-9, 62), (3, 60), (9, 58)]);
    places.into_iter().map(|(x, y)| picture(x, y)).collect()
}

fn locked<T: Target>(config: T::Config) -> Box<Tracker<T>> {
    let mut tracker = Box::new(Tracker::<T>::new(config).unwrap());
    tracker.lock(&whole(&picture(TARGET.x, TARGET.y)), TARGET).unwrap();
    tracker
}

fn answers<T: Target>(config: T::Config) -> Vec<Answer> {
    let mut tracker = locked::<T>(config);
    frames().iter().map(|pixels| tracker.update(&whole(pixels)).unwrap()).collect()
}

fn saved<T: Target>(target: &T) -> Vec<u8> {
    let mut bytes = vec![0; T::SAVED_SIZE];
    let length = target.save(&mut bytes).unwrap();
    bytes.truncate(length);
    bytes
}

/// Runs every test for both trackers, and for the robust one with its refiner where it is built in.
macro_rules! for_both {
    ($($name:ident),* $(,)?) => {
        mod paper_tracker {
            $(#[test] fn $name() { super::$name::<super::SmallPaper>(super::small_paper()); })*
        }
        mod robust_tracker {
            $(#[test] fn $name() { super::$name::<super::Robust>(super::robust::Config::robust()); })*
        }
        #[cfg(feature = "refiner")]
        mod refined_tracker {
            $(#[test] fn $name() { super::$name::<super::Robust>(super::robust::Config::refined()); })*
        }
    };
}

for_both! {
    the_scene_has_what_it_is_for,
    what_is_asked_for_is_enough,
    a_pixel_less_is_refused,
    the_answer_does_not_depend_on_how_an_update_is_cut,
    an_update_that_was_given_up_leaves_nothing_behind,
    one_workspace_serves_many_targets,
    a_step_in_a_workspace_that_served_another_is_refused,
    what_is_under_way_is_of_every_equal_target,
    an_update_does_not_outlive_the_state_that_began_it,
    a_neighbour_does_not_take_over_what_is_under_way,
    whoever_moves_whatever_is_under_way_goes_on_with_its_own_target,
    a_lock_that_is_refused_leaves_the_update_under_way,
    a_lock_in_steps_is_that_at_once,
    what_is_under_way_is_either_a_lock_or_an_update,
    a_flat_target_is_said_to_be_poor,
    a_turn_of_the_camera_is_followed,
    however_far_the_camera_turns_nothing_overflows,
    a_saved_target_goes_on_with_identical_answers,
    damaged_bytes_are_refused,
    misuse_is_an_error_and_changes_nothing,
}

fn the_scene_has_what_it_is_for<T: Target>(config: T::Config) {
    let answers = answers::<T>(config);
    let states: Vec<State> = answers.iter().map(|answer| answer.state).collect();
    assert_eq!(states[..3], [State::Tracking; 3]);
    assert!(states[3..].contains(&State::Lost), "{states:?}");
    assert_eq!(states.last(), Some(&State::Tracking), "{states:?}");
    assert_eq!(answers.iter().filter(|answer| answer.found_again).count(), 1, "{states:?}");
    for answer in answers {
        assert_eq!(answer.fine.whole(), answer.bbox);
    }
}

fn what_is_asked_for_is_enough<T: Target>(config: T::Config) {
    let mut tracker = Box::new(Tracker::<T>::new(config).unwrap());
    let first = picture(TARGET.x, TARGET.y);
    let bounds = whole(&first).bounds();
    let window = tracker.lock_window(bounds, TARGET);
    assert!(bounds.contains(window) && window.contains(TARGET));
    let part = Frame::part(whole(&first).patch(window).unwrap(), window.x as u16, window.y as u16, SIZE.0, SIZE.1);
    tracker.lock(&part.unwrap(), TARGET).unwrap();
    for (pixels, expected) in frames().iter().zip(answers::<T>(config)) {
        let frame = asked_for(&whole(pixels), tracker.target());
        assert_eq!(tracker.update(&frame).unwrap(), expected);
    }
    for outside in [Rect::new(150, 40, 24, 30), Rect::new(0, 0, 0, 5)] {
        assert!(tracker.lock_window(bounds, outside).is_empty(), "{outside:?}");
    }
}

fn a_pixel_less_is_refused<T: Target>(config: T::Config) {
    let mut tracker = locked::<T>(config);
    for pixels in &frames()[..20] {
        let frame = whole(pixels);
        let window = tracker.window().unwrap();
        let Rect { x, y, width, height } = window;
        let less = [
            Rect { x: x + 1, width: width - 1, ..window },
            Rect { y: y + 1, height: height - 1, ..window },
            Rect { width: width - 1, ..window },
            Rect { height: height - 1, ..window },
        ];
        for less in less {
            let part = Frame::part(frame.patch(less).unwrap(), less.x as u16, less.y as u16, SIZE.0, SIZE.1).unwrap();
            assert_eq!(tracker.update(&part).unwrap_err(), UpdateError::WindowNotInMemory);
        }
        if let Some(sweep) = tracker.sweep_window() {
            let only = Frame::part(frame.patch(window).unwrap(), x as u16, y as u16, SIZE.0, SIZE.1).unwrap();
            assert_eq!(tracker.update(&only).is_ok(), window.contains(sweep));
        } else {
            tracker.update(&frame).unwrap();
        }
    }
}

fn the_answer_does_not_depend_on_how_an_update_is_cut<T: Target>(config: T::Config) {
    for work in [1, 777, 50_000] {
        let (mut cut, mut dropped) = (locked::<T>(config), locked::<T>(config));
        for (pixels, expected) in frames().iter().zip(answers::<T>(config)) {
            let frame = whole(pixels);
            let mut update = cut.begin(&frame).unwrap();
            let mut before = 0;
            while !update.step(work) {
                assert!(update.work() > before, "every step makes progress");
                before = update.work();
            }
            assert_eq!(update.finish(), expected);
            let mut done = dropped.begin(&frame).unwrap().step(work);
            while !done {
                done = dropped.resume(&frame).unwrap().step(work);
            }
            assert_eq!(dropped.resume(&frame).unwrap().finish(), expected);
            assert_eq!(dropped.resume(&frame).err(), Some(UpdateError::NotBegun));
        }
    }
}

fn an_update_that_was_given_up_leaves_nothing_behind<T: Target>(config: T::Config) {
    let mut tracker = locked::<T>(config);
    let (first, elsewhere) = (picture(TARGET.x, TARGET.y), picture(75, 50));
    for (pixels, expected) in frames().iter().zip(answers::<T>(config)) {
        for work in [1, 5000, u32::MAX] {
            let before = saved(tracker.target());
            tracker.begin(&whole(&elsewhere)).unwrap().step(work);
            assert_eq!(saved(tracker.target()), before, "an unfinished update changes nothing");
        }
        assert_eq!(tracker.update(&whole(pixels)).unwrap(), expected);
    }
    tracker.begin(&whole(&elsewhere)).unwrap().step(5000);
    tracker.lock(&whole(&first), TARGET).unwrap();
    assert_eq!(tracker.resume(&whole(&elsewhere)).err(), Some(UpdateError::NotBegun));
    tracker.begin(&whole(&elsewhere)).unwrap().step(5000);
    tracker.moved(0, 0);
    assert!(tracker.resume(&whole(&elsewhere)).is_ok(), "nothing has moved");
    tracker.moved(256, 0);
    assert_eq!(tracker.resume(&whole(&elsewhere)).err(), Some(UpdateError::NotBegun));
}

fn one_workspace_serves_many_targets<T: Target>(config: T::Config) {
    let (mut own, mut one) = (locked::<T>(config), locked::<T>(config));
    let mut other = T::new(config).unwrap();
    let first = picture(TARGET.x, TARGET.y);
    let place = Rect::new(20, 20, 20, 20);
    own.lock(&whole(&first), place).unwrap();
    other.lock(one.parts().1, &whole(&first), place).unwrap();
    for (pixels, expected) in frames().iter().zip(answers::<T>(config)) {
        let frame = whole(pixels);
        assert_eq!(one.update(&frame).unwrap(), expected);
        assert_eq!(other.update(one.parts().1, &frame).unwrap(), own.update(&frame).unwrap());
    }
}

fn a_step_in_a_workspace_that_served_another_is_refused<T: Target>(config: T::Config) {
    let mut one = locked::<T>(config);
    let mut other = T::new(config).unwrap();
    let pixels = picture(62, 42);
    let frame = whole(&pixels);
    other.lock(one.parts().1, &frame, Rect::new(20, 20, 20, 20)).unwrap();
    one.begin(&frame).unwrap().step(100);
    assert_eq!(other.resume(one.parts().1, &frame).err(), Some(UpdateError::NotBegun));
    other.begin(one.parts().1, &frame).unwrap().step(100);
    assert_eq!(one.resume(&frame).err(), Some(UpdateError::NotBegun));
    other.resume(one.parts().1, &frame).unwrap().step(100);
    assert_eq!(one.update(&frame).unwrap(), locked::<T>(config).update(&frame).unwrap());
}

/// Two cameras have seen the same, so the two targets are equal, bit for bit. Either of them may continue the update.
fn what_is_under_way_is_of_every_equal_target<T: Target>(config: T::Config) {
    let (mut left, mut right) = (locked::<T>(config), locked::<T>(config));
    let (a, b) = (picture(62, 42), picture(58, 47));
    let (a, b) = (whole(&a), whole(&b));
    left.begin(&a).unwrap().step(3000);
    right.begin(&b).unwrap().step(3000);
    let crossed = [
        right.parts().0.resume(left.parts().1, &a).unwrap().finish(),
        left.parts().0.resume(right.parts().1, &b).unwrap().finish(),
    ];
    assert_eq!(crossed, [&a, &b].map(|frame| locked::<T>(config).update(frame).unwrap()));
    assert_eq!(left.resume(&a).err(), Some(UpdateError::NotBegun));
}

/// Every change of the target or workspace, and every replacement, ends the update.
fn an_update_does_not_outlive_the_state_that_began_it<T: Target>(config: T::Config) {
    let pixels = picture(62, 42);
    let frame = whole(&pixels);
    let mut other = locked::<T>(config);
    other.update(&frame).unwrap();
    let other = saved(other.target());
    type Change<T> = fn(&mut Tracker<T>, &[u8], <T as Target>::Config);
    let changes: [Change<T>; 5] = [
        |tracker, other, _| tracker.restore(other).unwrap(),
        |tracker, _, _| tracker.moved(256, 0),
        |tracker, other, config| {
            *tracker.parts().0 = T::new(config).unwrap();
            tracker.restore(other).unwrap();
        },
        |tracker, _, _| assert!(tracker.lock(&whole(&picture(TARGET.x, TARGET.y)), TARGET).is_ok()),
        |tracker, _, _| *tracker.parts().1 = T::Workspace::default(),
    ];
    for (number, change) in changes.into_iter().enumerate() {
        let mut tracker = locked::<T>(config);
        tracker.begin(&frame).unwrap().step(u32::MAX);
        change(&mut tracker, &other, config);
        assert_eq!(tracker.resume(&frame).err(), Some(UpdateError::NotBegun), "{number}");
        assert!(tracker.update(&frame).is_ok());
    }
}

/// Two targets change places. The workspace's update belongs to only one of them.
fn a_neighbour_does_not_take_over_what_is_under_way<T: Target>(config: T::Config) {
    let pixels = picture(TARGET.x, TARGET.y);
    let frame = whole(&pixels);
    let places = [Rect::new(131, 90, 27, 2), Rect::new(20, 3, 12, 57)];
    for work in [1, 100, 3000, 40_000, 3_000_000] {
        let mut workspace = Box::new(T::Workspace::default());
        let mut targets: Vec<T> = (0..2).map(|_| T::new(config).unwrap()).collect();
        for (target, place) in targets.iter_mut().zip(places) {
            target.lock(&mut workspace, &frame, place).unwrap();
        }
        targets[1].begin(&mut workspace, &frame).unwrap().step(1);
        targets[0].begin(&mut workspace, &frame).unwrap().step(work);
        targets.swap(0, 1);
        assert_eq!(targets[0].resume(&mut workspace, &frame).err(), Some(UpdateError::NotBegun));
        assert_eq!(targets[1].resume(&mut workspace, &frame).unwrap().finish().bbox, places[0]);

        targets[1].begin_lock(&mut workspace, &frame, places[1]).unwrap().step(1);
        targets[0].begin_lock(&mut workspace, &frame, places[0]).unwrap().step(work);
        let mut moved = targets.remove(0);
        assert_eq!(targets[0].resume_lock(&mut workspace, &frame).err(), Some(LockError::NotBegun));
        moved.resume_lock(&mut workspace, &frame).unwrap().finish();
        assert_eq!(moved.bbox(), Some(places[0].into()));
    }
}

fn a_lock_that_is_refused_leaves_the_update_under_way<T: Target>(config: T::Config) {
    let mut tracker = locked::<T>(config);
    let pixels = picture(62, 42);
    let frame = whole(&pixels);
    let part = Frame::part(frame.patch(Rect::new(61, 46, 5, 5)).unwrap(), 61, 46, SIZE.0, SIZE.1).unwrap();
    tracker.begin(&frame).unwrap().step(3000);
    for (frame, rect) in [(&frame, Rect::new(5, 5, 0, 7)), (&frame, Rect::new(-1, 5, 7, 7)), (&part, TARGET)] {
        assert!(tracker.lock(frame, rect).is_err());
        assert!(tracker.begin_lock(frame, rect).is_err());
    }
    assert!(tracker.restore(b"SMR").is_err());
    assert!(tracker.begin(&part).is_err());
    let answer = tracker.resume(&frame).unwrap().finish();
    assert_eq!(answer, locked::<T>(config).update(&frame).unwrap());
}

fn a_lock_in_steps_is_that_at_once<T: Target>(config: T::Config) {
    let pixels = picture(TARGET.x, TARGET.y);
    let frame = whole(&pixels);
    let at_once = locked::<T>(config);
    let quality = Tracker::<T>::new(config).unwrap().lock(&frame, TARGET).unwrap();
    for work in [0, 3000, 400_000] {
        let mut tracker = Box::new(Tracker::<T>::new(config).unwrap());
        tracker.lock(&frame, Rect::new(20, 20, 10, 10)).unwrap();
        let mut lock = tracker.begin_lock(&frame, TARGET).unwrap();
        let mut before = 0;
        while !lock.step(work) {
            assert!(lock.work() > before, "every step makes progress");
            before = lock.work();
        }
        assert_eq!(lock.finish(), quality);
        assert_eq!(saved(tracker.target()), saved(at_once.target()));

        let mut done = tracker.begin_lock(&frame, TARGET).unwrap().step(work);
        while !done {
            done = tracker.resume_lock(&frame).unwrap().step(work);
        }
        assert_eq!(tracker.resume_lock(&frame).unwrap().finish(), quality);
        assert_eq!(tracker.resume_lock(&frame).err(), Some(LockError::NotBegun));
        assert_eq!(saved(tracker.target()), saved(at_once.target()));
    }
}

fn what_is_under_way_is_either_a_lock_or_an_update<T: Target>(config: T::Config) {
    let mut tracker = locked::<T>(config);
    let pixels = picture(62, 42);
    let frame = whole(&pixels);
    tracker.begin(&frame).unwrap().step(100);
    assert_eq!(tracker.resume_lock(&frame).err(), Some(LockError::NotBegun));
    tracker.begin_lock(&frame, TARGET).unwrap().step(100);
    assert_eq!(tracker.resume(&frame).err(), Some(UpdateError::NotBegun));
    // There is no target until the lock is finished.
    assert_eq!((tracker.bbox(), tracker.state(), tracker.window()), (None, None, None));
    assert_eq!(tracker.update(&frame).err(), Some(UpdateError::NotLocked));
    assert_eq!(tracker.save(&mut []).err(), Some(SaveError::NotLocked));
    let turned = Frame::whole(Image::new(&pixels, SIZE.1, SIZE.0).unwrap());
    assert_eq!(tracker.resume_lock(&turned).err(), Some(LockError::FrameSizeChanged));
    let part = Frame::part(frame.patch(Rect::new(61, 46, 5, 5)).unwrap(), 61, 46, SIZE.0, SIZE.1).unwrap();
    assert_eq!(tracker.resume_lock(&part).err(), Some(LockError::LockWindowNotInMemory));
    tracker.resume_lock(&frame).unwrap().finish();
    assert_eq!(tracker.bbox(), Some(FineRect::from(TARGET)));
    // Another target uses the workspace; the target changes.
    let mut other = T::new(config).unwrap();
    tracker.begin_lock(&frame, TARGET).unwrap().step(100);
    other.lock(tracker.parts().1, &frame, TARGET).unwrap();
    assert_eq!(tracker.resume_lock(&frame).err(), Some(LockError::NotBegun));
    tracker.begin_lock(&frame, TARGET).unwrap().step(100);
    tracker.moved(0, 0);
    assert_eq!(tracker.resume_lock(&frame).err(), Some(LockError::NotBegun));
}

fn a_flat_target_is_said_to_be_poor<T: Target>(config: T::Config) {
    let (flat, textured) = (vec![90; 160 * 120], picture(TARGET.x, TARGET.y));
    let lock = |pixels, target| Tracker::<T>::new(config).unwrap().lock(&whole(pixels), target).unwrap();
    assert!(!lock(&textured, TARGET).is_poor(), "{:?}", lock(&textured, TARGET));
    assert_eq!([lock(&flat, TARGET), lock(&flat, Rect::new(7, 7, 1, 1))].map(|quality| quality.value()), [0, 0]);
}

fn a_turn_of_the_camera_is_followed<T: Target>(config: T::Config) {
    let mut tracker = locked::<T>(config);
    let window = tracker.window().unwrap();
    tracker.moved(30 * 256, 15 * 256);
    let moved = tracker.window().unwrap();
    assert_eq!((moved.x - window.x, moved.y - window.y), (30, 15));
    let bbox = tracker.bbox().unwrap().whole();
    assert_eq!(bbox, Rect::new(TARGET.x + 30, TARGET.y + 15, TARGET.width, TARGET.height));
    let answer = tracker.update(&whole(&picture(TARGET.x + 31, TARGET.y + 14))).unwrap();
    let off = (answer.bbox.x - TARGET.x - 31).abs().max((answer.bbox.y - TARGET.y - 14).abs());
    assert!(off <= 1 && answer.state == State::Tracking, "{answer:?}");
}

fn however_far_the_camera_turns_nothing_overflows<T: Target>(config: T::Config) {
    let mut tracker = locked::<T>(config);
    let pixels = picture(62, 42);
    for (right, down) in [(i32::MAX, i32::MAX), (i32::MIN, i32::MIN), (i32::MIN, i32::MAX), (0, i32::MIN), (127, -128)]
    {
        tracker.moved(right, down);
        tracker.moved(right, down);
        let window = tracker.window().unwrap();
        assert!(whole(&pixels).bounds().contains(window), "{window:?}");
        tracker.update(&whole(&pixels)).unwrap();
    }
    let mut empty = T::new(config).unwrap();
    empty.moved(5, 5);
    assert_eq!((empty.bbox(), empty.state()), (None, None));
}

fn a_saved_target_goes_on_with_identical_answers<T: Target>(config: T::Config) {
    let mut tracker = locked::<T>(config);
    for (pixels, expected) in frames().iter().zip(answers::<T>(config)) {
        let bytes = saved(tracker.target());
        assert!(bytes.len() <= T::SAVED_SIZE);
        // As after a loss of power: only the bytes are left.
        *tracker = Tracker::new(config).unwrap();
        tracker.restore(&bytes).unwrap();
        assert_eq!(saved(tracker.target()), bytes);
        assert_eq!(tracker.update(&whole(pixels)).unwrap(), expected);
    }
}

fn damaged_bytes_are_refused<T: Target>(config: T::Config) {
    let mut tracker = locked::<T>(config);
    let older = saved(tracker.target());
    tracker.update(&whole(&frames()[0])).unwrap();
    let bytes = saved(tracker.target());
    let mut other = locked::<T>(config);
    let before = saved(other.target());
    for length in 0..bytes.len() {
        let error = other.restore(&bytes[..length]).unwrap_err();
        assert!(matches!(error, RestoreError::Truncated | RestoreError::NotSaved), "{length}: {error:?}");
        // The power failed while it was written over an older one, or from the end on.
        for torn in
            [[&bytes[..length], &older[length..]], [&older[..length], &bytes[length..]]].map(|torn| torn.concat())
        {
            let is_whole = torn == bytes || torn == older;
            assert!(is_whole || other.restore(&torn).is_err(), "the first {length} bytes are of another target");
        }
    }
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        assert!(other.restore(&damaged).is_err(), "byte {at}");
    }
    assert_eq!(other.restore(b"something else entirely, of another program"), Err(RestoreError::NotSaved));
    assert_eq!(saved(other.target()), before, "what is refused changes nothing");
    let mut longer = bytes.clone();
    longer.push(7);
    assert_eq!(other.restore(&longer), Ok(()), "what follows in memory does not matter");
}

fn misuse_is_an_error_and_changes_nothing<T: Target>(config: T::Config) {
    let mut tracker = Box::new(Tracker::<T>::new(config).unwrap());
    let pixels = picture(TARGET.x, TARGET.y);
    let frame = whole(&pixels);
    assert_eq!(tracker.update(&frame).err(), Some(UpdateError::NotLocked));
    assert_eq!(tracker.resume(&frame).err(), Some(UpdateError::NotBegun));
    assert_eq!(tracker.resume_lock(&frame).err(), Some(LockError::NotBegun));
    assert_eq!(tracker.save(&mut [0; 64]), Err(SaveError::NotLocked));
    assert_eq!((tracker.window(), tracker.sweep_window(), tracker.bbox(), tracker.state()), (None, None, None, None));

    let mut lock = |x, y, width, height| tracker.lock(&frame, Rect::new(x, y, width, height));
    assert_eq!(lock(5, 5, 0, 7), Err(LockError::BoxEmpty));
    assert_eq!(lock(5, 5, 7, 0), Err(LockError::BoxEmpty));
    assert_eq!(lock(-1, 5, 7, 7), Err(LockError::BoxOutsideFrame));
    assert_eq!(lock(154, 5, 7, 7), Err(LockError::BoxOutsideFrame));
    assert_eq!(lock(i32::MAX, i32::MIN, u16::MAX, u16::MAX), Err(LockError::BoxOutsideFrame));
    tracker.lock(&frame, TARGET).unwrap();
    assert_eq!(tracker.state(), Some(State::Tracking));
    assert_eq!(tracker.bbox(), Some(FineRect::from(TARGET)));

    let turned = Frame::whole(Image::new(&pixels, SIZE.1, SIZE.0).unwrap());
    assert_eq!(tracker.update(&turned).err(), Some(UpdateError::FrameSizeChanged));
    assert_eq!(tracker.lock(&turned, Rect::new(100, 1, 30, 30)), Err(LockError::BoxOutsideFrame));
    let inside = Frame::part(frame.patch(Rect::new(61, 46, 5, 5)).unwrap(), 61, 46, SIZE.0, SIZE.1).unwrap();
    assert_eq!(tracker.lock(&inside, TARGET), Err(LockError::LockWindowNotInMemory));
    let (size, mut bytes) = (tracker.saved_size().unwrap(), vec![0xA5; T::SAVED_SIZE]);
    assert_eq!(tracker.save(&mut bytes[..size - 1]), Err(SaveError::BufferTooSmall));
    assert!(bytes.iter().all(|&byte| byte == 0xA5), "a save that is refused writes nothing");
    assert_eq!(tracker.save(&mut bytes), Ok(size));
    assert_eq!(tracker.update(&frame).unwrap(), locked::<T>(config).update(&frame).unwrap(), "nothing has changed");
    tracker.lock(&turned, Rect::new(10, 10, 20, 20)).unwrap();
    assert!(tracker.update(&turned).is_ok(), "locking again may change the frame's size");
}

#[test]
fn bytes_of_the_other_tracker_or_another_configuration_are_refused() {
    let bytes = saved(locked::<SmallPaper>(small_paper()).target());
    let mut robust = Robust::new(robust::Config::robust()).unwrap();
    assert_eq!(robust.restore(&bytes), Err(RestoreError::OtherTracker));
    // Backend and pruning do not matter.
    let mut slow = small_paper();
    (slow.backend, slow.pruning) = (Some(crate::similarity::Backend::Scalar), false);
    assert_eq!(SmallPaper::new(slow).unwrap().restore(&bytes), Ok(()));
    assert_eq!(Paper::<256, 161>::new(small_paper()).unwrap().restore(&bytes), Err(RestoreError::TooLarge));
    assert_eq!(Paper::<1024, 33>::new(small_paper()).unwrap().restore(&bytes), Err(RestoreError::TooLarge));
    let bytes = saved(locked::<Robust>(robust::Config::robust()).target());
    assert_eq!(SmallPaper::new(small_paper()).unwrap().restore(&bytes), Err(RestoreError::OtherTracker));
}

/// A setting's name, and a change of it.
type Change<T> = (&'static str, fn(&mut <T as Target>::Config));

/// Saves a target with `config`, and restores it with each of the `changes`. Each error must name its setting, and
/// the changes must cover all `settings`.
fn refusals_name<T: Target>(config: T::Config, settings: &[Setting], changes: &[Change<T>]) {
    let bytes = saved(locked::<T>(config).target());
    for (name, change) in changes {
        let mut other = config;
        change(&mut other);
        let mut target = T::new(other).unwrap();
        let Err(refusal @ RestoreError::OtherConfig(setting)) = target.restore(&bytes) else { panic!("{name}") };
        assert_eq!((setting.name(), target.check_saved(&bytes)), (*name, Err(refusal)));
        assert_eq!(setting.name_with_zero().strip_suffix('\0'), Some(*name));
        let text = format!("the target was saved with another configuration: {name} differs");
        assert_eq!(refusal.to_string(), text);
    }
    let names: BTreeSet<&str> = settings.iter().map(|setting| setting.name()).collect();
    assert_eq!(changes.iter().map(|(name, _)| *name).collect::<BTreeSet<_>>(), names);
}

static OTHER_TABLE: Table = match Table::new(100) {
    Ok(table) => table,
    Err(_) => panic!("in range"),
};

#[test]
fn a_refusal_names_the_setting_of_the_papers_tracker_that_differs() {
    let numbers = paper::numbers(&small_paper()).map(|(setting, _)| setting);
    let settings: Vec<_> = numbers.into_iter().chain([Setting::Table]).collect();
    refusals_name::<SmallPaper>(
        small_paper(),
        &settings,
        &[
            ("table", |of| of.table = &OTHER_TABLE),
            ("k", |of| of.k.numerator += 1),
            ("k", |of| of.k.denominator += 1),
            ("gate.tracking", |of| of.gate.tracking.numerator += 1),
            ("gate.tracking", |of| of.gate.tracking.denominator += 1),
            ("gate.leaving", |of| of.gate.leaving.numerator += 1),
            ("gate.leaving", |of| of.gate.leaving.denominator += 1),
            ("gate.returning", |of| of.gate.returning.numerator += 1),
            ("gate.returning", |of| of.gate.returning.denominator += 1),
            ("gate.lost", |of| of.gate.lost.numerator += 1),
            ("gate.lost", |of| of.gate.lost.denominator += 1),
            ("gate.lead", |of| of.gate.lead -= 1),
            ("gate.least_ratio", |of| of.gate.least_ratio += 1),
            ("first_threshold", |of| of.first_threshold += 1),
            ("least_threshold", |of| of.least_threshold += 1),
            ("padding", |of| of.padding += 1),
            ("window", |of| of.window.x -= 1),
            ("window", |of| of.window.y -= 1),
            ("growth", |of| of.growth += 1),
            ("window_limit", |of| of.window_limit.x -= 1),
            ("window_limit", |of| of.window_limit.y -= 1),
            ("neighbourhood", |of| of.neighbourhood += 1),
            ("runner_up", |of| of.runner_up = paper::RunnerUp::Always),
            ("update_zone", |of| of.update_zone.left += 1),
            ("update_zone", |of| of.update_zone.top += 1),
            ("update_zone", |of| of.update_zone.right += 1),
            ("update_zone", |of| of.update_zone.bottom += 1),
        ],
    );
}

#[test]
fn a_refusal_names_the_setting_of_the_robust_tracker_that_differs() {
    let numbers = robust::numbers(&robust::Config::robust()).map(|(setting, _)| setting);
    // Only with their features can a part be left out and the refiner be on.
    let left_out = |setting: &Setting| match setting {
        Setting::Parts => !cfg!(feature = "unstable"),
        Setting::Refiner => !cfg!(feature = "refiner"),
        _ => false,
    };
    let settings: Vec<_> = numbers.into_iter().chain([Setting::Table]).filter(|setting| !left_out(setting)).collect();
    refusals_name::<Robust>(
        robust::Config::robust(),
        &settings,
        &[
            ("table", |of| of.table = &OTHER_TABLE),
            ("size", |of| of.size = false),
            ("sweep", |of| of.sweep = false),
            #[cfg(feature = "unstable")]
            ("parts", |of| *of = crate::unstable::without(*of, robust::config::Part::GatedLearning)),
            ("reach", |of| of.reach -= 1),
            ("patience", |of| of.patience += 1),
            ("lost_below", |of| of.lost_below += 1),
            ("uncertain_below", |of| of.uncertain_below += 1),
            ("learning_rate", |of| of.learning_rate += 1),
            ("early_rate", |of| of.early_rate += 1),
            #[cfg(feature = "refiner")]
            ("refiner", |of| *of = robust::Config::refined()),
        ],
    );
}

/// Two settings differ: the first one in the order of the bytes is named.
#[test]
fn a_refusal_names_the_first_of_several() {
    let bytes = saved(locked::<Robust>(robust::Config::robust()).target());
    let mut other = robust::Config::robust();
    (other.reach, other.early_rate) = (5, 9);
    assert_eq!(Robust::new(other).unwrap().restore(&bytes), Err(RestoreError::OtherConfig(Setting::Reach)));
}

#[test]
fn the_preset_robust_is_the_same_in_every_build() {
    let mut config = robust::Config::robust();
    assert!(!config.refiner && robust::Config::default() == config);
    config.refiner = true;
    if cfg!(feature = "refiner") {
        assert_eq!(config.check(), Ok(()));
        #[cfg(feature = "refiner")]
        assert_eq!(config, robust::Config::refined());
    } else {
        assert_eq!(config.check(), Err(ConfigError::RefinerNotBuiltIn));
        config.reach = 9;
        assert_eq!(config.check(), Err(ConfigError::OutOfRange));
    }
}

/// One checksum of everything that a user can see of the preset `robust`. It is the same in builds with and without the
/// refiner.
#[test]
fn the_preset_robust_answers_the_same_in_every_build() {
    let mut sum = Crc::new();
    let mut tracker = Tracker::<Robust>::new(robust::Config::robust()).unwrap();
    let mut recorder = Recorder::begin(tracker.target(), |bytes| {
        sum.update(bytes);
        Ok::<(), ()>(())
    })
    .unwrap();
    let frames = frames();
    tracker.lock(&whole(&frames[0]), TARGET).unwrap();
    recorder.lock(tracker.target(), &whole(&frames[0]), TARGET).unwrap();
    let mut works = vec![];
    for pixels in &frames[1..] {
        recorder.window(tracker.target(), &whole(pixels)).unwrap();
        recorder.answer(&tracker.update(&whole(pixels)).unwrap()).unwrap();
        works.push(Robust::work(tracker.workspace()));
        recorder.restored(&saved(tracker.target())).unwrap();
    }
    let most = robust::Config::robust().most_work();
    assert_eq!((most.update, most.lock, most.beyond_a_step), (6_443_388, 50_467_089, 128_000));
    assert_eq!((works.iter().sum::<u32>(), sum.finish()), (137_775_022, 1_604_446_645));
}

/// A target holds no scratch memory.
#[test]
fn a_second_target_takes_no_scratch() {
    let (paper, robust) = (size_of::<SmallPaper>(), size_of::<Robust>());
    std::println!("Paper<1024, 161> {paper}, workspace {}", size_of::<paper::Workspace<1024, 161>>());
    std::println!("Robust {robust}, workspace {}", size_of::<robust::Workspace>());
    let most = 12 * 1024 + if cfg!(feature = "refiner") { 1040 } else { 0 };
    assert!(paper <= 1024 + 200 && robust <= most, "{paper} {robust}");
}
