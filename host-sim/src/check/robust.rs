//! The robust tracker against its reference, score by score, through a recording.
//!
//! Core is given no more of a frame than it asks for, the reference all of it. Two comparisons, in every frame:
//!
//! 1. **Bit for bit.** With the reference's p rounded to the table's grid: what core asks for, the window on the grid, the
//!    scores of all its offsets by the last and by the slow template, the peak by all templates, alpha, the early template's ratio, the
//!    state, the scale, the box, and the bytes of all four templates.
//! 2. **Within the bound.** With the reference's p exact, a score of n pixels may differ by n times half a unit of
//!    1/65535, the rounding of n table entries, and by f64's own rounding.

use super::{Mismatch, Violation, bound, differs};
use crate::reference::Sums;
use crate::reference::robust::{Belief, Numbers, Patch, Reference, Step};
use crate::sequence::GrayFrame;
use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::Serialize;
use smr_core::robust::{Answer, Config, State, ThresholdRule, Tracker};
use smr_core::similarity::{Backend, Scorer};
use smr_core::{Frame, Image, Rect};

/// What was compared, and what was found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The recording's name.
    pub sequence: String,
    /// Frames compared: all but the first, which is locked on, or up to and including the first violation.
    pub frames: usize,
    /// Candidates compared in all frames together, by the last and by the slow template.
    pub scores: u64,
    /// Of the frames, those after which the target was uncertain, and lost.
    pub uncertain: usize,
    pub lost: usize,
    /// Windows of the sweep, and in how many the target was found again.
    pub swept: usize,
    pub found_again: usize,
    /// The first frame in which something that must hold did not.
    pub violation: Option<Violation>,
    /// The largest |core's score - exact score| of a candidate, in units of 1/65535.
    pub largest_difference: f64,
    /// What that may be at most, for this template's number of pixels.
    pub bound: f64,
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
    parts.enlarging = config.enlarging;
    parts.slow_template = config.slow_template;
    parts.anchor = config.anchor;
    parts.sub_pixel = config.sub_pixel;
    parts.cells = config.cells;
    parts.verification = config.verification;
    parts.sweep = config.sweep;
    parts.contrast = config.threshold == ThresholdRule::Contrast;
    if let ThresholdRule::LargestChange(k) = config.threshold {
        numbers.k = (k.numerator.into(), k.denominator.into());
    }
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
            scores: 0,
            uncertain: 0,
            lost: 0,
            swept: 0,
            found_again: 0,
            violation: None,
            largest_difference: 0.0,
            bound: bound(
                core.template().map_or(0, |template| u32::from(template.width()) * u32::from(template.height())),
            ),
        };
        Ok(Self { core, reference, report })
    }

    /// Compares one more frame. After a violation the two no longer walk side by side: there is nothing to go on with.
    pub fn update(&mut self, frame: &GrayFrame) -> Result<()> {
        if !self.report.holds() {
            bail!("{}: a check ends with its first violation", self.report.sequence);
        }
        let before = self.before();
        let part = self.asked_for(frame)?;
        let window = Bytes::of(self.core.window_on_grid(&part)?);
        let last = self.core_scores(&window, self.core.template())?;
        let slow = if self.core.config().slow_template { self.core.slow_template() } else { None };
        let slow = slow.map_or(Ok(Vec::new()), |slow| self.core_scores(&window, Some(slow)))?;
        let answer = self.core.update(&part)?;
        let step = self.reference.update(&frame.pixels);
        self.count(&step, last.len() + slow.len());
        let number = self.report.frames + 1;
        self.report.violation = before
            .or_else(|| pixels("search window", Some(window.image()), &step.window))
            .or_else(|| self.each_score("last", &last, &step.last))
            .or_else(|| self.each_score("slow", &slow, &step.slow))
            .or_else(|| decisions(&answer, &step))
            .or_else(|| self.templates())
            .map(|mismatch| mismatch.in_frame(number));
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

    fn count(&mut self, step: &Step, scores: usize) {
        let report = &mut self.report;
        report.frames += 1;
        report.scores += scores as u64;
        report.uncertain += usize::from(step.belief == Belief::Uncertain);
        report.lost += usize::from(step.belief == Belief::Lost);
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

    /// Core's score of every offset, row by row, each asked for by itself: whatever way the search takes, these are what it
    /// must have found.
    fn core_scores(&self, window: &Bytes, template: Option<Image<'_>>) -> Result<Vec<u32>> {
        let (config, window) = (self.core.config(), window.image());
        let template = template.context("the tracker is locked")?;
        let scorer = Scorer::new(config.backend.unwrap_or_else(Backend::best), config.table, self.core.alpha());
        let (width, height) = (template.width(), template.height());
        let score = |x: u16, y: u16| {
            let patch = window.crop(Rect::new(x.into(), y.into(), width, height));
            Ok(scorer.score(patch.context("an offset lies in the window")?, template))
        };
        let (columns, rows) = (window.width() - width + 1, window.height() - height + 1);
        (0..rows).into_par_iter().flat_map_iter(|y| (0..columns).map(move |x| score(x, y))).collect()
    }

    /// What is known before a frame is looked at: the grid, and what is asked for.
    fn before(&self) -> Option<Mismatch> {
        let (grid, shape) = (self.core.grid()?, self.reference.shape());
        let of_core = (i64::from(grid.columns), i64::from(grid.rows), f64::from(grid.step) / 4096.0);
        let region = self.core.window()?;
        let edges = [region.x, region.y, region.right(), region.bottom()].map(i64::from);
        differs("grid: columns, rows, step", of_core, (shape.columns, shape.rows, shape.step))
            .or_else(|| differs("pixels asked for: left, top, right, bottom", edges, self.reference.region()))
    }

    fn each_score(&mut self, template: &str, core: &[u32], reference: &[((i64, i64), Sums)]) -> Option<Mismatch> {
        if core.len() != reference.len() {
            return differs(&format!("offsets of the {template} template"), core.len(), reference.len());
        }
        let mut different = None;
        for (&((x, y), sums), &score) in reference.iter().zip(core) {
            let difference = (f64::from(score) - sums.exact).abs();
            self.report.largest_difference = self.report.largest_difference.max(difference);
            if f64::from(score) != sums.rounded && different.is_none() {
                different =
                    Some(Mismatch::new(format!("score of the {template} template at ({x}, {y})"), score, sums.rounded));
            }
        }
        if self.report.largest_difference > self.report.bound {
            let what = "largest difference from an exact score".to_owned();
            different = different.or(Some(Mismatch::new(what, self.report.largest_difference, self.report.bound)));
        }
        different
    }

    /// What the next frame will be compared with.
    fn templates(&self) -> Option<Mismatch> {
        let (core, reference) = (&self.core, &self.reference);
        pixels("last template", core.template(), reference.last())
            .or_else(|| pixels("slow template", core.slow_template(), &reference.slow()))
            .or_else(|| pixels("early template", core.early_template(), &reference.early()))
            .or_else(|| pixels("anchor", core.anchor(), reference.anchor()))
            .or_else(|| differs("next alpha, rounded up", f64::from(core.alpha()), reference.alpha().ceil()))
    }
}

/// A copy of a picture of core's.
struct Bytes {
    pixels: Vec<u8>,
    width: u16,
    height: u16,
}

impl Bytes {
    fn of(image: Image<'_>) -> Self {
        let pixels = image.rows().flatten().copied().collect();
        Self { pixels, width: image.width(), height: image.height() }
    }

    fn image(&self) -> Image<'_> {
        Image::new(&self.pixels, self.width, self.height).expect("it was one before")
    }
}

fn pixels(what: &str, core: Option<Image<'_>>, reference: &Patch) -> Option<Mismatch> {
    let Some(core) = core else { return Some(Mismatch::new(what.into(), "none", "one")) };
    let size = (i64::from(core.width()), i64::from(core.height()));
    let pixels: Vec<f64> = core.rows().flatten().map(|&pixel| f64::from(pixel)).collect();
    let first = pixels.iter().zip(&reference.pixels).position(|(core, reference)| core != reference);
    differs(&format!("size of the {what}"), size, (reference.columns, reference.rows)).or_else(|| {
        let first = first?;
        Some(Mismatch::new(format!("{what}, pixel {first}"), pixels[first], reference.pixels[first]))
    })
}

fn decisions(answer: &Answer, step: &Step) -> Option<Mismatch> {
    let Answer { fine, bbox, peak, .. } = answer;
    let edges = [f64::from(fine.x), f64::from(fine.y), f64::from(fine.width), f64::from(fine.height)];
    let whole = [i64::from(bbox.x), i64::from(bbox.y), i64::from(bbox.width), i64::from(bbox.height)];
    differs("peak's offset", (i64::from(peak.x), i64::from(peak.y)), step.peak.0)
        .or_else(|| differs("peak's score", f64::from(peak.score), step.peak.1))
        .or_else(|| differs("alpha, rounded up", f64::from(answer.alpha), step.alpha.ceil()))
        .or_else(|| differs("ratio", f64::from(answer.ratio), step.ratio))
        .or_else(|| differs("state", belief(answer.state), step.belief))
        .or_else(|| differs("found again", answer.found_again, step.found_again))
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
    use smr_core::Fraction;
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

    const WITHOUT: [Change<Config>; 8] = [
        ("enlarging", |config| config.enlarging = false),
        ("contrast", |config| config.threshold = ThresholdRule::LargestChange(Fraction::new(1, 4))),
        ("slow template", |config| config.slow_template = false),
        ("anchor", |config| config.anchor = false),
        ("sub-pixel", |config| config.sub_pixel = false),
        ("cells", |config| config.cells = false),
        ("verification", |config| config.verification = false),
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
                assert!(report.frames > 0 && report.scores > 0, "{name} without {without}");
            }
        }
    }

    #[test]
    fn other_numbers_are_noticed() {
        let others: [Change<Numbers>; 16] = [
            ("table", |numbers| numbers.scale = 250.0),
            ("pixels", |numbers| numbers.pixels = 900),
            ("radius", |numbers| numbers.radius = 31),
            ("margin", |numbers| numbers.margin = 3),
            ("contrast", |numbers| numbers.contrast = (3.0, 2.0)),
            ("slow rate", |numbers| numbers.slow_rate = 16.0),
            ("early rate", |numbers| numbers.early_rate = 64.0),
            ("cells' stride", |numbers| numbers.cells.stride = 7),
            ("cells' reach", |numbers| numbers.cells.reach = 1),
            ("gain of light", |numbers| numbers.most_gain = 1.0),
            ("parts", |numbers| numbers.parts_across = 3),
            ("ratio that counts", |numbers| numbers.ratio_that_counts = 5),
            ("sub-pixel", |numbers| numbers.parts.sub_pixel = false),
            ("slow template", |numbers| numbers.parts.slow_template = false),
            ("anchor", |numbers| numbers.parts.anchor = false),
            ("verification", |numbers| numbers.parts.verification = false),
        ];
        for (what, change) in others {
            let mut numbers = Numbers::robust();
            change(&mut numbers);
            let report = checked(CHECKED[0], Config::robust(), numbers, 40);
            assert!(!report.holds(), "another {what} goes unnoticed");
        }
    }

    /// The numbers of a loss and of the sweep, on a target that leaves and comes back.
    #[test]
    fn other_numbers_of_the_sweep_are_noticed() {
        let others: [Change<Numbers>; 10] = [
            ("doubtful", |numbers| numbers.doubtful_below = 0.0),
            ("denied", |numbers| (numbers.denied_below, numbers.far_below) = (0.0, 0.0)),
            ("far below", |numbers| numbers.far_below = 0.0),
            ("patience", |numbers| numbers.patience = 9),
            ("count of what is far below", |numbers| numbers.far_counts = 1),
            ("doubts", |numbers| numbers.doubts = 4),
            ("seen", |numbers| numbers.seen_from = 65_536.0),
            ("better", |numbers| numbers.better_by = 65_536.0),
            ("coarser", |numbers| numbers.coarser = 3),
            ("margin", |numbers| numbers.sweep_margin = 5),
        ];
        for (what, change) in others {
            let mut numbers = Numbers::robust();
            change(&mut numbers);
            assert!(!hidden(numbers).holds(), "another {what} goes unnoticed");
        }
    }

    #[test]
    fn a_target_that_is_lost_swept_for_and_found_again_holds() {
        let report = hidden(Numbers::robust());
        assert_eq!(report.violation, None);
        assert!(report.lost > 0 && report.swept >= report.lost && report.found_again > 0, "{report:?}");
    }

    /// The target leaves a scene of tiles, is lost and swept for, and comes back far from where it left.
    fn hidden(numbers: Numbers) -> Report {
        let (width, height) = (240usize, 160usize);
        let texture =
            |x: usize, y: usize| u8::try_from((x / 4 * 83 + y / 4 * 47 + x / 4 * (y / 4) * 29) % 256).unwrap();
        let frame = |at: Option<(usize, usize)>| {
            let ground = |x: usize, y: usize| u8::try_from(100 + (x / 40 + y / 40) % 2 * 30).unwrap();
            let mut pixels: Vec<u8> = (0..width * height).map(|at| ground(at % width, at / width)).collect();
            for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
                if let Some((left, top)) = at {
                    pixels[(top + y) * width + left + x] = texture(x, y);
                }
            }
            GrayFrame { width: 240, height: 160, pixels }
        };
        let target = Rect::new(30, 40, 32, 32);
        let mut check = Check::lock("hidden", Config::robust(), numbers, &frame(Some((30, 40))), target).unwrap();
        let there = (0..5).map(|step| Some((30 + step, 40)));
        for at in there.chain([None; 8]).chain([Some((190, 120)); 24]) {
            check.update(&frame(at)).unwrap();
            if !check.report().holds() {
                break;
            }
        }
        check.into_report()
    }
}
