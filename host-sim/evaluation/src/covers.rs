//! Test of a covered lens: 300 frames that show nothing of the target are inserted in the middle of a recording.
//!
//! A tracker should report *tracking* in at most `MAX_TRACKING_FRAMES` covered frames, *lost* by covered frame
//! `LOST_BY`, and a right box within `RECOVERY_FRAMES` frames after the cover, if its box was right before.

use super::matrix::{self, Case, Intervention, Measured, Progress, Protocol, Recording};
use super::robustness::whole;
use super::table::{Column, Table, TableName, Tables};
use super::{Origin, Run, Variant};
use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;
use smr_core::State;
use smr_files::messages::choice_name;
use smr_recordings::cover::Cover;
use smr_recordings::{GrayFrame, OpenOptions, Resize, SLOW, Sequence, slow, synthetic};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const FRAMES: usize = 300;
const MAX_TRACKING_FRAMES: usize = 2;
/// Latest covered frame, counted from 1, in which a tracker's first report of *lost* still meets the goal.
const LOST_BY: usize = 30;
const RECOVERY_FRAMES: usize = 10;

#[derive(Clone, Debug, PartialEq, Eq)]
struct Counts {
    tracker: String,
    cover: Cover,
    sequence: String,
    /// True if the box was right in the frame before the cover.
    right_before: bool,
    tracking: usize,
    /// The first covered frame with the state *lost*, counted from 1.
    lost_at: Option<usize>,
    /// First frame after the cover in which the box was right, from 1 to `RECOVERY_FRAMES`.
    right_again: Option<usize>,
}

/// A goal: the text listed for recordings that miss the goal, and a check that is true if a recording misses it.
type Goal = (&'static str, fn(&Counts) -> bool);

const NOT_TRACKING: Goal = ("tracking in more than 2 frames", |of| of.tracking > MAX_TRACKING_FRAMES);
const LOST: Goal = ("not lost by frame 30", |of| of.lost_at.is_none_or(|frame| frame > LOST_BY));
const RIGHT_AGAIN: Goal = ("not right again", |of| of.right_before && of.right_again.is_none());

struct CoverFigures {
    tracker: String,
    origin: Origin,
    cover: Cover,
    recordings: Vec<Counts>,
}

/// Runs every variant on the recordings at `paths` and on the generated recordings of [`slow`]. Each kind of
/// cover is inserted in the middle of every recording, in a run of its own.
pub fn measure(
    paths: &[PathBuf],
    open: impl Fn(&Path) -> Result<Sequence> + Sync,
    variants: &[Variant],
    progress: &(dyn Fn(Progress) + Sync),
) -> Measured {
    let open = |place: usize| match paths.get(place) {
        Some(path) => open(path),
        None => Ok(slow(place - paths.len())),
    };
    let count = paths.len() + SLOW;
    let (records, failures) = matrix::measure(&Covers { paths }, count, open, variants, progress);
    let is_empty = records.is_empty();
    let counts: Vec<_> = records.into_iter().flat_map(|record| record.runs).map(|(_, counts)| counts).collect();
    Measured { tables: Ok(tables(&counts, variants)), failures, notes: Vec::new(), is_empty }
}

struct Covers<'a> {
    paths: &'a [PathBuf],
}

impl Covers<'_> {
    /// Returns a frame of another recording than the one with index `place`, scaled to `width` x `height`.
    fn other(&self, place: usize, width: u16, height: u16) -> Result<GrayFrame> {
        // Takes the recording half the list further on, because neighbours in the list often show the same scene.
        let path = match self.paths.len() {
            count if count > 1 && place < count => &self.paths[(place + count / 2) % count],
            _ => Path::new(synthetic::NAME),
        };
        let other = smr_recordings::open(path, &OpenOptions::default())?.resized(Resize::To(width, height))?;
        let (name, mut frames) = (other.name, other.frames);
        Ok(frames.next().with_context(|| format!("{name} holds no frame"))??.gray)
    }
}

impl Protocol for Covers<'_> {
    type Figures = Counts;
    const IS_COMMON: bool = true;

    fn cases(&self, place: usize, recording: &Recording) -> Result<Vec<Case>> {
        let (name, frames) = (&recording.name, &recording.frames);
        let count = frames.len();
        ensure!(count >= 4, "{name}: it has {count} frames: expected at least 4, to be covered in the middle");
        let other = Arc::new(self.other(place, frames[0].width, frames[0].height)?);
        let (target, middle) = (whole(&recording.init)?, count / 2);
        let case = |cover| {
            let intervention = Intervention::Cover(middle, FRAMES, cover, Arc::clone(&other));
            Case { name: String::new(), frame: 0, target, end: count.min(middle + RECOVERY_FRAMES), intervention }
        };
        Ok(Cover::value_variants().iter().copied().map(case).collect())
    }

    fn figures(&self, variant: &Variant, recording: &Recording, case: &Case, run: &Run) -> Result<Counts> {
        let Intervention::Cover(middle, count, cover, _) = &case.intervention else { bail!("a case without a cover") };
        let mut judged = run.judged(&recording.truth).map(|(_, state, right)| (state, right));
        let right_before = judged.by_ref().take(*middle).last().is_some_and(|(_, right)| right);
        let covered: Vec<State> = judged.by_ref().take(*count).map(|(state, _)| state).collect();
        Ok(Counts {
            tracker: variant.name.clone(),
            cover: *cover,
            sequence: recording.name.clone(),
            right_before,
            tracking: covered.iter().filter(|&&state| state == State::Tracking).count(),
            lost_at: covered.iter().position(|&state| state == State::Lost).map(|index| index + 1),
            right_again: judged.position(|(_, right)| right).map(|index| index + 1),
        })
    }
}

const MEASURED: &[Column<Counts>] = &[
    ("tracker", "", 0, |of| of.tracker.as_str().into()),
    ("cover", "", 0, |of| choice_name(&of.cover).into()),
    ("sequence", "", 0, |of| of.sequence.as_str().into()),
    ("right_before", "", 0, |of| of.right_before.into()),
    ("tracking", "", 0, |of| of.tracking.into()),
    ("lost_at", "", 0, |of| of.lost_at.into()),
    ("right_again", "", 0, |of| of.right_again.into()),
];

/// Columns of the table of covers. The median of an even number of recordings is the larger of the two middle values.
const COVERS: &[Column<CoverFigures>] = &[
    ("tracker", "tracker", 0, |row| row.tracker.as_str().into()),
    ("cover", "cover", 0, |row| choice_name(&row.cover).into()),
    ("recordings", "recordings", 0, |row| row.recordings.len().into()),
    ("right_before", "right before", 0, |row| row.right_before().into()),
    ("tracking_median", "", 0, |row| row.tracking().0.into()),
    ("tracking_most", "", 0, |row| row.tracking().1.into()),
    ("", "tracking (median, most)", 0, |row| {
        let (median, most) = row.tracking();
        format!("{median}, {most}").into()
    }),
    ("tracking_too_long", "in more than 2 frames", 0, |row| row.missing(NOT_TRACKING).len().into()),
    ("lost_in_time", "", 0, |row| row.lost_in_time().into()),
    ("", "lost by frame 30", 0, |row| format!("{} of {}", row.lost_in_time(), row.recordings.len()).into()),
    ("right_again", "", 0, |row| row.right_again().into()),
    ("", "right again", 0, |row| format!("{} of {}", row.right_again(), row.right_before()).into()),
];

impl CoverFigures {
    fn right_before(&self) -> usize {
        self.recordings.iter().filter(|of| of.right_before).count()
    }

    /// Returns median and maximum, over the recordings, of the frames called *tracking* while the cover hides the
    /// target.
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

    fn missed(&self) -> Vec<String> {
        let missed = [NOT_TRACKING, LOST, RIGHT_AGAIN].map(|goal| (goal.0, self.missing(goal)));
        let missed = missed.iter().filter(|(_, which)| !which.is_empty());
        let start = format!("- {}, {}", self.tracker, choice_name(&self.cover));
        missed.map(|(what, which)| format!("{start}, {what}: {}\n", which.join(", "))).collect()
    }
}

/// Returns a table of all runs, a table with a row per tracker and cover, and for each row, one line per missed `Goal`.
fn tables(counts: &[Counts], variants: &[Variant]) -> Tables {
    let cases = variants.iter().flat_map(|variant| Cover::value_variants().iter().map(move |&cover| (variant, cover)));
    let row = |(variant, cover): (&Variant, Cover)| {
        let of_case = |of: &&Counts| of.tracker == variant.name && of.cover == cover;
        let recordings = counts.iter().filter(of_case).cloned().collect();
        CoverFigures { tracker: variant.name.clone(), origin: variant.origin(), cover, recordings }
    };
    let rows: Vec<CoverFigures> = cases.filter(|_| !counts.is_empty()).map(row).collect();
    let origins = rows.iter().map(|row| Some(row.origin.clone()));
    Tables {
        tables: vec![
            Table::of(TableName::Measured, 0, MEASURED, counts),
            Table::of(TableName::Means, 2, COVERS, &rows).and(Origin::COLUMNS, origins),
        ],
        remarks: rows.iter().flat_map(CoverFigures::missed).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Layout, MethodKind};
    use smr_core::paper::Config;

    fn variants() -> Vec<Variant> {
        [MethodKind::Paper, MethodKind::Robust].map(|kind| Variant::new(kind, &Config::camera().into())).to_vec()
    }

    fn run(name: &str, right_before: bool, (tracking, lost_at): (usize, Option<usize>), right_again: bool) -> Counts {
        let (tracker, sequence) = ("robust".to_owned(), name.to_owned());
        let right_again = right_again.then_some(10);
        Counts { tracker, cover: Cover::Gray, sequence, right_before, tracking, lost_at, right_again }
    }

    #[test]
    fn goals_are_counted_and_named() {
        let runs = vec![
            run("good", true, (2, Some(30)), true),
            run("long", true, (3, Some(1)), false),
            run("late", false, (0, Some(31)), false),
            run("never", false, (300, None), true),
        ];
        let results = tables(&runs, &variants()[1..]);
        let text = results.text(Layout::Markdown);
        assert!(text.contains("| robust | gray | 4 | 2 | 3, 300 | 2 | 2 of 4 | 1 of 2 |"), "{text}");
        let missed = "- robust, gray, tracking in more than 2 frames: long, never\n- robust, gray, not lost by frame 30: late, never\n\
                      - robust, gray, not right again: long\n";
        assert!(text.ends_with(&format!("\n\n{missed}")), "{text}");
        let csv = results.csv(TableName::Means).unwrap();
        assert_eq!(csv.lines().count(), 1 + Cover::value_variants().len());
        assert!(csv.contains("\nrobust,gray,4,2,3,300,2,2,1,robust,"), "{csv}");
        let csv = results.csv(TableName::Measured).unwrap();
        assert!(csv.contains("\nrobust,gray,never,false,300,,10\n"), "{csv}");
    }

    /// Covers the first `count` slow recordings.
    fn every_cover(variants: &[Variant], count: usize) {
        let open = |number| Ok(slow(number));
        let (records, failures) = matrix::measure(&Covers { paths: &[] }, count, open, variants, &|_| ());
        assert_eq!((records.len(), failures.len()), (count, 0));
        let runs: Vec<_> = records.into_iter().flat_map(|record| record.runs).collect();
        assert_eq!(runs.len(), count * Cover::value_variants().len());
        for (_, run) in runs {
            let is_in = |frame: Option<usize>, last| frame.is_none_or(|frame| (1..=last).contains(&frame));
            let holds = run.right_before && run.tracking <= FRAMES;
            assert!(holds && is_in(run.lost_at, FRAMES) && is_in(run.right_again, RECOVERY_FRAMES), "{run:?}");
            if run.tracker == "robust" && run.cover == Cover::Black {
                assert!(run.tracking == 0 && run.lost_at.is_some_and(|frame| frame <= LOST_BY), "{run:?}");
            }
        }
    }

    #[test]
    fn each_cover_goes_over_the_middle_and_a_black_lens_is_soon_lost() {
        let variants = variants();
        every_cover(&variants[..1], 1);
        every_cover(&variants[1..], 1);
    }

    #[test]
    #[ignore = "most of a minute: .ci/run nightly"]
    fn a_black_lens_is_soon_lost_in_every_slow_recording() {
        every_cover(&variants()[1..], SLOW);
    }

    #[test]
    fn a_short_recording_is_refused() {
        let mut short = slow(0);
        short.frames = Box::new(short.frames.take(3));
        short.truth = short.truth.map(|truth| truth[..3].to_vec());
        let recording = Recording::read(short, u64::MAX).unwrap();
        let error = Covers { paths: &[] }.cases(0, &recording).unwrap_err();
        assert_eq!(error.to_string(), "dark: it has 3 frames: expected at least 4, to be covered in the middle");
    }
}
