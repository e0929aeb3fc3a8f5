//! What trackers say while they cannot see: from the middle of a recording on, 300 frames show nothing of the target, and then the recording
//! goes on where it was interrupted.
//!
//! A tracker shall say so: *tracking* in at most `TRACKING` of these frames, *lost* by frame `LOST_BY` of them. And it shall follow the target
//! again within `AGAIN` frames, if it was right in the frame before.

use super::configs::ORIGIN;
use super::layout::header;
use super::robustness::recording::{self, Recording};
use super::tables::{Table, TableName, Tables, columns};
use super::{Layout, Origin, Variant};
use anyhow::{Context, Result, ensure};
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use smr_core::State;
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

/// What one tracker made of one cover in one recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Run {
    pub tracker: String,
    pub cover: &'static str,
    pub sequence: String,
    /// Whether the box was right in the frame before.
    pub right_before: bool,
    /// Covered frames that it called *tracking*.
    pub tracking: usize,
    /// The first that it called *lost*, counted from 1.
    pub lost_at: Option<usize>,
    /// The first frame after them in which the box was right, counted from 1, of the first ten.
    pub right_again: Option<usize>,
}

impl Run {
    const fn tracks_too_long(&self) -> bool {
        self.tracking > TRACKING
    }

    fn is_lost_late(&self) -> bool {
        self.lost_at.is_none_or(|frame| frame > LOST_BY)
    }

    const fn is_not_right_again(&self) -> bool {
        self.right_before && self.right_again.is_none()
    }
}

/// One tracker and one cover, over all recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub tracker: String,
    #[serde(flatten)]
    pub origin: Origin,
    pub cover: &'static str,
    pub recordings: usize,
    /// Recordings in which the box was right in the frame before the cover.
    pub right_before: usize,
    /// Covered frames that were called *tracking*: in the median of the recordings (the larger of two middle values), and in the worst.
    pub tracking_median: usize,
    pub tracking_most: usize,
    /// Recordings in which more than two frames were.
    #[serde(serialize_with = "how_many")]
    pub tracking_too_long: Vec<String>,
    /// Recordings in which it was lost by frame 30 of the cover, and those in which it was not.
    pub lost_in_time: usize,
    #[serde(skip)]
    pub lost_late: Vec<String>,
    /// Recordings in which it was right before, and again within ten frames; and those in which it was right before alone.
    pub right_again: usize,
    #[serde(skip)]
    pub not_right_again: Vec<String>,
}

/// In the tables the names follow from what was measured in each recording.
fn how_many<S: Serializer>(names: &[String], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    names.len().serialize(serializer)
}

/// The tables of what is measured.
pub const TABLES: &[TableName] = &[TableName::Measured, TableName::Means];

/// All that was measured.
#[derive(Clone, Debug)]
pub struct Results {
    pub covers: Vec<Row>,
    pub recordings: Vec<Run>,
}

/// Runs every variant through every cover in the middle of a recording. `other` is a frame of another scene, of this recording's size.
/// Errors: No ground truth, a frame that cannot be read, frames that are too few, or a method that fails.
pub fn measure(sequence: Sequence, other: &GrayFrame, variants: &[Variant]) -> Result<Vec<Run>> {
    let start = sequence.start()?;
    let recording = Recording::read(sequence, recording::MOST_BYTES)?;
    let Recording { name, frames, .. } = &recording;
    ensure!(
        frames.len() >= 4,
        "{name}: it has {} frames: expected at least 4, to be covered in the middle",
        frames.len()
    );
    let sizes = [&frames[0], other].map(|frame| (frame.width, frame.height));
    ensure!(sizes[0] == sizes[1], "{name}: its frames are of {:?}, the other scene's of {:?}", sizes[0], sizes[1]);
    let cases: Vec<_> = variants.iter().flat_map(|variant| Cover::ALL.map(|cover| (variant, cover))).collect();
    let run = |&(variant, cover): &(&Variant, Cover)| {
        run(&recording, variant, variant.start(start), (cover, other))
            .with_context(|| format!("{name}: {}", variant.name))
    };
    cases.par_iter().map(run).collect()
}

fn run(recording: &Recording, variant: &Variant, start: smr_core::Rect, cover: (Cover, &GrayFrame)) -> Result<Run> {
    let Recording { name, frames, .. } = recording;
    let middle = frames.len() / 2;
    let mut watch = recording.watch(variant, 0, start)?;
    let mut right_before = true;
    for (number, frame) in frames.iter().enumerate().take(middle).skip(1) {
        right_before = watch.update(number, frame)?.1;
    }
    let (mut tracking, mut lost_at) = (0, None);
    for index in 0..FRAMES {
        let (state, _) = watch.update(middle, &cover.0.frame(index, cover.1))?;
        tracking += usize::from(state == State::Tracking);
        if state == State::Lost {
            lost_at = lost_at.or(Some(index + 1));
        }
    }
    let mut right_again = None;
    for (number, frame) in frames.iter().enumerate().skip(middle).take(AGAIN) {
        if watch.update(number, frame)?.1 {
            right_again = right_again.or(Some(number + 1 - middle));
        }
    }
    let (tracker, sequence, cover) = (variant.name.clone(), name.clone(), cover.0.name());
    Ok(Run { tracker, cover, sequence, right_before, tracking, lost_at, right_again })
}

impl Results {
    /// Of the runs of all recordings: one row for each variant and cover.
    pub fn of(recordings: Vec<Run>, variants: &[Variant]) -> Self {
        let cases = variants.iter().flat_map(|variant| Cover::ALL.map(|cover| (variant, cover)));
        let row = |(variant, cover): (&Variant, Cover)| {
            let of_case = |run: &&Run| run.tracker == variant.name && run.cover == cover.name();
            Row::of(variant, cover, &recordings.iter().filter(of_case).collect::<Vec<_>>())
        };
        Self { covers: cases.map(row).collect(), recordings }
    }

    /// What was measured in each recording, and the counts over them, for JSON and CSV.
    pub fn tables(&self) -> Result<Tables> {
        let runs = columns("tracker,cover,sequence,right_before,tracking,lost_at,right_again");
        let counts = columns(
            "tracker,cover,recordings,right_before,tracking_median,tracking_most,tracking_too_long,lost_in_time,right_again",
        );
        let counts = [counts, columns(ORIGIN)].concat();
        Ok(Tables(vec![
            Table::new(TableName::Measured, runs, &self.recordings)?,
            Table::new(TableName::Means, counts, &self.covers)?,
        ]))
    }

    /// The table, and what misses a goal.
    pub fn text(&self, layout: Layout) -> String {
        let titles = "tracker|cover|recordings|right before|tracking (median, most)|in more than 2 frames|lost by frame 30|right again";
        let mut lines = vec![header(titles)];
        lines.extend(self.covers.iter().map(Row::line));
        let missed: String = self.covers.iter().flat_map(Row::missed).map(|line| format!("- {line}\n")).collect();
        let table = layout.table(&lines, 2);
        if missed.is_empty() { table } else { format!("{table}\n{missed}") }
    }
}

impl Row {
    fn of(variant: &Variant, cover: Cover, runs: &[&Run]) -> Self {
        let mut tracking: Vec<usize> = runs.iter().map(|run| run.tracking).collect();
        tracking.sort_unstable();
        let which = |fails: fn(&Run) -> bool| -> Vec<String> {
            runs.iter().filter(|run| fails(run)).map(|run| run.sequence.clone()).collect()
        };
        let (lost_late, not_right_again) = (which(Run::is_lost_late), which(Run::is_not_right_again));
        let right_before = runs.iter().filter(|run| run.right_before).count();
        Self {
            tracker: variant.name.clone(),
            origin: variant.origin(),
            cover: cover.name(),
            recordings: runs.len(),
            right_before,
            tracking_median: tracking.get(tracking.len() / 2).copied().unwrap_or(0),
            tracking_most: tracking.last().copied().unwrap_or(0),
            tracking_too_long: which(Run::tracks_too_long),
            lost_in_time: runs.len() - lost_late.len(),
            lost_late,
            right_again: right_before - not_right_again.len(),
            not_right_again,
        }
    }

    fn line(&self) -> Vec<String> {
        vec![
            self.tracker.clone(),
            self.cover.to_owned(),
            self.recordings.to_string(),
            self.right_before.to_string(),
            format!("{}, {}", self.tracking_median, self.tracking_most),
            self.tracking_too_long.len().to_string(),
            format!("{} of {}", self.lost_in_time, self.recordings),
            format!("{} of {}", self.right_again, self.right_before),
        ]
    }

    /// One line for each goal that is missed, with the recordings that miss it.
    fn missed(&self) -> impl Iterator<Item = String> {
        let goals = [
            ("tracking in more than 2 frames", &self.tracking_too_long),
            ("not lost by frame 30", &self.lost_late),
            ("not right again", &self.not_right_again),
        ];
        let line = |(what, which): (&str, &Vec<String>)| {
            format!("{}, {}, {what}: {}", self.tracker, self.cover, which.join(", "))
        };
        goals.into_iter().filter(|(_, which)| !which.is_empty()).map(line).collect::<Vec<_>>().into_iter()
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

    fn run(name: &str, right_before: bool, (tracking, lost_at): (usize, Option<usize>), right_again: bool) -> Run {
        let (tracker, sequence) = ("robust".to_owned(), name.to_owned());
        let right_again = right_again.then_some(10);
        Run { tracker, cover: "gray", sequence, right_before, tracking, lost_at, right_again }
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
        let row = &results.covers[2];
        assert_eq!((row.recordings, row.right_before, row.tracking_median, row.tracking_most), (4, 2, 3, 300));
        assert_eq!((&row.tracking_too_long, row.lost_in_time), (&vec!["long".to_owned(), "never".to_owned()], 2));
        assert_eq!((&row.lost_late, row.right_again), (&vec!["late".to_owned(), "never".to_owned()], 1));
        assert_eq!(row.not_right_again, ["long"]);
        let text = results.text(Layout::Markdown);
        assert!(text.contains("| robust | gray | 4 | 2 | 3, 300 | 2 | 2 of 4 | 1 of 2 |"), "{text}");
        assert!(text.contains("\n- robust, gray, not lost by frame 30: late, never\n"), "{text}");
        let csv = results.tables().unwrap().csv(TableName::Means).unwrap();
        assert_eq!(csv.lines().count(), 1 + Cover::ALL.len());
        assert!(csv.contains("\nrobust,gray,4,2,3,300,2,2,1,robust,"), "{csv}");
    }

    #[test]
    fn it_is_the_same_again_and_goes_over_the_middle() {
        let variants = variants();
        let measured = |variants: &[Variant]| {
            let sequence = slow::sequences().remove(2);
            let other = slow::sequences().remove(4).frames.next().unwrap().unwrap();
            measure(sequence, &other, variants).unwrap()
        };
        let runs = measured(&variants);
        assert!(measured(&variants[1..]).iter().all(|again| runs.contains(again)), "{runs:?}");
        assert_eq!(runs.len(), variants.len() * Cover::ALL.len());
        for run in runs {
            assert!(run.right_before && run.tracking <= FRAMES, "{run:?}");
            assert!(run.lost_at.is_none_or(|frame| (1..=FRAMES).contains(&frame)), "{run:?}");
            assert!(run.right_again.is_none_or(|frame| (1..=AGAIN).contains(&frame)), "{run:?}");
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
