//! Figures of OTB (Wu, Lim, Yang, *Online Object Tracking: A Benchmark*, CVPR 2013), from one run over a recording.
//!
//! The figures count the frames in which the target is visible, with boxes as they were answered:
//!
//! - success at a threshold: fraction of frames with IoU > threshold; the AUC is its mean at 0, 0.05, ... 1
//! - precision at a distance: fraction of frames whose centres are at most so far apart, quoted at 20 pixels
//!
//! A frame without an answer passes no threshold. IoU is never above 1, so a perfect tracker has an AUC of 20/21.

use super::means::means;
use smr_recordings::{BoundingBox, Trajectory};

/// Number of intervals between thresholds of the success curve, which has one point more.
pub const STEPS: usize = 20;

/// Distance between the centres of answer and truth, in pixels, at which the precision is given as a single figure.
pub const NEAR: usize = 20;

/// Largest distance of the precision curve, in pixels.
pub const FARTHEST: usize = 50;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Otb {
    /// The area under the success curve; 0 if the target is never visible.
    pub otb_auc: f64,
    /// The precision at 20 pixels; 0 if the target is never visible.
    pub otb_precision: f64,
}

impl Otb {
    pub(super) fn new(answers: &Trajectory, truth: &Trajectory) -> Self {
        let counts = Counts::new(answers, truth);
        let passed: u32 = counts.above.iter().sum();
        Self {
            otb_auc: counts.per_frame(passed) / counts.above.len() as f64,
            otb_precision: counts.per_frame(counts.within[NEAR]),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Success at the thresholds 0, 1/20, ... 1.
    pub success: Vec<f64>,
    /// Precision at distances of 0, 1, ... 50 pixels.
    pub precision: Vec<f64>,
}

impl Curves {
    pub fn new(answers: &Trajectory, truth: &Trajectory) -> Self {
        let counts = Counts::new(answers, truth);
        let curve = |of: &[u32]| of.iter().map(|&count| counts.per_frame(count)).collect();
        Self { success: curve(&counts.above), precision: curve(&counts.within) }
    }

    /// Returns the mean curves, with all recordings weighted equally; `None` without recordings.
    pub fn mean(of: &[&Self]) -> Option<Self> {
        let mean = |curve: fn(&Self) -> &Vec<f64>| means(&of.iter().map(|one| curve(one).clone()).collect::<Vec<_>>());
        (!of.is_empty()).then(|| Self { success: mean(|one| &one.success), precision: mean(|one| &one.precision) })
    }

    pub fn auc(&self) -> f64 {
        area(&self.success)
    }

    pub fn precision_area(&self) -> f64 {
        area(&self.precision)
    }
}

fn area(curve: &[f64]) -> f64 {
    curve.iter().sum::<f64>() / curve.len() as f64
}

/// Returns the distance between the centres in each frame, in pixels; `None` where one of the boxes is missing.
pub fn centre_errors(answers: &Trajectory, truth: &Trajectory) -> Vec<Option<f64>> {
    answers.iter().zip(truth).map(|(answer, truth)| Some(centre_error(answer.as_ref()?, truth.as_ref()?))).collect()
}

struct Counts {
    visible: u32,
    above: [u32; STEPS + 1],
    within: [u32; FARTHEST + 1],
}

impl Counts {
    fn new(answers: &Trajectory, truth: &Trajectory) -> Self {
        let mut counts = Self { visible: 0, above: [0; STEPS + 1], within: [0; FARTHEST + 1] };
        for (answer, truth) in answers.iter().zip(truth) {
            let Some(truth) = truth else { continue };
            counts.visible += 1;
            let Some(answer) = answer else { continue };
            let (iou, error) = (answer.iou(truth), centre_error(answer, truth));
            for (step, count) in counts.above.iter_mut().enumerate() {
                *count += u32::from(iou > step as f64 / STEPS as f64);
            }
            for (pixels, count) in counts.within.iter_mut().enumerate() {
                *count += u32::from(error <= pixels as f64);
            }
        }
        counts
    }

    fn per_frame(&self, count: u32) -> f64 {
        if self.visible == 0 { 0.0 } else { f64::from(count) / f64::from(self.visible) }
    }
}

fn centre_error(a: &BoundingBox, b: &BoundingBox) -> f64 {
    let ((x, y), (to_x, to_y)) = (a.centre(), b.centre());
    (to_x - x).hypot(to_y - y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> Option<BoundingBox> {
        Some(BoundingBox { x, y, width: 10.0, height: 10.0 })
    }

    #[test]
    fn thresholds_by_hand() {
        let (near, far) = (at(0.0, 0.0), at(300.0, 0.0));
        let cases: [(&[_], &[_], f64, f64); 11] = [
            // A perfect tracker passes all thresholds but the last. An answer while the target is hidden does not count.
            (&[near, at(5.0, 5.0), None], &[near, at(5.0, 5.0), None], 20.0, 1.0),
            (&[near, at(5.0, 5.0), at(9.0, 9.0)], &[near, at(5.0, 5.0), None], 20.0, 1.0),
            (&[None, None], &[near; 2], 0.0, 0.0),
            (&[near; 2], &[None, None], 0.0, 0.0),
            (&[], &[], 0.0, 0.0),
            (&[near, near, far, None], &[near; 4], 10.0, 0.5),
            // 5 to the right: the IoU is 50 / 150, above the thresholds 0, 0.05, ... 0.30.
            (&[at(5.0, 0.0)], &[near], 7.0, 1.0),
            // 6 to the right: the IoU is 40 / 160, which is not above the threshold 0.25.
            (&[at(6.0, 0.0)], &[near], 5.0, 1.0),
            // Centres 20 pixels apart count as near, farther ones do not; IoU is 0, so no threshold is passed.
            (&[at(12.0, 16.0)], &[near], 0.0, 1.0),
            (&[at(12.0, 16.1)], &[near], 0.0, 0.0),
            (&[far], &[near], 0.0, 0.0),
        ];
        for (answers, truth, passed, otb_precision) in cases {
            let expected = Otb { otb_auc: passed / 21.0, otb_precision };
            assert_eq!(Otb::new(answers, truth), expected, "{answers:?} {truth:?}");
        }
    }

    #[test]
    fn curves_by_hand() {
        let truth = [at(0.0, 0.0), at(0.0, 0.0), at(0.0, 0.0), None];
        let answers = [at(0.0, 0.0), at(3.0, 4.0), None, at(1.0, 1.0)];
        assert_eq!(centre_errors(&answers, &truth), [Some(0.0), Some(5.0), None, None]);
        let curves = Curves::new(&answers, &truth);
        // The IoU of the second frame is 42 / 158.
        assert_eq!([0, 5, 6, 19, 20].map(|step| curves.success[step] * 3.0), [2.0, 2.0, 1.0, 1.0, 0.0]);
        assert_eq!([0, 4, 5, 50].map(|pixels| curves.precision[pixels] * 3.0), [1.0, 1.0, 2.0, 2.0]);
        assert!((curves.precision_area() - (5.0 + 46.0 * 2.0) / 3.0 / 51.0).abs() < 1e-12);
        let otb = Otb::new(&answers, &truth);
        assert!((curves.auc() - otb.otb_auc).abs() < 1e-12 && curves.precision[NEAR] == otb.otb_precision);
        let none = Curves::new(&[None; 4], &truth);
        let mean = Curves::mean(&[&curves, &none]).unwrap();
        assert!((mean.auc() - curves.auc() / 2.0).abs() < 1e-12);
        assert_eq!(Curves::mean(&[]), None);
    }
}
