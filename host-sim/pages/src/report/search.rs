//! A method's box in a frame, believed or not, and the pixels that it compared.

use super::difference::Difference;
use anyhow::{Context, Result};
use smr_core::unstable::followed;
use smr_core::{Frame, Rect, Robust, State, Tracker};
use smr_evaluation::{Method, MethodKind, Paper, Report, Variant};
use smr_recordings::{BoundingBox, GrayFrame};
use smr_reference::robust::{Lattice, Numbers, Patch, Picture, free_gain, relit, threshold};

pub struct Sight {
    /// The method's box; when lost, the last accepted one, or the one that the tracker follows meanwhile.
    pub bbox: BoundingBox,
    /// `None` in the frame of a lock, which needs no search.
    pub search: Option<Search>,
}

pub struct Search {
    /// The difference from the template: for smr at the peak, even if the gate refused it; for the robust tracker in its box, from
    /// the early template; for a baseline in its box.
    pub difference: Difference,
    /// Smaller differences count; `None` if all count.
    pub alpha: Option<u16>,
}

/// A tracker that keeps what it compares.
pub(super) struct Looking {
    kind: MethodKind,
    tracker: Looked,
    /// The sight of the last frame, until it is taken.
    pub sight: Option<Sight>,
}

enum Looked {
    Paper(Box<Tracker<Paper>>),
    Robust(Box<Tracker<Robust>>),
    Baseline(Box<dyn Method>),
}

impl Looking {
    /// Errors: A number of the configuration that smr-core cannot use.
    pub fn new(variant: &Variant) -> Result<Self> {
        let mut configs = variant.configs;
        // The page draws the runner-up. To search it in every frame changes nothing else.
        configs.paper.runner_up_always = true;
        let tracker = match variant.kind {
            MethodKind::Smr => Looked::Paper(Box::new(Tracker::with(configs.paper)?)),
            MethodKind::Robust => Looked::Robust(Box::new(Tracker::with(configs.robust)?)),
            _ => Looked::Baseline(variant.build()?),
        };
        Ok(Self { kind: variant.kind, tracker, sight: None })
    }
}

impl Method for Looking {
    fn kind(&self) -> MethodKind {
        self.kind
    }

    fn lock(&mut self, frame: &Frame<'_>, start: Rect) -> Result<()> {
        match &mut self.tracker {
            Looked::Paper(tracker) => tracker.lock(frame, start).map(|_| ())?,
            Looked::Robust(tracker) => tracker.lock(frame, start).map(|_| ())?,
            Looked::Baseline(tracker) => tracker.lock(frame, start)?,
        }
        self.sight = Some(Sight { bbox: start.into(), search: None });
        Ok(())
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<Report> {
        let image = frame.patch(frame.bounds()).context("a frame to be shown is wholly in memory")?.into();
        let (report, sight) = match &mut self.tracker {
            Looked::Paper(tracker) => paper(tracker, &image)?,
            Looked::Robust(tracker) => robust(tracker, &image)?,
            Looked::Baseline(tracker) => baseline(tracker.as_mut(), &image)?,
        };
        self.sight = Some(sight);
        Ok(report)
    }
}

/// A frame without an answer; the first box of the target is `start`.
pub(super) fn not_begun(start: Rect) -> (Report, Sight) {
    let report = Report { target: None, bbox: None, state: State::Lost, evidence: None, work: None };
    (report, Sight { bbox: start.into(), search: None })
}

fn paper(tracker: &mut Tracker<Paper>, frame: &GrayFrame) -> Result<(Report, Sight)> {
    // The template, before this frame replaces it.
    let template = GrayFrame::from(tracker.target().template().context("there is no template yet")?);
    let answer = tracker.update(&frame.frame())?;
    let work = tracker.work();
    let found = smr_core::unstable::peaks(tracker.workspace()).context("the update is finished")?;
    let peak = Rect { x: found.peak.x, y: found.peak.y, ..answer.bbox };
    let search = Search { difference: Difference::new(frame, peak, template), alpha: answer.alpha };
    let report = Report { work: Some(work), ..answer.into() };
    Ok((report, Sight { bbox: answer.bbox.into(), search: Some(search) }))
}

/// The robust tracker compares on its grid: the patch in its box with the early template in the light of that patch.
fn robust(tracker: &mut Tracker<Robust>, frame: &GrayFrame) -> Result<(Report, Sight)> {
    let grid = tracker.target().grid().context("there is no grid yet")?;
    let early = tracker.target().early_template().context("there is no early template yet")?;
    let (columns, rows) = (grid.columns.into(), grid.rows.into());
    let early = Patch { columns, rows, pixels: early.map(f64::from).collect() };
    let answer = tracker.update(&frame.frame())?;
    let work = tracker.work();
    let target = BoundingBox::from(answer.fine);
    // The template lies where the target was followed to, not in the middle of the refined box.
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
    let report = Report { work: Some(work), ..answer.into() };
    Ok((report, Sight { bbox: target, search: Some(search) }))
}

fn baseline(tracker: &mut dyn Method, frame: &GrayFrame) -> Result<(Report, Sight)> {
    let template = GrayFrame::from(tracker.template().context("there is no template yet")?);
    let report = tracker.update(&frame.frame())?;
    let (bbox, at) = report.target.zip(report.bbox).context("a baseline always answers")?;
    let difference = Difference::new(frame, at, template);
    Ok((report, Sight { bbox, search: Some(Search { difference, alpha: None }) }))
}
