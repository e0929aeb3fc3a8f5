//! Comparison of the robust tracker with its reference, in each frame: sampling grid, requested windows, features,
//! response map, redetection, largest filter response, similarity to the early template (`ratio`), confidence, identity,
//! state, scale, box, filter weights, early template. smr-core gets only the pixels in the windows that it requests.

use super::{Checked, Sides, Violation, differs};
use anyhow::{Context, Result};
use serde::Serialize;
use smr_core::robust::{CHANNELS, Size};
use smr_core::{Answer, Frame, Image, Rect, Robust, State, Target, Tracker, unstable};
use smr_recordings::GrayFrame;
use smr_reference::robust::{Decision, Numbers, Reference, Step};

#[derive(Clone, Debug, Default, Serialize)]
pub struct Counts {
    pub responses: u64,
    /// Frames in which the target was uncertain, and frames in which it was lost.
    pub uncertain: usize,
    pub lost: usize,
    pub learned: usize,
    /// Frames in which the whole frame was searched for a lost target, and frames in which that search found it.
    pub swept: usize,
    pub found_again: usize,
}

impl Counts {
    fn add(&mut self, step: &Step) {
        self.responses += step.responses.len() as u64;
        self.uncertain += usize::from(step.decision == Decision::Uncertain);
        self.lost += usize::from(step.decision == Decision::Lost);
        self.learned += usize::from(step.learned);
        self.swept += usize::from(step.swept);
        self.found_again += usize::from(step.found);
    }
}

impl<S: Size> Checked for Robust<S> {
    type Reference = Reference;
    type Numbers = Numbers;
    type Counts = Counts;

    fn reference(numbers: Numbers, first: &[u8], size: (i64, i64), target: (i64, i64, i64, i64)) -> Reference {
        Reference::lock(numbers, unstable::REFINER_WEIGHTS, first, size, target)
    }

    fn locked(core: &Self, reference: &Reference) -> Option<Violation> {
        learned(core, reference)
    }

    fn compare(sides: &mut Sides<Self>, frame: &GrayFrame, _: usize) -> Result<Option<Violation>> {
        let before = before(sides.core.target(), &sides.reference);
        let part = asked_for(&sides.core, frame)?;
        let (target, workspace) = sides.core.parts();
        let cells: Vec<f64> = unstable::features(target, workspace, &part)?.iter().map(|&byte| byte.into()).collect();
        let responses = unstable::response_map(target, workspace, &part)?;
        let reach = unstable::reach(target).context("the tracker is locked")?;
        let span = 2 * usize::from(reach) + 1;
        let responses = responses.iter().take(span).flat_map(|row| row.iter().take(span));
        let responses: Vec<f64> = responses.map(|&of| of.into()).collect();
        let columns = window_columns(target, reach);
        let answer = sides.update(&part)?;
        let response = unstable::response(sides.core.workspace());
        let step = sides.reference.update(&frame.pixels);
        sides.counts.add(&step);
        Ok(before
            .or_else(|| numbers_differ("features: byte", &cells, &step.cells.bytes, columns))
            .or_else(|| numbers_differ("response", &responses, &step.responses, span))
            .or_else(|| decisions(&answer, response, &step))
            .or_else(|| learned(sides.core.target(), &sides.reference)))
    }
}

fn asked_for<'a, S: Size>(core: &Tracker<Robust<S>>, frame: &'a GrayFrame) -> Result<Frame<'a>> {
    let part = |region: Rect| -> Result<(Image<'a>, u16, u16)> {
        let pixels = frame.frame().patch(region).with_context(|| format!("{region:?} is not within the frame"))?;
        Ok((pixels, u16::try_from(region.x)?, u16::try_from(region.y)?))
    };
    let (pixels, x, y) = part(core.window().context("the tracker is locked")?)?;
    let near = Frame::part(pixels, x, y, frame.width, frame.height)?;
    let Some(elsewhere) = core.sweep_window() else { return Ok(near) };
    let (pixels, x, y) = part(elsewhere)?;
    Ok(near.and_part(pixels, x, y)?)
}

/// Compares the sampling grid and the requested pixel windows, before the frame is read.
fn before<S: Size>(core: &Robust<S>, reference: &Reference) -> Option<Violation> {
    let (grid, shape) = (core.grid()?, reference.shape());
    let of_core = [grid.columns, grid.rows, grid.across, grid.down].map(i64::from);
    let edges = |rect: Rect| [rect.x, rect.y, rect.right(), rect.bottom()].map(i64::from);
    let (near, elsewhere) = (edges(core.window()?), core.sweep_window().map(edges));
    differs("grid: columns, rows, across, down", of_core, [shape.columns, shape.rows, shape.across, shape.down])
        .or_else(|| differs("grid: step", f64::from(grid.step) / 4096.0, shape.step))
        .or_else(|| differs("pixels asked for: left, top, right, bottom", near, reference.region()))
        .or_else(|| differs("pixels asked for to sweep", elsewhere, reference.sweep_region()))
}

fn window_columns<S: Size>(core: &Robust<S>, reach: u16) -> usize {
    core.grid().map_or(1, |grid| usize::from(grid.across + 2 * reach) * CHANNELS)
}

/// Compares two tables value by value; `columns` values are a row. Names the row and column of the first difference.
fn numbers_differ(what: &str, core: &[f64], reference: &[f64], columns: usize) -> Option<Violation> {
    differs(&format!("number of: {what}"), core.len(), reference.len()).or_else(|| {
        let first = core.iter().zip(reference).position(|(core, reference)| core != reference)?;
        let what = format!("{what} {} of row {}", first % columns, first / columns);
        Some(Violation::new(what, core[first], reference[first]))
    })
}

fn learned<S: Size>(core: &Robust<S>, reference: &Reference) -> Option<Violation> {
    let shape = reference.shape();
    let weights: Vec<f64> = unstable::weights(core).iter().map(|&weight| weight.into()).collect();
    let early: Vec<f64> = core.early_template().into_iter().flatten().map(f64::from).collect();
    let columns = |columns: i64| usize::try_from(columns).unwrap_or(1);
    numbers_differ("weight", &weights, reference.weights(), columns(shape.across) * CHANNELS)
        .or_else(|| numbers_differ("early template: pixel", &early, &reference.early().pixels, columns(shape.columns)))
}

fn decisions(answer: &Answer, response: i32, step: &Step) -> Option<Violation> {
    let Answer { fine, bbox, .. } = answer;
    let edges = [f64::from(fine.x), f64::from(fine.y), f64::from(fine.width), f64::from(fine.height)];
    let whole = [i64::from(bbox.x), i64::from(bbox.y), i64::from(bbox.width), i64::from(bbox.height)];
    differs("found again", answer.found_again, step.found_again)
        .or_else(|| differs("response at the place", f64::from(response), step.response))
        .or_else(|| differs("ratio", f64::from(answer.ratio), step.ratio))
        .or_else(|| differs("confidence", f64::from(answer.confidence), step.confidence))
        .or_else(|| differs("identity", answer.identity.map(f64::from), step.identity))
        .or_else(|| differs("state", answer.state, state(step.decision)))
        .or_else(|| differs("scale", f64::from(answer.scale) / 65536.0, step.scale))
        .or_else(|| differs("box: left, top, width, height", edges.map(|edge| edge / 256.0), step.fine))
        .or_else(|| differs("box in whole pixels", whole, step.bbox))
}

fn state(decision: Decision) -> State {
    match decision {
        Decision::Tracking => State::Tracking,
        Decision::Uncertain => State::Uncertain,
        Decision::Lost => State::Lost,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{self, Check};
    use rayon::prelude::*;
    use smr_core::robust::{Config, Small, Standard};
    use smr_recordings::{CHECKED, OpenOptions};
    use std::path::Path;

    type Comparison = check::Comparison<Counts>;

    fn lock(name: &str, numbers: Numbers, config: Config, first: &GrayFrame, target: Rect) -> Check<Robust> {
        Check::lock(name, (config, numbers), u32::MAX, first, target).unwrap()
    }

    fn through<S: Size>(mut check: Check<Robust<S>>, frames: impl Iterator<Item = GrayFrame>) -> Comparison {
        for frame in frames {
            if !check.holds() {
                break;
            }
            check.update(&frame).unwrap();
        }
        check.into_comparison()
    }

    fn checked(name: &str, config: Config, numbers: Numbers, length: usize) -> Comparison {
        checked_of::<Standard>(name, config, numbers, length)
    }

    fn checked_of<S: Size>(name: &str, config: Config, numbers: Numbers, length: usize) -> Comparison {
        let sequence = smr_recordings::open(Path::new(name), &OpenOptions::default()).unwrap();
        let target = sequence.start().unwrap();
        let mut frames = sequence.frames.map(|frame| frame.unwrap().gray);
        let first = frames.next().unwrap();
        let check = Check::<Robust<S>>::lock(name, (config, numbers), u32::MAX, &first, target).unwrap();
        through(check, frames.take(length))
    }

    type Change<T> = (&'static str, fn(&mut T));

    /// Expands each assignment to a pair: its text, and a function that performs it.
    macro_rules! changes {
        ($of:ident; $($change:expr),+ $(,)?) => { &[$((stringify!($change), |$of| $change)),+] };
    }

    type Both = (&'static str, fn(&mut Config), fn(&mut Numbers));

    #[test]
    fn other_numbers_of_the_configuration_hold() {
        let others: [Both; 8] = [
            ("size", |config| config.size = false, |numbers| numbers.size = false),
            ("sweep", |config| config.sweep = 2, |numbers| numbers.sweep = 2),
            ("refiner", |config| config.refiner = false, |numbers| numbers.refiner = false),
            ("reach", |config| config.reach = 5, |numbers| numbers.reach = 5),
            ("patience", |config| config.patience = 240, |numbers| numbers.confidence_rate = 16.0),
            (
                "states",
                |config| (config.lost_below, config.uncertain_below) = (30_000, 50_000),
                |numbers| (numbers.lost_below, numbers.uncertain_below) = (30_000.0, 50_000.0),
            ),
            ("learning rate", |config| config.learning_rate = 64, |numbers| numbers.update_step = 0.25),
            ("early rate", |config| config.early_rate = 128, |numbers| numbers.early_rate = 0.125),
        ];
        for (what, change, same) in others {
            let (mut config, mut numbers) = (Config::refined(), Numbers::refined());
            change(&mut config);
            same(&mut numbers);
            for name in CHECKED {
                let report = checked(name, config, numbers.clone(), 25);
                assert_eq!(report.violation, None, "{name}, {what}");
                assert!(report.frames > 0 && report.counts.responses > 0, "{name}: {what}");
            }
        }
    }

    #[test]
    fn the_small_size_holds() {
        let small = |name, numbers| checked_of::<Small>(name, Config::refined().within::<Small>(), numbers, 25);
        for name in CHECKED {
            assert_eq!(small(name, Numbers::refined().small()).violation, None, "{name}");
        }
        let others: [fn(&mut Numbers); 3] =
            [|numbers| numbers.pixels = 1300, |numbers| numbers.most_cells = 155, |numbers| numbers.reach = 8];
        for change in others {
            let mut numbers = Numbers::refined().small();
            change(&mut numbers);
            assert_ne!(small(CHECKED[0], numbers).violation, None);
        }
        let frame = |step: usize| GrayFrame { width: 240, height: 160, pixels: tiles(240, 160, |x, y| (x + step, y)) };
        for target in [Rect::new(100, 20, 6, 3), Rect::new(10, 15, 220, 4), Rect::new(10, 10, 200, 140)] {
            let numbers = (Config::refined().within::<Small>(), Numbers::refined().small());
            let check = Check::<Robust<Small>>::lock("bounds", numbers, 5000, &frame(0), target).unwrap();
            assert_eq!(through(check, std::iter::once(frame(1))).violation, None, "{target:?}");
        }
    }

    /// The check must notice each changed parameter of the reference, on frames that depend on that parameter.
    #[test]
    fn other_numbers_are_noticed() {
        let [seen, _, border] = CHECKED.map(|name| move |numbers| checked(name, Config::refined(), numbers, 40));
        noticed(
            seen,
            changes! { of;
                of.pixels = 1599, of.cell = 5, of.filter_over_box = (3.0, 2.0), of.most_cells = 190, of.norm_floor = 31.0, of.norm_gain = 634.0, of.reach = 7,
                of.label_width = (1.0, 9.0), of.update_step = 0.75, of.regularisation = 5055.0, of.most_scaled = 4095.0, of.most_scaled_error = 8191.0,
                of.first_steps = 6, of.most_conjugate = 0.5, of.distance_penalty = 128.0, of.velocity_fraction = 0.25, of.velocity_rate = 0.25,
                of.scale_step = 1.03, of.early_rate = 1.0 / 64.0, of.similarity_scale = 250.0, of.alpha_bounds.0 = 99.0, of.alpha_bounds.1 = 9.0,
                of.most_change = 1.0, of.gain_bounds.1 = 0.25, of.tiles_across = 3, of.counted_tile_rank = 5, of.refined_from = 65_535.0,
                of.most_move = 0.125, of.most_growth = 64.0, of.damping = 32.0, of.confidence_rate = 76.0, of.size = false,
                of.calm_reach = 5, of.calm_after = 4, of.calm_off = 0.25,
            },
        );
        // Switches the refiner off, because its larger window would hide a change of the scale search's window.
        let unrefined = |mut numbers: Numbers| {
            numbers.refiner = false;
            checked(CHECKED[0], Config::robust(), numbers, 40)
        };
        noticed(unrefined, changes! { of; of.scale_reach = 1 });
        noticed(jumping, changes! { of; of.scale_gain = 128.0, of.calm_decay = 0.5 });
        noticed(border, changes! { of; of.coarse_step = 1, of.most_sum = 2048.0 });
        noticed(dimmed, changes! { of; of.gain_bounds.0 = 0.5, of.light_rate = 0.5, of.least_window = 16.0 });
        let on = |target| move |numbers| moved_once(numbers, target);
        noticed(on(Rect::new(100, 20, 6, 3)), changes! { of; of.least_step = 1.0, of.least_side = 5 });
        noticed(on(Rect::new(10, 15, 220, 4)), changes! { of; of.most_side = 31 });
        noticed(on(Rect::new(10, 10, 200, 140)), changes! { of; of.read_per_side = 1, of.read_per_side = 3 });
        noticed(
            hidden,
            changes! { of;
                of.least_contrast = 0.0, of.least_deviation = 128.0, of.margin = 5, of.lost_below = 10_000.0, of.uncertain_below = 19_300.0,
                of.learned_from = 98_304.0, of.recognised_from = 98_304.0, of.recognised_better_by = 98_304.0, of.recognised_logit = 6.5,
                of.exact_logit = 2.0, of.identity_found = 0.5, of.identity_rate = 0.5, of.most_logit = 5.0,
                of.sweep = 0, of.sweep = 3, of.refiner = false,
            },
        );
        noticed(noisy, changes! { of; of.most_trust = 2.0, of.opinion_rate = 0.25, of.opinion_rising_rate = 0.125 });
        noticed(noisy, changes! { of; of.opinion_lost_below = 1.3, of.opinion_uncertain_below = 1.0 });
        noticed(
            noisy,
            changes! { of; of.opinion_patience = 29, of.opinion_found = 2.0, of.veto = 64.0, of.same_from = 0.0, of.most_veto = 20_000.0 },
        );
        let hidden_unrefined = |mut numbers: Numbers| {
            numbers.refiner = false;
            hidden_from(Config::robust(), numbers)
        };
        noticed(hidden_unrefined, changes! { of; of.found_from = 98_304.0, of.better_by = 98_304.0 });
        noticed(cut_off, changes! { of; of.most_cut_off = 1.0 });
    }

    /// Fails if the unchanged parameters violate the check, or if changed ones do not.
    #[track_caller]
    fn noticed(report: impl Fn(Numbers) -> Comparison + Sync, others: &[Change<Numbers>]) {
        assert_eq!(report(Numbers::refined()).violation, None);
        let holds = |change: fn(&mut Numbers)| {
            let mut numbers = Numbers::refined();
            change(&mut numbers);
            report(numbers).violation.is_none()
        };
        let unnoticed: Vec<_> = others.par_iter().filter(|(_, change)| holds(*change)).map(|(what, _)| what).collect();
        assert!(unnoticed.is_empty(), "other numbers go unnoticed: {unnoticed:?}");
    }

    fn moved_once(numbers: Numbers, target: Rect) -> Comparison {
        let frame = |step: usize| GrayFrame { width: 240, height: 160, pixels: tiles(240, 160, |x, y| (x + step, y)) };
        through(lock("bounds", numbers, Config::refined(), &frame(0), target), std::iter::once(frame(1)))
    }

    /// Frames turn pure black and white: they have contrast, but all pixels are clipped, so they cannot show a target.
    fn cut_off(numbers: Numbers) -> Comparison {
        let cut = |mut frame: GrayFrame| {
            frame.pixels.iter_mut().for_each(|pixel| *pixel = if *pixel < 128 { 0 } else { 255 });
            frame
        };
        let check = lock("cut off", numbers, Config::refined(), &still(0), Rect::new(14, 14, 32, 32));
        through(check, [still(0), cut(still(0)), cut(still(0)), still(0)].into_iter())
    }

    /// Noise hides the target for 75 frames. The confidence limits for uncertain and lost are 1/65535, so that the
    /// refiner's network decides the state.
    fn noisy(mut numbers: Numbers) -> Comparison {
        let mut config = Config::refined();
        (config.lost_below, config.uncertain_below) = (1, 1);
        (numbers.lost_below, numbers.uncertain_below) = (1.0, 1.0);
        let noise = |at: usize, step: usize| (at + step * 19_200).wrapping_mul(2_654_435_761) >> 13;
        let target = tiles(40, 40, |x, y| (x, y));
        let frame = |step: usize| {
            let pixel = |at: usize| match ((at % 160).wrapping_sub(60), (at / 160).wrapping_sub(40)) {
                _ if (5..80).contains(&step) => u8::try_from(noise(at, step) % 256).unwrap(),
                (column, row) if column < 40 && row < 40 => target[row * 40 + column],
                _ => 100,
            };
            GrayFrame { width: 160, height: 120, pixels: (0..160 * 120).map(pixel).collect() }
        };
        through(lock("noisy", numbers, config, &frame(0), Rect::new(60, 40, 40, 40)), (1..94).map(frame))
    }

    /// A target jumps over a tiled background. Then it grows by a pixel in each frame, with its right half inverted.
    fn jumping(numbers: Numbers) -> Comparison {
        let frame = |(left, top): (usize, usize), side: usize| {
            let target = tiles(32, 32, |x, y| (x, y));
            let pixel =
                |x: usize, y: usize| match (x.saturating_sub(left) * 32 / side, y.saturating_sub(top) * 32 / side) {
                    (column, row) if x >= left && y >= top && column < 32 && row < 32 => {
                        let pixel = target[row * 32 + column];
                        if side > 32 && column >= 16 { 255 - pixel } else { pixel }
                    }
                    _ => u8::try_from(100 + (x / 24 * 7 + y / 24 * 5) % 4 * 20).unwrap(),
                };
            let pixels = (0..160 * 120).map(|at| pixel(at % 160, at / 160)).collect();
            GrayFrame { width: 160, height: 120, pixels }
        };
        let jumps = [(43, 45), (41, 50), (48, 47), (45, 41), (52, 44), (47, 49), (53, 43), (50, 50), (44, 46)];
        let grows = (33..43).map(|side| frame((44, 46), side));
        let check = lock("jumping", numbers, Config::refined(), &frame((40, 40), 32), Rect::new(40, 40, 32, 32));
        through(check, jumps.map(|at| frame(at, 32)).into_iter().chain(grows))
    }

    /// The contrast of the target falls to a third, and then that of the whole picture to a sixth.
    fn dimmed(numbers: Numbers) -> Comparison {
        let frame = |(target, all): (i32, i32)| {
            let mut frame = still(0);
            for (at, pixel) in frame.pixels.iter_mut().enumerate() {
                let inside = |place: usize| (14..46).contains(&place);
                let of_target = if inside(at % 60) && inside(at / 60) { target } else { 6 };
                *pixel = u8::try_from(110 + (i32::from(*pixel) - 110) * of_target * all / 36).unwrap();
            }
            frame
        };
        let check = lock("dimmed", numbers, Config::refined(), &frame((6, 6)), Rect::new(14, 14, 32, 32));
        through(check, [(6, 6), (2, 6), (2, 6), (2, 6), (2, 1), (2, 1), (6, 1), (6, 1), (6, 6)].into_iter().map(frame))
    }

    /// The target is found again in its search window, before the search of the whole frame finds it.
    #[test]
    fn a_lost_target_that_comes_back_where_it_is_followed_holds() {
        let hidden = [0; 5].into_iter().chain([28; 8]).chain([0; 8]);
        let check = lock("still", Numbers::refined(), Config::refined(), &still(0), Rect::new(14, 14, 32, 32));
        let Comparison { violation, counts, .. } = through(check, hidden.map(still));
        assert_eq!((violation, counts.found_again), (None, 0));
        assert!(counts.lost > 0 && counts.swept > 0 && counts.lost < 8, "{counts:?}");
    }

    /// A 60x60 frame with the target in its middle. The first `hidden` columns of the target are covered.
    fn still(hidden: usize) -> GrayFrame {
        let target = tiles(32, 32, |x, y| (x, y));
        let pixel = |x: usize, y: usize| match (x.wrapping_sub(14), y.wrapping_sub(14)) {
            (column, row) if column < 32 && row < 32 => {
                if column < hidden {
                    20
                } else {
                    target[row * 32 + column]
                }
            }
            _ => 100,
        };
        let pixels = (0..60).flat_map(|y| (0..60).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        GrayFrame { width: 60, height: 60, pixels }
    }

    #[test]
    fn a_target_that_is_lost_swept_for_and_found_again_holds() {
        let report = hidden(Numbers::refined());
        assert_eq!(report.violation, None);
        let Counts { lost, swept, found_again, .. } = report.counts;
        assert!(lost > 0 && swept >= lost && found_again > 0, "{report:?}");
    }

    fn hidden(numbers: Numbers) -> Comparison {
        hidden_from(Config::refined(), numbers)
    }

    /// The target disappears until it is lost, then returns far away.
    fn hidden_from(config: Config, numbers: Numbers) -> Comparison {
        let frame = |at: Option<(usize, usize)>| {
            let ground = |x: usize, y: usize| u8::try_from(100 + (x / 40 + y / 40) % 2 * 30).unwrap();
            let mut pixels: Vec<u8> = (0..240 * 160).map(|at| ground(at % 240, at / 240)).collect();
            let target = tiles(32, 32, |x, y| (x, y));
            for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
                if let Some((left, top)) = at {
                    pixels[(top + y) * 240 + left + x] = target[y * 32 + x];
                }
            }
            GrayFrame { width: 240, height: 160, pixels }
        };
        let target = Rect::new(30, 40, 32, 32);
        let check = lock("hidden", numbers, config, &frame(Some((30, 40))), target);
        let there = (0..5).map(|step| Some((30 + step, 40)));
        through(check, there.chain([None; 8]).chain([Some((190, 120)); 16]).map(frame))
    }

    /// Picture of a pattern of tiles; a tile has 4x4 pixels of one gray level. Pixel (x, y) shows the pattern at
    /// `moved(x, y)`.
    fn tiles(width: usize, height: usize, moved: impl Fn(usize, usize) -> (usize, usize)) -> Vec<u8> {
        let tile = |x: usize, y: usize| u8::try_from((x * 83 + y * 47 + x * y * 29) % 256).unwrap();
        let pixel = |(x, y): (usize, usize)| tile(x / 4, y / 4);
        (0..width * height).map(|at| pixel(moved(at % width, at / width))).collect()
    }
}
