//! The score of VOT's long-term challenge: F of a recording at the best confidence threshold. Source: Lukezic et al.,
//! *Now you see me*, 2018.
//!
//! At a threshold, only answers with at least this confidence count, and they are not normalised:
//!
//! - precision: mean IoU of these answers, counted as 0 where the target is hidden
//! - recall: sum of their IoU over the number of frames in which the target is visible
//! - F: 2 precision recall / (precision + recall)
//!
//! The threshold is the reported confidence at which F of the recording is largest. An answer without a confidence, or
//! the box given to the tracker, has confidence 1, so it counts at every threshold.

use smr_recordings::Trajectory;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vot {
    /// F at the best threshold; 0 if no answer overlaps the target.
    pub vot_f: f64,
    pub vot_precision: f64,
    pub vot_recall: f64,
    /// The highest confidence at which F is largest; `None` if the tracker reports no confidence, or if `vot_f` is 0.
    pub vot_threshold: Option<f64>,
}

impl Vot {
    pub(super) fn new(answers: &Trajectory, confidences: &[Option<f64>], truth: &Trajectory) -> Self {
        let visible = truth.iter().flatten().count() as f64;
        let answers = answers.iter().zip(truth).zip(confidences).filter_map(|((answer, truth), confidence)| {
            let answer = answer.as_ref()?;
            Some((confidence.unwrap_or(1.0), truth.as_ref().map_or(0.0, |truth| answer.iou(truth))))
        });
        let mut answers: Vec<(f64, f64)> = answers.collect();
        answers.sort_by(|a, b| b.0.total_cmp(&a.0));

        let mut best = Self::default();
        let (mut answered, mut sum) = (0.0, 0.0);
        for same in answers.chunk_by(|a, b| a.0 == b.0) {
            answered += same.len() as f64;
            sum += same.iter().map(|(_, iou)| iou).sum::<f64>();
            // F = 2PR / (P + R), with P = `sum` / `answered` and R = `sum` / `visible`.
            let f = 2.0 * sum / (answered + visible);
            if f > best.vot_f {
                let (vot_precision, vot_recall) = (sum / answered, sum / visible);
                best = Self { vot_f: f, vot_precision, vot_recall, vot_threshold: Some(same[0].0) };
            }
        }
        let reported = confidences.iter().any(Option::is_some);
        Self { vot_threshold: best.vot_threshold.filter(|_| reported), ..best }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::BoundingBox;

    fn at(x: f64) -> Option<BoundingBox> {
        Some(BoundingBox { x, y: 0.0, width: 10.0, height: 10.0 })
    }

    #[test]
    fn the_best_threshold_is_taken() {
        let (right, wrong) = (at(0.0), at(300.0));
        let truth = [right, at(3.0), None];
        let perfect = Vot { vot_f: 1.0, vot_precision: 1.0, vot_recall: 1.0, vot_threshold: None };
        let half = [right, right, wrong, wrong];
        // If all four answers of `half` count, precision and recall are 1/2. If only its two right answers count
        // (threshold 0.75), precision is 1 and recall stays 1/2.
        let all = Vot { vot_f: 0.5, vot_precision: 0.5, vot_recall: 0.5, vot_threshold: None };
        let without = Vot { vot_f: 2.0 / 3.0, vot_precision: 1.0, vot_recall: 0.5, vot_threshold: Some(0.75) };
        let cases: [(&[_], &[_], &[_], Vot); 7] = [
            (&truth, &[None; 3], &truth, perfect),
            (&truth, &[None, Some(0.2), Some(0.1)], &truth, Vot { vot_threshold: Some(0.2), ..perfect }),
            (&[None, None], &[None, Some(0.0)], &[right; 2], Vot::default()),
            (&[right; 2], &[None, Some(0.9)], &[None, None], Vot::default()),
            (&[], &[], &[], Vot::default()),
            (&half, &[None; 4], &[right; 4], all),
            (&half, &[None, Some(0.75), Some(0.5), Some(0.25)], &[right; 4], without),
        ];
        for (answers, confidences, truth, expected) in cases {
            assert_eq!(Vot::new(answers, confidences, truth), expected, "{answers:?} {confidences:?}");
        }
    }

    #[test]
    fn thresholds_by_hand() {
        let truth = [at(0.0), at(0.0), at(0.0), None];
        let answers = [at(0.0), at(5.0), at(0.0), at(0.0)];
        let confidences = [None, Some(0.5), Some(0.5), Some(0.25)];
        // Threshold 1: one answer of IoU 1, F = 2 / (1 + 3). Threshold 0.5: three answers of IoU 1, 1/3 and 1, F =
        // (14/3) / 6 = 7/9. Threshold 0.25: one more answer, while the target is hidden, F = (14/3) / 7 = 2/3.
        let vot = Vot::new(&answers, &confidences, &truth);
        assert_eq!(vot.vot_threshold, Some(0.5));
        for figure in [vot.vot_f, vot.vot_precision, vot.vot_recall] {
            assert!((figure - 7.0 / 9.0).abs() < 1e-12, "{vot:?}");
        }
    }
}
