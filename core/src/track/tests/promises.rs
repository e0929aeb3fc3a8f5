//! Tests both trackers in random films: no answer depends on how its frame arrives, and no value leaves its bounds.

use super::*;
use crate::MostWork;
use crate::robust::Size;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

/// The texture of a target, of its background, or of a cover over both.
#[derive(Clone, Copy, Debug)]
enum Look {
    Flat(i32),
    Tiles(i32),
    Slopes,
    /// A checkerboard of black and white squares with this side in pixels. Black and white swap from frame to frame.
    Board(i32),
}

impl Look {
    const NOISE: Self = Self::Tiles(1);

    fn level(self, (x, y): (i32, i32), seed: i32, frame: i32) -> i32 {
        match self {
            Self::Flat(level) => level,
            Self::Tiles(side) => {
                let mixed = ((x / side) ^ ((y / side) << 16) ^ seed).wrapping_mul(-1_640_531_535);
                (mixed ^ mixed >> 15).wrapping_mul(739_982_445) >> 24 & 255
            }
            Self::Slopes => ((5 * x + 3 * y + seed % 99).rem_euclid(400) - 200).abs() + 30,
            Self::Board(side) => 255 * ((x / side + y / side + frame) & 1),
        }
    }
}

/// A sequence of 1 + `more` similar frames.
#[derive(Clone, Debug, Default)]
struct Shot {
    more: i32,
    cover: Option<Look>,
    /// The position to which the target jumps, in 1/256 of the frame.
    jump: Option<(i32, i32)>,
    /// The target's motion (right, down) in pixels per frame, and its growth per frame in percent of its first size.
    step: (i32, i32, i32),
    /// The change of the shot's gray levels, in percent of each level; negative is darker.
    light: i32,
    grain: i32,
}

#[derive(Clone, Debug)]
struct Film {
    size: (u16, u16),
    target: Rect,
    looks: [Look; 2],
    seed: i32,
    shots: Vec<Shot>,
}

impl Film {
    /// The first frame, on which the trackers lock, and the frames of all shots.
    fn frames(&self) -> Vec<Vec<u8>> {
        let (mut place, mut zoom, mut frames) = ((self.target.x, self.target.y), 100, vec![]);
        for shot in [&Shot::default()].into_iter().chain(&self.shots) {
            let there = |(x, y)| (i32::from(self.size.0) * x / 256, i32::from(self.size.1) * y / 256);
            place = shot.jump.map_or(place, there);
            for _ in 0..=shot.more {
                place = (place.0 + shot.step.0, place.1 + shot.step.1);
                zoom = (zoom + shot.step.2).clamp(40, 250);
                frames.push(self.frame(shot, place, zoom, frames.len() as i32));
            }
        }
        frames
    }

    fn frame(&self, shot: &Shot, (left, top): (i32, i32), zoom: i32, number: i32) -> Vec<u8> {
        let [across, down] = [self.target.width, self.target.height].map(|side| i32::from(side) * zoom);
        drawn(self.size, |x, y| {
            let (u, v) = (100 * (x - left), 100 * (y - top));
            let is_inside = (0..across).contains(&u) && (0..down).contains(&v);
            let level = match shot.cover {
                Some(cover) => cover.level((x, y), number, number),
                None if is_inside => self.looks[0].level((u / zoom, v / zoom), self.seed, number),
                None => 90 + self.looks[1].level((x, y), !self.seed, number) / 4,
            };
            let grain = shot.grain * (Look::NOISE.level((x, y), number, 0) - 128) / 128;
            (level * (100 + shot.light) / 100 + grain).clamp(0, 255) as u8
        })
    }
}

fn look() -> impl Strategy<Value = Look> {
    let flat = prop::sample::select(&[0, 77, 255][..]).prop_map(Look::Flat);
    prop_oneof![5 => (1..7).prop_map(Look::Tiles), 2 => Just(Look::Slopes), 1 => (1..20).prop_map(Look::Board), 1 => flat]
}

fn grant() -> impl Strategy<Value = u32> {
    prop_oneof![Just(0), 1..1000_u32, 1000..100_000_u32, 100_000..4_000_000_u32, Just(u32::MAX)]
}

prop_compose! {
    fn shot(most: i32, hides: bool)(
        more in 0..most,
        cover in look(),
        jump in prop::option::weighted(0.3, (0..256, 0..256)),
        step in (-4..=4, -4..=4, prop_oneof![2 => Just(0), 1 => -3..=3]),
        light in prop_oneof![3 => Just(0), 1 => -70..=60],
        grain in prop::sample::select(&[0, 0, 4, 25][..]),
    ) -> Shot {
        Shot { more, cover: hides.then_some(cover), jump, step, light, grain }
    }
}

prop_compose! {
    /// A film in which the target is visible, hidden, and back.
    fn film(most: u32)(
        size in prop_oneof![9 => (30..=170_u16, 30..=130_u16), 1 => (1..=9_u16, 1..=9_u16), 1 => (1..=4_u16, 200..=900_u16)],
        sides in prop_oneof![4 => [20..100_u32, 20..100_u32], 1 => [1..=256_u32, 1..=256_u32]],
        place in [0..=256_u32, 0..=256_u32],
        looks in [look(), look()],
        seed in any::<i32>(),
        shots in [shot(4, false), shot(8, true), shot(7, false)],
    ) -> Film {
        let part = |whole: u16, part: u32| (u32::from(whole) * part / 256) as u16;
        let (width, height) = (part(size.0, sides[0]).max(1), part(size.1, sides[1]).max(1));
        let [x, y] = [part(size.0 - width, place[0]), part(size.1 - height, place[1])];
        let target = at_most(most, Rect::new(x.into(), y.into(), width, height));
        Film { size, target, looks, seed, shots: shots.into() }
    }
}

/// `target`, cut on the right and below to at most `most` pixels.
fn at_most(most: u32, target: Rect) -> Rect {
    let width = target.width.min(most.min(65_535) as u16);
    Rect { width, height: target.height.min((most / u32::from(width)).min(65_535) as u16), ..target }
}

/// The way in which the second of two trackers gets a frame. The first gets it whole, in one update.
#[derive(Clone, Debug, Default)]
struct Way {
    /// The work granted to each step.
    grant: u32,
    /// If set to n, each step of an update is a call of `update_step_until` whose deadline has expired at the n-th
    /// check. `grant` is then unused.
    until: Option<u32>,
    /// Only the windows that the tracker reads are in memory.
    part: bool,
    /// The tracker is restored from saved bytes, as after a loss of power.
    restored: bool,
    /// Before each update, another target is updated in the same workspace.
    shared: bool,
    /// The turn of the camera (right, down), in units of 1/256 pixel, that both trackers are told before the frame.
    turn: Option<(i32, i32)>,
    /// A call to interrupt before the update: (its grant in 1/256 of the last call's work; number of the interrupting
    /// call in `call`; true to interrupt a lock, false an update). `restored` and `shared` are then ignored.
    interrupted: Option<(u32, usize, bool)>,
}

prop_compose! {
    fn way()(
        grant in grant(),
        until in prop::option::weighted(0.2, 1..9_u32),
        [part, restored, shared] in any::<[bool; 3]>(),
        turn in prop::option::weighted(0.15, prop_oneof![(-9000..9000, -9000..9000), any::<(i32, i32)>(), Just((i32::MAX, i32::MIN))]),
        interrupted in prop::option::weighted(0.3, (0..256_u32, 0..CALLS, prop::bool::weighted(0.25))),
    ) -> Way {
        Way { grant, until, part, restored, shared, turn, interrupted }
    }
}

/// The parameters and checks of a tracker under test.
pub(super) trait Filmed: Target<Config: Debug> {
    const FILMS: u32;
    /// The largest number of pixels of a target.
    const PIXELS: u32;

    fn configs() -> BoxedStrategy<Self::Config>;

    /// Checks the promises that only this tracker makes for an answer.
    fn check_answer(tracker: &Tracker<Self>, first: Rect, bounds: Rect, answer: &Answer);
}

impl Filmed for SmallPaper {
    const FILMS: u32 = 100;
    const PIXELS: u32 = 1024;

    fn configs() -> BoxedStrategy<paper::Config> {
        let radius = || prop_oneof![6 => 0..16_u16, 1 => 0..=80_u16];
        let radii = (radius(), radius(), radius(), radius());
        let grown = || prop_oneof![0..30_u16, Just(u16::MAX)];
        (radii, grown(), [grown(), grown()], 1..=60_u8, 0..150_u16, any::<[bool; 4]>())
            .prop_map(
                |(
                    (x, y, across, down),
                    growth,
                    [padding, neighbourhood],
                    first,
                    gate,
                    [always, pruning, zone, few],
                )| {
                    let mut config = if zone { paper::Config::paper() } else { paper::Config::camera() };
                    config.window = paper::Radius { x, y };
                    config.window_limit = paper::Radius { x: x.max(across), y: y.max(down) };
                    (config.growth, config.padding, config.first_threshold) = (growth, padding, first);
                    config.neighbourhood = neighbourhood;
                    config.gate_tracking = paper::Fraction::new(gate, 100);
                    (config.runner_up_always, config.pruning) = (always, pruning);
                    config.gate_lead = if few { 100 } else { u16::MAX };
                    config
                },
            )
            .boxed()
    }

    fn check_answer(tracker: &Tracker<Self>, first: Rect, bounds: Rect, answer: &Answer) {
        let (bbox, border) = (answer.bbox, i32::from(tracker.config().padding));
        assert_eq!((bbox.width, bbox.height, answer.scale), (first.width, first.height, 65_536));
        assert!(bbox.x >= -border && bbox.right() <= bounds.right() + border);
        assert!(bbox.y >= -border && bbox.bottom() <= bounds.bottom() + border);
        let found = if bounds.contains(bbox) { State::Tracking } else { State::Leaving };
        let is_lost = answer.state == State::Lost;
        assert!(if is_lost {
            answer.confidence == 0
        } else {
            (answer.state, answer.confidence) == (found, answer.ratio)
        });
    }
}

impl<S: Size> Filmed for Robust<S> {
    const FILMS: u32 = 32;
    const PIXELS: u32 = u32::MAX;

    fn configs() -> BoxedStrategy<robust::Config> {
        let patience = prop_oneof![Just((179, 19_200)), Just((0, u16::MAX)), (any::<u8>(), 0..=32_500_u16)];
        let largest = u8::try_from(S::REACH).unwrap();
        (4..=largest, patience, prop_oneof![Just(160), 0..=256_u16], (0..=8_u8, any::<[bool; 2]>()))
            .prop_map(|(reach, (patience, lost_below), learning_rate, (sweep, [size, refiner]))| {
                let mut config = robust::Config::robust();
                (config.patience, config.lost_below) = (patience, lost_below);
                config.uncertain_below = lost_below.max(32_500);
                (config.reach, config.learning_rate, config.size, config.sweep) = (reach, learning_rate, size, sweep);
                config.refiner = refiner && cfg!(feature = "refiner");
                config
            })
            .boxed()
    }

    fn check_answer(tracker: &Tracker<Self>, _: Rect, bounds: Rect, answer: &Answer) {
        // The centre of the box stays on the frame, so the box overlaps or touches it.
        let Rect { x, y, width, height } = answer.bbox;
        let around = Rect::new(x - 1, y - 1, width.saturating_add(2), height.saturating_add(2));
        assert!(!answer.bbox.is_empty() && !around.intersection(bounds).is_empty());
        assert!((65_536 / 5..=5 * 65_536).contains(&answer.scale));
        assert!(answer.state != State::Leaving && tracker.workspace().response().abs() <= 1 << 24);
    }
}

/// The number of different calls, in [`call`], that interrupt an update or lock.
const CALLS: usize = 8;

/// Returns true if the call was refused, and has changed nothing.
fn call<T: Filmed>(tracker: &mut Tracker<T>, number: usize, frame: &Frame<'_>, first: Rect, bytes: &[u8]) -> bool {
    let corner = Rect { x: 0, y: 0, ..first };
    match number {
        0 => tracker.restore(bytes).unwrap(),
        1 => tracker.moved(256, 0),
        2 => drop(tracker.lock(frame, first).unwrap()),
        3 => drop(tracker.lock_step(frame, corner, u32::MAX).unwrap().unwrap()),
        4 => return tracker.update(frame).is_err(),
        5 => tracker.parts().0.restore(bytes).unwrap(),
        6 => tracker.configure(*tracker.config()).unwrap(),
        _ => *tracker.parts().1 = T::Workspace::default(),
    }
    false
}

/// Repeats `step` until the call is done. Each step must progress, and exceed its grant by at most `beyond`.
fn stepped<T: Filmed, A>(
    tracker: &mut Tracker<T>,
    (grant, beyond, most): (u32, u64, u64),
    step: impl Fn(&mut Tracker<T>) -> Option<A>,
    refused: impl Fn(&mut Tracker<T>),
) -> A {
    let (mut before, mut idle) = (0, 0);
    loop {
        let (done, work) = (step(tracker), tracker.work());
        assert!(u64::from(work - before) <= u64::from(grant.max(1)) + beyond, "{before} to {work}: {grant}, {beyond}");
        assert!(u64::from(work) <= most, "{work} of {most}");
        if let Some(done) = done {
            return done;
        }
        // A step costs nothing if only the best offset so far is left to score. A call has at most two such steps.
        idle += u32::from(work == before);
        assert!(idle < 3, "every step makes progress");
        refused(tracker);
        assert_eq!(tracker.work(), work, "calls that are refused leave what is under way");
        before = work;
    }
}

/// Frames that lack one row or column of the window, or the whole second window.
fn lacking<'a>(frame: &Frame<'a>, window: Rect, second: Option<Rect>) -> Vec<Frame<'a>> {
    let Rect { x, y, width, height } = window;
    let [left, top] = [Rect { x: x + 1, width: width - 1, ..window }, Rect { y: y + 1, height: height - 1, ..window }];
    let less = [left, top, Rect { x, ..left }, Rect { y, ..top }];
    let first = second.filter(|second| !window.contains(*second)).map(|_| window);
    less.into_iter().chain(first).filter(|part| !part.is_empty()).map(|part| cut(frame, part)).collect()
}

/// Two trackers of one target. The second shares its workspace with another target.
struct Twins<'a, T: Target> {
    film: &'a Film,
    most: MostWork,
    plain: Box<Tracker<T>>,
    other: Box<Tracker<T>>,
    neighbour: T,
}

impl<'a, T: Filmed> Twins<'a, T> {
    fn lock(config: T::Config, film: &'a Film, pixels: &[u8], grant: u32) -> Self {
        let (frame, first) = (of_size(pixels, film.size), film.target);
        let [corner, bounds] = [Rect::new(0, 0, first.width.min(9), first.height.min(9)), frame.bounds()];
        let (plain, mut other) = (locked::<T>(config, &frame, first), Box::new(Tracker::<T>::with(config).unwrap()));
        let mut neighbour = T::with(config).unwrap();
        neighbour.lock(other.parts().1, &frame, corner).unwrap();
        other.lock_step(&frame, corner, 5000).unwrap();
        let (most, window) = (T::most_work(&config, first.width, first.height), other.lock_window(bounds, first));
        assert!(bounds.contains(window) && !window.is_empty());
        let (part, is_one_step) = (cut(&frame, window), T::PIXELS < u32::MAX);
        let beyond = if is_one_step { most.lock } else { most.beyond_a_step.into() };
        let step = |tracker: &mut Tracker<T>| tracker.lock_step(&part, first, grant).unwrap();
        let lacking = lacking(&part, window, None);
        let quality = stepped(&mut other, (grant, beyond, most.lock), step, |tracker| {
            assert_eq!((tracker.bbox(), tracker.state(), tracker.window()), (None, None, None));
            assert_eq!(tracker.update_step(&frame, 1), Err(UpdateError::NotLocked));
            assert_eq!(tracker.save(&mut []), Err(SaveError::NotLocked));
            assert_eq!(tracker.lock_step(&frame, Rect::default(), 1), Err(LockError::BoxEmpty));
            for less in &lacking {
                assert_eq!(tracker.lock_step(less, first, 1), Err(LockError::LockWindowNotInMemory));
            }
        });
        assert_eq!(Some(quality), plain.quality());
        let twins = Self { film, most, plain, other, neighbour };
        twins.agree();
        twins
    }

    /// Checks that both trackers are equal, bit for bit, and that their windows are inside the frame.
    fn agree(&self) {
        assert!(saved(self.plain.target()) == saved(self.other.target()));
        let bounds = Rect::new(0, 0, self.film.size.0, self.film.size.1);
        for window in [self.other.window(), self.other.sweep_window()].into_iter().flatten() {
            assert!(bounds.contains(window) && !window.is_empty(), "{window:?}");
        }
    }

    /// Begins an update (a lock if `locks`) of the second tracker in the frame `elsewhere`, with `part` / 256 of the
    /// last call's work, then interrupts it by the call with index `number` in `call`.
    fn interrupt(&mut self, frame: &Frame<'_>, elsewhere: &Frame<'_>, (part, number, locks): (u32, usize, bool)) {
        let Self { plain, other, film: Film { target: first, .. }, .. } = self;
        let (bytes, grant) = (saved(other.target()), plain.work() / 256 * part);
        if locks {
            other.lock_step(elsewhere, *first, grant).unwrap();
            // An update before the lock is done is refused, and the lock goes on with its frame.
            let frame = if call(other, number, frame, *first, &bytes) { elsewhere } else { frame };
            assert_eq!(other.lock_step(frame, *first, u32::MAX).unwrap(), plain.lock(frame, *first).ok());
            return self.agree();
        }
        match other.update_step(elsewhere, grant).unwrap() {
            None => assert!(saved(other.target()) == bytes, "an unfinished update changes nothing"),
            answer => assert_eq!(plain.update(elsewhere).ok(), answer),
        }
        for tracker in [plain, other] {
            call(tracker, number, frame, *first, &bytes);
            if tracker.bbox().is_none() {
                assert_eq!(tracker.update_step(frame, 1), Err(UpdateError::NotLocked));
                tracker.lock(frame, *first).unwrap();
            }
        }
    }

    fn update(&mut self, frame: &Frame<'_>, way: &Way) -> Answer {
        let Self { film, most, plain, other, neighbour } = self;
        let goes_on = way.interrupted.is_some();
        if way.restored && !goes_on {
            let bytes = saved(other.target());
            **other = Tracker::with(*plain.config()).unwrap();
            other.restore(&bytes).unwrap();
        }
        if way.shared && !goes_on {
            neighbour.update(other.parts().1, frame).unwrap();
        }
        let (before, part) = (other.state(), asked_for(frame, other.target()));
        let answer = in_steps(other, if way.part { &part } else { frame }, way, most);
        assert_eq!(Ok(answer), plain.update(frame));
        assert!(u64::from(plain.work()) <= most.update);
        assert_eq!((Some(answer.fine), Some(answer.state)), (other.bbox(), other.state()));
        assert_eq!(answer.bbox, answer.fine.whole());
        assert_eq!(answer.found_again, before == Some(State::Lost) && answer.state != State::Lost);
        T::check_answer(other, film.target, frame.bounds(), &answer);
        self.agree();
        answer
    }
}

fn in_steps<T: Filmed>(tracker: &mut Tracker<T>, frame: &Frame<'_>, way: &Way, most: &MostWork) -> Answer {
    let lacking = lacking(frame, tracker.window().unwrap(), tracker.sweep_window());
    let (grant, times) = way.until.map_or((way.grant, 1), |times| (10_000 * times, times));
    let step = |tracker: &mut Tracker<T>| {
        let Some(times) = way.until else { return tracker.update_step(frame, grant).unwrap() };
        let mut asked = 0;
        let expired = || (asked += 1, asked == times).1;
        let answer = tracker.update_step_until(frame, expired).unwrap();
        assert!(answer.is_some() || asked == times);
        answer
    };
    let beyond = u64::from(times) * u64::from(most.beyond_a_step);
    stepped(tracker, (grant, beyond, most.update), step, |tracker| {
        for less in &lacking {
            assert_eq!(tracker.update_step(less, 1), Err(UpdateError::WindowNotInMemory));
        }
        assert_eq!(tracker.lock_step(frame, Rect::new(-1, 0, 1, 1), 1), Err(LockError::BoxOutsideFrame));
    })
}

fn promises_hold<T: Filmed>(config: T::Config, film: &Film, grant: u32, ways: &[Way]) -> Vec<Answer> {
    let frames = film.frames();
    let mut twins = Twins::<T>::lock(config, film, &frames[0], grant);
    let answer = |(pixels, way): (&Vec<u8>, &Way)| {
        let frame = of_size(pixels, film.size);
        let (right, down) = way.turn.unwrap_or_default();
        [&mut twins.plain, &mut twins.other].into_iter().for_each(|tracker| tracker.moved(right, down));
        if let Some(interruption) = way.interrupted {
            let reversed: Vec<u8> = pixels.iter().rev().copied().collect();
            twins.interrupt(&frame, &of_size(&reversed, film.size), interruption);
        }
        twins.update(&frame, way)
    };
    frames[1..].iter().zip(ways.iter().cycle()).map(answer).collect()
}

pub(super) fn promises_hold_in_films<T: Filmed>(_: T::Config) {
    let films = (T::configs(), film(T::PIXELS), grant(), prop::collection::vec(way(), 1..9));
    // A film takes long, so the search for a smaller failing one is limited to 20 seconds.
    let numbers = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(T::FILMS) };
    let numbers = ProptestConfig { max_shrink_time: 20_000, ..numbers };
    let ran = TestRunner::new(numbers).run(&films, |(config, film, grant, ways)| {
        promises_hold::<T>(config, &film, grant, &ways);
        Ok(())
    });
    ran.unwrap();
}

/// Tests the smallest, longest and largest frames and boxes. Films show target, noise, black, white, noise, target.
pub(super) fn promises_hold_at_the_edges<T: Filmed>(config: T::Config) {
    for (size, target) in [
        ((1, 1), Rect::new(0, 0, 1, 1)),
        ((1, 2000), Rect::new(0, 0, 1, 2000)),
        ((30, 2000), Rect::new(29, 0, 1, 2000)),
        ((65535, 1), Rect::new(0, 0, 65535, 1)),
        ((65535, 1), Rect::new(65534, 0, 1, 1)),
        ((1, 65535), Rect::new(0, 0, 1, 65535)),
        ((320, 240), Rect::new(0, 0, 320, 240)),
        ((640, 120), Rect::new(5, 40, 600, 16)),
        ((60, 900), Rect::new(20, 30, 12, 800)),
        ((1200, 900), Rect::new(100, 100, 1000, 700)),
    ] {
        let covers = [None, Some(Look::NOISE), Some(Look::Flat(0)), Some(Look::Flat(255)), Some(Look::NOISE), None];
        let shots = covers.map(|cover| Shot { cover, ..Shot::default() }).into();
        let film = Film { size, target: at_most(T::PIXELS, target), looks: [Look::NOISE; 2], seed: 1, shots };
        let ways = [0, 20_000].map(|grant| Way { grant, part: true, ..Way::default() });
        let found = promises_hold::<T>(config, &film, 0, &ways)[0].bbox;
        let edges = |of: Rect| [of.x, of.y, of.right(), of.bottom()];
        let off = edges(found).into_iter().zip(edges(film.target)).map(|(found, wanted)| found.abs_diff(wanted)).max();
        assert!(off <= Some(1), "{size:?}: {found:?} for {:?}", film.target);
    }
}
