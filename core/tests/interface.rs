//! Tests of the public interface: rules of the paper tracker that recordings rarely exercise, and the README's memory
//! sizes.

use smr_core::paper::{Config, Margins, Workspace};
use smr_core::{Answer, Frame, Image, Paper, Rect, Robust, State, Tracker, robust};

const WIDTH: u16 = 90;
const HEIGHT: u16 = 70;
const SIDE: u16 = 12;

/// A tracker with enough memory for a window of the whole frame with 20 pixels of padding on each side.
type Follower = Tracker<Paper<144, { WIDTH as usize + 40 }>>;

fn noise(x: i32, y: i32, seed: u32) -> u8 {
    let mut bits = (x.cast_unsigned().wrapping_mul(0x9E37_79B1) ^ y.cast_unsigned().wrapping_mul(0x85EB_CA77)) ^ seed;
    for _ in 0..2 {
        bits = (bits ^ bits >> 15).wrapping_mul(0x27D4_EB2F);
    }
    bits.to_be_bytes()[0]
}

/// Noise unique for each `seed`, with the target at each of `places`. The target's top left pixel depends on `seed`.
fn picture(seed: u32, places: &[(i32, i32)]) -> Vec<u8> {
    let side = i32::from(SIDE);
    let pixel = |x: i32, y: i32| {
        let place =
            places.iter().find(|&&(left, top)| (left..left + side).contains(&x) && (top..top + side).contains(&y));
        match place {
            Some(&place) if place == (x, y) => seed.to_le_bytes()[0].wrapping_mul(40),
            Some(&(left, top)) => noise(x - left, y - top, 7),
            None => noise(x, y, seed << 8),
        }
    };
    (0..i32::from(HEIGHT)).flat_map(|y| (0..i32::from(WIDTH)).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}

fn frame(pixels: &[u8]) -> Frame<'_> {
    Frame::whole(Image::new(pixels, WIDTH, HEIGHT).expect("a picture of this size"))
}

fn at((x, y): (i32, i32)) -> Rect {
    Rect::new(x, y, SIDE, SIDE)
}

fn locked(config: Config, place: (i32, i32)) -> Follower {
    let mut tracker = Follower::with(config).expect("a configuration that can be used");
    tracker.lock(&frame(&picture(1, &[place])), at(place)).expect("a box in the picture");
    tracker
}

fn with(mut config: Config, change: impl FnOnce(&mut Config)) -> Config {
    change(&mut config);
    config
}

fn update(tracker: &mut Follower, seed: u32, places: &[(i32, i32)]) -> Answer {
    tracker.update(&frame(&picture(seed, places))).expect("a frame of the same size")
}

/// Updates the tracker with a frame that has the target at `place`. Returns true if the template was updated from this
/// frame: the template's top left pixel then equals the target's in this frame, which depends on `seed`.
fn learns(tracker: &mut Follower, seed: u32, place: (i32, i32)) -> bool {
    let answer = update(tracker, seed, &[place]);
    assert_eq!((answer.bbox, answer.state), (at(place), State::Tracking));
    let corner = usize::try_from(place.1 * i32::from(WIDTH) + place.0).unwrap();
    tracker.target().template().unwrap().row(0)[0] == picture(seed, &[place])[corner]
}

#[test]
fn the_template_is_updated_only_inside_the_zone() {
    // Places on both sides of each limit of `update_zone`: x >= 20, y >= 20, x + 12 < 90 - 1, y + 12 < 70 - 1 (boxes of
    // 12x12 pixels, frames of 90x70).
    let places = [(20, 20), (19, 20), (20, 19), (76, 56), (77, 56), (76, 57), (30, 30), (19, 56), (76, 19)];
    let mut tracker = locked(Config::paper(), (40, 30));
    for (seed, place) in (2..).zip(places) {
        let (x, y) = place;
        let in_zone = x >= 20 && y >= 20 && x + 12 < 90 - 1 && y + 12 < 70 - 1;
        assert_eq!(learns(&mut tracker, seed, place), in_zone, "at {place:?}");
    }
}

#[test]
fn a_camera_updates_up_to_the_edge() {
    let mut tracker = locked(Config::camera(), (30, 30));
    for (seed, place) in (2..).zip([(0, 30), (0, 0), (30, 40), (78, 58)]) {
        assert!(learns(&mut tracker, seed, place), "at {place:?}");
    }
}

/// Among the paper's gates, only `gate_tracking` is at most 1. Under such a gate, the tracker reports no runner-up
/// below the peak. So a runner-up in an answer shows that another gate applied.
#[test]
fn returning_takes_more_until_a_lost_target_is_found_again() {
    let mut tracker = locked(Config::paper(), (10, 30));
    let mut step = |seed, place: (i32, i32), state| {
        let answer = update(&mut tracker, seed, &[place]);
        assert_eq!(answer.state, state, "at {place:?}");
        answer.runner_up_ratio.is_some()
    };
    assert!(!step(2, (5, 30), State::Tracking), "inside, and never outside before");
    assert!(step(3, (-3, 30), State::Leaving));
    for seed in 4..8 {
        assert!(step(seed, (5, 30), State::Tracking), "it has been outside: frame {seed}");
    }
    let nowhere = (200, 200);
    assert!(step(8, nowhere, State::Lost));
    assert!(step(9, nowhere, State::Lost));
    assert!(step(10, (20, 30), State::Tracking), "found again");
    assert!(!step(11, (22, 30), State::Tracking), "as if it had never been outside");
}

/// A peak partly outside the frame sets the tracker's flag `edge`, even if the gate refuses the peak.
#[test]
fn a_peak_outside_that_is_not_accepted_counts_until_the_target_is_found_again() {
    let config =
        with(Config::paper(), |config| (config.gate_leaving.numerator, config.gate_lead) = (u16::MAX, u16::MAX));
    let mut tracker = locked(config, (5, 30));
    assert_eq!(update(&mut tracker, 2, &[(-3, 30)]).state, State::Lost);
    let found = update(&mut tracker, 3, &[(4, 30)]);
    assert_eq!((found.state, found.bbox), (State::Tracking, at((4, 30))));
    assert_eq!(update(&mut tracker, 4, &[(4, 30)]).runner_up_ratio, None);
}

#[test]
fn a_peak_that_is_no_larger_than_the_runner_up_is_not_accepted() {
    let twins = [(30, 30), (42, 30)];
    let answer = update(&mut locked(Config::paper(), (30, 30)), 1, &twins);
    assert_eq!((answer.state, answer.runner_up_ratio), (State::Lost, Some(answer.ratio)));
    // Offsets in the peak's neighbourhood cannot be the runner-up.
    for (neighbourhood, state) in [(11, State::Lost), (12, State::Tracking)] {
        let config = with(Config::paper(), |config| config.neighbourhood = neighbourhood);
        assert_eq!(update(&mut locked(config, (30, 30)), 1, &twins).state, state);
    }
    let answer = update(&mut locked(Config::camera(), (30, 30)), 1, &twins);
    assert_eq!((answer.state, answer.bbox), (State::Tracking, at((30, 30))), "a camera follows the closest");
}

#[test]
fn a_lead_of_many_pixels_is_enough_in_every_state() {
    let accepted = |lead: u16, places: &[(i32, i32)]| {
        let mut config = Config::paper();
        for ratio in [&mut config.gate_tracking, &mut config.gate_leaving, &mut config.gate_lost] {
            ratio.numerator = u16::MAX;
        }
        config.gate_lead = lead;
        let mut tracker = locked(config, (5, 30));
        let answers = (2..).zip(places).map(|(seed, &place)| update(&mut tracker, seed, &[place]));
        answers.last().is_some_and(|answer| answer.state != State::Lost)
    };
    let nowhere = (200, 200);
    for path in [&[(6, 30)][..], &[(-2, 30)], &[nowhere, (6, 30)], &[nowhere, (-2, 30)]] {
        assert!(accepted(80, path), "{path:?}");
        assert!(!accepted(144, path), "{path:?}");
    }
}

/// A frame of width 320 with padding of 20 pixels on both sides has 360 offsets for a box of width 1, 359 for width 2.
#[test]
fn a_capacity_that_cannot_hold_the_window_is_refused_when_locking() {
    let pixels = vec![7; 320 * 240];
    let frame = Frame::whole(Image::new(&pixels, 320, 240).unwrap());
    let lock = |config, width| {
        let mut tracker = Box::new(Tracker::<Paper<256, 359>>::with(config).unwrap());
        tracker.lock(&frame, Rect::new(20, 20, width, 8)).map(|_| ())
    };
    assert_eq!(lock(Config::paper(), 2), Ok(()));
    assert_eq!(lock(Config::paper(), 1), Err(smr_core::LockError::WindowTooLarge));
    assert_eq!(lock(Config::camera(), 1), Ok(()));
}

#[test]
fn a_least_ratio_is_asked_of_the_peak_alone() {
    let mut tracker = locked(with(Config::camera(), |config| config.least_ratio = u16::MAX / 2), (30, 30));
    assert_eq!(update(&mut tracker, 2, &[]).state, State::Lost);
    let answer = update(&mut tracker, 3, &[(33, 28)]);
    assert_eq!((answer.state, answer.bbox), (State::Tracking, at((33, 28))));
}

#[test]
fn margins_are_kept_inside_the_picture() {
    let picture = Rect::new(0, 0, 64, 48);
    let margins = Margins { left: 1, top: 2, right: 3, bottom: 4 };
    assert!(margins.kept_by(Rect::new(1, 2, 60, 42), picture));
    for other in [Rect::new(0, 2, 60, 42), Rect::new(1, 1, 60, 42), Rect::new(1, 2, 61, 42), Rect::new(1, 2, 60, 43)] {
        assert!(!margins.kept_by(other, picture));
        assert!(Margins::NONE.kept_by(other, picture));
    }
    assert!(!Margins::NONE.kept_by(Rect::new(-1, 0, 5, 5), picture));
    assert!(!Margins::NONE.kept_by(Rect::new(i32::MAX, i32::MIN, u16::MAX, u16::MAX), picture));
}

const TARGET: Rect = Rect::new(60, 40, 24, 24);

/// Noise of gray levels 40 to 167, plus `light`; if `uneven`, every seventh pixel is one level brighter.
fn lit(light: u8, uneven: bool) -> Vec<u8> {
    let mut state = 3_u32;
    let noise = std::iter::repeat_with(move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state.to_be_bytes()[0]
    });
    let uneven = |index: usize| u8::from(uneven && index.is_multiple_of(7));
    noise.take(160 * 120).enumerate().map(|(index, level)| level / 2 + 40 + light + uneven(index)).collect()
}

fn states(config: Config) -> Vec<(Rect, State)> {
    let pictures = [lit(0, false), lit(1, true), lit(3, false)];
    let frame = |pixels| Frame::whole(Image::new(pixels, 160, 120).expect("160x120 pixels"));
    let mut tracker = Tracker::<Paper<576, 200>>::with(config).expect("a configuration that can be used");
    tracker.lock(&frame(&pictures[0]), TARGET).expect("a box in the picture");
    let answers = pictures[1..].iter().map(|pixels| tracker.update(&frame(pixels)).expect("a frame of the same size"));
    answers.map(|answer| (answer.bbox, answer.state)).collect()
}

#[test]
fn two_gray_levels_of_light_after_a_still_scene_do_not_move_the_box() {
    assert_eq!(states(Config::camera()), [(TARGET, State::Tracking); 2]);
    // By the paper's rule the threshold alpha falls to one gray level, so no pixel matches after the light has changed.
    let paper = states(Config::paper());
    assert_eq!(paper[0], (TARGET, State::Tracking));
    assert_ne!(paper[1], (TARGET, State::Tracking));
}

/// With `least_threshold` 0 hardly any pixel matches after a change of light, so the peak is accidental. `least_ratio`
/// refuses such a peak.
#[test]
fn a_peak_of_a_few_pixels_is_not_accepted() {
    let config = with(Config::camera(), |config| config.least_threshold = 0);
    assert_eq!(states(config)[1], (TARGET, State::Lost));
    assert_ne!(states(with(config, |config| config.least_ratio = 0))[1].0, TARGET);
}

/// The sizes in bytes of target and workspace, from the README's table row that begins with `beginning`.
fn row(beginning: &str) -> (usize, usize) {
    let readme = include_str!("../README.md");
    let row = readme.lines().find(|line| line.starts_with(beginning)).unwrap_or_else(|| panic!("no row {beginning}"));
    let mut cells = row.split('|').skip(2).map(|cell| cell.trim().replace(',', "").parse().expect("a number"));
    (cells.next().expect("the target"), cells.next().expect("the workspace"))
}

fn states_the_memory_of<const PIXELS: usize, const SPAN: usize>() {
    let sizes = (size_of::<Paper<PIXELS, SPAN>>(), size_of::<Workspace<PIXELS, SPAN>>());
    assert_eq!(sizes, row(&format!("| `Paper<{PIXELS}, {SPAN}>`")));
}

#[cfg(target_pointer_width = "64")]
#[test]
fn the_readme_states_the_memory() {
    states_the_memory_of::<1024, 33>();
    states_the_memory_of::<4096, 33>();
    states_the_memory_of::<4096, 161>();
    let with = if cfg!(feature = "refiner") { " with the feature `refiner`" } else { "" };
    let robust = row(&format!("| `Robust`{with} |"));
    assert_eq!((size_of::<Robust>(), size_of::<robust::Workspace>()), robust);
    let small = row(&format!("| `Robust<Small>`{with} |"));
    assert_eq!((size_of::<Robust<robust::Small>>(), size_of::<robust::Workspace<robust::Small>>()), small);
}

/// The largest first window, the largest while the target is calm, and the largest second window of a robust target in a
/// box of `width` x `height` pixels, in bytes for each pixel of the box.
fn windows(config: robust::Config, (width, height): (u16, u16)) -> [f64; 3] {
    let (across, down) = (640, 480);
    let area = |window: Option<Rect>| window.map_or(0.0, |window| f64::from(window.area()));
    let mut tracker = Box::new(Tracker::<Robust>::with(config).expect("a configuration that can be used"));
    let pixels: Vec<u8> = (0..i32::from(across) * i32::from(down)).map(|at| noise(at, 0, 1)).collect();
    let black = vec![0; pixels.len()];
    let [seen, black] =
        [&pixels, &black].map(|pixels| Frame::whole(Image::new(pixels, across, down).expect("a picture")));
    let target = Rect::new(i32::from(across - width) / 2, i32::from(down - height) / 2, width, height);
    tracker.lock(&seen, target).expect("a box in the picture");
    let first = area(tracker.window());
    for _ in 0..4 {
        tracker.update(&seen).expect("a frame of the same size");
    }
    let calm = area(tracker.window());
    let lost = |_| {
        tracker.update(&black).expect("a frame of the same size");
        area(tracker.sweep_window())
    };
    let second = (0..40).map(lost).fold(0.0, f64::max);
    [first, calm, second].map(|pixels| pixels / f64::from(width) / f64::from(height))
}

#[test]
fn the_readme_states_the_memory_of_the_windows() {
    let kinds = [
        ("robust", robust::Config::robust()),
        #[cfg(feature = "refiner")]
        ("refined", robust::Config::refined()),
    ];
    for (name, config) in kinds {
        let mut once = config;
        once.sweep = 1;
        for (what, boxes) in [
            ("square box", [(20, 20), (21, 21), (23, 23), (40, 40)]),
            ("four times as long as wide", [(80, 20), (20, 80), (41, 164), (30, 120)]),
        ] {
            let largest = |config| {
                boxes
                    .map(|size| windows(config, size))
                    .into_iter()
                    .reduce(|a, b| [0, 1, 2].map(|at| f64::max(a[at], b[at])))
            };
            let ([first, calm, second], [.., one]) = (largest(config).expect("boxes"), largest(once).expect("boxes"));
            let row = format!("| `{name}`, {what} | {first:.1} | {calm:.1} | {second:.1} | {one:.1} |");
            assert!(include_str!("../README.md").contains(&row), "core/README.md: {row}");
        }
    }
}
