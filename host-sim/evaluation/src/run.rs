//! One method on its way through one recording.

use super::Refused;
use super::method::{Method, Report};
use anyhow::{Context, Result};
use smr_core::{Frame, Quality, Rect};
use smr_recordings::GrayFrame;

/// Locks the method on the first frame, and looks for the target in all others.
pub struct Run {
    method: Box<dyn Method>,
    start: Rect,
    frames: usize,
}

impl Run {
    /// `method` will be locked on `start`.
    pub fn new(method: Box<dyn Method>, start: Rect) -> Self {
        Self { method, start, frames: 0 }
    }

    /// See [`Method::quality`].
    pub fn quality(&self) -> Option<Quality> {
        self.method.quality()
    }

    /// What the method says about the next frame.
    /// Errors: The method's, with the number of the frame; the first is 1.
    pub fn step(&mut self, frame: &GrayFrame) -> Result<Report> {
        self.frames += 1;
        let report = match self.frames {
            1 => lock(self.method.as_mut(), &frame.frame(), self.start).map(|()| Report::locked(self.start)),
            _ => self.method.update(&frame.frame()),
        };
        report.with_context(|| format!("frame {}", self.frames))
    }
}

/// Starts `method` on the target in `target`.
/// Errors: What the method refuses is a [`Refused`].
pub fn lock(method: &mut dyn Method, frame: &Frame<'_>, target: Rect) -> Result<()> {
    method.lock(frame, target).map_err(|error| Refused::or(error, method.kind(), target, frame.bounds()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Configs, MethodKind};
    use clap::ValueEnum;
    use smr_core::{State, UpdateError, paper};

    fn plain(width: u16, height: u16) -> GrayFrame {
        GrayFrame { width, height, pixels: vec![7; usize::from(width) * usize::from(height)] }
    }

    /// In plain frames no peak exceeds the runner-up, which only the camera's preset does not ask for.
    fn built(kind: MethodKind) -> Box<dyn Method> {
        kind.build(&paper::Config::camera().into()).unwrap()
    }

    fn all_kinds() -> impl Iterator<Item = MethodKind> {
        MethodKind::value_variants().iter().copied()
    }

    #[test]
    fn a_run_locks_once_and_then_updates() {
        let start = Rect::new(3, 2, 4, 4);
        for kind in all_kinds() {
            let mut run = Run::new(built(kind), start);
            assert_eq!(run.step(&plain(16, 12)).unwrap(), Report::locked(start));
            let report = run.step(&plain(16, 12)).unwrap();
            assert_eq!((report.target, report.state), (Some(start.into()), State::Tracking), "{}", kind.name());
            assert_eq!((report.evidence.is_some(), report.work.is_some()), (kind.is_core(), kind.is_core()));
        }
    }

    #[test]
    fn errors_name_the_frame() {
        for kind in all_kinds() {
            let mut run = Run::new(built(kind), Rect::new(3, 2, 4, 4));
            run.step(&plain(16, 12)).unwrap();
            let error = run.step(&plain(16, 13)).unwrap_err();
            assert_eq!(format!("{error:#}"), format!("frame 2: {}", UpdateError::FrameSizeChanged));
            let mut run = Run::new(built(kind), Rect::new(13, 2, 4, 4));
            let error = run.step(&plain(16, 12)).unwrap_err();
            let expected = "the box 13,2,4,4 (x,y,width,height) is not wholly inside the frame of 16x12 pixels";
            assert_eq!(format!("{error:#}"), format!("frame 1: {expected}"));
        }
    }

    #[test]
    fn steps_change_no_answer_and_no_work_is_left_out() {
        let frame = |step: u16| {
            let texture =
                |x: u16, y: u16| u8::try_from((x / 3 * 83 + y / 3 * 47 + x / 3 * (y / 3) * 29) % 256).unwrap();
            let pixels = (0..60).flat_map(|y| (0..80).map(move |x| texture(x + step, y))).collect();
            GrayFrame { width: 80, height: 60, pixels }
        };
        for kind in all_kinds().filter(|kind| kind.is_core()) {
            let reports = |step| {
                let configs = Configs { step, ..paper::Config::camera().into() };
                let mut run = Run::new(kind.build(&configs).unwrap(), Rect::new(30, 20, 20, 16));
                (0..6).map(|step| run.step(&frame(step)).unwrap()).collect::<Vec<_>>()
            };
            let whole = reports(u32::MAX);
            for step in [1, 5000] {
                for (whole, stepped) in whole.iter().zip(reports(step)) {
                    assert_eq!(Report { work: None, ..*whole }, Report { work: None, ..stepped }, "{}", kind.name());
                }
            }
        }
    }
}
