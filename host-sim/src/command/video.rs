//! Video with the trackers' answers drawn over the frames.

use super::steady::Steady;
use anyhow::Result;
use smr_core::State;
use smr_evaluation::{MethodAnswer, name_of};
use smr_pages::colors::{Color, TRUTH, WHITE, color_of, of_target};
use smr_pages::export::{self, Overlay, Plan};
use smr_recordings::{BoundingBox, Frame};
use std::collections::VecDeque;
use std::path::Path;

/// Marks that a video shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Mark {
    /// The box, and that of the ground truth
    Box,
    /// The number of the frame, and the name and the state of the target
    Name,
    /// The path of the target through the last frames
    Trail,
    /// Nothing: the frames as they are
    Nothing,
}

/// Frames through which a trail is drawn, as in the viewer.
const TRAIL: usize = 75;

/// The marks of a video, and the index and first box of the target that it is cropped to, if it is.
pub struct Look {
    pub marks: Vec<Mark>,
    pub cropped: Option<(usize, BoundingBox)>,
}

pub struct AnswersVideo {
    film: export::VideoWriter,
    truth: std::vec::IntoIter<Option<BoundingBox>>,
    /// Id of each target, which selects its color; 1, 2, ... if the list is shorter.
    ids: Vec<usize>,
    /// Last known box of each target.
    lasts: Vec<Option<BoundingBox>>,
    /// Last centres of each target's box.
    trails: Vec<VecDeque<(f64, f64)>>,
    marks: Vec<Mark>,
    /// The part that is shown, and the index of the target that it is around.
    part: Option<(usize, Steady)>,
}

pub struct Shown<'a> {
    pub name: Option<&'a str>,
    /// Answer of the tracker; `None` before the first box of the target, and while the target is gone.
    pub report: Option<MethodAnswer>,
}

impl AnswersVideo {
    /// Creates the video. `truth` has the ground-truth box of each frame, if there is any.
    pub fn create(out: &Path, plan: Plan, truth: Vec<Option<BoundingBox>>, ids: &[usize], look: Look) -> Result<Self> {
        let film = export::VideoWriter::create(out, plan)?;
        let (truth, ids) = (truth.into_iter(), ids.to_vec());
        let part = look.cropped.map(|(target, first)| (target, Steady::new(&first)));
        Ok(Self { film, truth, ids, lasts: Vec::new(), trails: Vec::new(), marks: look.marks, part })
    }

    fn shows(&self, mark: Mark) -> bool {
        self.marks.contains(&mark)
    }

    /// Draws the ground truth in green, and each target's box in the target's color: dashed while it is not tracking.
    /// The state of a single target stands beside the frame number, those of several at their boxes.
    pub fn frame(&mut self, frame: Frame, targets: &[Shown<'_>]) -> Result<()> {
        let (number, moment) = (frame.number, frame.moment);
        let frame = frame.color.unwrap_or_else(|| (&frame.gray).into());
        self.follow(targets);
        let mut overlay = match &mut self.part {
            Some((target, part)) => {
                let report = targets.get(*target).and_then(|shown| shown.report);
                let middle = part.next(report.and_then(|report| report.target).as_ref());
                Overlay::part(&frame, middle, part.side())?
            }
            None => Overlay::new(&frame)?,
        };
        if let Some(truth) = self.truth.next().flatten().filter(|_| self.shows(Mark::Box)) {
            overlay.outline(&truth, TRUTH, false);
        }
        self.draw(&mut overlay, targets)?;
        let (words, color) = match targets {
            [Shown { report: Some(report), name }] => described(report, *name),
            _ => (String::new(), WHITE),
        };
        if self.shows(Mark::Name) {
            overlay.label(&format!("{number}{words}"), color)?;
        }
        self.film.frame(&overlay, moment)
    }

    fn follow(&mut self, targets: &[Shown<'_>]) {
        self.lasts.resize(targets.len(), None);
        self.trails.resize(targets.len(), VecDeque::new());
        for ((last, trail), shown) in self.lasts.iter_mut().zip(&mut self.trails).zip(targets) {
            let found = shown.report.and_then(|report| report.target);
            *last = found.or(*last);
            // A target that was lost is not led across the frame.
            let Some(found) = found else {
                trail.clear();
                continue;
            };
            trail.push_back(found.centre());
            trail.drain(..trail.len().saturating_sub(TRAIL));
        }
    }

    fn draw(&self, overlay: &mut Overlay, targets: &[Shown<'_>]) -> Result<()> {
        let is_only = targets.len() == 1;
        for (at, trail) in self.trails.iter().enumerate().filter(|_| self.shows(Mark::Trail)) {
            overlay.path(&trail.iter().copied().collect::<Vec<_>>(), self.color(at));
        }
        for (at, (shown, last)) in targets.iter().zip(&self.lasts).enumerate() {
            let (Some(MethodAnswer { state, .. }), Some(last)) = (shown.report, last) else { continue };
            let color = self.color(at);
            let is_tracking = state == State::Tracking;
            if self.shows(Mark::Box) {
                overlay.outline(last, color, !is_tracking);
            }
            if !is_only && self.shows(Mark::Name) {
                let name = shown.name.unwrap_or("");
                let words = if is_tracking { name.to_owned() } else { format!("{name} {}", name_of(state)) };
                overlay.label_box(last, &words, color)?;
            }
        }
        Ok(())
    }

    fn color(&self, target: usize) -> Color {
        of_target(self.ids.get(target).copied().unwrap_or(target + 1))
    }

    /// Ends the video. Returns a note if it has no sound, although the recording has.
    pub fn finish(self) -> Result<Option<String>> {
        self.film.finish()
    }
}

fn described(report: &MethodAnswer, name: Option<&str>) -> (String, Color) {
    let name = name.map_or(String::new(), |name| format!("{name} "));
    let confidence = report.evidence.map(|evidence| format!(" {:.0}", evidence.confidence * 100.0));
    (format!(" {name}{}{}", name_of(report.state), confidence.unwrap_or_default()), color_of(report.state))
}
