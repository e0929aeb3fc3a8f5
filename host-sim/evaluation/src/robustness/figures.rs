//! Aggregates the figures of runs: means of a recording over its starts, and means over recordings.

use crate::table::Column;
use crate::{CORRECT, Run, Score, overlaps};
use anyhow::Result;
use serde_json::Value;
use smr_core::State;
use smr_recordings::Trajectory;
use std::time::Duration;

#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RunFigures {
    pub score: Score,
    /// Counts of the run. Fields that are means stay 0; [`Figures::over_starts`] computes them.
    counts: Figures,
    answered_visible: usize,
    updates: u64,
    /// Sum of `MethodAnswer::work` over all updates; `None` if any update reports `None`.
    work: Option<u64>,
    time: Duration,
}

impl RunFigures {
    /// Computes the figures; `truth` begins with the frame of the lock. An error if run and truth differ in length.
    pub fn new(run: &Run, truth: &Trajectory) -> Result<Self> {
        let answers: Vec<_> = run.reports.iter().map(|report| report.target).collect();
        let (overlaps, score) = (overlaps(&answers, truth)?, Score::new(&answers, truth)?);
        let answered_visible =
            answers.iter().zip(truth).filter(|(answer, truth)| answer.and(**truth).is_some()).count();
        let (returns, found_again) = returns(&overlaps);
        let (hidden, answered_hidden) = (score.frames - score.visible, score.answered - answered_visible);
        let mut counts = Figures { hidden, answered_hidden, returns, found_again, ..Figures::default() };
        for (report, overlap) in run.updates().iter().zip(&overlaps[1..]) {
            let said = report.state == State::Tracking;
            let right = overlap.is_some_and(|overlap| overlap > CORRECT);
            counts.tracking += usize::from(said);
            counts.tracking_wrong += usize::from(said && !right);
            counts.wrong += usize::from(!right);
            counts.right += usize::from(right);
            counts.right_unsaid += usize::from(right && !said);
        }
        let work = run.updates().iter().map(|report| report.work.map(u64::from)).sum();
        let updates = run.updates().len() as u64;
        Ok(Self { score, counts, answered_visible, updates, work, time: run.time })
    }
}

/// Number of frames, from the target's return on, in which one correct answer counts as finding the target again.
const FOUND_AGAIN_FRAMES: usize = 50;

/// Counts the target's returns into view, and those after which it was found again; overlaps are `None` while hidden.
fn returns(overlaps: &[Option<f64>]) -> (usize, usize) {
    let back = (1..overlaps.len()).filter(|&frame| overlaps[frame - 1].is_none() && overlaps[frame].is_some());
    let soon = |frame: usize| &overlaps[frame..overlaps.len().min(frame + FOUND_AGAIN_FRAMES)];
    let found = |frame: &usize| soon(*frame).iter().flatten().any(|&overlap| overlap > CORRECT);
    (back.clone().count(), back.filter(found).count())
}

/// Figures by which trackers are compared: key and title.
pub(super) const HEADLINE: [(&str, &str); 3] =
    [("mean_correct", "correct"), ("mean_correct_50", "correct@0.5"), ("f", "F")];

/// Declares figures, one per line: field, type, mean or sum over recordings, title, digits, optional ratio column.
macro_rules! figures {
    ($($(#[$doc:meta])* $figure:ident: $type:ty = $over:ident, $title:literal $digits:literal
        $(, $ratio:literal $part:ident $whole:ident)?;)*) => {
        /// Figures of a method: on one recording, over all its starts; or over several recordings, as means and sums.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub(crate) struct Figures {
            $($(#[$doc])* pub $figure: $type,)*
        }

        impl Figures {
            pub(super) const COLUMNS: &[Column<Self>] = &[$(
                (stringify!($figure), $title, $digits, |figures| figures.$figure.into()),
                $(("", $ratio, 0, |figures| part(figures.$part, figures.$whole)),)?
            )*];

            pub(super) fn over_recordings(parts: &[Self]) -> Self {
                Self { $($figure: $over(parts.iter().map(|part| part.$figure)),)* }
            }
        }
    };
}

figures! {
    /// Fraction of the visible frames that are correct, mean over the starts.
    mean_correct: f64 = mean, "correct" 3;
    /// Fraction of the visible frames that are correct, in the worst start.
    worst_correct: f64 = mean, "worst" 3;
    /// As `mean_correct`, but a correct frame needs an intersection over union above 0.5.
    mean_correct_50: f64 = mean, "correct@0.5" 3;
    /// Harmonic mean of precision (correct answers over all answers, also while the target is hidden) and recall
    /// (correct over visible frames), mean over the starts.
    f: f64 = mean, "F" 3;
    /// Mean IoU over the frames with an answer and a visible target; 0 without such frames.
    mean_iou: f64 = mean, "mean IoU" 3;
    /// Correct answers over all answers; 0 without answers.
    precision: f64 = mean, "precision" 3;
    /// Frames in which the target is hidden, summed over the starts.
    hidden: usize = sum, "" 0;
    /// Frames with an answer while the target is hidden.
    answered_hidden: usize = sum, "" 0, "answered/hidden" answered_hidden hidden;
    /// Number of times that the target came back after it was hidden, summed over the starts.
    returns: usize = sum, "" 0;
    /// Number of returns with a correct answer in the first 50 frames from the return on, summed over the starts.
    found_again: usize = sum, "" 0, "found/returns" found_again returns;
    tracking: usize = sum, "" 0;
    /// Updates with the state *tracking* in which the target is hidden, or the answer is missing or not correct.
    tracking_wrong: usize = sum, "" 0, "wrong/tracking" tracking_wrong tracking;
    /// Updates, in any state, in which the target is hidden, or the answer is missing or not correct.
    wrong: usize = sum, "" 0, "tracking/wrong" tracking_wrong wrong;
    right: usize = sum, "" 0;
    /// Updates in which the answer is correct but the state is not *tracking*.
    right_unsaid: usize = sum, "" 0, "unsaid/right" right_unsaid right;
    /// Upper bound of the byte comparisons per update; `None` from methods that do not count them.
    work_per_frame: Option<f64> = mean_of_all, "work/frame" 0;
    /// Microseconds per update, measured while other threads may run trackers too. If `eval` is repeated, only this
    /// figure changes.
    microseconds_per_frame: f64 = mean, "us/frame" 0;
}

fn part(part: usize, whole: usize) -> Value {
    (whole > 0).then(|| format!("{part}/{whole}")).into()
}

fn mean(parts: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = parts.len() as f64;
    ratio(parts.sum(), count)
}

fn mean_of_all(parts: impl ExactSizeIterator<Item = Option<f64>>) -> Option<f64> {
    let count = parts.len() as f64;
    parts.sum::<Option<f64>>().map(|sum| ratio(sum, count))
}

fn sum(parts: impl Iterator<Item = usize>) -> usize {
    parts.sum()
}

impl Figures {
    /// Combines the runs of one recording, one run per start. Means over the runs: fractions of the visible frames, and
    /// F (but `worst_correct` is the lowest fraction). Sums: counts. Over all runs together: mean IoU of the frames
    /// with an answer and a visible target, precision of the answers, comparisons and time per update.
    pub(super) fn over_starts(runs: &[RunFigures]) -> Self {
        let mean = |of: fn(&Score) -> f64| ratio(runs.iter().map(|run| of(&run.score)).sum(), runs.len() as f64);
        let sum = |count: fn(&RunFigures) -> usize| runs.iter().map(count).sum::<usize>() as f64;
        // `recall` is never `None`, because recordings without a visible target are not measured.
        let recalls = || runs.iter().filter_map(|run| run.score.recall);
        let iou_sum = runs.iter().filter_map(|run| Some(run.score.mean_iou? * run.score.visible as f64)).sum();
        let updates = runs.iter().map(|run| run.updates).sum::<u64>() as f64;
        let work: Option<u64> = runs.iter().map(|run| run.work).sum();
        let time: Duration = runs.iter().map(|run| run.time).sum();
        Self {
            mean_correct: ratio(recalls().sum(), runs.len() as f64),
            worst_correct: recalls().reduce(f64::min).unwrap_or(0.0),
            mean_correct_50: mean(|score| ratio(score.correct_50 as f64, score.visible as f64)),
            f: mean(|score| score.f.unwrap_or(0.0)),
            mean_iou: ratio(iou_sum, sum(|run| run.answered_visible)),
            precision: ratio(sum(|run| run.score.correct), sum(|run| run.score.answered)),
            work_per_frame: work.map(|work| ratio(work as f64, updates)),
            microseconds_per_frame: ratio(time.as_secs_f64() * 1e6, updates),
            ..Self::over_recordings(&runs.iter().map(|run| run.counts).collect::<Vec<_>>())
        }
    }

    pub(super) fn headline(&self) -> Vec<f64> {
        vec![self.mean_correct, self.mean_correct_50, self.f]
    }
}

fn ratio(part: f64, whole: f64) -> f64 {
    if whole == 0.0 { 0.0 } else { part / whole }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Evidence, MethodAnswer};
    use smr_recordings::BoundingBox;

    fn at(x: f64) -> Option<BoundingBox> {
        Some(BoundingBox { x, y: 0.0, width: 10.0, height: 10.0 })
    }

    fn run(answers: &[Option<BoundingBox>], states: &[State], work: Option<u32>, microseconds: u64) -> Run {
        let states = std::iter::once(&State::Tracking).chain(states);
        let (confidence, ratio, scale) = (0.5, 1.0, 1.0);
        let (runner_up_ratio, alpha, identity) = (None, None, None);
        let found_again = false;
        let evidence = Some(Evidence { confidence, ratio, runner_up_ratio, alpha, identity, scale, found_again });
        let report = |(&target, &state): (&Option<BoundingBox>, &State)| MethodAnswer {
            target,
            bbox: None,
            state,
            evidence,
            work,
        };
        let reports = answers.iter().zip(states).map(report).collect();
        Run { reports, time: Duration::from_micros(microseconds), ..Run::default() }
    }

    /// Two runs in a recording of six frames: one from frame 1, one from frame 2. Frames 5 and 6 hide the target.
    fn runs(work: Option<u32>) -> [RunFigures; 2] {
        use State::{Lost, Tracking, Uncertain};
        let truth = [at(0.0), at(0.0), at(0.0), at(0.0), None, None];
        // Frames: IoU 1, IoU 1/3 (uncertain), IoU 0, no answer, an answer while hidden, no answer while hidden.
        let first = [at(0.0), at(5.0), at(20.0), None, at(0.0), None];
        let first = run(&first, &[Uncertain, Tracking, Lost, Tracking, Lost], Some(200), 30);
        // Frames: IoU 1, no answer, no answer, an answer while hidden, an answer while hidden.
        let second = run(&[at(0.0), None, None, at(0.0), at(3.0)], &[Lost, Lost, Uncertain, Tracking], work, 60);
        [RunFigures::new(&first, &truth).unwrap(), RunFigures::new(&second, &truth[1..]).unwrap()]
    }

    #[test]
    fn over_starts_by_hand() {
        let runs = runs(Some(200));
        let figures = Figures::over_starts(&runs);
        let expected = Figures {
            mean_correct: (2.0 / 4.0 + 1.0 / 3.0) / 2.0,
            worst_correct: 1.0 / 3.0,
            // In each run, only the first frame, that of the lock, has an IoU above 0.5.
            mean_correct_50: (1.0 / 4.0 + 1.0 / 3.0) / 2.0,
            // First start: 2 of 4 answers and 2 of 4 visible frames are correct; second start: 1 of 3 and 1 of 3.
            f: (1.0 / 2.0 + 1.0 / 3.0) / 2.0,
            mean_iou: (1.0 + 1.0 / 3.0 + 0.0 + 1.0) / 4.0,
            precision: 3.0 / 7.0,
            hidden: 4,
            answered_hidden: 3,
            returns: 0,
            found_again: 0,
            tracking: 3,
            tracking_wrong: 3,
            // 11 frames in both runs, minus 2 frames of locks (no updates) and 1 update with a correct answer.
            wrong: 8,
            right: 1,
            right_unsaid: 1,
            work_per_frame: Some(200.0),
            microseconds_per_frame: 10.0,
        };
        assert!((figures.mean_iou - expected.mean_iou).abs() < 1e-12);
        assert_eq!(Figures { mean_iou: expected.mean_iou, ..figures }, expected);
        let uncounted = Figures::over_starts(&self::runs(None));
        assert_eq!(uncounted.work_per_frame, None);
        assert_eq!(Figures::over_recordings(&[uncounted, figures]).work_per_frame, None);
    }

    #[test]
    fn recordings_count_alike() {
        let part = |mean_iou: f64, wrong: usize| {
            let work_per_frame = Some(mean_iou);
            Figures { mean_iou, wrong, work_per_frame, microseconds_per_frame: mean_iou, ..Figures::default() }
        };
        assert_eq!(Figures::over_recordings(&[part(0.25, 10), part(0.75, 2)]), part(0.5, 12));
    }

    #[test]
    fn a_target_is_found_again_within_fifty_frames_of_its_return() {
        let (hidden, wrong, right) = (None, Some(0.1), Some(0.9));
        assert_eq!(returns(&[hidden, right, right]), (1, 1));
        assert_eq!(returns(&[right, hidden, hidden, wrong, hidden, wrong, right]), (2, 2));
        let late = |frames| [vec![right, hidden], vec![wrong; frames], vec![right]].concat();
        assert_eq!((returns(&late(49)), returns(&late(50))), ((1, 1), (1, 0)));
        assert_eq!((returns(&[]), returns(&[right, wrong, hidden])), ((0, 0), (0, 0)));
    }

    #[test]
    fn nothing_divides_by_zero() {
        let silent = RunFigures::new(&run(&[None], &[], Some(0), 0), &[at(0.0)]).unwrap();
        let figures = Figures::over_starts(&[silent]);
        assert_eq!(figures, Figures { work_per_frame: Some(0.0), ..Figures::default() });
    }
}
