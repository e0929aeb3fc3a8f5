//! The robust tracker against its reference, number by number, through a recording.
//!
//! Core is given no more of a frame than it asks for, the reference all of it. All must be equal, in every frame: what core asks for, the
//! features of the search window, the filter's responses at all offsets, its weights after it has learned, the early template, the response
//! and the ratio at the place, the confidence, the state, the scale and the box.

use super::{Mismatch, Violation, differs};
use crate::reference::robust::{Belief, Numbers, Reference, Step};
use crate::sequence::GrayFrame;
use anyhow::{Context, Result, bail};
use serde::Serialize;
use smr_core::robust::{Answer, CHANNELS, Config, REACH, State, Tracker};
use smr_core::{Frame, Rect};

/// What was compared, and what was found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The recording's name.
    pub sequence: String,
    /// Frames compared: all but the first, which is locked on, or up to and including the first violation.
    pub frames: usize,
    /// Responses compared in all frames together.
    pub responses: u64,
    /// Of the frames, those after which the target was uncertain, and lost.
    pub uncertain: usize,
    pub lost: usize,
    /// Frames that were learned from.
    pub learned: usize,
    /// Windows of the sweep, and in how many the target was found again.
    pub swept: usize,
    pub found_again: usize,
    /// The first frame in which something that must hold did not; 0 is the one that is locked on.
    pub violation: Option<Violation>,
}

impl Report {
    /// True if everything that must hold did.
    pub fn holds(&self) -> bool {
        self.violation.is_none()
    }
}

/// The reference's numbers, with the parts that are in `config`.
#[must_use]
pub fn numbers(config: &Config) -> Numbers {
    let mut numbers = Numbers::robust();
    let parts = &mut numbers.parts;
    parts.velocity = config.velocity;
    parts.near = config.near;
    parts.size = config.size;
    parts.verification = config.verification;
    parts.caution = config.caution;
    parts.sweep = config.sweep;
    numbers
}

/// Runs both trackers side by side, one frame at a time.
pub struct Check {
    core: Box<Tracker>,
    reference: Reference,
    report: Report,
}

impl Check {
    /// Locks both on `target` in the first frame. `numbers` and `config` are meant to be the same, said twice.
    pub fn lock(name: &str, config: Config, numbers: Numbers, first: &GrayFrame, target: Rect) -> Result<Self> {
        let mut core = Box::new(Tracker::new(config));
        core.lock(&first.frame(), target).with_context(|| format!("{name}: cannot lock on {target:?}"))?;
        let size = (i64::from(first.width), i64::from(first.height));
        let box_ = (target.x.into(), target.y.into(), target.width.into(), target.height.into());
        let reference = Reference::lock(numbers, &first.pixels, size, box_);
        let report = Report {
            sequence: name.to_owned(),
            frames: 0,
            responses: 0,
            uncertain: 0,
            lost: 0,
            learned: 0,
            swept: 0,
            found_again: 0,
            violation: None,
        };
        let mut check = Self { core, reference, report };
        check.report.violation = check.learned().map(|mismatch| mismatch.in_frame(0));
        Ok(check)
    }

    /// Compares one more frame. After a violation the two no longer walk side by side: there is nothing to go on with.
    pub fn update(&mut self, frame: &GrayFrame) -> Result<()> {
        if self.report.frames > 0 && !self.report.holds() {
            bail!("{}: a check ends with its first violation", self.report.sequence);
        }
        let before = self.before();
        let part = self.asked_for(frame)?;
        let cells: Vec<f64> = self.core.features(&part)?.iter().map(|&byte| byte.into()).collect();
        let responses: Vec<f64> = self.core.response_map(&part)?.as_flattened().iter().map(|&of| of.into()).collect();
        let answer = self.core.update(&part)?;
        let step = self.reference.update(&frame.pixels);
        self.count(&step);
        let number = self.report.frames;
        let locked = self.report.violation.take();
        self.report.violation = locked.or_else(|| {
            let found = before
                .or_else(|| self.numbers("features: byte", &cells, &step.cells.bytes, self.window_columns()))
                .or_else(|| self.numbers("response", &responses, &step.responses, 2 * usize::from(REACH) + 1))
                .or_else(|| decisions(&answer, &step))
                .or_else(|| self.learned());
            found.map(|mismatch| mismatch.in_frame(number))
        });
        Ok(())
    }

    /// The report so far.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// The report, at the end.
    pub fn into_report(self) -> Report {
        self.report
    }

    fn count(&mut self, step: &Step) {
        let report = &mut self.report;
        report.frames += 1;
        report.responses += step.responses.len() as u64;
        report.uncertain += usize::from(step.belief == Belief::Uncertain);
        report.lost += usize::from(step.belief == Belief::Lost);
        report.learned += usize::from(step.learned);
        report.swept += usize::from(step.swept);
        report.found_again += usize::from(step.found_again);
    }

    /// Only those pixels of the frame that core asks for.
    fn asked_for<'a>(&self, frame: &'a GrayFrame) -> Result<Frame<'a>> {
        let region = self.core.window().context("the tracker is locked")?;
        let pixels = frame.frame().patch(region).with_context(|| format!("{region:?} is not within the frame"))?;
        let (x, y) = (u16::try_from(region.x)?, u16::try_from(region.y)?);
        Ok(Frame::part(pixels, x, y, frame.width, frame.height)?)
    }

    /// What is known before a frame is looked at: the grid, and what is asked for.
    fn before(&self) -> Option<Mismatch> {
        let (grid, shape) = (self.core.grid()?, self.reference.shape());
        let of_core = [grid.columns, grid.rows, grid.across, grid.down].map(i64::from);
        let region = self.core.window()?;
        let edges = [region.x, region.y, region.right(), region.bottom()].map(i64::from);
        differs("grid: columns, rows, across, down", of_core, [shape.columns, shape.rows, shape.across, shape.down])
            .or_else(|| differs("grid: step", f64::from(grid.step) / 4096.0, shape.step))
            .or_else(|| differs("pixels asked for: left, top, right, bottom", edges, self.reference.region()))
    }

    /// Bytes in a row of the search window's cells.
    fn window_columns(&self) -> usize {
        self.core.grid().map_or(1, |grid| usize::from(grid.across + 2 * REACH) * CHANNELS)
    }

    /// Number by number; the first that differs is named by its row and its place in it.
    fn numbers(&self, what: &str, core: &[f64], reference: &[f64], columns: usize) -> Option<Mismatch> {
        differs(&format!("number of: {what}"), core.len(), reference.len()).or_else(|| {
            let first = core.iter().zip(reference).position(|(core, reference)| core != reference)?;
            let what = format!("{what} {} of row {}", first % columns, first / columns);
            Some(Mismatch::new(what, core[first], reference[first]))
        })
    }

    /// What the next frame will be compared with.
    fn learned(&self) -> Option<Mismatch> {
        let (shape, core) = (self.reference.shape(), &self.core);
        let weights: Vec<f64> = core.weights().iter().map(|&weight| weight.into()).collect();
        let early: Vec<f64> = core.early_template().into_iter().flatten().map(f64::from).collect();
        let columns = |columns: i64| usize::try_from(columns).unwrap_or(1);
        self.numbers("weight", &weights, self.reference.weights(), columns(shape.across) * CHANNELS).or_else(|| {
            self.numbers("early template: pixel", &early, &self.reference.early().pixels, columns(shape.columns))
        })
    }
}

fn decisions(answer: &Answer, step: &Step) -> Option<Mismatch> {
    let Answer { fine, bbox, .. } = answer;
    let edges = [f64::from(fine.x), f64::from(fine.y), f64::from(fine.width), f64::from(fine.height)];
    let whole = [i64::from(bbox.x), i64::from(bbox.y), i64::from(bbox.width), i64::from(bbox.height)];
    differs("found again", answer.found_again, step.found_again)
        .or_else(|| differs("response at the place", f64::from(answer.response), step.response))
        .or_else(|| differs("ratio", f64::from(answer.ratio), step.ratio))
        .or_else(|| differs("confidence", f64::from(answer.confidence), step.confidence))
        .or_else(|| differs("state", belief(answer.state), step.belief))
        .or_else(|| differs("scale", f64::from(answer.scale) / 65536.0, step.scale))
        .or_else(|| differs("box: left, top, width, height", edges.map(|edge| edge / 256.0), step.fine))
        .or_else(|| differs("box in whole pixels", whole, step.bbox))
}

fn belief(state: State) -> Belief {
    match state {
        State::Tracking => Belief::Tracking,
        State::Uncertain => Belief::Uncertain,
        State::Lost => Belief::Lost,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{self, CHECKED, OpenOptions};
    use std::path::Path;

    /// The check of the first frames of a built-in recording.
    fn checked(name: &str, config: Config, numbers: Numbers, frames: usize) -> Report {
        let mut sequence = sequence::open(Path::new(name), &OpenOptions::default()).unwrap();
        let target = sequence.start().unwrap();
        let first = sequence.frames.next().unwrap().unwrap();
        let mut check = Check::lock(name, config, numbers, &first, target).unwrap();
        for frame in sequence.frames.take(frames) {
            check.update(&frame.unwrap()).unwrap();
            if !check.report().holds() {
                break;
            }
        }
        check.into_report()
    }

    type Change<T> = (&'static str, fn(&mut T));

    const WITHOUT: [Change<Config>; 6] = [
        ("velocity", |config| config.velocity = false),
        ("near", |config| config.near = false),
        ("size", |config| config.size = false),
        ("verification", |config| config.verification = false),
        ("caution", |config| config.caution = false),
        ("sweep", |config| config.sweep = false),
    ];

    #[test]
    fn built_in_recordings_hold_with_all_parts_and_without_each() {
        let all: Change<Config> = ("nothing", |_| ());
        for (without, change) in [all].into_iter().chain(WITHOUT) {
            let mut config = Config::robust();
            change(&mut config);
            for name in CHECKED {
                let report = checked(name, config, numbers(&config), 12);
                assert_eq!(report.violation, None, "{name} without {without}");
                assert!(report.frames > 0 && report.responses > 0, "{name} without {without}");
            }
        }
    }

    /// The numbers that a target needs which is seen all the time.
    #[test]
    fn other_numbers_are_noticed() {
        let others: [Change<Numbers>; 36] = [
            ("pixels", |numbers| numbers.pixels = 1599),
            ("cell", |numbers| numbers.cell = 5),
            ("cover", |numbers| numbers.cover = (3.0, 2.0)),
            ("most cells", |numbers| numbers.most_cells = 190),
            ("norm's floor", |numbers| numbers.norm_floor = 31.0),
            ("norm's gain", |numbers| numbers.norm_gain = 634.0),
            ("reach", |numbers| numbers.reach = 7),
            ("learns", |numbers| numbers.learns = 5),
            ("bell", |numbers| numbers.bell = (1.0, 9.0)),
            ("bell's entries", |numbers| numbers.bell_entries = 31.0),
            ("bell's end", |numbers| numbers.bell_end = 3.0),
            ("newest sample", |numbers| numbers.recent[0] = 3276.0),
            ("second sample", |numbers| numbers.recent[1] = 3110.0),
            ("third sample", |numbers| numbers.recent[2] = 2950.0),
            ("kept", |numbers| numbers.kept = 62_000.0),
            ("pull", |numbers| numbers.pull = 5055.0),
            ("coded", |numbers| numbers.most_coded = 8190.0),
            ("gathered", |numbers| numbers.most_gathered = 16_000.0),
            ("first steps", |numbers| numbers.first_steps = 19),
            ("near", |numbers| numbers.near = 76.0),
            ("expected", |numbers| numbers.expected = 0.25),
            ("last move", |numbers| numbers.last_move = 0.25),
            ("size step", |numbers| numbers.size_step = 1.02),
            ("size part", |numbers| numbers.size_part = 256.0),
            ("size reach", |numbers| numbers.size_reach = 0),
            ("early rate", |numbers| numbers.early_rate = 64.0),
            ("scale", |numbers| numbers.scale = 250.0),
            ("least alpha", |numbers| numbers.alpha_bounds.0 = 99.0),
            ("most alpha", |numbers| numbers.alpha_bounds.1 = 9.0),
            ("gain of light", |numbers| numbers.most_gain = 1.0),
            ("parts", |numbers| numbers.parts_across = 3),
            ("ratio that counts", |numbers| numbers.ratio_that_counts = 5),
            ("trust's rate", |numbers| numbers.trust_rate = 76.0),
            ("velocity", |numbers| numbers.parts.velocity = false),
            ("near", |numbers| numbers.parts.near = false),
            ("size", |numbers| numbers.parts.size = false),
        ];
        noticed(&others, |numbers| checked(CHECKED[0], Config::robust(), numbers, 40));
    }

    /// The bounds that only small, long and large targets meet.
    #[test]
    fn other_bounds_are_noticed() {
        let others: [Change<Numbers>; 3] = [
            ("finest", |numbers| numbers.finest = 1.0),
            ("least cells", |numbers| numbers.least_cells = 5),
            ("most cells on a side", |numbers| numbers.most_cells_on_a_side = 31),
        ];
        let frame = |step: usize| GrayFrame { width: 240, height: 40, pixels: tiles(240, 40, |x, y| (x + step, y)) };
        let report = |numbers: Numbers, target: Rect| {
            let mut check = Check::lock("bounds", Config::robust(), numbers, &frame(0), target).unwrap();
            check.update(&frame(1)).unwrap();
            check.into_report()
        };
        for target in [Rect::new(100, 20, 6, 3), Rect::new(10, 15, 220, 4)] {
            assert_eq!(report(Numbers::robust(), target).violation, None);
        }
        noticed(&others[..2], |numbers| report(numbers, Rect::new(100, 20, 6, 3)));
        noticed(&others[2..], |numbers| report(numbers, Rect::new(10, 15, 220, 4)));
    }

    /// The numbers of trust and of the sweep, on a target that is hidden and comes back elsewhere.
    #[test]
    fn other_numbers_of_trust_are_noticed() {
        let others: [Change<Numbers>; 8] = [
            ("lost", |numbers| numbers.lost_below = 15_000.0),
            ("uncertain", |numbers| numbers.uncertain_below = 30_000.0),
            ("learned", |numbers| numbers.learned_from = 5_000.0),
            ("found", |numbers| numbers.found_from = 98_304.0),
            ("better", |numbers| numbers.better_by = 98_304.0),
            ("verification", |numbers| numbers.parts.verification = false),
            ("caution", |numbers| numbers.parts.caution = false),
            ("sweep", |numbers| numbers.parts.sweep = false),
        ];
        noticed(&others, hidden);
    }

    fn noticed(others: &[Change<Numbers>], report: impl Fn(Numbers) -> Report) {
        let unnoticed = |&&(_, change): &&Change<Numbers>| {
            let mut numbers = Numbers::robust();
            change(&mut numbers);
            report(numbers).holds()
        };
        let unnoticed: Vec<_> = others.iter().filter(unnoticed).map(|(what, _)| what).collect();
        assert!(unnoticed.is_empty(), "other numbers go unnoticed: {unnoticed:?}");
    }

    #[test]
    fn a_target_that_is_lost_swept_for_and_found_again_holds() {
        let report = hidden(Numbers::robust());
        assert_eq!(report.violation, None);
        assert!(report.lost > 0 && report.swept >= report.lost && report.found_again > 0, "{report:?}");
    }

    /// The target is hidden by a plain wall until it is lost and swept for, and comes back far from where it was.
    fn hidden(numbers: Numbers) -> Report {
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
        let mut check = Check::lock("hidden", Config::robust(), numbers, &frame(Some((30, 40))), target).unwrap();
        let there = (0..5).map(|step| Some((30 + step, 40)));
        for at in there.chain([None; 8]).chain([Some((190, 120)); 16]) {
            check.update(&frame(at)).unwrap();
            if !check.report().holds() {
                break;
            }
        }
        check.into_report()
    }

    /// A picture of tiles of 4x4 pixels, moved.
    fn tiles(width: usize, height: usize, moved: impl Fn(usize, usize) -> (usize, usize)) -> Vec<u8> {
        let tile = |x: usize, y: usize| u8::try_from((x * 83 + y * 47 + x * y * 29) % 256).unwrap();
        let pixel = |(x, y): (usize, usize)| tile(x / 4, y / 4);
        (0..width * height).map(|at| pixel(moved(at % width, at / width))).collect()
    }
}
