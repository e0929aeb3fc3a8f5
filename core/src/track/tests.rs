//! Tests of all trackers by the same code: promises, camera motion, damaged bytes, misuse, settings, memory.

mod promises;
mod refused;
mod shared;

use super::checksum::Crc;
use super::record::{Recorder, replay};
use super::settings::recorded;
use super::update::Steps;
use super::{
    Answer, ConfigError, LockError, RestoreError, SaveError, Settings, Shape, State, Target, Tracker, UpdateError,
    paper, robust,
};
use crate::robust::{Small, Standard};
use crate::similarity::Table;
use crate::{FineRect, Frame, Image, Paper, Rect, Robust};
use core::fmt::Debug;
use promises::{promises_hold_at_the_edges, promises_hold_in_films};
use refused::refused_calls_change_nothing_between_steps;
use shared::{a_shared_workspace_costs_no_step, no_target_continues_the_call_of_another};
use std::{boxed::Box, string::ToString, vec, vec::Vec};

type SmallPaper = Paper<1024, 161>;
type SmallRobust = Robust<Small>;

fn small_paper() -> paper::Config {
    let mut config = paper::Config::camera();
    config.window = paper::Radius { x: 12, y: 12 };
    config.growth = 8;
    // A strict gate: the tracker reports a lost target rather than a wrong box.
    config.gate_tracking = paper::Fraction::new(5, 4);
    config.gate_lead = u16::MAX;
    config
}

const SIZE: (u16, u16) = (160, 120);
const TARGET: Rect = Rect::new(60, 45, 24, 20);

/// A frame with a target at (`x`, `y`) of random gray 4x4 tiles, on a background of 9x9 tiles with a fifth of the
/// contrast.
fn picture(x: i32, y: i32) -> Vec<u8> {
    let hash = |x: i32, y: i32, seed: u32| {
        ((x.cast_unsigned().wrapping_mul(31) ^ y.cast_unsigned().wrapping_mul(57) ^ seed).wrapping_mul(2_654_435_761)
            >> 24) as u8
    };
    let target = Rect { x, y, ..TARGET };
    drawn(SIZE, |px, py| {
        if target.contains(Rect::new(px, py, 1, 1)) {
            hash((px - x) / 4, (py - y) / 4, 7)
        } else {
            90 + hash(px / 9, py / 9, 3) / 5
        }
    })
}

pub(super) fn drawn((width, height): (u16, u16), mut level: impl FnMut(i32, i32) -> u8) -> Vec<u8> {
    (0..height.into()).flat_map(|y| (0..width.into()).map(move |x| (x, y))).map(|(x, y)| level(x, y)).collect()
}

pub(super) fn of_size(pixels: &[u8], (width, height): (u16, u16)) -> Frame<'_> {
    Frame::whole(Image::new(pixels, width, height).unwrap())
}

fn whole(pixels: &[u8]) -> Frame<'_> {
    of_size(pixels, SIZE)
}

pub(super) fn cut<'a>(frame: &Frame<'a>, window: Rect) -> Frame<'a> {
    let Rect { width, height, .. } = frame.bounds();
    Frame::part(frame.patch(window).unwrap(), window.x as u16, window.y as u16, width, height).unwrap()
}

/// The frame with only the windows of the next update in memory.
pub(super) fn asked_for<'a, T: Target>(frame: &Frame<'a>, target: &T) -> Frame<'a> {
    let part = cut(frame, target.window().unwrap());
    let Some(sweep) = target.sweep_window() else { return part };
    part.and_part(frame.patch(sweep).unwrap(), sweep.x as u16, sweep.y as u16).unwrap()
}

/// Frames in which the target is visible, hidden, elsewhere, half outside, and back.
fn frames() -> Vec<Vec<u8>> {
    let mut places = vec![(61, 41), (64, 43), (67, 44)];
    places.extend([(400, 400); 9]);
    places.extend([(15, 60); 14]);
    places.extend([(9, 60), (2, 61), (-8, 61), (-9, 62), (3, 60), (9, 58)]);
    places.into_iter().map(|(x, y)| picture(x, y)).collect()
}

pub(super) fn locked<T: Target>(config: T::Config, frame: &Frame<'_>, target: Rect) -> Box<Tracker<T>> {
    let mut tracker = Box::new(Tracker::<T>::with(config).unwrap());
    tracker.lock(frame, target).unwrap();
    tracker
}

fn of_scene<T: Target>(config: T::Config) -> Box<Tracker<T>> {
    locked(config, &whole(&picture(TARGET.x, TARGET.y)), TARGET)
}

fn saved<T: Target>(target: &T) -> Vec<u8> {
    let mut bytes = vec![0; T::SAVED_SIZE];
    let length = target.save(&mut bytes).unwrap();
    bytes.truncate(length);
    bytes
}

/// The configuration of the robust tracker, with the refiner if this build has it.
pub(super) fn most_parts() -> robust::Config {
    robust::Config { refiner: cfg!(feature = "refiner"), ..robust::Config::robust() }
}

macro_rules! for_all {
    ($($name:ident),* $(,)?) => {
        mod paper_tracker {
            $(#[test] fn $name() { super::$name::<super::SmallPaper>(super::small_paper()); })*
        }
        mod robust_tracker {
            $(#[test] fn $name() { super::$name::<super::Robust>(super::most_parts()); })*
        }
        mod small_robust_tracker {
            $(#[test] fn $name() { super::$name::<super::SmallRobust>(super::most_parts().within::<super::Small>()); })*
        }
    };
}

for_all! {
    the_scene_has_what_it_is_for,
    promises_hold_in_films,
    promises_hold_at_the_edges,
    a_flat_target_is_said_to_be_poor,
    a_turn_of_the_camera_is_followed,
    damaged_bytes_are_refused,
    misuse_is_an_error_and_changes_nothing,
    refused_calls_change_nothing_between_steps,
    a_shared_workspace_costs_no_step,
    no_target_continues_the_call_of_another,
}

fn the_scene_has_what_it_is_for<T: Target>(config: T::Config) {
    let mut tracker = of_scene::<T>(config);
    let answers: Vec<Answer> = frames().iter().map(|pixels| tracker.update(&whole(pixels)).unwrap()).collect();
    let states: Vec<State> = answers.iter().map(|answer| answer.state).collect();
    assert_eq!(states[..3], [State::Tracking; 3]);
    assert!(states[3..].contains(&State::Lost), "{states:?}");
    assert_eq!(states.last(), Some(&State::Tracking), "{states:?}");
    assert_eq!(answers.iter().filter(|answer| answer.found_again).count(), 1, "{states:?}");
    for answer in answers {
        assert_eq!(answer.fine.whole(), answer.bbox);
    }
}

fn a_flat_target_is_said_to_be_poor<T: Target>(config: T::Config) {
    let (flat, textured) = (vec![90; 160 * 120], picture(TARGET.x, TARGET.y));
    let lock = |pixels, target| Tracker::<T>::with(config).unwrap().lock(&whole(pixels), target).unwrap();
    assert!(!lock(&textured, TARGET).is_poor(), "{:?}", lock(&textured, TARGET));
    assert_eq!([lock(&flat, TARGET), lock(&flat, Rect::new(7, 7, 1, 1))].map(|quality| quality.value()), [0, 0]);
}

fn a_turn_of_the_camera_is_followed<T: Target>(config: T::Config) {
    let mut tracker = of_scene::<T>(config);
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

fn damaged_bytes_are_refused<T: Target>(config: T::Config) {
    let mut tracker = of_scene::<T>(config);
    let older = saved(tracker.target());
    tracker.update(&whole(&frames()[0])).unwrap();
    let bytes = saved(tracker.target());
    let mut other = of_scene::<T>(config);
    let before = saved(other.target());
    for length in 0..bytes.len() {
        let error = other.restore(&bytes[..length]).unwrap_err();
        assert!(matches!(error, RestoreError::Truncated | RestoreError::NotSaved), "{length}: {error:?}");
        // Bytes as after a power failure while a target was written over an older one, forwards or backwards.
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
    let mut tracker = Box::new(Tracker::<T>::with(config).unwrap());
    let pixels = picture(TARGET.x, TARGET.y);
    let frame = whole(&pixels);
    assert_eq!(tracker.update(&frame).err(), Some(UpdateError::NotLocked));
    assert_eq!(tracker.update_step(&frame, 1).err(), Some(UpdateError::NotLocked));
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
    assert!(tracker.lock_window(frame.bounds(), TARGET).contains(TARGET));
    for outside in [Rect::new(150, 40, 24, 30), Rect::new(0, 0, 0, 5)] {
        assert!(tracker.lock_window(frame.bounds(), outside).is_empty(), "{outside:?}");
    }

    let turned = Frame::whole(Image::new(&pixels, SIZE.1, SIZE.0).unwrap());
    assert_eq!(tracker.update(&turned).err(), Some(UpdateError::FrameSizeChanged));
    assert_eq!(tracker.lock(&turned, Rect::new(100, 1, 30, 30)), Err(LockError::BoxOutsideFrame));
    assert_eq!(tracker.lock(&cut(&frame, Rect::new(61, 46, 5, 5)), TARGET), Err(LockError::LockWindowNotInMemory));
    let (size, mut bytes) = (tracker.saved_size().unwrap(), vec![0xA5; T::SAVED_SIZE]);
    assert_eq!(tracker.save(&mut bytes[..size - 1]), Err(SaveError::BufferTooSmall));
    assert!(bytes.iter().all(|&byte| byte == 0xA5), "a save that is refused writes nothing");
    assert_eq!(tracker.save(&mut bytes), Ok(size));
    assert_eq!(tracker.update(&frame).unwrap(), of_scene::<T>(config).update(&frame).unwrap(), "nothing has changed");
    tracker.lock(&turned, Rect::new(10, 10, 20, 20)).unwrap();
    assert!(tracker.update(&turned).is_ok(), "locking again may change the frame's size");
}

#[test]
fn bytes_of_the_other_tracker_or_another_configuration_are_refused() {
    let bytes = saved(of_scene::<SmallPaper>(small_paper()).target());
    let mut robust = <Robust>::new();
    assert_eq!(robust.restore(&bytes), Err(RestoreError::OtherTracker));
    // A saved target may be restored with another backend or other pruning.
    let mut slow = small_paper();
    (slow.backend, slow.pruning) = (Some(crate::similarity::Backend::Scalar), false);
    assert_eq!(SmallPaper::with(slow).unwrap().restore(&bytes), Ok(()));
    assert_eq!(Paper::<256, 161>::with(small_paper()).unwrap().restore(&bytes), Err(RestoreError::TooLarge));
    assert_eq!(Paper::<1024, 33>::with(small_paper()).unwrap().restore(&bytes), Err(RestoreError::TooLarge));
    let bytes = saved(of_scene::<Robust>(robust::Config::robust()).target());
    assert_eq!(SmallPaper::with(small_paper()).unwrap().restore(&bytes), Err(RestoreError::OtherTracker));
}

#[test]
fn a_target_of_the_other_size_is_refused() {
    let config = most_parts().within::<Small>();
    let (standard, small) = (of_scene::<Robust>(config), of_scene::<SmallRobust>(config));
    let (of_standard, of_small) = (saved(standard.target()), saved(small.target()));
    let refusal = <Robust>::with(config).unwrap().restore(&of_small).unwrap_err();
    assert_eq!(refusal.to_string(), "the target was saved by another tracker, or by one of another size");
    assert_eq!(SmallRobust::with(config).unwrap().restore(&of_standard), Err(RestoreError::OtherTracker));
}

#[test]
fn a_flight_is_replayed_by_a_tracker_of_its_size() {
    let (mut file, mut tracker) = (vec![], Tracker::<SmallRobust>::new());
    let mut recorder = Recorder::begin(tracker.target(), |bytes| {
        file.extend_from_slice(bytes);
        Ok::<(), ()>(())
    })
    .unwrap();
    let frames = frames();
    tracker.lock(&whole(&frames[0]), TARGET).unwrap();
    recorder.lock(tracker.target(), &whole(&frames[0]), TARGET).unwrap();
    for pixels in &frames[1..20] {
        recorder.window(tracker.target(), &whole(pixels)).unwrap();
        recorder.answer(&tracker.update(&whole(pixels)).unwrap()).unwrap();
    }
    recorder.restored(&saved(tracker.target())).unwrap();
    let replayed = replay(&file, &mut tracker, |tracker, frame| tracker.update(frame)).unwrap();
    assert_eq!((replayed.locks, replayed.answers), (1, 19));
    let other = replay(&file, &mut Tracker::<Robust>::new(), |tracker, frame| tracker.update(frame)).unwrap_err();
    assert_eq!(other.to_string(), "entry 0: the record is of the tracker S (P: Paper, R: Robust, S: Robust<Small>)");
}

#[test]
fn a_small_tracker_has_a_smaller_reach() {
    let mut config = robust::Config::robust();
    assert_eq!(SmallRobust::with(config).unwrap_err().to_string(), "reach is 4 to 7, not 8");
    let before = *SmallRobust::new().config();
    assert_eq!((before.reach, before), (7, config.within::<Small>()));
    config.reach = 5;
    let small = config.within::<Small>();
    assert_eq!((small.reach, SmallRobust::with(config).map(|target| *target.config())), (5, Ok(small)));
    assert_eq!(
        (small.within::<Standard>(), <Robust>::with(small).map(|target| *target.config())),
        (config, Ok(config))
    );
    for mut config in [before, small] {
        assert_eq!(config.set("reach", &[8]).unwrap_err().to_string(), "reach is 4 to 7, not 8");
        assert_eq!(config.set("reach", &[7]), Ok(()));
        config.reach = 8;
        assert_eq!(config.check().unwrap_err().to_string(), "reach is 4 to 7, not 8");
    }
    (config.reach, config.uncertain_below) = (9, 0);
    assert_eq!(SmallRobust::with(config).unwrap_err().to_string(), "reach is 4 to 7, not 9");
    config.reach = 7;
    assert_eq!(SmallRobust::with(config).unwrap_err(), ConfigError::UncertainBelowLost);
}

static OTHER_TABLE: Table = match Table::new(100) {
    Ok(table) => table,
    Err(_) => panic!("in range"),
};

/// Checks that each value can be changed by its setting's name, that the numbers of a record keep the change, and that
/// restoring a target saved before the change fails with that name.
fn settings_have_names<T: Target<Config: Settings + Debug + PartialEq>>(config: T::Config) {
    let bytes = saved(of_scene::<T>(config).target());
    let refusal = |config| T::with(config).unwrap().restore(&bytes).unwrap_err();
    // The refiner can be on only in a build with its feature.
    let settings = config.settings().filter(|setting| setting.name() != "refiner" || cfg!(feature = "refiner"));
    for (setting, place) in settings.flat_map(|setting| (0..setting.shape.count()).map(move |place| (setting, place))) {
        let (name, count) = (setting.name(), setting.shape.count());
        let (mut other, mut values) = (config, config.get(name).unwrap());
        let least = setting.lowest + u16::from(setting.shape == Shape::Fraction);
        values[place] = if values[place] > least { values[place] - 1 } else { values[place] + 1 };
        assert_eq!((other.set(name, &values[..count]), other.get(name)), (Ok(()), Some(values)));
        let restored = T::Config::of_numbers(&Table::PAPER, &numbers_of(&other)).unwrap();
        assert_eq!(numbers_of(&restored), numbers_of(&other));
        assert_eq!(refusal(other), RestoreError::OtherConfig(name));
        assert_eq!(setting.name_with_zero().strip_suffix('\0'), Some(name));
        assert_eq!(other.set(name, &[1; 3]), Err(ConfigError::WrongCount { name, count }));
        if let Some(found) = setting.highest.checked_add(1) {
            values[place] = found;
            let (lowest, highest) = (setting.lowest, setting.highest);
            let refused = ConfigError::OutOfRange { name, lowest, highest, found };
            assert_eq!(other.set(name, &values[..count]), Err(refused));
        }
    }
    assert_eq!(config.get("speed"), None);
    assert!(T::Config::TEXTS.iter().all(|text| text.ends_with('.') && !text.contains("  ")));
    assert!(T::Config::of_numbers(&Table::PAPER, &numbers_of(&config)[2..]).is_err());
    let other = T::Config::of_numbers(&OTHER_TABLE, &numbers_of(&config)).unwrap();
    let text = "the target was saved with another configuration: table differs";
    assert_eq!(refusal(other).to_string(), text);
}

/// The numbers that a record stores for a configuration, without the 256 entries of the similarity table.
fn numbers_of<C: Settings>(config: &C) -> Vec<u16> {
    let mut numbers = vec![];
    recorded(config, |number| numbers.push(number));
    numbers.split_off(256)
}

#[test]
fn the_settings_of_the_papers_tracker_have_names() {
    settings_have_names::<SmallPaper>(small_paper());
}

#[test]
fn the_settings_of_the_robust_tracker_have_names() {
    settings_have_names::<Robust>(robust::Config::robust());
    settings_have_names::<SmallRobust>(robust::Config::robust().within::<Small>());
    for part in 2..6 {
        let mut numbers = numbers_of(&robust::Config::robust());
        numbers[part] = 0;
        let refused = ConfigError::OutOfRange { name: "parts", lowest: 1, highest: 1, found: 0 };
        assert_eq!(robust::Config::of_numbers(&Table::PAPER, &numbers), Err(refused));
    }
}

#[test]
fn a_refusal_names_the_first_of_several() {
    let bytes = saved(of_scene::<Robust>(robust::Config::robust()).target());
    let mut other = robust::Config::robust();
    (other.reach, other.early_rate) = (5, 9);
    assert_eq!(<Robust>::with(other).unwrap().restore(&bytes), Err(RestoreError::OtherConfig("reach")));
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
        let out_of_range = ConfigError::OutOfRange { name: "reach", lowest: 4, highest: 8, found: 9 };
        assert_eq!(config.check(), Err(out_of_range));
    }
}

/// Checks that all output of the preset `robust` has the same checksum in builds with and without the refiner.
#[test]
fn the_preset_robust_answers_the_same_in_every_build() {
    let mut sum = Crc::new();
    let mut tracker = Tracker::<Robust>::new();
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
        works.push(<Robust>::work(tracker.workspace()));
        recorder.restored(&saved(tracker.target())).unwrap();
    }
    let most = robust::Config::robust().most_work();
    assert_eq!((most.update, most.lock, most.beyond_a_step), (13_793_556, 11_012_255, 128_000));
    assert_eq!((works.iter().sum::<u32>(), sum.finish()), (150_210_575, 2_396_514_253));
}

#[test]
fn a_state_has_a_code_and_a_name() {
    for (code, name) in (0..).zip(["tracking", "leaving", "uncertain", "lost"]) {
        let state = State::from_code(code).unwrap();
        assert_eq!((state.code(), state.name()), (code, name));
        let mut answer = Answer::new(Rect::new(-3, 5, 10, 8).into(), state);
        assert_eq!((answer.bbox, answer.state, answer.identity), (Rect::new(-3, 5, 10, 8), state, None));
        answer.found_again = true;
        assert_ne!(answer, Answer::new(answer.fine, state));
    }
    assert_eq!((State::from_code(4), State::ALL.len()), (None, 4));
}

#[test]
fn a_second_target_takes_no_scratch() {
    let (paper, robust) = (size_of::<SmallPaper>(), size_of::<Robust>());
    std::println!("Paper<1024, 161> {paper}, workspace {}", size_of::<paper::Workspace<1024, 161>>());
    std::println!("Robust {robust}, workspace {}", size_of::<robust::Workspace>());
    let small = size_of::<SmallRobust>();
    std::println!("Robust<Small> {small}, workspace {}", size_of::<robust::Workspace<Small>>());
    let refiner = if cfg!(feature = "refiner") { 1040 } else { 0 };
    assert!(
        paper <= 1024 + 200 && robust <= 12 * 1024 + refiner && small <= 10 * 1024 + refiner,
        "{paper} {robust} {small}"
    );
}

/// The linker puts a `static` that begins as zeroes into `.bss`, where it takes no flash.
#[cfg(all(target_os = "linux", not(miri)))]
#[test]
#[allow(unsafe_code)]
fn a_tracker_in_a_static_takes_no_flash() {
    use std::sync::Mutex;
    static PAPER: Mutex<Tracker<SmallPaper>> = Mutex::new(Tracker::<SmallPaper>::new());
    static ROBUST: Mutex<Tracker<Robust>> = Mutex::new(Tracker::<Robust>::new());
    static SMALL: Mutex<Tracker<SmallRobust>> = Mutex::new(Tracker::<SmallRobust>::new());
    static OTHER: Mutex<[u8; 4096]> = Mutex::new([1; 4096]);
    // SAFETY: the linker defines both; only their addresses are taken.
    unsafe extern "C" {
        safe static __bss_start: u8;
        safe static _end: u8;
    }
    let bss = (&raw const __bss_start).addr()..(&raw const _end).addr();
    let (paper, robust, small) = ((&raw const PAPER).addr(), (&raw const ROBUST).addr(), (&raw const SMALL).addr());
    let all = [paper, robust, small, (&raw const OTHER).addr()];
    assert_eq!(all.map(|at| bss.contains(&at)), [true, true, true, false]);
}

#[test]
fn a_window_that_a_tracker_has_no_room_for_is_refused_when_it_is_configured() {
    let mut tracker = Tracker::<Paper<1024, 33>>::new();
    assert_eq!(tracker.config().window, paper::Radius { x: 16, y: 16 });
    assert_eq!(tracker.configure(paper::Config::camera()), Err(ConfigError::WindowTooLarge));
    assert!(tracker.lock(&whole(&picture(TARGET.x, TARGET.y)), TARGET).is_ok());
    tracker.configure(paper::Config::camera_within(12)).unwrap();
    assert_eq!((tracker.config().window.x, tracker.state()), (12, None));
}
