//! A tracker's answers as a film: what of an answer is drawn over its frame.

use crate::evaluate::{Report, name_of};
use crate::export::{self, AMBER, GREEN, Overlay, RED, WHITE};
use crate::sequence::{BoundingBox, GrayFrame};
use anyhow::Result;
use smr_core::State;
use std::num::NonZeroU16;
use std::path::Path;
use std::time::Duration;

/// A film under way.
pub struct Film {
    film: export::Film,
    truth: Option<Vec<Option<BoundingBox>>>,
    frames: usize,
    /// Where the target was seen last.
    last: Option<BoundingBox>,
}

impl Film {
    /// # Errors
    /// As [`export::Film::create`].
    pub fn create(
        out: &Path,
        rate: NonZeroU16,
        patience: Duration,
        truth: Option<Vec<Option<BoundingBox>>>,
    ) -> Result<Self> {
        Ok(Self { film: export::Film::create(out, rate, patience)?, truth, frames: 0, last: None })
    }

    /// Draws what was answered in the next frame. Ground truth is white; the box is green while the target is tracked, amber where that is not
    /// sure, and red, where it was seen last, when it is lost.
    ///
    /// # Errors
    /// As [`export::Film::frame`].
    pub fn frame(&mut self, frame: &GrayFrame, report: &Report) -> Result<()> {
        let mut overlay = Overlay::new(frame);
        let truth = self.truth.as_ref().and_then(|truth| truth.get(self.frames).copied().flatten());
        self.frames += 1;
        if let Some(truth) = truth {
            overlay.outline(&truth, WHITE);
        }
        self.last = report.target.or(self.last);
        let color = match report.state {
            State::Tracking => GREEN,
            State::Leaving | State::Uncertain => AMBER,
            State::Lost => RED,
        };
        if let Some(last) = self.last {
            overlay.outline(&last, color);
        }
        overlay.label(&label(self.frames, report), color);
        self.film.frame(&overlay)
    }

    /// # Errors
    /// As [`export::Film::finish`].
    pub fn finish(self) -> Result<()> {
        self.film.finish()
    }
}

/// Frame, state, and the confidence in hundredths.
fn label(frame: usize, report: &Report) -> String {
    let confidence = report.evidence.map(|evidence| format!(" {:.0}", evidence.confidence * 100.0));
    format!("{frame} {}{}", name_of(report.state), confidence.unwrap_or_default())
}
