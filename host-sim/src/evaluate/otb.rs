//! The figures of OTB: Wu, Lim, Yang, *Online Object Tracking: A Benchmark*, CVPR 2013, one run from the first frame.
//!
//! Over the frames in which the target is visible, on the boxes as they were answered:
//!
//! - success at a threshold: the fraction of frames with IoU > threshold; the AUC is the mean of the success at
//!   0, 0.05, ... 1
//! - precision: the fraction of frames in which the centres of answer and truth are at most 20 pixels apart
//!
//! A frame without an answer is in neither. IoU is never above 1, so a perfect tracker has an AUC of 20/21, as with the
//! benchmark's own code.

use super::protocol::Trajectory;
use crate::sequence::BoundingBox;
use serde::Serialize;

/// Steps between the thresholds of the success curve, which has one point more.
const STEPS: u32 = 20;

/// The largest centre error that counts, in pixels.
const NEAR: f64 = 20.0;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Otb {
    /// The area under the success curve; 0 if the target is never visible.
    pub otb_auc: f64,
    /// The precision at 20 pixels; 0 if the target is never visible.
    pub otb_precision: f64,
}

impl Otb {
    /// Of trajectories of the same length.
    pub(super) fn new(answers: &Trajectory, truth: &Trajectory) -> Self {
        let (mut visible, mut passed, mut near) = (0_u32, 0_u32, 0_u32);
        for (answer, truth) in answers.iter().zip(truth) {
            let Some(truth) = truth else { continue };
            visible += 1;
            let Some(answer) = answer else { continue };
            passed += thresholds_passed(answer.iou(truth));
            near += u32::from(centre_error(answer, truth) <= NEAR);
        }
        let per_frame = |sum: f64| if visible == 0 { 0.0 } else { sum / f64::from(visible) };
        Self { otb_auc: per_frame(f64::from(passed)) / f64::from(STEPS + 1), otb_precision: per_frame(near.into()) }
    }
}

/// Of the thresholds 0, 0.05, ... 1 those that `iou` is above.
fn thresholds_passed(iou: f64) -> u32 {
    (0..=STEPS).map(|step| u32::from(iou > f64::from(step) / f64::from(STEPS))).sum()
}

/// The distance of the two centres, in pixels.
fn centre_error(a: &BoundingBox, b: &BoundingBox) -> f64 {
    let centre = |of: &BoundingBox| (of.x + of.width / 2.0, of.y + of.height / 2.0);
    let ((x, y), (to_x, to_y)) = (centre(a), centre(b));
    (to_x - x).hypot(to_y - y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> Option<BoundingBox> {
        Some(BoundingBox { x, y, width: 10.0, height: 10.0 })
    }

    #[test]
    fn a_perfect_tracker_passes_all_thresholds_but_the_last() {
        let truth = [at(0.0, 0.0), at(5.0, 5.0), None];
        let expected = Otb { otb_auc: 20.0 / 21.0, otb_precision: 1.0 };
        assert_eq!(Otb::new(&truth, &truth), expected);
        // What is answered while the target is hidden does not count.
        assert_eq!(Otb::new(&[truth[0], truth[1], at(9.0, 9.0)], &truth), expected);
    }

    #[test]
    fn nothing_answered_and_nothing_visible_are_zero() {
        assert_eq!(Otb::new(&[None, None], &[at(0.0, 0.0); 2]), Otb::default());
        assert_eq!(Otb::new(&[at(0.0, 0.0); 2], &[None, None]), Otb::default());
        assert_eq!(Otb::new(&[], &[]), Otb::default());
    }

    #[test]
    fn half_right() {
        // Two frames right, one far away, one without an answer.
        let answers = [at(0.0, 0.0), at(0.0, 0.0), at(300.0, 0.0), None];
        let expected = Otb { otb_auc: 10.0 / 21.0, otb_precision: 0.5 };
        assert_eq!(Otb::new(&answers, &[at(0.0, 0.0); 4]), expected);
    }

    #[test]
    fn thresholds_by_hand() {
        // 5 to the right: 50 of 150, above 0, 0.05, ... 0.30.
        assert_eq!(Otb::new(&[at(5.0, 0.0)], &[at(0.0, 0.0)]), Otb { otb_auc: 7.0 / 21.0, otb_precision: 1.0 });
        // 6 to the right: 40 of 160. 0.25 is not above 0.25.
        assert_eq!(thresholds_passed(0.25), 5);
        assert_eq!(Otb::new(&[at(6.0, 0.0)], &[at(0.0, 0.0)]).otb_auc, 5.0 / 21.0);
        // Centres 20 pixels apart are near, and further ones are not; nothing is shared, so no threshold is passed.
        assert_eq!(Otb::new(&[at(12.0, 16.0)], &[at(0.0, 0.0)]), Otb { otb_auc: 0.0, otb_precision: 1.0 });
        assert_eq!(Otb::new(&[at(12.0, 16.1)], &[at(0.0, 0.0)]), Otb::default());
    }
}
