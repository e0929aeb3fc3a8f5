//! Accuracy over thresholds: centre errors, and the success and precision plots of the OTB benchmark with their areas.

use crate::evaluate::{Trajectory, overlaps};
use crate::sequence::BoundingBox;
use anyhow::Result;

/// Precision is quoted at this distance.
pub(super) const PRECISION_AT: usize = 20;
/// The largest distance of a precision plot.
pub(super) const FARTHEST: usize = 50;
/// Steps of a success plot from 0 to 1.
pub(super) const STEPS: usize = 20;

/// Parts of the visible frames over thresholds.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Accuracy {
    /// With an IoU above 0, 1/20, ... 1.
    pub success: Vec<f64>,
    /// With a centre error of at most 0, 1, ... 50 pixels.
    pub precision: Vec<f64>,
}

impl Accuracy {
    /// # Errors
    /// The two are not of the same length.
    pub fn new(answers: &Trajectory, truth: &Trajectory) -> Result<Self> {
        let overlaps: Vec<f64> = overlaps(answers, truth)?.into_iter().flatten().collect();
        let errors = centre_errors(answers, truth);
        let errors: Vec<f64> = errors.into_iter().flatten().collect();
        let visible = overlaps.len().max(1) as f64;
        let part = |count: usize| count as f64 / visible;
        let above = |step: usize| overlaps.iter().filter(|&&iou| iou > step as f64 / STEPS as f64).count();
        let within = |pixels: usize| errors.iter().filter(|&&error| error <= pixels as f64).count();
        Ok(Self {
            success: (0..=STEPS).map(|step| part(above(step))).collect(),
            precision: (0..=FARTHEST).map(|pixels| part(within(pixels))).collect(),
        })
    }

    /// The mean over recordings, each counting the same; `None` of none.
    pub fn mean(of: &[Self]) -> Option<Self> {
        let mean = |values: fn(&Self) -> &Vec<f64>, at: usize| {
            of.iter().map(|one| values(one)[at]).sum::<f64>() / of.len() as f64
        };
        (!of.is_empty()).then(|| Self {
            success: (0..=STEPS).map(|at| mean(|one| &one.success, at)).collect(),
            precision: (0..=FARTHEST).map(|at| mean(|one| &one.precision, at)).collect(),
        })
    }

    /// The area under the success plot: the mean over its thresholds.
    pub fn success_area(&self) -> f64 {
        area(&self.success)
    }

    pub fn precision_area(&self) -> f64 {
        area(&self.precision)
    }

    /// At 20 pixels.
    pub fn precision_at_20(&self) -> f64 {
        self.precision[PRECISION_AT]
    }
}

fn area(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The distance in pixels from the centre of each answer to that of the truth; `None` where one of them is missing.
///
/// As in the scores, answers are shifted so that the first centres agree: a tracker may have been started on another box than
/// the annotator drew.
pub(super) fn centre_errors(answers: &Trajectory, truth: &Trajectory) -> Vec<Option<f64>> {
    let centre = |of: &BoundingBox| (of.x + of.width / 2.0, of.y + of.height / 2.0);
    let first = |boxes: &Trajectory| boxes.first().and_then(|first| first.as_ref().map(centre));
    let shift = match (first(answers), first(truth)) {
        (Some(from), Some(to)) => (to.0 - from.0, to.1 - from.1),
        _ => (0.0, 0.0),
    };
    let error = |(answer, truth): (&Option<BoundingBox>, &Option<BoundingBox>)| {
        let (answer, truth) = (centre(answer.as_ref()?), centre(truth.as_ref()?));
        Some((answer.0 + shift.0 - truth.0).hypot(answer.1 + shift.1 - truth.1))
    };
    answers.iter().zip(truth).map(error).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> Option<BoundingBox> {
        Some(BoundingBox { x, y, width: 10.0, height: 10.0 })
    }

    #[test]
    fn by_hand() {
        let truth = [at(0.0, 0.0), at(0.0, 0.0), at(0.0, 0.0), None];
        let answers = [at(0.0, 0.0), at(3.0, 4.0), None, at(1.0, 1.0)];
        assert_eq!(centre_errors(&answers, &truth), [Some(0.0), Some(5.0), None, None]);
        let accuracy = Accuracy::new(&answers, &truth).unwrap();
        // The IoU of the second is 42 of 158.
        assert_eq!([0, 5, 6, 19, 20].map(|step| accuracy.success[step] * 3.0), [2.0, 2.0, 1.0, 1.0, 0.0]);
        assert_eq!([0, 4, 5, 50].map(|pixels| accuracy.precision[pixels] * 3.0), [1.0, 1.0, 2.0, 2.0]);
        assert!((accuracy.success_area() - (6.0 * 2.0 + 14.0) / 3.0 / 21.0).abs() < 1e-12);
        assert!((accuracy.precision_area() - (5.0 + 46.0 * 2.0) / 3.0 / 51.0).abs() < 1e-12);
        let none = Accuracy::new(&[None; 4], &truth).unwrap();
        let mean = Accuracy::mean(&[accuracy.clone(), none]).unwrap();
        assert!((mean.precision_at_20() - accuracy.precision_at_20() / 2.0).abs() < 1e-12);
        assert_eq!(Accuracy::mean(&[]), None);
    }

    #[test]
    fn the_first_centres_agree() {
        let truth = [at(0.0, 0.0), at(10.0, 0.0)];
        assert_eq!(centre_errors(&[at(2.0, 3.0), at(15.0, 3.0)], &truth), [Some(0.0), Some(3.0)]);
    }
}
