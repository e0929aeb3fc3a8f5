//! Tests of the paper tracker: states, decisions of the gate, the work of a search, limits.

use super::{Config, Fraction, Paper, Radius, Workspace};
use crate::track::Target;
use crate::track::tests::{cut, drawn, of_size};
use crate::{ConfigError, Frame, Image, ImageError, LockError, Rect, State, Tracker};
use std::{println, vec, vec::Vec};

type Small = Tracker<Paper<256, 41>>;

fn small_config() -> Config {
    Config { window: Radius { x: 10, y: 10 }, window_limit: Radius { x: 20, y: 20 }, ..Config::camera() }
}

struct Picture {
    width: u16,
    height: u16,
    pixels: Vec<u8>,
}

impl Picture {
    fn of(width: u16, height: u16, level: impl FnMut(i32, i32) -> u8) -> Self {
        Self { width, height, pixels: drawn((width, height), level) }
    }

    fn noise(width: u16, height: u16, seed: u32) -> Self {
        let mut state = seed | 1;
        Self::of(width, height, |_, _| {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            (state >> 24) as u8
        })
    }

    fn frame(&self) -> Frame<'_> {
        of_size(&self.pixels, (self.width, self.height))
    }
}

fn scene(seed: u32, left: i32, top: i32) -> Picture {
    let (ground, target) = (Picture::noise(64, 48, seed).pixels, Picture::noise(12, 12, 99).pixels);
    Picture::of(64, 48, |x, y| match (x - left, y - top) {
        (column @ 0..12, row @ 0..12) => target[(12 * row + column) as usize],
        _ => ground[(64 * y + x) as usize],
    })
}

fn locked_at(x: i32, y: i32) -> Small {
    locked_with(small_config(), x, y)
}

fn locked_with(config: Config, x: i32, y: i32) -> Small {
    let mut tracker = Small::with(config).unwrap();
    tracker.lock(&scene(1, x, y).frame(), Rect::new(x, y, 12, 12)).unwrap();
    tracker
}

#[test]
fn memory_is_twice_the_template_five_words_an_offset_and_a_table() {
    fn bounded<const PIXELS: usize, const SPAN: usize>(name: &str) {
        let (target, workspace) = (size_of::<Paper<PIXELS, SPAN>>(), size_of::<Workspace<PIXELS, SPAN>>());
        let size = target + workspace;
        println!("Paper<{PIXELS}, {SPAN}>: {target} bytes, workspace {workspace} ({name})");
        assert!(target <= PIXELS + 180, "{name}: {target} bytes");
        assert!(size <= 2 * PIXELS + 20 * SPAN + 1000, "{name}: {size} bytes");
    }
    bounded::<1024, 33>("32x32 pixels, +-16");
    bounded::<4096, 33>("64x64 pixels, +-16");
    bounded::<4096, 161>("64x64 pixels, the paper's window");
    bounded::<65536, 680>("256x256 pixels, the whole of 640x480");
}

#[test]
fn the_runner_up_is_there_where_it_is_wanted_or_decides() {
    let mut tracker = locked_with(Config { runner_up_always: true, ..small_config() }, 20, 20);
    let answer = tracker.update(&scene(2, 22, 21).frame()).unwrap();
    assert!(answer.runner_up_ratio.is_some_and(|ratio| 0 < ratio && ratio < 20000));

    let mut tracker = locked_at(5, 20);
    let answer = tracker.update(&scene(2, -3, 20).frame()).unwrap();
    assert_eq!(answer.state, State::Leaving);
    assert!(answer.runner_up_ratio.is_some(), "whether it leaves depends on it");
}

#[test]
fn the_most_work_is_nearly_done() {
    let noise = [Picture::noise(160, 120, 7), Picture::noise(160, 120, 8)];
    // Every 4x4 block of the second picture has the levels 100 and 200. The template's level, 150, lies between them,
    // so the bound of every group of 4x4 offsets is the full score, but no pixel has that level.
    let of = |level: fn(i32, i32) -> u8| Picture::of(160, 120, level);
    let stripes = [of(|_, _| 150), of(|x, y| if (x + y) % 2 == 0 { 100 } else { 200 })];
    // About one in eight template pixels matches, the same ones at every offset: all scores are equal, and equal to the bound
    // of every group of 4x4 offsets.
    let dots = [of(|x, y| if (x + y) % 8 == 0 { 150 } else { 250 }), of(|_, _| 150)];
    let mut closest = 0.0_f64;
    for (radius, pruning, runner_up_always) in
        (1..=20).flat_map(|radius| [(radius, true, true), (radius, true, false), (radius, false, true)])
    {
        for side in [1, 2, 5, 8, 12, 16, 24, 32, 64] {
            let window = Radius { x: radius, y: radius / 2 + 1 };
            let numbers = Config { window, window_limit: window, pruning, runner_up_always, ..Config::camera() };
            let config = Config { first_threshold: 60, ..numbers };
            let most = Paper::<4096, 41>::most_work(&config, side, side).update;
            let mut worst = 0;
            for [first, second] in [&noise, &stripes, &dots] {
                let mut tracker = std::boxed::Box::new(Tracker::<Paper<4096, 41>>::with(config).unwrap());
                tracker.lock(&first.frame(), Rect::new(48, 28, side, side)).unwrap();
                tracker.update(&second.frame()).unwrap();
                worst = worst.max(u64::from(tracker.work()));
            }
            assert!(worst <= most, "+-{radius} {side}x{side} {pruning} {runner_up_always}: {worst} of {most}");
            if runner_up_always {
                closest = closest.max(worst as f64 / most as f64);
                assert!(worst as f64 >= 0.9 * most as f64, "+-{radius} {side}x{side} {pruning}: {worst} of {most}");
            }
        }
    }
    assert!(closest > 0.995, "{closest}");
}

/// Checks the documented bound of the work: 1.25 * offsets * pixels, or twice that if the window is searched twice.
#[test]
fn the_most_work_is_what_the_documentation_says() {
    for (side, radius) in (8..=64).flat_map(|side| (4..=80).map(move |radius| (side, radius))) {
        let window = Radius { x: radius, y: radius };
        let of = |runner_up_always| {
            let config = Config { window, window_limit: window, runner_up_always, ..Config::camera() };
            Paper::<4096, 161>::most_work(&config, side, side).update
        };
        let all = (2 * u64::from(radius) + 1).pow(2) * u64::from(side).pow(2);
        assert!(4 * of(true) <= 5 * all, "{side}x{side}, +-{radius}");
        assert!(2 * of(false) <= 5 * all, "{side}x{side}, +-{radius}");
    }
}

#[test]
fn a_leaving_target_keeps_its_template() {
    let mut tracker = locked_at(2, 20);
    let before: Vec<u8> = tracker.target().template().unwrap().rows().flatten().copied().collect();
    let answer = tracker.update(&scene(2, -3, 20).frame()).unwrap();
    assert_eq!((answer.bbox, answer.state), (Rect::new(-3, 20, 12, 12), State::Leaving));
    let after: Vec<u8> = tracker.target().template().unwrap().rows().flatten().copied().collect();
    assert_eq!(before, after);
    let answer = tracker.update(&scene(3, 3, 20).frame()).unwrap();
    assert_eq!((answer.bbox, answer.state), (Rect::new(3, 20, 12, 12), State::Tracking));
}

#[test]
fn a_lost_target_is_found_again_by_a_growing_window() {
    let mut tracker = locked_with(Config { gate_tracking: Fraction::new(2, 1), ..small_config() }, 20, 20);
    for frames in 1..=4u16 {
        let answer = tracker.update(&Picture::noise(64, 48, u32::from(frames) + 40).frame()).unwrap();
        assert_eq!((answer.state, answer.bbox), (State::Lost, Rect::new(20, 20, 12, 12)));
        let reach = 10 + i32::from(frames);
        assert_eq!(tracker.target().offsets().unwrap().xs(), 20 - reach..=20 + reach);
    }
    let answer = tracker.update(&scene(2, 33, 8).frame()).unwrap();
    assert_eq!((answer.state, answer.bbox), (State::Tracking, Rect::new(33, 8, 12, 12)));
    assert_eq!(tracker.target().offsets().unwrap().xs(), 23..=43, "the window has shrunk again");
}

/// A target of 12x12 pixels at (20, 20), pixel i of gray level `level(i)`, on a background of level `around`.
fn plain_but(around: u8, level: impl Fn(usize) -> u8) -> Picture {
    Picture::of(64, 48, |x, y| match (x - 20, y - 20) {
        (column @ 0..12, row @ 0..12) => level((row * 12 + column) as usize),
        _ => around,
    })
}

/// Locks in the first picture and returns the state after an update with the second. alpha is 255: any two pixels
/// match, except black (0) and white (255).
fn seen_after(first: &Picture, second: &Picture, least_ratio: u16) -> State {
    let window = Radius { x: 0, y: 0 };
    let mut tracker = Small::with(Config { first_threshold: 255, window, least_ratio, ..small_config() }).unwrap();
    tracker.lock(&first.frame(), Rect::new(20, 20, 12, 12)).unwrap();
    tracker.update(&second.frame()).unwrap().state
}

#[test]
fn a_patch_without_contrast_is_not_accepted() {
    let contrast = |by: u8| plain_but(100, move |at| if at % 2 == 0 { 100 - by } else { 100 + by });
    let target = contrast(40);
    assert_eq!(seen_after(&target, &contrast(10), 1), State::Tracking, "a quarter is enough");
    assert_eq!(seen_after(&target, &contrast(9), 1), State::Lost);
    assert_eq!(seen_after(&target, &plain_but(128, |_| 128), 1), State::Lost);
    assert_eq!(seen_after(&target, &contrast(9), 0), State::Tracking, "where there is no least ratio nothing is asked");
    assert_eq!(seen_after(&contrast(0), &contrast(0), 1), State::Tracking, "a plain target has no contrast to miss");
}

#[test]
fn a_patch_that_is_mostly_clipped_is_not_accepted() {
    let target = plain_but(100, |at| if at % 2 == 0 { 60 } else { 140 });
    let clipped = |pixels: usize| plain_but(100, move |at| if at < pixels { 255 * (at % 2) as u8 } else { 100 });
    assert_eq!(seen_after(&target, &clipped(72), 1), State::Tracking, "half of 144");
    assert_eq!(seen_after(&target, &clipped(73), 1), State::Lost);
    assert_eq!(seen_after(&target, &clipped(73), 0), State::Tracking);
    assert_eq!(seen_after(&clipped(73), &clipped(73), 1), State::Tracking, "a target may be so itself");
    let black = plain_but(0, |_| 0);
    assert_eq!(seen_after(&black, &black, 1), State::Tracking);
}

#[test]
fn a_covered_lens_leaves_box_template_and_alpha() {
    let first = plain_but(100, |at| if at % 2 == 0 { 60 } else { 140 });
    let gray = plain_but(128, |_| 128);
    let mut tracker = Small::with(Config { first_threshold: 255, ..small_config() }).unwrap();
    tracker.lock(&first.frame(), Rect::new(20, 20, 12, 12)).unwrap();
    let state = |tracker: &Small| {
        let target = tracker.target();
        (target.template().unwrap().rows().flatten().copied().collect::<Vec<_>>(), target.alpha())
    };
    let before = state(&tracker);
    for frames in 1..=3 {
        let answer = tracker.update(&gray.frame()).unwrap();
        assert_eq!((answer.state, answer.bbox, answer.confidence), (State::Lost, Rect::new(20, 20, 12, 12), 0));
        assert!(answer.ratio > 0, "it was similar");
        assert_eq!(state(&tracker), before);
        assert_eq!(tracker.target().offsets().unwrap().xs(), 10 - frames..=30 + frames);
    }
}

/// The check of the contrast skips a box that is partly outside the frame.
#[test]
fn a_box_partly_outside_the_frame_may_have_no_contrast() {
    let config = Config { first_threshold: 255, gate_leaving: Fraction::new(0, 1), ..small_config() };
    let mut tracker = Small::with(config).unwrap();
    let board = Picture::of(64, 48, |x, _| if x < 8 && x % 2 == 0 { 90 } else { 10 });
    tracker.lock(&board.frame(), Rect::new(0, 20, 12, 12)).unwrap();
    // The target (levels 10 and 90) is more similar to the black padding than to the white frame, so the box at the
    // peak lies partly in the padding.
    let white = plain_but(255, |_| 255);
    assert_eq!(tracker.update(&white.frame()).unwrap().state, State::Leaving);
}

#[test]
fn the_window_grows_until_it_is_the_padded_picture() {
    let mut config = Config { window: Radius { x: 3, y: 2 }, neighbourhood: 0, ..Config::paper() };
    (config.gate_tracking.numerator, config.gate_lost.numerator) = (u16::MAX, u16::MAX);
    let mut tracker = Tracker::<Paper<256, 130>>::with(config).unwrap();
    tracker.lock(&scene(1, 20, 16).frame(), Rect::new(20, 16, 12, 12)).unwrap();
    for lost_for in 0..60 {
        let offsets = tracker.target().offsets().unwrap();
        let (x, y) = (3 + lost_for, 2 + lost_for);
        assert_eq!(offsets.xs(), (20 - x).max(-20)..=(20 + x).min(64 + 20 - 12));
        assert_eq!(offsets.ys(), (16 - y).max(-20)..=(16 + y).min(48 + 20 - 12));
        let noise = Picture::noise(64, 48, 40 + lost_for.cast_unsigned());
        assert_eq!(tracker.update(&noise.frame()).unwrap().state, State::Lost);
    }
    assert_eq!(tracker.target().offsets().unwrap().size(), (93, 77));
}

#[test]
fn the_window_grows_to_its_limit_and_never_overflows() {
    let mut tracker = locked_at(20, 20);
    let nothing = vec![255; 64 * 48];
    let nothing = Frame::whole(Image::new(&nothing, 64, 48).unwrap());
    if let Some(track) = tracker.parts().0.track.get_mut() {
        track.lost_for = u16::MAX - 1;
        track.state = State::Lost;
    }
    for _ in 0..3 {
        assert_eq!(tracker.update(&nothing).unwrap().state, State::Lost);
        assert_eq!(tracker.target().offsets().unwrap().xs(), 0..=40);
    }
}

#[test]
fn what_only_this_tracker_refuses() {
    let (mut tracker, scene) = (Small::with(small_config()).unwrap(), scene(1, 20, 20));
    let (frame, target) = (scene.frame(), Rect::new(20, 20, 12, 12));
    assert_eq!((tracker.target().alpha(), tracker.target().score_at(&frame, 0, 0)), (0, None));
    assert!(tracker.target().offsets().is_none() && tracker.target().template().is_none());
    assert_eq!(tracker.lock(&frame, Rect::new(5, 5, 17, 16)), Err(LockError::BoxTooLarge));
    assert!(tracker.lock(&frame, Rect::new(5, 5, 16, 16)).is_ok());
    let box_alone = cut(&frame, target);
    assert!(tracker.lock(&box_alone, target).is_ok());
    assert_eq!(tracker.window(), Some(Rect::new(10, 10, 32, 32)));
    assert_eq!(tracker.lock(&box_alone, Rect::new(19, 20, 12, 12)), Err(LockError::LockWindowNotInMemory));
    for (limit, refused) in [(20, None), (21, Some(LockError::WindowTooLarge))] {
        let config = Config { window_limit: Radius { x: limit, y: 10 }, ..small_config() };
        assert_eq!(Small::with(config).unwrap().lock(&frame, target).err(), refused);
    }
}

#[test]
fn a_configuration_is_checked_when_the_tracker_is_built() {
    let out_of_range = |name, highest| Some(ConfigError::OutOfRange { name, lowest: 1, highest, found: 0 });
    let cases: [(fn(&mut Config), _); 6] = [
        (|_| (), None),
        (|config| config.k.denominator = 0, out_of_range("k", 65535)),
        (|config| config.gate_lost.denominator = 0, out_of_range("gate_lost", 65535)),
        (|config| config.k.numerator = 0, out_of_range("k", 65535)),
        (|config| config.first_threshold = 0, out_of_range("first_threshold", 255)),
        (|config| config.window_limit.x = config.window.x - 1, Some(ConfigError::LimitBelowWindow)),
    ];
    for (change, refused) in cases {
        let mut config = small_config();
        change(&mut config);
        assert_eq!(Small::with(config).err(), refused);
    }
}

#[test]
fn the_largest_template_has_a_ratio_of_one() -> Result<(), ImageError> {
    let pixels = vec![200; 256 * 256];
    let frame = Frame::whole(Image::new(&pixels, 256, 256)?);
    let config = Config { window: Radius { x: 1, y: 1 }, window_limit: Radius { x: 1, y: 1 }, ..Config::camera() };
    let mut tracker = std::boxed::Box::new(Tracker::<Paper<65536, 3>>::with(config).unwrap());
    tracker.lock(&frame, frame.bounds()).unwrap();
    let answer = tracker.update(&frame).unwrap();
    assert_eq!((answer.ratio, tracker.workspace().peaks().unwrap().peak.score), (65535, 65536 * 65535));
    Ok(())
}
