//! Video with the trackers' answers drawn over the frames.

use anyhow::Result;
use smr_core::State;
use smr_evaluation::{MethodAnswer, name_of};
use smr_pages::colors::{Color, WHITE, color_of, of_target};
use smr_pages::export::{self, Overlay, Plan};
use smr_recordings::{BoundingBox, Frame};
use std::path::Path;

pub struct AnswersVideo {
    film: export::VideoWriter,
    truth: std::vec::IntoIter<Option<BoundingBox>>,
    /// Id of each target, which selects its color; 1, 2, ... if the list is shorter.
    ids: Vec<usize>,
    /// Last known box of each target.
    lasts: Vec<Option<BoundingBox>>,
}

pub struct Shown<'a> {
    pub name: Option<&'a str>,
    /// Answer of the tracker; `None` before the first box of the target, and while the target is gone.
    pub report: Option<MethodAnswer>,
}

impl AnswersVideo {
    /// Creates the video. `truth` has the ground-truth box of each frame, if there is any.
    pub fn create(out: &Path, plan: Plan, truth: Vec<Option<BoundingBox>>, ids: &[usize]) -> Result<Self> {
        let film = export::VideoWriter::create(out, plan)?;
        Ok(Self { film, truth: truth.into_iter(), ids: ids.to_vec(), lasts: Vec::new() })
    }

    /// Draws the ground truth in white, and each target's box in the target's color: dashed while it is not tracking.
    /// The state of a single target stands beside the frame number, those of several at their boxes.
    pub fn frame(&mut self, frame: Frame, targets: &[Shown<'_>]) -> Result<()> {
        let (number, moment) = (frame.number, frame.moment);
        let mut overlay = Overlay::new(frame.color.unwrap_or_else(|| (&frame.gray).into()));
        if let Some(Some(truth)) = self.truth.next() {
            overlay.outline(&truth, WHITE);
        }
        self.lasts.resize(targets.len(), None);
        for (last, shown) in self.lasts.iter_mut().zip(targets) {
            *last = shown.report.and_then(|report| report.target).or(*last);
        }
        self.draw(&mut overlay, targets);
        let (words, color) = match targets {
            [Shown { report: Some(report), name }] => described(report, *name),
            _ => (String::new(), WHITE),
        };
        overlay.label(&format!("{number}{words}"), color);
        self.film.frame(&overlay, moment)
    }

    fn draw(&self, overlay: &mut Overlay, targets: &[Shown<'_>]) {
        let is_only = targets.len() == 1;
        for (at, (shown, last)) in targets.iter().zip(&self.lasts).enumerate() {
            let (Some(MethodAnswer { state, .. }), Some(last)) = (shown.report, last) else { continue };
            let color = of_target(self.ids.get(at).copied().unwrap_or(at + 1));
            let is_tracking = state == State::Tracking;
            if is_tracking {
                overlay.outline(last, color);
            } else {
                overlay.dashed_outline(last, color);
            }
            if !is_only {
                let name = shown.name.unwrap_or("");
                let words = if is_tracking { name.to_owned() } else { format!("{name} {}", name_of(state)) };
                overlay.label_box(last, &words, color);
            }
        }
    }

    /// Ends the video. Returns a note if it has no sound, although the recording has.
    pub fn finish(self) -> Result<Option<String>> {
        self.film.finish()
    }
}

fn described(report: &MethodAnswer, name: Option<&str>) -> (String, Color) {
    let name = name.map_or(String::new(), |name| format!("{name} "));
    let confidence = report.evidence.map(|evidence| format!(" {:.0}", evidence.confidence * 100.0));
    let color = if report.state == State::Tracking { WHITE } else { color_of(report.state) };
    (format!(" {name}{}{}", name_of(report.state), confidence.unwrap_or_default()), color)
}
