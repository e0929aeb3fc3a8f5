//! Tests of the whole tracker: bounds of its work, changing targets, covered targets, and targets that come back.

use super::{Config, Robust, Size};
use crate::track::tests::{cut, drawn, locked, most_parts, of_size};
use crate::{Answer, FineRect, Rect, State, Tracker};
use std::{vec, vec::Vec};

fn noise(pixels: usize) -> Vec<u8> {
    (0..pixels as u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 13) as u8).collect()
}

/// A tracker that is locked on `target`, as a function from each further frame to its answer.
fn following(first: &[u8], size: (u16, u16), target: Rect) -> impl FnMut(&[u8]) -> Answer + use<> {
    let mut tracker = locked::<Robust>(most_parts(), &of_size(first, size), target);
    move |pixels| tracker.update(&of_size(pixels, size)).unwrap()
}

/// Tests that hold for a tracker of each size.
macro_rules! for_both_sizes {
    ($($name:ident),* $(,)?) => {
        mod standard {
            $(#[test] fn $name() { super::$name::<crate::robust::Standard>(); })*
        }
        mod small {
            $(#[test] fn $name() { super::$name::<crate::robust::Small>(); })*
        }
    };
}

for_both_sizes! {
    a_target_of_any_size_costs_about_the_same,
    the_most_work_is_nearly_done,
    a_distinct_target_is_not_refused,
}

/// The size of the target hardly affects the work, because only a few pixels of each block are read. The largest frame
/// has 4 GiB, nearly all of which is never touched.
fn a_target_of_any_size_costs_about_the_same<S: Size>() {
    if usize::BITS < 64 {
        return;
    }
    let work_of = |config: Config, pixels: &[u8], size: (u16, u16), target: Rect| {
        let (frame, config) = (of_size(pixels, size), config.within::<S>());
        let (mut tracker, most) = (locked::<Robust<S>>(config, &frame, target), config.most_work_of::<S>());
        assert!(u64::from(tracker.work()) <= most.lock, "{target:?}: {} of {most:?}", tracker.work());
        let works = [(); 2].map(|()| tracker.update(&frame).map(|_| tracker.work()).unwrap());
        let work = works[0].max(works[1]);
        assert!(u64::from(work) <= most.update, "{target:?}: {work} of {most:?}");
        work
    };
    // Puts the target in the middle of a frame of twice its size, at most 65,535 pixels on a side.
    let around = |across: u16, down: u16, pixels: fn(usize) -> Vec<u8>| {
        let [width, height] = [across, down].map(|side| side.saturating_mul(2));
        let pixels = pixels(usize::from(width) * usize::from(height));
        let [left, top] = [width - across, height - down].map(|room| i32::from(room / 2));
        let target = Rect::new(left, top, across, down);
        work_of(Config { refiner: cfg!(feature = "refiner"), ..Config::robust() }, &pixels, (width, height), target);
        // Returns an update's work with one sweep window, without scale search and refiner (not run in every frame).
        work_of(Config { refiner: false, size: false, sweep: 1, ..Config::robust() }, &pixels, (width, height), target)
    };
    let black: fn(usize) -> Vec<u8> = |pixels| vec![0; pixels];
    let holds = |across: u16, down: u16, pixels, of_40: u32| {
        let work = around(across, down, pixels);
        std::println!("{across}x{down}: {work}");
        assert!(100 * u64::from(work) <= 115 * u64::from(of_40), "{across}x{down}: {work}, and {of_40} for 40x40");
    };
    let [seen_40, black_40] = [noise, black].map(|pixels| around(40, 40, pixels));
    for side in [1, 79, 100, 159, 200, 319, 400, 800, 1279, 1500] {
        holds(side, side, noise, seen_40);
    }
    // The boxes include the longest possible ones, and some about six times as long as wide. For 50,920x7890 pixels,
    // neighbouring samples are nearly two blocks of pixels apart, which is the largest distance.
    let small = [(600, 16), (16, 600), (65_535, 1), (1, 65_535), (992, 160), (160, 992)];
    for (across, down) in small.into_iter().chain([(13_000, 13_000), (65_535, 65_535), (50_920, 7890), (7890, 50_920)])
    {
        holds(across, down, black, black_40);
    }
}

/// The largest work of an update, of a lock, and of a step that was granted one unit of work.
fn most_done<S: Size>(config: Config) -> [u64; 3] {
    let mut most = [0; 3];
    // Boxes whose filters have nearly 200 cells, the maximum: 14x14, 22x9, and twice 32x6 cells. In the small size nearly
    // 162: 12x13, 20x8, and twice 32x5.
    for (width, height) in [(79, 79), (158, 66), (316, 50), (300, 48)] {
        // The frame has five times the target's width, so that a row of the sweep has at least four windows.
        let (across, down) = (5 * width, 3 * height);
        let pixels = 15 * usize::from(width) * usize::from(height);
        let (first, other) = (noise(pixels), vec![0; pixels]);
        let target = Rect::new((2 * width).into(), height.into(), width, height);
        let mut tracker = locked::<Robust<S>>(config, &of_size(&first, (across, down)), target);
        most[1] = most[1].max(tracker.work().into());
        for pixels in [&first, &first, &other, &other, &other] {
            let frame = of_size(pixels, (across, down));
            let mut before = 0;
            while tracker.update_step(&frame, 1).unwrap().is_none() {
                most[2] = most[2].max((tracker.work() - before).into());
                before = tracker.work();
            }
            most[0] = most[0].max(tracker.work().into());
        }
    }
    most
}

/// The largest work of an update, of a lock and of a step is 85 to 100 % of its own bound; that of an update with the
/// refiner and a sweep 65 to 100 %, because no frame here learns, is then refused by the network, and has something like
/// the target in every window.
fn the_most_work_is_nearly_done<S: Size>() {
    let lost = |config| Config { lost_below: u16::MAX, uncertain_below: u16::MAX, ..config };
    for config in [
        most_parts(),
        Config { reach: 4, ..most_parts() },
        Config { size: false, ..most_parts() },
        Config { sweep: 0, ..most_parts() },
    ] {
        let config = config.within::<S>();
        let most = config.most_work_of::<S>();
        let both = most_done::<S>(config)
            .into_iter()
            .zip(most_done::<S>(lost(config)))
            .map(|(learns, looks)| learns.max(looks));
        let rare = config.refiner && config.sweep > 0;
        let parts = [(most.update, if rare { 65 } else { 85 }), (most.lock, 85), (most.beyond_a_step.into(), 85)];
        for (done, (most, percent)) in both.zip(parts) {
            assert!(done <= most && 100 * done >= percent * most, "{config:?}: {done} of {most}");
        }
    }
}

/// A smaller search radius takes less work and a smaller window, and still follows slow targets.
#[test]
fn every_reach_follows() {
    let mut before = (0, 0);
    for reach in 4..=8 {
        let config = Config { reach, ..most_parts() };
        let mut tracker =
            locked::<Robust>(config, &of_size(&scene(Some((100, 90)), 100), (320, 240)), Rect::new(100, 90, 40, 40));
        // The least work of an update (as the refiner runs only in some), and the largest window area in pixels.
        let mut after = (u32::MAX, 0);
        for number in 1..12 {
            let place = (100 + 3 * number, 90 - 2 * number);
            let pixels = scene(Some(place), 100);
            let window = tracker.window().unwrap();
            let answer = tracker.update(&cut(&of_size(&pixels, (320, 240)), window)).unwrap();
            assert!(answer.state == State::Tracking && iou(answer.fine, place) > 0.5, "{reach}: {answer:?}");
            after = (after.0.min(tracker.work()), after.1.max(window.area()));
        }
        assert!(after > before && after.1 > before.1, "{reach}: {after:?} after {before:?}");
        before = after;
    }
}

/// A target without contrast resembles everything else: its box stays, and it is lost.
#[test]
fn a_plain_frame_holds_the_box() {
    let target = Rect::new(40, 30, 20, 20);
    let mut update = following(&[77; 100 * 80], (100, 80), target);
    for state in [State::Uncertain, State::Lost, State::Lost] {
        let answer = update(&[77; 100 * 80]);
        assert_eq!((answer.bbox, answer.state, answer.ratio), (target, state, 0));
    }
}

/// A target of 40x40 pixels, if `at` is given, on a background of low contrast. `light` scales gray levels, in percent.
fn scene(at: Option<(i32, i32)>, light: u32) -> Vec<u8> {
    drawn((320, 240), |x, y| {
        let level = match at.map(|(left, top)| (x - left, y - top)) {
            Some((x @ 0..40, y @ 0..40)) => hash(x / 5, y / 5, 1) % 200,
            _ => 70 + hash(x / 16, y / 16, 999) % 200 / 4,
        };
        (level * light / 100) as u8
    })
}

fn hash(x: i32, y: i32, seed: i32) -> u32 {
    ((u64::from((x * 31 + y * 57 + seed).cast_unsigned()) * 2_654_435_761) >> 16) as u32
}

fn iou(fine: FineRect, (left, top): (i32, i32)) -> f64 {
    let overlap = |from: i32, size: u32, start: i32| {
        let (from, start) = (f64::from(from) / 256.0, f64::from(start));
        ((from + f64::from(size) / 256.0).min(start + 40.0) - from.max(start)).max(0.0)
    };
    let both = overlap(fine.x, fine.width, left) * overlap(fine.y, fine.height, top);
    both / (1600.0 + f64::from(fine.width) * f64::from(fine.height) / 65_536.0 - both)
}

#[test]
fn a_target_that_moves_by_whole_pixels_keeps_its_size_and_its_box() {
    let mut update = following(&scene(Some((20, 30)), 100), (320, 240), Rect::new(20, 30, 40, 40));
    let (mut scales, mut worst) = ((u32::MAX, 0), 1.0_f64);
    // The target moves along an ellipse, by at most three pixels per frame.
    let at = |frame: f64| {
        let turn = frame * std::f64::consts::TAU / 150.0;
        ((20.0 + 60.0 * (1.0 - turn.cos())) as i32, (30.0 + 60.0 * turn.sin().abs()) as i32)
    };
    for frame in 1..=300 {
        let place = at(f64::from(frame));
        let answer = update(&scene(Some(place), 100));
        assert_eq!(answer.state, State::Tracking, "{frame}: {answer:?}");
        scales = (scales.0.min(answer.scale), scales.1.max(answer.scale));
        worst = worst.min(iou(answer.fine, place));
    }
    assert!(scales.0 >= 64_881 && scales.1 <= 66_191, "{scales:?}: 1 +- 0.01");
    assert!(worst > 0.97, "{worst}");
}

#[test]
fn light_may_change() {
    let place = (100, 90);
    let mut update = following(&scene(Some(place), 100), (320, 240), Rect::new(100, 90, 40, 40));
    for light in [100, 90, 80, 70, 60, 60, 75, 100, 115, 125, 125, 80] {
        let answer = update(&scene(Some(place), light));
        assert_eq!(answer.state, State::Tracking, "{light}: {answer:?}");
        assert!(iou(answer.fine, place) > 0.9, "{light}: {answer:?}");
    }
}

/// A moving target of 40x40 pixels in 160x120, by `kind`: dark, bright, textured, smooth, clipped or noisy.
fn on_ground(kind: i32, frame: i32) -> Vec<u8> {
    let (left, top) = (40 + frame / 2, 30 + frame / 4);
    on_its_ground(kind, (left, top), |x, y| {
        let tile = hash(x / 5, y / 5, kind) % 100;
        let level = match kind {
            0 => 5 + tile / 2,
            1 => 200 + tile / 2,
            2 => 10 + 2 * tile,
            3 => (50 + 2 * x + y).cast_unsigned(),
            4 => 255 * (tile / 50),
            _ => 20 + 3 * tile / 2 + (hash(x, y, frame << 10) >> 3) % 256 / 5,
        };
        level as u8
    })
}

/// A target of 40x40 pixels on a background of low contrast, in a frame of 160x120.
fn on_its_ground(kind: i32, (left, top): (i32, i32), target: impl Fn(i32, i32) -> u8) -> Vec<u8> {
    drawn((160, 120), |x, y| match (x - left, y - top) {
        (x @ 0..40, y @ 0..40) => target(x, y),
        _ => (100 + hash(x / 12, y / 12, kind) % 60) as u8,
    })
}

/// A target that `lock` rates as distinct is not lost while it stands still, however much of it is black or white.
fn a_distinct_target_is_not_refused<S: Size>() {
    let targets: [fn(i32, i32) -> u8; 4] = [
        |x, y| if hash(x / 8, y / 8, 0).is_multiple_of(2) { 0 } else { 255 },
        |x, y| if (x - 20).pow(2) + (y - 20).pow(2) < 300 { 255 } else { 90 },
        |x, y| if (8..32).contains(&x) && (8..32).contains(&y) { 0 } else { 255 },
        |x, _| if x < 30 { 255 } else { 120 },
    ];
    let scenes = targets.map(|target| on_its_ground(0, (50, 40), target));
    for (number, scene) in scenes.iter().enumerate() {
        for (margin, light) in [(0, 100), (4, 100), (4, 60)] {
            let side = 40 + 2 * margin;
            let bbox = Rect::new(50 - i32::from(margin), 40 - i32::from(margin), side, side);
            let mut tracker = locked::<Robust<S>>(most_parts().within::<S>(), &of_size(scene, (160, 120)), bbox);
            let dimmed: Vec<u8> = scene.iter().map(|&level| (u32::from(level) * light / 100) as u8).collect();
            for frame in 0..12 {
                let answer = tracker.update(&of_size(&dimmed, (160, 120))).unwrap();
                let (refused, quality) = (answer.state == State::Lost, tracker.quality().unwrap());
                assert!(!refused || quality.is_poor(), "{number}, {margin}, {light}, {frame}: {quality:?}, {answer:?}");
            }
        }
    }
}

#[test]
fn a_covered_lens_is_lost_and_teaches_nothing() {
    for (kind, name) in (0..).zip(["dark", "bright", "textured", "smooth", "clipped", "noisy"]) {
        for level in [0, 255, 128] {
            let first = on_ground(kind, 0);
            let mut tracker = locked::<Robust>(most_parts(), &of_size(&first, (160, 120)), Rect::new(40, 30, 40, 40));
            let update =
                |tracker: &mut Tracker<Robust>, pixels: &[u8]| tracker.update(&of_size(pixels, (160, 120))).unwrap();
            for frame in 1..20 {
                let answer = update(&mut tracker, &on_ground(kind, frame));
                assert_eq!(answer.state, State::Tracking, "{name}, {frame}: {answer:?}");
            }
            let learned = |tracker: &Tracker<Robust>| -> (Vec<i32>, Vec<u8>) {
                let target = tracker.target();
                (target.weights().to_vec(), target.early_template().unwrap().collect())
            };
            let before = learned(&tracker);
            // 60 covered frames suffice, because each sweep of the whole picture takes only a few frames. For
            // `textured`, 300 frames are covered, as in `eval --fault cover`.
            let covered = if name == "textured" { 300 } else { 60 };
            let states: Vec<State> = (0..covered).map(|_| update(&mut tracker, &[level; 160 * 120]).state).collect();
            let tracking = states.iter().filter(|&&state| state == State::Tracking).count();
            assert!(tracking <= 2, "{name}, {level}: {tracking} times tracking");
            assert!(states[..30].contains(&State::Lost), "{name}, {level}: {:?}", &states[..30]);
            assert!(states[30..].iter().all(|&state| state == State::Lost), "{name}, {level}");
            assert!(learned(&tracker) == before, "{name}, {level}: something was learned");
            let place = |frame: i32| (40 + frame / 2, 30 + frame / 4);
            let again = (20..30).find(|&frame| {
                let answer = update(&mut tracker, &on_ground(kind, frame));
                answer.state != State::Lost && iou(answer.fine, place(frame)) > 0.25
            });
            assert!(again.is_some(), "{name}, {level}: not found again");
        }
    }
}

#[test]
fn a_hidden_target_is_lost_and_found_where_it_comes_back() {
    let mut update = following(&scene(Some((40, 40)), 100), (320, 240), Rect::new(40, 40, 40, 40));
    for _ in 0..5 {
        assert_eq!(update(&scene(Some((40, 40)), 100)).state, State::Tracking);
    }
    let hidden: Vec<State> = (0..12).map(|_| update(&scene(None, 100)).state).collect();
    assert!(hidden[5..].iter().all(|&state| state != State::Tracking), "{hidden:?}");
    assert!(hidden.contains(&State::Lost), "{hidden:?}");
    let place = (230, 170);
    let again: Vec<Answer> = (0..30).map(|_| update(&scene(Some(place), 100))).collect();
    assert!(again.iter().any(|answer| answer.found_again), "{again:?}");
    let last = again.last().unwrap();
    assert!(last.state == State::Tracking && iou(last.fine, place) > 0.9, "{last:?}");
}
