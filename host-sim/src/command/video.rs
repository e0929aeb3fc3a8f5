//! Video with the trackers' answers drawn over the frames.

use anyhow::Result;
use smr_core::State;
use smr_evaluation::{Report, name_of};
use smr_pages::colors::{AMBER, GREEN, RED, TARGETS, WHITE};
use smr_pages::export::{self, Overlay, Plan};
use smr_recordings::{BoundingBox, Frame};
use std::path::Path;

pub struct Film {
    film: export::Film,
    truth: std::vec::IntoIter<Option<BoundingBox>>,
    /// Last known box of each target.
    lasts: Vec<Option<BoundingBox>>,
}

pub struct Shown<'a> {
    pub name: Option<&'a str>,
    /// Answer of the tracker; `None` before the first box of the target, and while the target is gone.
    pub report: Option<Report>,
}

impl Film {
    /// Creates the video. `truth` has the ground-truth box of each frame, if there is any.
    pub fn create(out: &Path, plan: Plan, truth: Vec<Option<BoundingBox>>) -> Result<Self> {
        Ok(Self { film: export::Film::create(out, plan)?, truth: truth.into_iter(), lasts: Vec::new() })
    }

    /// Draws the ground truth in white. The box of a single target has the color of the target's state; with several
    /// targets, the box of each has the target's own color.
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
        match targets {
            [Shown { report: Some(report), name }] => self.draw_only(&mut overlay, number, report, *name),
            _ => self.draw_all(&mut overlay, number, targets),
        }
        self.film.frame(&overlay, moment)
    }

    fn draw_only(&self, overlay: &mut Overlay, number: usize, report: &Report, name: Option<&str>) {
        let color = match report.state {
            State::Tracking => GREEN,
            State::Leaving | State::Uncertain => AMBER,
            State::Lost => RED,
        };
        if let Some(last) = self.lasts[0] {
            overlay.outline(&last, color);
        }
        let name = name.map_or(String::new(), |name| format!("{name} "));
        let confidence = report.evidence.map(|evidence| format!(" {:.0}", evidence.confidence * 100.0));
        let state = name_of(report.state);
        overlay.label(&format!("{number} {name}{state}{}", confidence.unwrap_or_default()), color);
    }

    fn draw_all(&self, overlay: &mut Overlay, number: usize, targets: &[Shown<'_>]) {
        for ((shown, last), &color) in targets.iter().zip(&self.lasts).zip(TARGETS.iter().cycle()) {
            let (Some(report), Some(last), name) = (&shown.report, last, shown.name.unwrap_or("")) else { continue };
            if report.state == State::Tracking {
                overlay.outline(last, color);
                overlay.label_box(last, name, color);
            } else {
                overlay.dashed_outline(last, color);
                overlay.label_box(last, &format!("{name} {}", name_of(report.state)), color);
            }
        }
        overlay.label(&number.to_string(), WHITE);
    }

    pub fn finish(self) -> Result<()> {
        self.film.finish()
    }
}
