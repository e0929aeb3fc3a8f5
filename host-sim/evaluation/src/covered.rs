//! What trackers say while they cannot see: from the middle of a recording on, 300 frames show nothing of the target, and then the recording
//! goes on where it was interrupted.
//!
//! A tracker shall say so: *tracking* in at most `TRACKING` of these frames, *lost* by frame `LOST_BY` of them. And it shall follow the target
//! again within `AGAIN` frames, if it was right in the frame before.

use super::run::{Intervention, MOST_BYTES, Recording};
use super::tables::{Columns, Listed, TableName, Tables};
use super::{Layout, Origin, Variant};
use anyhow::{Context, Result, ensure};
use rayon::prelude::*;
use smr_core::{Rect, State};
use smr_recordings::cover::Cover;
use smr_recordings::{GrayFrame, Sequence};

/// Frames that show nothing of the target.
pub const FRAMES: usize = 300;
/// The most of them that may be called *tracking*.
const TRACKING: usize = 2;
/// The target is to be lost by this one, counted from 1.
const LOST_BY: usize = 30;
/// Frames after them in which the box is to become right.
const AGAIN: usize = 10;

pub const TABLES: &[TableName] = &[TableName::Measured, TableName::Means];

/// What one tracker made of one cover in one recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counts {
    tracker: String,
    cover: &'static str,
    sequence: String,
    /// Whether the box was right in the frame before.
    right_before: bool,
    /// Covered frames that it called *tracking*.
    tracking: usize,
    /// The first that it called *lost*, counted from 1.
    lost_at: Option<usize>,
    /// The first frame after them in which the box was right, counted from 1, of the first ten.
    right_again: Option<usize>,
}

/// A goal: what is said of those that miss it, and whether one does.
type Goal = (&'static str, fn(&Counts) -> bool);

const NOT_TRACKING: Goal = ("tracking in more than 2 frames", |of| of.tracking > TRACKING);
const LOST: Goal = ("not lost by frame 30", |of| of.lost_at.is_none_or(|frame| frame > LOST_BY));
const RIGHT_AGAIN: Goal = ("not right again", |of| of.right_before && of.right_again.is_none());

/// One tracker and one cover, over all recordings.
struct Row {
    tracker: String,
    origin: Origin,
    cover: &'static str,
    recordings: Vec<Counts>,
}

pub struct Results {
    covers: Vec<Row>,
    recordings: Vec<Counts>,
}

/// Runs every variant through every cover in the middle of a recording. `other` is a frame of another scene, of this recording's size.
/// Errors: No ground truth, a frame that cannot be read, frames that are too few, or a method that fails.
pub fn measure(sequence: Sequence, other: &GrayFrame, variants: &[Variant]) -> Result<Vec<Counts>> {
    let start = sequence.start()?;
    let recording = Recording::read(sequence, MOST_BYTES)?;
    let Recording { name, frames, .. } = &recording;
    let count = frames.len();
    ensure!(count >= 4, "{name}: it has {count} frames: expected at least 4, to be covered in the middle");
    let sizes = [&frames[0], other].map(|frame| (frame.width, frame.height));
    ensure!(sizes[0] == sizes[1], "{name}: its frames are of {:?}, the other scene's of {:?}", sizes[0], sizes[1]);
    let cases: Vec<_> = variants.iter().flat_map(|variant| Cover::ALL.map(|cover| (variant, cover))).collect();
    let run = |&(variant, cover): &(&Variant, Cover)| {
        run(&recording, variant, variant.start(start), (cover, other))
            .with_context(|| format!("{name}: {}", variant.name))
    };
    cases.par_iter().map(run).collect()
}

fn run(recording: &Recording, variant: &Variant, start: Rect, (cover, other): (Cover, &GrayFrame)) -> Result<Counts> {
    let middle = recording.frames.len() / 2;
    let end = recording.frames.len().min(middle + AGAIN);
    let run = recording.run(variant, (0, start), end, Intervention::Cover(middle, FRAMES, cover, other), || ())?;
    let mut judged = run.judged(&recording.truth).map(|(_, state, right)| (state, right));
    let right_before = judged.by_ref().take(middle).last().is_some_and(|(_, right)| right);
    let covered: Vec<State> = judged.by_ref().take(FRAMES).map(|(state, _)| state).collect();
    Ok(Counts {
        tracker: variant.name.clone(),
        cover: cover.name(),
        sequence: recording.name.clone(),
        right_before,
        tracking: covered.iter().filter(|&&state| state == State::Tracking).count(),
        lost_at: covered.iter().position(|&state| state == State::Lost).map(|index| index + 1),
        right_again: judged.position(|(_, right)| right).map(|index| index + 1),
    })
}

const MEASURED: &[Listed<Counts>] = &[
    ("tracker", "", |of| of.tracker.as_str().into()),
    ("cover", "", |of| of.cover.into()),
    ("sequence", "", |of| of.sequence.as_str().into()),
    ("right_before", "", |of| of.right_before.into()),
    ("tracking", "", |of| of.tracking.into()),
    ("lost_at", "", |of| of.lost_at.into()),
    ("right_again", "", |of| of.right_again.into()),
];

/// The median is the larger of two middle values.
const COVERS: &[Listed<Row>] = &[
    ("tracker", "tracker", |row| row.tracker.as_str().into()),
    ("cover", "cover", |row| row.cover.into()),
    ("recordings", "recordings", |row| row.recordings.len().into()),
    ("right_before", "right before", |row| row.right_before().into()),
    ("tracking_median", "", |row| row.tracking().0.into()),
    ("tracking_most", "", |row| row.tracking().1.into()),
    ("", "tracking (median, most)", |row| {
        let (median, most) = row.tracking();
        format!("{median}, {most}").into()
    }),
    ("tracking_too_long", "in more than 2 frames", |row| row.missing(NOT_TRACKING).len().into()),
    ("lost_in_time", "", |row| row.lost_in_time().into()),
    ("", "lost by frame 30", |row| format!("{} of {}", row.lost_in_time(), row.recordings.len()).into()),
    ("right_again", "", |row| row.right_again().into()),
    ("", "right again", |row| format!("{} of {}", row.right_again(), row.right_before()).into()),
];

impl Row {
    fn right_before(&self) -> usize {
        self.recordings.iter().filter(|of| of.right_before).count()
    }

    /// In the median of the recordings, and in the worst.
    fn tracking(&self) -> (usize, usize) {
        let mut all: Vec<usize> = self.recordings.iter().map(|of| of.tracking).collect();
        all.sort_unstable();
        (all.get(all.len() / 2).copied().unwrap_or(0), all.last().copied().unwrap_or(0))
    }

    fn lost_in_time(&self) -> usize {
        self.recordings.len() - self.missing(LOST).len()
    }

    fn right_again(&self) -> usize {
        self.right_before() - self.missing(RIGHT_AGAIN).len()
    }

    fn missing(&self, (_, misses): Goal) -> Vec<&str> {
        self.recordings.iter().filter(|of| misses(of)).map(|of| of.sequence.as_str()).collect()
    }

    /// One line for each goal that is missed, with the recordings that miss it.
    fn missed(&self) -> Vec<String> {
        let missed = [NOT_TRACKING, LOST, RIGHT_AGAIN].map(|goal| (goal.0, self.missing(goal)));
        let missed = missed.iter().filter(|(_, which)| !which.is_empty());
        missed
            .map(|(what, which)| format!("- {}, {}, {what}: {}\n", self.tracker, self.cover, which.join(", ")))
            .collect()
    }
}

impl Results {
    /// Of the runs of all recordings: one row for each variant and cover.
    pub fn of(recordings: Vec<Counts>, variants: &[Variant]) -> Self {
        let cases = variants.iter().flat_map(|variant| Cover::ALL.map(|cover| (variant, cover.name())));
        let row = |(variant, cover): (&Variant, &'static str)| {
            let of_case = |of: &&Counts| of.tracker == variant.name && of.cover == cover;
            let recordings = recordings.iter().filter(of_case).cloned().collect();
            Row { tracker: variant.name.clone(), origin: variant.origin(), cover, recordings }
        };
        Self { covers: cases.map(row).collect(), recordings }
    }

    /// What was measured in each recording, and the counts over them, for JSON and CSV.
    pub fn tables(&self) -> Tables {
        let covers = Columns::new(COVERS).and(Origin::columns(), |row| Some(&row.origin));
        Tables(vec![
            Columns::new(MEASURED).table(TableName::Measured, &self.recordings),
            covers.table(TableName::Means, &self.covers),
        ])
    }

    /// The table, and what misses a goal.
    pub fn text(&self, layout: Layout) -> String {
        let missed: String = self.covers.iter().flat_map(Row::missed).collect();
        let table = Columns::new(COVERS).text(&self.covers, layout, 2);
        if missed.is_empty() { table } else { format!("{table}\n{missed}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MethodKind;
    use smr_core::paper::Config;
    use smr_recordings::slow;

    fn variants() -> Vec<Variant> {
        [MethodKind::Smr, MethodKind::Robust].map(|kind| Variant::new(kind, &Config::camera().into())).to_vec()
    }

    fn run(name: &str, right_before: bool, (tracking, lost_at): (usize, Option<usize>), right_again: bool) -> Counts {
        let (tracker, sequence) = ("robust".to_owned(), name.to_owned());
        let right_again = right_again.then_some(10);
        Counts { tracker, cover: "gray", sequence, right_before, tracking, lost_at, right_again }
    }

    #[test]
    fn goals_are_counted_and_named() {
        let runs = vec![
            run("good", true, (2, Some(30)), true),
            run("long", true, (3, Some(1)), false),
            run("late", false, (0, Some(31)), false),
            run("never", false, (300, None), true),
        ];
        let results = Results::of(runs, &variants()[1..]);
        let text = results.text(Layout::Markdown);
        assert!(text.contains("| robust | gray | 4 | 2 | 3, 300 | 2 | 2 of 4 | 1 of 2 |"), "{text}");
        let missed = "- robust, gray, tracking in more than 2 frames: long, never\n- robust, gray, not lost by frame 30: late, never\n\
                      - robust, gray, not right again: long\n";
        assert!(text.ends_with(&format!("\n\n{missed}")), "{text}");
        let csv = results.tables().csv(TableName::Means).unwrap();
        assert_eq!(csv.lines().count(), 1 + Cover::ALL.len());
        assert!(csv.contains("\nrobust,gray,4,2,3,300,2,2,1,robust,"), "{csv}");
        let csv = results.tables().csv(TableName::Measured).unwrap();
        assert!(csv.contains("\nrobust,gray,never,false,300,,10\n"), "{csv}");
    }

    #[test]
    fn a_black_lens_is_never_tracked_and_soon_lost() {
        let robust = &variants()[1];
        for sequence in slow::sequences() {
            let start = robust.start(sequence.start().unwrap());
            let recording = Recording::read(sequence, MOST_BYTES).unwrap();
            let run = super::run(&recording, robust, start, (Cover::Black, &recording.frames[0])).unwrap();
            let is_lost = (1..=LOST_BY).contains(&run.lost_at.unwrap_or(0));
            assert!(run.right_before && run.tracking == 0 && is_lost, "{run:?}");
        }
    }

    #[test]
    fn each_cover_goes_over_the_middle() {
        let other = slow::sequences().remove(4).frames.next().unwrap().unwrap().gray;
        let runs = measure(slow::sequences().remove(2), &other, &variants()).unwrap();
        assert_eq!(runs.len(), variants().len() * Cover::ALL.len());
        for run in runs {
            let is_in = |frame: Option<usize>, last| frame.is_none_or(|frame| (1..=last).contains(&frame));
            let holds = run.right_before && run.tracking <= FRAMES;
            assert!(holds && is_in(run.lost_at, FRAMES) && is_in(run.right_again, AGAIN), "{run:?}");
        }
    }

    #[test]
    fn a_frame_of_another_size_and_a_short_recording_are_refused() {
        let other = GrayFrame { width: 3, height: 2, pixels: vec![0; 6] };
        let error = |sequence| format!("{:#}", measure(sequence, &other, &variants()).unwrap_err());
        assert!(error(slow::sequences().remove(0)).contains("the other scene's of (3, 2)"));
        let mut short = slow::sequences().remove(0);
        short.frames = Box::new(short.frames.take(3));
        short.truth = short.truth.map(|truth| truth[..3].to_vec());
        assert!(error(short).contains("it has 3 frames"));
    }
}
