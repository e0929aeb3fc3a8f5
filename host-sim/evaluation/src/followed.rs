//! One of the targets of a recording on its way through the frames.

use super::Variant;
use super::method::{Method, Report};
use super::run::lock;
use anyhow::{Context, Result, anyhow};
use smr_core::{Quality, Rect};
use smr_recordings::{GrayFrame, Target};

/// A target. The tracker locks on it at its first box, and again at each further one.
pub struct Followed {
    /// `None` if it is the only one, and was given none.
    pub name: Option<String>,
    method: Box<dyn Method>,
    /// The boxes that it is locked on, and the numbers of their frames. The next one is the first.
    starts: std::iter::Peekable<std::vec::IntoIter<(usize, Rect)>>,
    begun: bool,
}

impl Followed {
    /// A target for each of `targets`, all followed by `variant` with one workspace.
    /// Errors: A box has less than one pixel, or the configuration is invalid.
    pub fn all(targets: Vec<Target>, variant: &Variant) -> Result<Vec<Self>> {
        let methods = variant.build_all(targets.len())?;
        targets.into_iter().zip(methods).map(|(target, method)| Self::new(target, method)).collect()
    }

    fn new(Target { name, starts }: Target, method: Box<dyn Method>) -> Result<Self> {
        let pixels = |(frame, bbox): (usize, smr_recordings::BoundingBox)| {
            let rect = bbox.pixels().map_err(|what| anyhow!("the box to start from {what}"))?;
            Ok((frame, rect))
        };
        let starts = starts.into_iter().map(pixels).collect::<Result<Vec<_>>>()?;
        Ok(Self { name, method, starts: starts.into_iter().peekable(), begun: false })
    }

    /// What is known of it in the frame of this number; `None` before its first box.
    /// Errors: The tracker's.
    pub fn step(&mut self, number: usize, frame: &GrayFrame) -> Result<Option<Report>> {
        let report = match self.starts.next_if(|(at, _)| *at == number) {
            Some((_, start)) => {
                self.begun = true;
                lock(self.method.as_mut(), &frame.frame(), start).map(|()| Some(Report::locked(start)))
            }
            None if self.begun => self.method.update(&frame.frame()).map(Some),
            None => Ok(None),
        };
        let named = self.name.as_ref().map_or(String::new(), |name| format!("{name}, "));
        report.with_context(|| format!("{named}frame {number}"))
    }

    /// Of the frame that was locked on last: see [`Method::quality`].
    pub fn quality(&self) -> Option<Quality> {
        self.method.quality()
    }

    /// The frame of the next box, if there is one left.
    pub fn next_start(&mut self) -> Option<usize> {
        self.starts.peek().map(|(frame, _)| *frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Configs, MethodKind};
    use smr_core::paper;
    use smr_recordings::synthetic;

    fn target(name: &str, frames: &[usize]) -> Target {
        let start = |&frame: &usize| (frame, synthetic::truth(frame - 1).unwrap());
        Target { name: Some(name.to_owned()), starts: frames.iter().map(start).collect() }
    }

    fn followed(kind: MethodKind, targets: Vec<Target>) -> Vec<Vec<Option<Report>>> {
        let variant = Variant::new(kind, &Configs::from(paper::Config::paper()));
        let mut all = Followed::all(targets, &variant).unwrap();
        let frames: Vec<GrayFrame> = synthetic::frames().take(12).collect();
        let mut reports = vec![Vec::new(); all.len()];
        for (number, frame) in (1..).zip(&frames) {
            for (target, reports) in all.iter_mut().zip(&mut reports) {
                reports.push(target.step(number, frame).unwrap());
            }
        }
        reports
    }

    /// One workspace or one for each: the answers are the same.
    #[test]
    fn targets_beside_one_another_do_not_disturb_each_other() {
        for kind in [MethodKind::Smr, MethodKind::Robust, MethodKind::Sad] {
            let targets = || [target("a", &[1]), target("b", &[4]), target("c", &[1, 8])];
            let together = followed(kind, targets().to_vec());
            for (alone, together) in targets().into_iter().zip(&together) {
                assert_eq!(&followed(kind, vec![alone])[0], together, "{}", kind.name());
            }
            assert_eq!(together[1][..3], [None; 3]);
            assert_eq!(together[1][3].unwrap().target, synthetic::truth(3));
            assert_eq!(together[2][7], Some(Report::locked(synthetic::truth(7).unwrap().to_rect().unwrap())));
            assert_eq!(together[0][..7], together[2][..7]);
        }
    }

    #[test]
    fn errors_name_the_target_and_the_frame() {
        let mut outside = target("car", &[3]);
        outside.starts[0].1.x = -30.0;
        let variant = Variant::new(MethodKind::Robust, &Configs::from(paper::Config::paper()));
        let mut all = Followed::all(vec![outside], &variant).unwrap();
        let mut frames = synthetic::frames();
        assert_eq!(all[0].step(1, &frames.next().unwrap()).unwrap(), None);
        assert_eq!(all[0].next_start(), Some(3));
        let error = format!("{:#}", all[0].step(3, &frames.next().unwrap()).unwrap_err());
        assert!(error.starts_with("car, frame 3: the box -30,"), "{error}");
    }
}
