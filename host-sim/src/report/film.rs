//! Methods on their way through a recording: what is known of every frame, and the pictures of those to show.

use super::look::{self, Shown, Sight};
use super::reel::{Choice, Reel};
use crate::evaluate::{Contestant, Evaluation, MethodKind, Report, Score, Variant};
use crate::sequence::{BoundingBox, GrayFrame, Sequence};
use anyhow::{Context, Result, ensure};
use smr_core::Rect;

/// All that a report tells.
pub struct Film {
    pub name: String,
    /// The first is the one whose states are shown.
    pub methods: Vec<Variant>,
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

/// What the methods said about one frame.
pub struct Moment {
    pub reports: Vec<Report>,
}

impl Moment {
    /// What the first one said.
    #[must_use]
    pub fn first(&self) -> &Report {
        &self.reports[0]
    }
}

/// A frame to show.
pub(super) struct Still {
    /// The first is 0.
    pub index: usize,
    pub frame: GrayFrame,
    /// What each method looked at.
    pub sights: Vec<Sight>,
}

impl Still {
    /// The search window that is drawn: that of the first method that shows one.
    pub fn window(&self) -> Option<Rect> {
        self.sights.iter().find_map(|sight| sight.search.as_ref()?.window)
    }
}

/// Runs all `methods` over the sequence. Frames stream: only those of `choice` are kept. `progress` is called after each.
///
/// # Errors
/// No method, no box to start from, a frame that cannot be read or tracked, or a listed frame that there is not.
pub fn watch(sequence: Sequence, methods: &[Variant], choice: Choice, progress: impl Fn()) -> Result<Film> {
    ensure!(!methods.is_empty(), "there is no method to show");
    let start = sequence.start()?;
    let Sequence { name, frames, truth, .. } = sequence;
    let last = if let Choice::Listed(frames) = &choice { frames.last().copied() } else { None };
    let mut trackers: Vec<Box<dyn Shown>> = methods.iter().map(look::shown).collect::<Result<_>>()?;
    let (mut reel, mut moments, mut size) = (Reel::new(choice), Vec::<Moment>::new(), (0, 0));
    for (index, frame) in frames.enumerate() {
        let frame = frame?;
        let look = |(tracker, variant): (&mut Box<dyn Shown>, &Variant)| {
            let look = if index == 0 { tracker.lock(&frame, start) } else { tracker.update(&frame) };
            look.with_context(|| format!("{name}: {}: frame {}", variant.name, index + 1))
        };
        let looks: Result<Vec<(Report, Sight)>> = trackers.iter_mut().zip(methods).map(look).collect();
        let (reports, sights) = looks?.into_iter().unzip();
        let moment = Moment { reports };
        let changed = moments.last().is_some_and(|last| last.first().state != moment.first().state);
        size = (frame.width, frame.height);
        moments.push(moment);
        reel.offer(index, changed, || Still { index, frame, sights });
        progress();
    }
    let length = moments.len();
    if let Some(last) = last {
        ensure!(last < length, "{name}: there is no frame {}: expected 1 to {length}", last + 1);
    }
    let (stills, changes_left_out) = reel.into_stills();
    let padding = methods[0].configs().paper.padding;
    Ok(Film { name, methods: methods.to_vec(), size, start, padding, moments, stills, changes_left_out, truth })
}

impl Film {
    /// Numbers of the frames that are shown; the first is 1.
    #[must_use]
    pub fn shown(&self) -> Vec<usize> {
        self.stills.iter().map(|still| still.index + 1).collect()
    }

    /// How well all did, by the protocol of the recordings; `None` without ground truth.
    ///
    /// # Errors
    /// The ground truth is not that of so many frames.
    pub fn evaluation(&self) -> Result<Option<Evaluation>> {
        let Some(truth) = &self.truth else { return Ok(None) };
        let score = |(index, variant): (usize, &Variant)| {
            let score = Score::new(&self.trajectory(index), truth).with_context(|| self.name.clone())?;
            anyhow::Ok((Contestant::of(variant), score))
        };
        let scores = self.methods.iter().enumerate().map(score).collect::<Result<_>>()?;
        let visible = truth.iter().flatten().count();
        Ok(Some(Evaluation { sequence: self.name.clone(), visible, scores, failures: vec![], notes: vec![] }))
    }

    /// Where in the list of methods those of this kind are.
    pub(super) fn all_of(&self, kind: MethodKind) -> impl Iterator<Item = usize> {
        (0..self.methods.len()).filter(move |&index| self.methods[index].kind == kind)
    }

    /// What one of the methods answered.
    pub(super) fn trajectory(&self, method: usize) -> Vec<Option<BoundingBox>> {
        self.moments.iter().map(|moment| moment.reports[method].target).collect()
    }

    pub(super) fn truth_at(&self, index: usize) -> Option<BoundingBox> {
        self.truth.as_ref().and_then(|truth| *truth.get(index)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Configs;
    use crate::sequence::{self, OpenOptions, synthetic};
    use smr_core::State;
    use smr_core::paper::Config;
    use std::path::Path;

    fn open() -> Sequence {
        sequence::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap()
    }

    fn variants(methods: &[MethodKind]) -> Vec<Variant> {
        let configs = Configs::from(Config::paper());
        methods.iter().map(|&kind| Variant::new(kind, &configs)).collect()
    }

    fn film(methods: &[MethodKind]) -> Film {
        watch(open(), &variants(methods), Choice::Spread, || ()).unwrap()
    }

    #[test]
    fn the_film_is_what_the_methods_answer() {
        let methods = [MethodKind::Smr, MethodKind::Sad, MethodKind::Robust];
        let film = film(&methods);
        let evaluated = crate::evaluate::evaluate(open(), &variants(&methods), &[], || ()).unwrap();
        assert_eq!(film.evaluation().unwrap().unwrap().scores, evaluated.scores);
        assert_eq!(film.moments.len(), synthetic::LENGTH);
        let states: Vec<State> = film.stills.iter().map(|still| film.moments[still.index].first().state).collect();
        for state in [State::Tracking, State::Leaving, State::Lost] {
            assert!(states.contains(&state), "{state:?}");
        }
    }

    #[test]
    fn any_method_can_be_the_first() {
        use clap::ValueEnum;
        for &kind in MethodKind::value_variants() {
            let film = film(&[kind]);
            assert!(film.moments.iter().all(|moment| kind.states().contains(&moment.first().state)), "{}", kind.name());
            let page = crate::report::page(&film).unwrap();
            assert!(page.contains(&format!(">{}</th>", kind.name().to_uppercase())));
            assert_eq!(page.contains("</span>uncertain<span"), kind == MethodKind::Robust);
            assert_eq!(page.contains("</span>leaving"), kind != MethodKind::Robust);
            assert!(crate::report::picture(&film).unwrap().starts_with(b"\x89PNG"));
        }
        assert!(watch(open(), &[], Choice::Spread, || ()).is_err());
    }

    #[test]
    fn what_counts_adds_up_to_the_ratio() {
        let film = film(&[MethodKind::Smr]);
        let mut searched = 0;
        for still in &film.stills {
            let Some(search) = &still.sights[0].search else { continue };
            let evidence = film.moments[still.index].first().evidence.unwrap();
            let alpha = search.alpha.unwrap();
            let counting = search.difference.pixels.iter().filter(|&&d| u16::from(d) < alpha);
            let score: f64 = counting.map(|&d| (-f64::from(d) / 255.0).exp()).sum();
            let ratio = score / search.difference.pixels.len() as f64;
            assert_eq!(evidence.alpha, search.alpha);
            assert!((ratio - evidence.ratio).abs() < 3e-5, "frame {}: {ratio} {}", still.index, evidence.ratio);
            assert!(search.window.unwrap().contains(search.difference.at));
            searched += 1;
        }
        assert!(searched > 10);
    }

    #[test]
    fn a_frame_that_there_is_not_is_named() {
        let choice = Choice::Listed([0, 240].into());
        let error = watch(open(), &variants(&[MethodKind::Smr]), choice, || ()).err().unwrap();
        assert_eq!(error.to_string(), "synthetic: there is no frame 241: expected 1 to 240");
    }

    #[test]
    fn ground_truth_of_another_length_is_an_error() {
        let truth = open().truth.map(|truth| truth[..9].to_vec());
        let film = watch(Sequence { truth, ..open() }, &variants(&[MethodKind::Smr]), Choice::Spread, || ()).unwrap();
        let error = format!("{:#}", film.evaluation().err().unwrap());
        assert_eq!(error, "synthetic: there are 240 frames, but the ground truth has 9 boxes");
    }
}
