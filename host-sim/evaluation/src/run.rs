//! A run: the answers of one tracker in one recording, from which scores and tables are computed.

use super::method::{Method, MethodAnswer};
use super::{CORRECT, Refused, Variant};
use anyhow::{Context, Result};
use smr_core::{Frame, Quality, Rect, State};
use smr_recordings::{BoundingBox, GrayFrame, Target, Trajectory};
use std::time::{Duration, Instant};

/// A tracker that follows one target: locks on the first box, locks again on each correction, and updates in all other
/// frames. It stores no answers, so it can follow a camera for days.
pub struct Follower<M: Method + ?Sized = dyn Method> {
    /// Name of the target; `None` for a single target without a name.
    pub name: Option<String>,
    pub method: Box<M>,
    /// Entries still to come: a frame number and a box to lock on, or `None`: the target is gone until the next box.
    starts: std::iter::Peekable<std::vec::IntoIter<(usize, Option<Rect>)>>,
    is_there: bool,
}

impl Follower {
    /// Creates a follower for each target. Errors: A box has less than one pixel, or the configuration is invalid.
    pub fn all(targets: Vec<Target>, variant: &Variant) -> Result<Vec<Self>> {
        let methods = variant.build_all(targets.len())?;
        let one = |(target, method): (Target, _)| {
            let starts = target.rects()?;
            Ok(Self { name: target.name, ..Self::new(method, starts) })
        };
        targets.into_iter().zip(methods).map(one).collect()
    }
}

impl<M: Method + ?Sized> Follower<M> {
    /// Creates a follower. It locks on each box of `starts` in the box's frame; if that is missing, in the next frame.
    pub fn new(method: Box<M>, starts: Vec<(usize, Option<Rect>)>) -> Self {
        Self { name: None, method, starts: starts.into_iter().peekable(), is_there: false }
    }

    /// Returns the report of frame `number`; `None` before the first box, and while the target is gone.
    /// Errors: Those of the tracker, with the number of the frame.
    pub fn step(&mut self, number: usize, frame: &GrayFrame) -> Result<Option<MethodAnswer>> {
        let report = match self.starts.next_if(|(at, _)| *at <= number) {
            Some((_, start)) => {
                self.is_there = start.is_some();
                let locked = start.map(|start| lock(self.method.as_mut(), &frame.frame(), start));
                locked.transpose().map(|_| start.map(MethodAnswer::locked))
            }
            None if self.is_there => self.method.update(&frame.frame()).map(Some),
            None => Ok(None),
        };
        report.with_context(|| match &self.name {
            Some(name) => format!("{name}, frame {number}"),
            None => format!("frame {number}"),
        })
    }

    pub fn quality(&self) -> Option<Quality> {
        self.method.quality()
    }

    /// Returns the number of the next frame with an entry in `starts`: a box to lock on, or `None` (target gone).
    pub fn next_start(&mut self) -> Option<usize> {
        self.starts.peek().map(|(frame, _)| *frame)
    }
}

/// Locks `method` on the box `target`; the error is a [`Refused`] if the method refuses the box.
pub fn lock(method: &mut (impl Method + ?Sized), frame: &Frame<'_>, target: Rect) -> Result<()> {
    method.lock(frame, target).map_err(|error| Refused::or(error, method.kind(), target, frame.bounds()))
}

#[derive(Clone, Debug, Default)]
pub struct Run {
    /// A report for each frame from the first lock on, except those in which the target is gone.
    pub reports: Vec<MethodAnswer>,
    /// Frame index of each report, from 0.
    pub frames: Vec<usize>,
    /// Total time of all frames after the first lock: updates, and locks on corrections.
    pub time: Duration,
    /// The most pixels that a lock or an update has read; 0 from baselines.
    pub most_pixels: usize,
}

impl Run {
    /// Passes the frame with index `place` to `follower` and records the report; errors are those of the tracker.
    pub fn add(&mut self, follower: &mut Follower, place: usize, frame: &GrayFrame) -> Result<()> {
        let begin = Instant::now();
        if let Some(report) = follower.step(place + 1, frame)? {
            if !self.reports.is_empty() {
                self.time += begin.elapsed();
            }
            self.reports.push(report);
            self.frames.push(place);
            self.most_pixels = follower.method.most_pixels();
        }
        Ok(())
    }

    /// Returns all reports except the first, which reports the lock.
    pub fn updates(&self) -> &[MethodAnswer] {
        self.reports.get(1..).unwrap_or_default()
    }

    /// Returns for each report: frame index, state, and true if the IoU of its box with `truth` is above `CORRECT`. The
    /// boxes are not normalised.
    pub fn judged<'a>(&'a self, truth: &'a Trajectory) -> impl Iterator<Item = (usize, State, bool)> + Clone + 'a {
        self.frames.iter().zip(&self.reports).map(|(&frame, report)| {
            let right = |(answer, truth): (BoundingBox, BoundingBox)| truth.iou(&answer) > CORRECT;
            (frame, report.state, report.target.zip(truth[frame]).is_some_and(right))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Configs, MethodKind};
    use clap::ValueEnum;
    use smr_core::{UpdateError, paper};
    use smr_recordings::synthetic;

    fn variant(kind: MethodKind) -> Variant {
        Variant::new(kind, &paper::Config::paper().into())
    }

    fn target(name: &str, frames: &[usize]) -> Target {
        let start = |&frame: &usize| (frame, synthetic::truth(frame - 1));
        Target::new(Some(name.to_owned()), frames.iter().map(start).collect())
    }

    fn followed(variant: &Variant, targets: Vec<Target>) -> Vec<Vec<Option<MethodAnswer>>> {
        let mut all = Follower::all(targets, variant).unwrap();
        let frames: Vec<GrayFrame> = synthetic::frames().take(12).collect();
        let of =
            |one: &mut Follower| (1..).zip(&frames).map(|(number, frame)| one.step(number, frame).unwrap()).collect();
        all.iter_mut().map(of).collect()
    }

    #[test]
    fn targets_beside_one_another_do_not_disturb_each_other() {
        for &kind in MethodKind::value_variants() {
            let variant = variant(kind);
            let targets = [target("a", &[1]), target("b", &[4]), target("c", &[1, 8])];
            let together = followed(&variant, targets.to_vec());
            for (alone, together) in targets.into_iter().zip(&together) {
                assert_eq!(&followed(&variant, vec![alone])[0], together, "{}", kind.name());
            }
            assert_eq!(together[1][..3], [None; 3]);
            assert_eq!(together[1][3].unwrap().target, synthetic::truth(3));
            // In the frame of a correction, the answer is the box of the correction.
            assert_eq!(together[2][7], Some(MethodAnswer::locked(synthetic::truth(7).unwrap().to_rect().unwrap())));
            assert_eq!(together[0][..7], together[2][..7]);
            let report = together[0][1].unwrap();
            assert_eq!((report.evidence.is_some(), report.work.is_some()), (kind.is_core(), kind.is_core()));
        }
    }

    #[test]
    fn a_target_that_is_gone_has_no_answers_until_its_next_box() {
        for &kind in MethodKind::value_variants() {
            let mut gone = target("a", &[1, 5, 8]);
            gone.starts[1].1 = None;
            let [whole, gone] = [target("a", &[1, 8]), gone].map(|one| followed(&variant(kind), vec![one]).remove(0));
            assert_eq!(
                (&gone[..4], &gone[4..7], &gone[7..]),
                (&whole[..4], &[None; 3][..], &whole[7..]),
                "{}",
                kind.name()
            );
        }
    }

    #[test]
    fn errors_name_the_target_and_the_frame() {
        let frames: Vec<GrayFrame> = synthetic::frames().take(2).collect();
        for &kind in MethodKind::value_variants() {
            let mut outside = target("car", &[2]);
            outside.boxes_mut().for_each(|bbox| bbox.x = -30.0);
            let mut all = Follower::all(vec![outside, target("man", &[1])], &variant(kind)).unwrap();
            assert_eq!((all[0].step(1, &frames[0]).unwrap(), all[0].next_start()), (None, Some(2)));
            let error = format!("{:#}", all[0].step(2, &frames[1]).unwrap_err());
            assert!(error.starts_with("car, frame 2: the box -30,"), "{error}");
            all[1].step(1, &frames[0]).unwrap();
            let other = GrayFrame { width: 9, height: 9, pixels: vec![0; 81] };
            let error = format!("{:#}", all[1].step(2, &other).unwrap_err());
            assert_eq!(error, format!("man, frame 2: {}", UpdateError::FrameSizeChanged));
        }
    }

    #[test]
    fn steps_change_no_answer_and_no_work_is_left_out() {
        for kind in [MethodKind::Paper, MethodKind::Robust] {
            let reports = |step| {
                let configs = Configs { step, ..paper::Config::camera().into() };
                let mut reports = followed(&Variant::new(kind, &configs), vec![target("a", &[1])]).remove(0);
                reports.iter_mut().flatten().for_each(|report| report.work = None);
                reports
            };
            let whole = reports(u32::MAX);
            assert!([1, 5000].into_iter().all(|step| reports(step) == whole), "{}", kind.name());
        }
    }
}
