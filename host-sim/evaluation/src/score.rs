//! Scores a tracker on a recording by the protocol of the TLD recordings: counts correct frames, and computes figures.

use super::MethodAnswer;
use super::otb::Otb;
use super::vot::Vot;
use anyhow::{Result, ensure};
use serde::{Serialize, Serializer};
use serde_json::Value;
use smr_recordings::{BoundingBox, Trajectory};

/// Intersection over union of answer and truth above which a frame is correct.
pub const CORRECT: f64 = 0.25;

const CORRECT_50: f64 = 0.5;

/// Figures of a tracker on a recording. If the target is never visible, only the counts are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    pub frames: usize,
    /// Frames in which the target is visible, that is, has ground truth.
    pub visible: usize,
    pub answered: usize,
    pub correct: usize,
    /// Frames with an IoU above 0.5.
    pub correct_50: usize,
    /// `correct / answered`; 0 if nothing was answered.
    pub precision: Option<f64>,
    /// `correct / visible`
    pub recall: Option<f64>,
    pub f: Option<f64>,
    /// Mean IoU over the visible frames, in which a missing answer has IoU 0.
    pub mean_iou: Option<f64>,
    /// Number, from 1, of the first visible frame that is not correct.
    pub first_failure: Option<usize>,
    /// OTB figures; `None` in a total, because OTB has means over recordings instead.
    pub otb: Option<Otb>,
    /// VOT figures; `None` in a total, and from `Score::new`, which gets no confidences.
    pub vot: Option<Vot>,
}

impl Serialize for Score {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(Self::FIGURES.iter().map(|figure| (figure.key, figure.value(self))))
    }
}

/// The description of a figure, for tables, means and the page of `report`.
pub struct Figure {
    /// Key in JSON and CSV.
    pub key: &'static str,
    /// Heading in tables; empty if the figure has no column in tables.
    pub title: &'static str,
    /// Heading on the page of `report`; empty if the figure has no column on the page.
    pub page: &'static str,
    pub digits: usize,
    pub has_mean: bool,
    pub is_ranked: bool,
    pub of: Of,
}

impl Figure {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // what has no digits is a count
    pub(super) fn value(&self, of: &Score) -> Value {
        (self.of)(of).map_or(Value::Null, |value| if self.digits == 0 { (value as u64).into() } else { value.into() })
    }
}

type Of = fn(&Score) -> Option<f64>;

const fn count(key: &'static str, title: &'static str, page: &'static str, of: Of) -> Figure {
    Figure { key, title, page, digits: 0, has_mean: false, is_ranked: false, of }
}

const fn correct(key: &'static str, title: &'static str, page: &'static str, of: Of) -> Figure {
    Figure { is_ranked: true, ..count(key, title, page, of) }
}

const fn fraction(key: &'static str, title: &'static str, page: &'static str, of: Of) -> Figure {
    Figure { key, title, page, digits: 3, has_mean: true, is_ranked: true, of }
}

const fn without_mean(key: &'static str, title: &'static str, of: Of) -> Figure {
    Figure { has_mean: false, ..fraction(key, title, "", of) }
}

impl Score {
    /// All figures in the order of JSON: to add one, add a field, compute it, and give it a line here.
    pub const FIGURES: &[Figure] = &[
        count("frames", "frames", "", |score| Some(score.frames as f64)),
        count("visible", "visible", "", |score| Some(score.visible as f64)),
        count("answered", "answered", "answered", |score| Some(score.answered as f64)),
        correct("correct", "correct", "correct", |score| Some(score.correct as f64)),
        correct("correct_50", "correct@0.5", "correct at 0.5", |score| Some(score.correct_50 as f64)),
        fraction("precision", "precision", "correct / answered", |score| score.precision),
        fraction("recall", "recall", "correct / visible", |score| score.recall),
        fraction("f", "F", "F", |score| score.f),
        fraction("mean_iou", "mean IoU", "mean IoU", |score| score.mean_iou),
        count("first_failure", "first failure", "first failure", |score| Some(score.first_failure? as f64)),
        fraction("otb_auc", "OTB AUC", "OTB AUC", |score| Some(score.otb?.otb_auc)),
        fraction("otb_precision", "OTB P20", "OTB P20", |score| Some(score.otb?.otb_precision)),
        fraction("vot_f", "VOT F", "", |score| Some(score.vot?.vot_f)),
        without_mean("vot_precision", "", |score| Some(score.vot?.vot_precision)),
        without_mean("vot_recall", "", |score| Some(score.vot?.vot_recall)),
        without_mean("vot_threshold", "threshold", |score| score.vot?.vot_threshold),
    ];

    /// Scores the reports of a tracker, one for each frame; an error if `truth` has another length.
    pub fn of(reports: &[MethodAnswer], truth: &Trajectory) -> Result<Self> {
        let answers: Vec<_> = reports.iter().map(|report| report.target).collect();
        let confidences: Vec<_> = reports.iter().map(MethodAnswer::confidence).collect();
        Self::with_confidence(&answers, &confidences, truth)
    }

    /// Scores `answers` by `truth`, and adds VOT's figures, which need `confidences`; an error if the lengths differ.
    pub fn with_confidence(answers: &Trajectory, confidences: &[Option<f64>], truth: &Trajectory) -> Result<Self> {
        let (frames, count) = (answers.len(), confidences.len());
        ensure!(frames == count, "there are {frames} frames, but {count} confidences");
        let score = Self::new(answers, truth)?;
        Ok(Self { vot: (score.visible > 0).then(|| Vot::new(answers, confidences, truth)), ..score })
    }

    /// Scores `answers` by `truth`, without VOT's figures; an error if the lengths differ. OTB's figures take the
    /// answers as they are, all others take them normalised.
    pub fn new(answers: &Trajectory, truth: &Trajectory) -> Result<Self> {
        let overlaps = overlaps(answers, truth)?;
        let mut score = Self { frames: truth.len(), answered: answers.iter().flatten().count(), ..Self::default() };
        let mut iou_sum = 0.0;
        for (frame, iou) in (1..).zip(overlaps) {
            let Some(iou) = iou else { continue };
            iou_sum += iou;
            score.visible += 1;
            score.correct_50 += usize::from(iou > CORRECT_50);
            if iou > CORRECT {
                score.correct += 1;
            } else {
                score.first_failure.get_or_insert(frame);
            }
        }
        score.otb = (score.visible > 0).then(|| Otb::new(answers, truth));
        Ok(score.with_means(iou_sum))
    }

    /// Adds up `parts`, except those in which the target is never visible. Figures without a total are `None`.
    pub fn total<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut total = Self::default();
        let mut iou_sum = 0.0;
        for part in parts.into_iter().filter(|part| part.visible > 0) {
            total.frames += part.frames;
            total.visible += part.visible;
            total.answered += part.answered;
            total.correct += part.correct;
            total.correct_50 += part.correct_50;
            iou_sum += part.mean_iou.unwrap_or(0.0) * part.visible as f64;
        }
        total.with_means(iou_sum)
    }

    fn with_means(self, iou_sum: f64) -> Self {
        let per = |part: f64, whole: usize| (self.visible > 0).then_some(part / whole.max(1) as f64);
        let correct = self.correct as f64;
        Self {
            precision: per(correct, self.answered),
            recall: per(correct, self.visible),
            // 2PR / (P + R), but computed from the counts, because P = R = 0 would give 0 / 0.
            f: per(2.0 * correct, self.answered + self.visible),
            mean_iou: per(iou_sum, self.visible),
            ..self
        }
    }
}

/// Returns the IoU of each frame, with normalised answers: 0 without an answer, `None` without a visible target.
/// Errors: The arguments differ in length.
pub fn overlaps(answers: &Trajectory, truth: &Trajectory) -> Result<Vec<Option<f64>>> {
    let (frames, boxes) = (answers.len(), truth.len());
    ensure!(frames == boxes, "there are {frames} frames, but the ground truth has {boxes} boxes");
    let iou = |answer: Option<BoundingBox>, truth| answer.map_or(0.0, |answer| answer.iou(truth));
    let pairs = normalised(answers, truth).zip(truth);
    Ok(pairs.map(|(answer, truth)| truth.as_ref().map(|truth| iou(answer, truth))).collect())
}

/// Shifts and scales all answers so that the first one equals the first box of the truth, because a tracker may have
/// been started on a tighter or looser box. If either first box is missing or has no size, answers stay as they are.
fn normalised(answers: &Trajectory, truth: &Trajectory) -> impl Iterator<Item = Option<BoundingBox>> {
    let first = first_box(answers).zip(first_box(truth));
    answers.iter().map(move |answer| match first {
        Some((from, to)) => answer.map(|answer| moved(answer, from, to)),
        None => *answer,
    })
}

fn first_box(boxes: &Trajectory) -> Option<BoundingBox> {
    boxes.first().copied().flatten().filter(|first| first.width > 0.0 && first.height > 0.0)
}

fn moved(answer: BoundingBox, from: BoundingBox, to: BoundingBox) -> BoundingBox {
    let (width, height) = (answer.width * (to.width / from.width), answer.height * (to.height / from.height));
    let ((x, y), (from_x, from_y), (to_x, to_y)) = (answer.centre(), from.centre(), to.centre());
    BoundingBox { x: x + (to_x - from_x) - width / 2.0, y: y + (to_y - from_y) - height / 2.0, width, height }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(x: f64, y: f64, width: f64, height: f64) -> Option<BoundingBox> {
        Some(BoundingBox { x, y, width, height })
    }

    #[test]
    fn counts_and_means_by_hand() {
        let shown = at(0.0, 0.0, 10.0, 10.0);
        let truth = [shown, shown, shown, shown, None, None];
        let answers = [
            shown,                    // 1
            at(5.0, 0.0, 10.0, 10.0), // 50 of 150: correct, but not at 0.5
            at(0.0, 6.0, 10.0, 10.0), // 40 of 160: exactly 0.25 is not more than 0.25
            None,                     // 0
            shown,                    // the target is not visible
            None,
        ];
        let expected = Score {
            frames: 6,
            visible: 4,
            answered: 4,
            correct: 2,
            correct_50: 1,
            precision: Some(0.5),
            recall: Some(0.5),
            f: Some(0.5),
            mean_iou: Some((1.0 + 1.0 / 3.0 + 0.25) / 4.0),
            first_failure: Some(3),
            // The IoUs of the first three frames exceed 20, 7 and 5 of the 21 thresholds; their centre errors are at
            // most 20 pixels. The fourth frame has no answer.
            otb: Some(Otb { otb_auc: 32.0 / 4.0 / 21.0, otb_precision: 0.75 }),
            vot: None,
        };
        assert_eq!(Score::new(&answers, &truth).unwrap(), expected);
        let vot = Some(Vot::new(&answers, &[None; 6], &truth));
        assert_eq!(Score::with_confidence(&answers, &[None; 6], &truth).unwrap(), Score { vot, ..expected });
    }

    #[test]
    fn the_first_boxes_are_made_equal() {
        // Normalisation halves widths and doubles heights; the first answer's centre moves from (12, 4.5) to (5, 5).
        let truth = [at(0.0, 0.0, 10.0, 10.0), at(10.0, 0.0, 10.0, 10.0), at(0.0, 0.0, 10.0, 10.0)];
        let answers = [at(2.0, 2.0, 20.0, 5.0), at(12.0, 2.0, 20.0, 5.0), at(2.0, 2.0, 40.0, 5.0)];
        let normalised: Vec<_> = normalised(&answers, &truth).collect();
        assert_eq!(normalised, [truth[0], truth[1], at(5.0, 0.0, 20.0, 10.0)]);
    }

    #[test]
    fn without_a_first_box_answers_stay_as_they_are() {
        let one = at(3.0, 4.0, 10.0, 10.0);
        for first in [None, at(0.0, 0.0, 0.0, 5.0)] {
            assert!(normalised(&[first, one], &[one, one]).eq([first, one]));
            assert!(normalised(&[one, one], &[first, one]).eq([one, one]));
        }
    }

    #[test]
    fn nothing_answered_is_zero_and_nothing_visible_is_unknown() {
        let one = at(0.0, 0.0, 1.0, 1.0);
        let silent = Score::with_confidence(&[None, None], &[None, None], &[one, one]).unwrap();
        assert_eq!([silent.precision, silent.recall, silent.f, silent.mean_iou], [Some(0.0); 4]);
        assert_eq!(silent.first_failure, Some(1));
        let unseen = Score::with_confidence(&[one, one], &[None, None], &[None, None]).unwrap();
        let value = serde_json::to_value(unseen).unwrap();
        for figure in Score::FIGURES {
            let is_count = ["frames", "visible", "answered", "correct", "correct_50"].contains(&figure.key);
            assert_eq!(value[figure.key].is_null(), !is_count, "{}", figure.key);
        }
        let both = Score::total([&silent, &unseen]);
        assert_eq!((both.frames, both.visible, both.recall), (2, 2, Some(0.0)));
    }

    #[test]
    fn lengths_that_differ_are_both_named() {
        let error = Score::new(&[None, None], &[None; 3]).unwrap_err();
        assert_eq!(error.to_string(), "there are 2 frames, but the ground truth has 3 boxes");
        let error = Score::with_confidence(&[None; 3], &[None; 2], &[None; 3]).unwrap_err();
        assert_eq!(error.to_string(), "there are 3 frames, but 2 confidences");
    }

    fn any_box() -> impl Strategy<Value = Option<BoundingBox>> {
        (0..60_i32, 0..60_i32, 1..40_i32, 1..40_i32)
            .prop_map(|(x, y, width, height)| at(x.into(), y.into(), width.into(), height.into()))
    }

    /// Answers and truth of the same length; both begin with a box.
    fn trajectories() -> impl Strategy<Value = (Vec<Option<BoundingBox>>, Vec<Option<BoundingBox>>)> {
        let entry = || prop_oneof![4 => any_box(), 1 => Just(None)];
        let rest = proptest::collection::vec((entry(), entry()), 0..12);
        ((any_box(), any_box()), rest).prop_map(|(first, rest)| std::iter::once(first).chain(rest).unzip())
    }

    proptest! {
        #[test]
        fn counts_and_means_are_bounded((answers, truth) in trajectories()) {
            let score = Score::new(&answers, &truth).unwrap();
            prop_assert!(score.correct_50 <= score.correct);
            prop_assert!(score.correct <= score.visible.min(score.answered));
            prop_assert!(score.visible.max(score.answered) <= score.frames);
            let (otb, vot) = (score.otb.unwrap(), Vot::new(&answers, &vec![None; answers.len()], &truth));
            let [precision, recall, f, mean_iou] =
                [score.precision, score.recall, score.f, score.mean_iou].map(Option::unwrap);
            for ratio in [precision, recall, f, otb.otb_precision, vot.vot_f, vot.vot_recall] {
                prop_assert!((0.0..=1.0 + 1e-12).contains(&ratio));
            }
            prop_assert!((0.0..=20.0 / 21.0 + 1e-12).contains(&otb.otb_auc));
            prop_assert!((0.0..=1.0 + 1e-12).contains(&mean_iou));
            prop_assert!(f <= precision.max(recall) && f >= precision.min(recall));
            prop_assert_eq!(score.first_failure.is_none(), score.correct == score.visible);
            // Normalisation makes the first boxes equal, so the first frame cannot fail.
            prop_assert!(score.first_failure != Some(1));
        }

        #[test]
        fn the_truth_itself_is_perfect((truth, _) in trajectories()) {
            let score = Score::new(&truth, &truth).unwrap();
            prop_assert_eq!((score.correct_50, score.answered), (score.visible, score.visible));
            prop_assert_eq!([score.precision, score.recall, score.f], [Some(1.0); 3]);
            prop_assert!((score.mean_iou.unwrap() - 1.0).abs() < 1e-12);
        }

        /// All numbers are exact in f64, so the scores are equal to the bit.
        #[test]
        fn where_and_how_large_a_tracker_starts_does_not_matter(
            (answers, truth) in trajectories(),
            (dx, dy) in (-50..50_i32, -50..50_i32),
            (wider, higher) in (-2..3_i32, -2..3_i32),
        ) {
            let (wider, higher) = (2_f64.powi(wider), 2_f64.powi(higher));
            let other = |of: &BoundingBox| {
                let (width, height) = (of.width * wider, of.height * higher);
                let x = of.x + f64::from(dx) + (of.width - width) / 2.0;
                let y = of.y + f64::from(dy) + (of.height - height) / 2.0;
                BoundingBox { x, y, width, height }
            };
            let others: Vec<_> = answers.iter().map(|answer| answer.as_ref().map(other)).collect();
            // OTB's figures depend on the boxes before normalisation.
            let tld = |answers: &[_]| Score { otb: None, ..Score::new(answers, &truth).unwrap() };
            prop_assert_eq!(tld(&others), tld(&answers));
        }

        #[test]
        fn a_total_adds_up((a, b) in (trajectories(), trajectories())) {
            let parts = [Score::new(&a.0, &a.1).unwrap(), Score::new(&b.0, &b.1).unwrap()];
            let total = Score::total(&parts);
            prop_assert_eq!(total.frames, a.0.len() + b.0.len());
            prop_assert_eq!(total.correct, parts[0].correct + parts[1].correct);
            prop_assert_eq!(total.recall, Some(total.correct as f64 / total.visible as f64));
            prop_assert!((0.0..=1.0 + 1e-12).contains(&total.mean_iou.unwrap()));
            prop_assert_eq!(Score::total(&parts[..1]).f, parts[0].f);
        }
    }
}
