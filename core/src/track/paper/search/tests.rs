//! Tests the search against a map of all scores: the result must be the same with any pruning, backend and step size.

use super::*;
use crate::similarity::{Backend, CutTable, Scorer, Table, score_at};
use crate::{Frame, Image, Rect};
use core::cmp::Reverse;
use proptest::prelude::*;
use std::{vec, vec::Vec};

/// Pictures that are difficult for the bounds and the tie rule of a search.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Noise,
    /// Noise of few gray levels.
    Faint,
    Constant,
    /// Random black and white pixels.
    Saturated,
    Periodic,
    /// Each column alternates between two gray levels, so every block of 4x4 pixels has the same range.
    EqualRanges,
    Gradient,
}

const KINDS: [Kind; 7] =
    [Kind::Noise, Kind::Faint, Kind::Constant, Kind::Saturated, Kind::Periodic, Kind::EqualRanges, Kind::Gradient];

fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let bits = (x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ seed).wrapping_mul(0xC2B2_AE35);
    (bits ^ bits >> 15).wrapping_mul(0x27D4_EB2F) >> 24
}

impl Kind {
    fn level(self, x: u32, y: u32, seed: u32) -> u8 {
        let level = match self {
            Self::Noise => hash(x, y, seed),
            Self::Faint => 100 + hash(x, y, seed) % 6,
            Self::Constant => seed % 256,
            Self::Saturated => 255 * (hash(x, y, seed) % 2),
            Self::Periodic => 60 + 90 * ((x / 2 + y / 2 + seed) % 2),
            Self::EqualRanges => 100 + 50 * ((y + hash(x, 0, seed)) % 2),
            Self::Gradient => (x * 3 + y * 2 + seed) % 256,
        };
        level as u8
    }
}

/// A frame, and a template that may occur in it.
#[derive(Clone, Debug)]
struct Case {
    kind: Kind,
    seed: u32,
    frame: (u16, u16),
    template: (u16, u16),
    /// Largest noise added to a pixel of the template, in gray levels.
    noise: u8,
    window: Window,
    threshold: u16,
    neighbourhood: u16,
    scale: &'static Table,
}

static STEEP: Table = match Table::new(20) {
    Ok(table) => table,
    Err(_) => panic!("20 is in range"),
};

/// The capacity of the search in pixels: the size of the largest template, so that large windows need several tiles.
const PIXELS: usize = 24 * 20;

prop_compose! {
    fn case()(
        kind in prop::sample::select(&KINDS[..]),
        seed in any::<u32>(),
        frame in (1u16..70, 1u16..60),
        template in (1u16..=24, 1u16..=20),
        place in (-6i32..70, -6i32..60),
        radius in (0u16..34, 0u16..30),
        noise in prop::sample::select(vec![0u8, 1, 5, 40]),
        threshold in prop_oneof![0u16..=64, 0u16..=256],
        neighbourhood in 0u16..10,
        steep in any::<bool>(),
    ) -> Case {
        let template = (template.0.min(frame.0), template.1.min(frame.1));
        let padding = 6;
        let at = |at: i32, frame: u16, size: u16| at.min(i32::from(frame) + padding - i32::from(size));
        let target = Rect::new(at(place.0, frame.0, template.0), at(place.1, frame.1, template.1), template.0, template.1);
        let bounds = Rect::new(0, 0, frame.0, frame.1);
        let window = Window::new(target, Radius { x: radius.0, y: radius.1 }, bounds, 6);
        let scale = if steep { &STEEP } else { &Table::PAPER };
        Case { kind, seed, frame, template, noise, window, threshold, neighbourhood, scale }
    }
}

impl Case {
    fn pixels(&self) -> (Vec<u8>, Vec<u8>) {
        let (width, height) = (u32::from(self.frame.0), u32::from(self.frame.1));
        let frame = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let frame: Vec<u8> = frame.map(|(x, y)| self.kind.level(x, y, self.seed)).collect();
        let (left, top) = (width - u32::from(self.template.0), height - u32::from(self.template.1));
        let (left, top) = (self.seed % (left + 1), self.seed / 7 % (top + 1));
        let mut template = Vec::new();
        for y in 0..u32::from(self.template.1) {
            for x in 0..u32::from(self.template.0) {
                let level = frame[((top + y) * width + left + x) as usize];
                let noise = hash(x, y, self.seed ^ 1) % (u32::from(self.noise) + 1);
                template.push(level.saturating_add(noise as u8));
            }
        }
        (frame, template)
    }

    /// The result by definition, from the scores of all offsets.
    fn expected(&self, wanted: Wanted, score: impl Fn(i32, i32) -> u32) -> Peaks {
        let all = || self.window.ys().flat_map(|y| self.window.xs().map(move |x| (x, y)));
        let peaks = all().map(|(x, y)| Peak { x, y, score: score(x, y) });
        let (centre_x, centre_y) = self.window.centre();
        let order = |peak: &Peak| {
            let (dx, dy) = (i64::from(peak.x - centre_x), i64::from(peak.y - centre_y));
            (Reverse(peak.score), dx * dx + dy * dy, peak.y, peak.x)
        };
        let peak = peaks.min_by_key(order).unwrap();
        let near = i32::from(self.neighbourhood);
        let far = all().filter(|(x, y)| (x - peak.x).abs().max((y - peak.y).abs()) > near);
        let runner_up = far.map(|(x, y)| score(x, y)).max().unwrap_or(0);
        let is_wanted = match wanted {
            Wanted::Peak => false,
            Wanted::Equals(_) => peak.score > 0 && runner_up == peak.score,
            Wanted::RunnerUp(_) => true,
        };
        Peaks { peak, runner_up: is_wanted.then_some(runner_up) }
    }
}

impl Case {
    /// An upper bound of the work: little more than scoring every offset, even if no offset can be excluded.
    fn most_work(&self) -> u64 {
        let (columns, rows) = self.window.size();
        let (offsets, pixels) = ((columns * rows) as u64, u64::from(self.template.0) * u64::from(self.template.1));
        // Scoring every offset, times 9/8: 1/16 more for ranges, 1/32 for the descent, 1/32 for scouts. Then one bound
        // for each group, and 3 more scores.
        let groups = (columns.div_ceil(4) * rows.div_ceil(4)) as u64;
        // Words of working memory that are read: each maximum twice, each group at most 8 times.
        let words = 2 * (columns + rows) as u64 + 8 * groups;
        offsets * pixels * 9 / 8 + (groups + 3) * (pixels + 4) + words
    }
}

#[derive(Clone, Copy, Debug)]
struct Way {
    pruning: bool,
    wanted: Wanted,
    /// Searches for the peak first, then again for the runner-up.
    afterwards: bool,
    work: u32,
}

fn search(case: &Case, backend: Backend, frame: Frame<'_>, template: Image<'_>, way: Way) -> (Peaks, u64) {
    let table = CutTable::new(case.scale, case.threshold);
    let scorer = Scorer::new(backend, &table);
    let scene = Scene { frame, template, window: case.window, scorer: &scorer };
    let mut search = Search::<PIXELS, 128>::new();
    search.begin(&scene.window, way.pruning, if way.afterwards { Wanted::Peak } else { way.wanted });
    let mut work = 0;
    let mut run = |search: &mut Search<PIXELS, 128>| {
        while !search.is_done() {
            work += u64::from(search.step(&scene, way.work));
        }
    };
    run(&mut search);
    if way.afterwards {
        search.begin_runner_up(&scene, case.neighbourhood);
        run(&mut search);
    }
    (search.peaks(&case.window).unwrap(), work)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 3 } else { 1500 }))]

    #[test]
    fn peak_and_runner_up_are_those_of_the_whole_map(
        case in case(),
        (pruning, wanted) in (any::<bool>(), 0..4usize),
        work in prop::sample::select(vec![1u32, 100, 3000, u32::MAX, u32::MAX]),
    ) {
        let (pixels, template) = case.pixels();
        let frame = Frame::whole(Image::new(&pixels, case.frame.0, case.frame.1).unwrap());
        let template = Image::new(&template, case.template.0, case.template.1).unwrap();
        let table = CutTable::new(case.scale, case.threshold);
        let plain = Scorer::new(Backend::Scalar, &table);
        let nearby = case.neighbourhood;
        let afterwards = wanted == 3;
        let wanted = [Wanted::Peak, Wanted::Equals(nearby), Wanted::RunnerUp(nearby), Wanted::RunnerUp(nearby)][wanted];
        let expected = case.expected(wanted, |x, y| score_at(&frame, template, x, y, &plain).unwrap());
        let way = Way { pruning, wanted, afterwards, work };
        for backend in Backend::available() {
            let (found, work) = search(&case, backend, frame, template, way);
            prop_assert_eq!(found, expected, "{:?}, {:?}, {:?}", backend, way, &case);
            let is_cheap = !pruning || afterwards || way.work < u32::MAX || work <= case.most_work();
            prop_assert!(is_cheap, "{} of {}, {:?}", work, case.most_work(), &case);
        }
    }
}
