//! SMR, the paper's or the robust one, and SAD on their way through a recording: what is known of every frame, and the pictures of those to show.

use super::difference::Difference;
use super::reel::{Choice, Reel};
use crate::Tracker;
use crate::evaluate::{Configs, Contestant, Evaluation, Method, MethodKind, Report, Score, State};
use crate::reference::robust::{Lattice, Numbers, Patch, Picture, in_light_of, threshold};
use crate::sequence::{BoundingBox, GrayFrame, Sequence};
use anyhow::{Context, Result, ensure};
use smr_core::search::Window;
use smr_core::{Image, Rect, robust};

/// All that a report tells.
pub struct Film {
    pub name: String,
    /// What SMR is called in results.
    pub(super) smr_name: &'static str,
    /// Those that it can be in, the best one first.
    pub(super) states: [State; 3],
    pub(super) size: (u16, u16),
    pub(super) start: Rect,
    pub(super) padding: u16,
    /// One a frame.
    pub moments: Vec<Moment>,
    pub(super) stills: Vec<Still>,
    /// Changes of state that there was no room to show.
    pub changes_left_out: usize,
    pub(super) truth: Option<Vec<Option<BoundingBox>>>,
}

/// What the two trackers said about one frame.
pub struct Moment {
    pub smr: Report,
    pub sad: Report,
}

/// A frame to show.
pub(super) struct Still {
    /// The first is 0.
    pub index: usize,
    pub frame: GrayFrame,
    pub sight: Sight,
}

/// What was looked at in a frame.
pub(super) struct Sight {
    /// SMR's box; when lost, the last one that was believed, or the one that is followed meanwhile.
    pub smr_box: BoundingBox,
    /// `None` in the frame that was locked on: nothing was looked for.
    pub search: Option<Search>,
}

/// What was looked for and found.
pub(super) struct Search {
    /// All that SMR's search window covers, of the padding too; of the robust tracker all that it may read.
    pub window: Rect,
    /// Of SMR's peak, believed or not, to its template; of the robust tracker's box to its early template.
    pub smr: Difference,
    /// Differences below count for SMR.
    pub alpha: u16,
    pub sad: Difference,
}

/// Runs both trackers over the sequence. Frames stream: only those of `choice` are kept. `progress` is called after each.
///
/// # Errors
/// No box to start from, a frame that cannot be read or tracked, or a listed frame that there is not.
pub fn watch(sequence: Sequence, configs: &Configs, choice: Choice, progress: impl Fn()) -> Result<Film> {
    let start = sequence.start()?;
    let Sequence { name, frames, truth, .. } = sequence;
    let last = if let Choice::Listed(frames) = &choice { frames.last().copied() } else { None };
    let mut trackers = Trackers { smr: Smr::new(configs)?, sad: MethodKind::Sad.build(configs)? };
    let (mut reel, mut moments, mut size) = (Reel::new(choice), Vec::<Moment>::new(), (0, 0));
    for (index, frame) in frames.enumerate() {
        let frame = frame?;
        let step = if index == 0 { trackers.lock(&frame, start) } else { trackers.update(&frame) };
        let (moment, sight) = step.with_context(|| format!("{name}: frame {}", index + 1))?;
        let changed = moments.last().is_some_and(|last| last.smr.state != moment.smr.state);
        size = (frame.width, frame.height);
        moments.push(moment);
        reel.offer(index, changed, || Still { index, frame, sight });
        progress();
    }
    let length = moments.len();
    if let Some(last) = last {
        ensure!(last < length, "{name}: there is no frame {}: expected 1 to {length}", last + 1);
    }
    let (stills, changes_left_out) = reel.into_stills();
    Ok(Film {
        name,
        smr_name: MethodKind::Smr.name(configs),
        states: configs.states(),
        size,
        start,
        padding: configs.paper.padding,
        moments,
        stills,
        changes_left_out,
        truth,
    })
}

impl Film {
    /// Numbers of the frames that are shown; the first is 1.
    pub fn shown(&self) -> Vec<usize> {
        self.stills.iter().map(|still| still.index + 1).collect()
    }

    /// How well both did, by the protocol of the recordings; `None` without ground truth.
    ///
    /// # Errors
    /// The ground truth is not that of so many frames.
    pub fn evaluation(&self) -> Result<Option<Evaluation>> {
        let Some(truth) = &self.truth else { return Ok(None) };
        let score = |name, of| {
            let score = Score::new(&self.trajectory(of), truth).with_context(|| self.name.clone())?;
            anyhow::Ok((Contestant::Method(String::from(name)), score))
        };
        let scores = vec![score(self.smr_name, Moment::smr)?, score("sad", Moment::sad)?];
        let visible = truth.iter().flatten().count();
        Ok(Some(Evaluation { sequence: self.name.clone(), visible, scores, failures: vec![], notes: vec![] }))
    }

    /// True if SMR is the robust tracker.
    pub(super) fn is_robust(&self) -> bool {
        self.states.contains(&State::Uncertain)
    }

    /// What SMR's evidence is called.
    pub(super) fn measure(&self) -> &'static str {
        if self.is_robust() { "confidence" } else { "ratio" }
    }

    /// What one of the trackers answered.
    pub(super) fn trajectory(&self, of: fn(&Moment) -> &Report) -> Vec<Option<BoundingBox>> {
        self.moments.iter().map(|moment| of(moment).target).collect()
    }

    pub(super) fn truth_at(&self, index: usize) -> Option<BoundingBox> {
        self.truth.as_ref().and_then(|truth| *truth.get(index)?)
    }
}

impl Moment {
    pub(super) const fn smr(&self) -> &Report {
        &self.smr
    }

    pub(super) const fn sad(&self) -> &Report {
        &self.sad
    }
}

struct Trackers {
    smr: Smr,
    sad: Box<dyn Method>,
}

impl Trackers {
    fn lock(&mut self, frame: &GrayFrame, start: Rect) -> Result<(Moment, Sight)> {
        self.smr.lock(frame, start)?;
        self.sad.lock(&frame.frame(), start)?;
        let (smr, sad) = (Report::locked(start), Report::locked(start));
        Ok((Moment { smr, sad }, Sight { smr_box: start.into(), search: None }))
    }

    fn update(&mut self, frame: &GrayFrame) -> Result<(Moment, Sight)> {
        let smr = self.smr.update(frame)?;
        // What is compared with, before this frame takes its place.
        let sad_template = Pixels::of(self.sad.template().context("SAD has no template yet")?);
        let sad = self.sad.update(&frame.frame())?;
        let sad_box = sad.target.and_then(|target| target.to_rect()).context("SAD always answers")?;
        let search = Search {
            window: smr.window,
            smr: smr.difference,
            alpha: smr.alpha,
            sad: Difference::new(frame, sad_box, sad_template.image()?),
        };
        Ok((Moment { smr: smr.report, sad }, Sight { smr_box: smr.bbox, search: Some(search) }))
    }
}

/// SMR is here as itself, not as a [`Method`]: what it did not believe is shown, too.
enum Smr {
    Paper(Box<Tracker>),
    Robust(Box<robust::Tracker>),
}

/// What SMR says of a frame, and what that is drawn from.
struct Look {
    report: Report,
    bbox: BoundingBox,
    window: Rect,
    difference: Difference,
    alpha: u16,
}

impl Smr {
    fn new(configs: &Configs) -> Result<Self> {
        Ok(match configs.robust {
            None => Self::Paper(Box::new(Tracker::new(configs.paper)?)),
            Some(config) => Self::Robust(Box::new(robust::Tracker::new(config))),
        })
    }

    fn lock(&mut self, frame: &GrayFrame, start: Rect) -> Result<()> {
        match self {
            Self::Paper(tracker) => Ok(tracker.lock(&frame.frame(), start)?),
            Self::Robust(tracker) => Ok(tracker.lock(&frame.frame(), start)?),
        }
    }

    fn update(&mut self, frame: &GrayFrame) -> Result<Look> {
        match self {
            Self::Paper(tracker) => look(tracker, frame),
            Self::Robust(tracker) => look_of_robust(tracker, frame),
        }
    }
}

fn look(tracker: &mut Tracker, frame: &GrayFrame) -> Result<Look> {
    let offsets = tracker.offsets().context("SMR has no target yet")?;
    // What is compared with, before this frame takes its place.
    let template = Pixels::of(tracker.template().context("SMR has no template yet")?);
    let answer = tracker.update(&frame.frame())?;
    let peak = Rect { x: answer.found.peak.x, y: answer.found.peak.y, ..answer.bbox };
    Ok(Look {
        report: answer.into(),
        bbox: answer.bbox.into(),
        window: covered(&offsets, answer.bbox),
        difference: Difference::new(frame, peak, template.image()?),
        alpha: answer.alpha,
    })
}

/// The robust tracker compares on its grid: here what is seen in its box, with the early template in the light of that.
fn look_of_robust(tracker: &mut robust::Tracker, frame: &GrayFrame) -> Result<Look> {
    let window = tracker.window().context("SMR has no target yet")?;
    let grid = tracker.grid().context("SMR has no grid yet")?;
    let early = tracker.early_template().context("SMR has no early template yet")?;
    let (columns, rows) = (grid.columns.into(), grid.rows.into());
    let early = Patch { columns, rows, pixels: early.map(f64::from).collect() };
    let answer = tracker.update(&frame.frame())?;
    let target = BoundingBox::from(answer.fine);
    let lattice = Lattice {
        x: target.x + target.width / 2.0 - 0.5,
        y: target.y + target.height / 2.0 - 0.5,
        step: f64::from(grid.step) / 4096.0 * f64::from(answer.scale) / 65536.0,
        columns,
        rows,
    };
    let picture = Picture { pixels: &frame.pixels, width: frame.width.into(), height: frame.height.into() };
    let (seen, numbers) = (lattice.sample(&picture), Numbers::robust());
    let lit = in_light_of(&numbers, &early, &seen);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // gray levels, and a threshold of them
    let byte = |level: f64| level as u8;
    let pairs = seen.pixels.iter().zip(&lit.pixels);
    Ok(Look {
        report: answer.into(),
        bbox: target,
        window,
        difference: Difference {
            at: answer.bbox,
            size: (grid.columns, grid.rows),
            pixels: pairs.map(|(seen, lit)| byte((seen - lit).abs())).collect(),
        },
        alpha: byte(threshold(&numbers, &seen)).into(),
    })
}

/// A copy of an image.
struct Pixels {
    size: (u16, u16),
    pixels: Vec<u8>,
}

impl Pixels {
    fn of(image: Image<'_>) -> Self {
        Self { size: (image.width(), image.height()), pixels: image.rows().flatten().copied().collect() }
    }

    fn image(&self) -> Result<Image<'_>> {
        Ok(Image::new(&self.pixels, self.size.0, self.size.1)?)
    }
}

/// Every pixel that a box of the size of `target` covers at one offset or another.
fn covered(offsets: &Window, target: Rect) -> Rect {
    let (columns, rows) = offsets.size();
    let extent = |offsets: usize, size: u16| u16::try_from(offsets - 1 + usize::from(size)).unwrap_or(u16::MAX);
    Rect::new(*offsets.xs().start(), *offsets.ys().start(), extent(columns, target.width), extent(rows, target.height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{self, OpenOptions, synthetic};
    use smr_core::Config;
    use std::path::Path;

    fn open() -> Sequence {
        sequence::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap()
    }

    fn variants(methods: &[MethodKind], configs: &Configs) -> Vec<crate::evaluate::Variant> {
        methods.iter().map(|&kind| crate::evaluate::Variant::new(kind, configs)).collect()
    }

    #[test]
    fn the_film_is_what_the_methods_answer() {
        let film = watch(open(), &Config::paper().into(), Choice::Spread, || ()).unwrap();
        let methods = [MethodKind::Smr, MethodKind::Sad];
        let evaluated =
            crate::evaluate::evaluate(open(), &variants(&methods, &Config::paper().into()), &[], || ()).unwrap();
        assert_eq!(film.evaluation().unwrap().unwrap().scores, evaluated.scores);
        assert_eq!(film.moments.len(), synthetic::LENGTH);
        let states: Vec<State> = film.stills.iter().map(|still| film.moments[still.index].smr.state).collect();
        for state in [State::Tracking, State::Leaving, State::Lost] {
            assert!(states.contains(&state), "{state:?}");
        }
    }

    #[test]
    fn the_robust_tracker_is_filmed_too() {
        let configs = Configs { robust: Some(robust::Config::robust()), ..Config::paper().into() };
        let film = watch(open(), &configs, Choice::Spread, || ()).unwrap();
        let methods = [MethodKind::Smr, MethodKind::Sad];
        let evaluated = crate::evaluate::evaluate(open(), &variants(&methods, &configs), &[], || ()).unwrap();
        let scores = film.evaluation().unwrap().unwrap().scores;
        assert_eq!(scores, evaluated.scores);
        assert_eq!(scores[0].0.name(), "robust");
        let states = || film.moments.iter().map(|moment| moment.smr.state);
        assert!(states().all(|state| film.states.contains(&state)) && states().any(|state| state == State::Uncertain));
        let page = crate::report::page(&film).unwrap();
        assert!(page.contains(">ROBUST</th>") && page.contains("</span>uncertain<span"));
        assert!(!page.contains("</span>leaving"));
    }

    #[test]
    fn what_counts_adds_up_to_the_ratio() {
        let film = watch(open(), &Config::paper().into(), Choice::Spread, || ()).unwrap();
        let mut searched = 0;
        for still in &film.stills {
            let Some(search) = &still.sight.search else { continue };
            let evidence = film.moments[still.index].smr.evidence.unwrap();
            let counting = search.smr.pixels.iter().filter(|&&d| u16::from(d) < search.alpha);
            let score: f64 = counting.map(|&d| (-f64::from(d) / 255.0).exp()).sum();
            let ratio = score / search.smr.pixels.len() as f64;
            assert_eq!(evidence.alpha, Some(search.alpha));
            assert!((ratio - evidence.ratio).abs() < 3e-5, "frame {}: {ratio} {}", still.index, evidence.ratio);
            assert!(search.window.contains(search.smr.at));
            searched += 1;
        }
        assert!(searched > 10);
    }

    #[test]
    fn a_frame_that_there_is_not_is_named() {
        let choice = Choice::Listed([0, 240].into());
        let error = watch(open(), &Config::paper().into(), choice, || ()).err().unwrap();
        assert_eq!(error.to_string(), "synthetic: there is no frame 241: expected 1 to 240");
    }

    #[test]
    fn ground_truth_of_another_length_is_an_error() {
        let truth = open().truth.map(|truth| truth[..9].to_vec());
        let film = watch(Sequence { truth, ..open() }, &Config::paper().into(), Choice::Spread, || ()).unwrap();
        let error = format!("{:#}", film.evaluation().err().unwrap());
        assert_eq!(error, "synthetic: there are 240 frames, but the ground truth has 9 boxes");
    }
}
