//! Runs a tracking method and records, for each frame, its box (accepted or not) and the pixels that it compared.

use super::difference::Difference;
use anyhow::{Context, Result};
use smr_core::robust::{Size, Small};
use smr_core::unstable::followed;
use smr_core::{Frame, Rect, Robust, State, Tracker};
use smr_evaluation::{Method, MethodAnswer, MethodKind, Paper, RobustSize, Variant};
use smr_recordings::{BoundingBox, GrayFrame};
use smr_reference::robust::{Lattice, Numbers, Patch, Picture, free_gain, relit, threshold};

pub struct Observation {
    /// Box of the method. While the target is lost: the last accepted box, or a candidate that is not confirmed.
    pub bbox: BoundingBox,
    /// Compared pixels; `None` in the frame of a lock, which needs no search.
    pub search: Option<Search>,
}

pub struct Search {
    /// Difference between a template and the frame's pixels at one position. Paper's tracker: the most similar
    /// position, accepted or not. Baselines: the method's box. Robust tracker: the tracked position; the template is
    /// the early one (of the first frames).
    pub difference: Difference,
    /// Threshold: pixels with a smaller difference count toward the similarity. `None` if all pixels count.
    pub alpha: Option<u16>,
}

pub(super) struct ObservedTracker {
    kind: MethodKind,
    tracker: AnyTracker,
    /// Box and compared pixels of the last frame, until the caller takes them.
    pub observation: Option<Observation>,
}

enum AnyTracker {
    Paper(Box<Tracker<Paper>>),
    Robust(Box<Tracker<Robust>>),
    SmallRobust(Box<Tracker<Robust<Small>>>),
    Baseline(Box<dyn Method>),
}

impl ObservedTracker {
    /// Errors: smr-core rejects a parameter of the configuration.
    pub fn new(variant: &Variant) -> Result<Self> {
        let mut configs = variant.configs;
        // The page plots the runner-up's score, so it is computed in every frame; answers stay the same.
        configs.paper.runner_up_always = true;
        let tracker = match variant.kind {
            MethodKind::Paper => AnyTracker::Paper(Box::new(Tracker::with(configs.paper)?)),
            MethodKind::Robust => match configs.robust_size {
                RobustSize::Standard => AnyTracker::Robust(Box::new(Tracker::with(configs.robust)?)),
                RobustSize::Small => AnyTracker::SmallRobust(Box::new(Tracker::with(configs.robust)?)),
            },
            _ => AnyTracker::Baseline(variant.build()?),
        };
        Ok(Self { kind: variant.kind, tracker, observation: None })
    }
}

impl Method for ObservedTracker {
    fn kind(&self) -> MethodKind {
        self.kind
    }

    fn lock(&mut self, frame: &Frame<'_>, start: Rect) -> Result<()> {
        match &mut self.tracker {
            AnyTracker::Paper(tracker) => tracker.lock(frame, start).map(|_| ())?,
            AnyTracker::Robust(tracker) => tracker.lock(frame, start).map(|_| ())?,
            AnyTracker::SmallRobust(tracker) => tracker.lock(frame, start).map(|_| ())?,
            AnyTracker::Baseline(tracker) => tracker.lock(frame, start)?,
        }
        self.observation = Some(Observation { bbox: start.into(), search: None });
        Ok(())
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<MethodAnswer> {
        let image = frame.patch(frame.bounds()).context("a frame to be shown is wholly in memory")?.into();
        let (report, observation) = match &mut self.tracker {
            AnyTracker::Paper(tracker) => paper(tracker, &image)?,
            AnyTracker::Robust(tracker) => robust(tracker, &image)?,
            AnyTracker::SmallRobust(tracker) => robust(tracker, &image)?,
            AnyTracker::Baseline(tracker) => baseline(tracker.as_mut(), &image)?,
        };
        self.observation = Some(observation);
        Ok(report)
    }
}

/// Returns a *lost* report for a frame before the target's first lock, and the box of that lock, `start`, to draw.
pub(super) fn not_begun(start: Rect) -> (MethodAnswer, Observation) {
    let report = MethodAnswer { target: None, bbox: None, state: State::Lost, evidence: None, work: None };
    (report, Observation { bbox: start.into(), search: None })
}

fn paper(tracker: &mut Tracker<Paper>, frame: &GrayFrame) -> Result<(MethodAnswer, Observation)> {
    // The template is copied now, before this frame replaces it.
    let template = GrayFrame::from(tracker.target().template().context("there is no template yet")?);
    let answer = tracker.update(&frame.frame())?;
    let work = tracker.work();
    let found = smr_core::unstable::peaks(tracker.workspace()).context("the update is finished")?;
    let peak = Rect { x: found.peak.x, y: found.peak.y, ..answer.bbox };
    let search = Search { difference: Difference::new(frame, peak, template), alpha: answer.alpha };
    let report = MethodAnswer { work: Some(work), ..answer.into() };
    Ok((report, Observation { bbox: answer.bbox.into(), search: Some(search) }))
}

/// Updates the tracker, then compares the pixels at the tracked position with the early template, whose brightness and
/// contrast are first adjusted to these pixels.
fn robust<S: Size>(tracker: &mut Tracker<Robust<S>>, frame: &GrayFrame) -> Result<(MethodAnswer, Observation)> {
    let grid = tracker.target().grid().context("there is no grid yet")?;
    let early = tracker.target().early_template().context("there is no early template yet")?;
    let (columns, rows) = (grid.columns.into(), grid.rows.into());
    let early = Patch { columns, rows, pixels: early.map(f64::from).collect() };
    let answer = tracker.update(&frame.frame())?;
    let work = tracker.work();
    let target = BoundingBox::from(answer.fine);
    // The template's centre is the tracked position, not the centre of the refined box.
    let followed = BoundingBox::from(followed(tracker.target()).unwrap_or(answer.fine));
    let step = f64::from(grid.step) / 4096.0 * f64::from(answer.scale) / 65536.0;
    let lattice = Lattice {
        x: followed.x + followed.width / 2.0 - 0.5,
        y: followed.y + followed.height / 2.0 - 0.5,
        step,
        step_down: step,
        columns,
        rows,
    };
    let picture = Picture { pixels: &frame.pixels, width: frame.width.into(), height: frame.height.into() };
    let numbers = Numbers::refined();
    let seen = lattice.sample(&numbers, &picture);
    let gain = free_gain(&early, &seen);
    let lit = relit(&early, &seen, gain);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // gray levels, and a threshold of them
    let byte = |level: f64| level as u8;
    let pairs = seen.pixels.iter().zip(&lit.pixels);
    let shown = |pixels: Vec<u8>| GrayFrame { width: grid.columns, height: grid.rows, pixels };
    let difference = Difference {
        pixels: shown(pairs.map(|(seen, lit)| byte((seen - lit).abs())).collect()),
        template: shown(lit.pixels.iter().copied().map(byte).collect()),
    };
    let search = Search { difference, alpha: Some(byte(threshold(&numbers, &early, &seen, gain)).into()) };
    let report = MethodAnswer { work: Some(work), ..answer.into() };
    Ok((report, Observation { bbox: target, search: Some(search) }))
}

fn baseline(tracker: &mut dyn Method, frame: &GrayFrame) -> Result<(MethodAnswer, Observation)> {
    let template = GrayFrame::from(tracker.template().context("there is no template yet")?);
    let report = tracker.update(&frame.frame())?;
    let (bbox, at) = report.target.zip(report.bbox).context("a baseline always answers")?;
    let difference = Difference::new(frame, at, template);
    Ok((report, Observation { bbox, search: Some(Search { difference, alpha: None }) }))
}
