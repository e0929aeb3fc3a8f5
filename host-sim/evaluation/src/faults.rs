//! What trackers do when the camera fails for a moment: the state during the fault, how soon the box is right again, and how often
//! *tracking* was said and wrong.
//!
//! A fault is put into a recording at several places. Each is a run of its own: the tracker is locked on the ground truth's box
//! `LEAD` frames before the fault, and is watched for `WATCHED` frames after it. Without a fault the same runs are made once more, so
//! that what goes wrong anyway can be told apart.

use super::run::{Intervention, MOST_BYTES, Recording, Run};
use super::tables::{Columns, Listed, TableName, Tables};
use super::{Layout, MethodKind, Origin, Variant, name_of};
use anyhow::{Context, Result};
use rayon::prelude::*;
use serde_json::Value;
use smr_core::State;
use smr_recordings::Sequence;
use smr_recordings::fault::Fault;
use std::ops::Range;

/// Frames between the lock and the fault.
const LEAD: usize = 10;
/// Frames after the fault in which the box may become right again.
const WATCHED: usize = 50;
/// Places in a recording, at most.
const PLACES: usize = 8;

pub const TABLES: &[TableName] = &[TableName::Measured];

/// What is measured if nothing is said: both trackers of smr-core.
pub const METHODS: [MethodKind; 2] = [MethodKind::Smr, MethodKind::Robust];

/// All that was measured: every variant without a fault, then with each of the faults.
#[derive(Debug, Default, PartialEq)]
pub struct Results(Vec<Row>);

/// One tracker and one fault, over all places of all recordings.
#[derive(Debug, PartialEq)]
struct Row {
    tracker: String,
    origin: Origin,
    /// `None` for the same runs without a fault.
    fault: Option<Fault>,
    /// Only those whose box was right in the frame before the fault.
    runs: Vec<Counts>,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Counts {
    /// Frames that came during the fault, by state.
    states: [usize; 4],
    /// Frames that came during the fault with the target visible, and in how many of them the box was right.
    visible: usize,
    right: usize,
    /// Frames after the fault until the box was right again, within those that were watched.
    until_right: Option<usize>,
    /// In the last frame of those in which the target is visible.
    right_at_the_end: bool,
    /// Frames, from the first of the fault to the last that was watched, in which *tracking* was said although the box was wrong or the target
    /// hidden; and all these frames.
    tracking_while_wrong: usize,
    frames: usize,
}

/// Runs every variant without a fault, and through every fault, at every place of a recording.
/// Errors: No ground truth, a frame that cannot be read, or a method that fails.
pub fn measure(sequence: Sequence, variants: &[Variant], faults: &[Fault]) -> Result<Results> {
    let recording = Recording::read(sequence, MOST_BYTES)?;
    let longest = faults.iter().map(Fault::frames).max().unwrap_or(0);
    let places = places(&recording, longest);
    let with_each = || std::iter::once(None).chain(faults.iter().copied().map(Some));
    let cases: Vec<_> = variants.iter().flat_map(|variant| with_each().map(move |fault| (variant, fault))).collect();
    let row = |&(variant, fault): &(&Variant, Option<Fault>)| {
        let run = |&place: &usize| run(&recording, variant, fault.as_ref(), longest, place);
        let runs: Result<Vec<Option<Counts>>> = places.par_iter().map(run).collect();
        let runs = runs.with_context(|| format!("{}: {}", recording.name, variant.name))?;
        let runs = runs.into_iter().flatten().collect();
        Ok(Row { tracker: variant.name.clone(), origin: variant.origin(), fault, runs })
    };
    cases.par_iter().map(row).collect::<Result<_>>().map(Results)
}

/// Where faults begin: evenly over the recording, where the target is visible from the lock to the first frame of the fault, and again at the
/// end of what is watched, or there is nothing to become right.
fn places(recording: &Recording, longest: usize) -> Vec<usize> {
    let visible = |frame: usize| recording.truth.get(frame).is_some_and(Option::is_some);
    let bounds = recording.bounds();
    let fits = |frame: usize| {
        let start = recording.truth[frame - LEAD].and_then(|target| target.to_rect());
        start.is_some_and(|start| bounds.contains(start))
    };
    let last = recording.frames.len().saturating_sub(longest + 1);
    let good: Vec<usize> = (LEAD..last).filter(|&frame| visible(frame - 1) && visible(frame) && fits(frame)).collect();
    let count = PLACES.min(good.len());
    (0..count).map(|number| good[(2 * number + 1) * good.len() / (2 * count)]).collect()
}

/// `None` where the box was not right before the fault.
fn run(
    recording: &Recording,
    variant: &Variant,
    fault: Option<&Fault>,
    longest: usize,
    place: usize,
) -> Result<Option<Counts>> {
    let Recording { frames, truth, .. } = recording;
    let start = place - LEAD;
    let Some(target) = truth[start].and_then(|target| target.to_rect()) else { return Ok(None) };
    // Without a fault as many frames are counted as with the longest.
    let end = place + fault.map_or(longest, Fault::frames);
    let intervention = fault.map_or(Intervention::None, |fault| {
        Intervention::Fault(if fault.is_there_at_the_lock() { start } else { place }, end, fault)
    });
    let watched = (end + WATCHED).min(frames.len());
    let run = recording.run(variant, (start, target), watched, intervention, || ())?;
    Ok(Counts::of(&run, place..end, truth))
}

impl Counts {
    fn of(run: &Run, fault: Range<usize>, truth: &super::Trajectory) -> Option<Self> {
        let mut counts = Self::default();
        for (frame, state, right) in run.judged(truth) {
            if frame < fault.start {
                if frame + 1 == fault.start && !right {
                    return None;
                }
                continue;
            }
            counts.frames += 1;
            counts.tracking_while_wrong += usize::from(state == State::Tracking && !right);
            if frame < fault.end {
                counts.states[state as usize] += 1;
                counts.visible += usize::from(truth[frame].is_some());
                counts.right += usize::from(right && truth[frame].is_some());
                continue;
            }
            if right {
                counts.until_right.get_or_insert(frame + 1 - fault.end);
            }
            if truth[frame].is_some() {
                counts.right_at_the_end = right;
            }
        }
        Some(counts)
    }
}

/// Until the box was right are the frames in the median of the runs in which it was, and in the worst.
const COLUMNS: &[Listed<Row>] = &[
    ("tracker", "tracker", |row| row.tracker.as_str().into()),
    ("fault", "fault", |row| row.fault.map_or("none".to_owned(), |fault| fault.to_string()).into()),
    ("fault_frames", "", |row| row.fault.map_or(0, |fault| fault.frames()).into()),
    ("", "state during it", Row::states),
    ("runs", "runs", |row| row.runs.len().into()),
    ("tracking", "", |row| row.sum(|run| run.states[0]).into()),
    ("leaving", "", |row| row.sum(|run| run.states[1]).into()),
    ("uncertain", "", |row| row.sum(|run| run.states[2]).into()),
    ("lost", "", |row| row.sum(|run| run.states[3]).into()),
    ("right", "", |row| row.sum(|run| run.right).into()),
    ("visible", "", |row| row.sum(|run| run.visible).into()),
    ("", "right during it", |row| percent(row.sum(|run| run.right), row.sum(|run| run.visible)).into()),
    ("right_again", "", |row| row.until_right().len().into()),
    ("", "right again", |row| percent(row.until_right().len(), row.runs.len()).into()),
    ("frames_until_right", "", |row| median(&row.until_right()).into()),
    ("most_frames_until_right", "", |row| row.until_right().last().copied().into()),
    ("", "after (median, most)", |row| {
        let all = row.until_right();
        median(&all).zip(all.last()).map(|(median, most)| format!("{median}, {most}")).into()
    }),
    ("right_at_the_end", "", |row| row.sum(|run| run.right_at_the_end.into()).into()),
    ("", "right at the end", |row| percent(row.sum(|run| run.right_at_the_end.into()), row.runs.len()).into()),
    ("tracking_while_wrong", "", |row| row.sum(|run| run.tracking_while_wrong).into()),
    ("frames", "", |row| row.sum(|run| run.frames).into()),
    ("", "tracking while wrong", |row| {
        let (wrong, all) = (row.sum(|run| run.tracking_while_wrong), row.sum(|run| run.frames));
        (all > 0).then(|| format!("{:.1} %", 100.0 * wrong as f64 / all as f64)).into()
    }),
];

/// `None` of nothing.
fn percent(part: usize, whole: usize) -> Option<String> {
    (100 * part + whole / 2).checked_div(whole).map(|percent| format!("{percent} %"))
}

fn median(sorted: &[usize]) -> Option<usize> {
    sorted.get(sorted.len() / 2).copied()
}

impl Row {
    fn sum(&self, of: fn(&Counts) -> usize) -> usize {
        self.runs.iter().map(of).sum()
    }

    /// Of the runs in which the box was right again, sorted.
    fn until_right(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.runs.iter().filter_map(|run| run.until_right).collect();
        all.sort_unstable();
        all
    }

    /// The share of each state in the frames that came during the fault.
    fn states(&self) -> Value {
        let of = |state: State| self.runs.iter().map(|run| run.states[state as usize]).sum::<usize>();
        let all = State::ALL.into_iter().map(of).sum();
        let came = State::ALL.into_iter().filter(|&state| of(state) > 0);
        let share = |state| Some(format!("{} {}", name_of(state), percent(of(state), all)?));
        let shares: Vec<String> = came.filter_map(share).collect();
        if shares.is_empty() { "no frame came".into() } else { shares.join(", ").into() }
    }
}

impl Results {
    /// Takes in what was measured of another recording, by the same variants with the same faults.
    pub fn add(&mut self, other: Self) {
        if self.0.is_empty() {
            *self = other;
        } else {
            self.0.iter_mut().zip(other.0).for_each(|(row, more)| row.runs.extend(more.runs));
        }
    }

    pub fn tables(&self) -> Tables {
        let columns = Columns::new(COLUMNS).and(Origin::columns(), |row| Some(&row.origin));
        Tables(vec![columns.table(TableName::Measured, &self.0)])
    }

    pub fn text(&self, layout: Layout) -> String {
        Columns::new(COLUMNS).text(&self.0, layout, 3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::paper::Config;
    use smr_recordings::{BUILT_IN, OpenOptions, open};
    use std::path::Path;

    fn measured(name: &str, faults: &[Fault]) -> Results {
        let mut sequence = open(Path::new(name), &OpenOptions::default()).unwrap();
        // Two of the built-in ones have none. What they have here is not right everywhere, but no tracker may panic for it.
        let still = vec![sequence.init; sequence.length.unwrap()];
        sequence.truth.get_or_insert(still);
        measure(sequence, &METHODS.map(|kind| Variant::new(kind, &Config::camera().into())), faults).unwrap()
    }

    /// Also that nothing panics: overflow checks are on in tests.
    fn every_fault_on(name: &str) {
        let Results(rows) = measured(name, &Fault::all());
        assert_eq!(rows.len(), 2 * 13);
        for row in &rows {
            assert!(name != "synthetic" || !row.runs.is_empty());
            for run in &row.runs {
                let came = run.states.iter().sum::<usize>();
                assert!(run.tracking_while_wrong <= run.frames, "{name}: {row:?}");
                let Some(fault) = row.fault else { continue };
                assert!(came <= fault.frames(), "{name}: {row:?}");
                assert!(!fault.to_string().starts_with("gap") || came == 0, "{name}: {row:?}");
            }
        }
    }

    #[test]
    fn every_fault_on_one_built_in_recording() {
        every_fault_on("synthetic");
    }

    #[test]
    #[ignore = "half a minute: .ci/run nightly"]
    fn every_fault_on_the_other_built_in_recordings() {
        BUILT_IN.into_iter().filter(|&name| name != "synthetic").for_each(every_fault_on);
    }

    #[test]
    fn the_same_again_and_no_fault_is_no_fault() {
        let faults = ["black:3", "gain:100"].map(|text| text.parse().unwrap());
        let mut first = measured("synthetic", &faults);
        let again = measured("synthetic", &faults);
        assert_eq!(first, again);
        for of_tracker in first.0.chunks(3) {
            let [none, black, gain] = of_tracker else { panic!("{of_tracker:?}") };
            // A gain of 1 changes nothing.
            assert_eq!(none.runs, gain.runs);
            assert!(black.runs.iter().all(|run| run.states.iter().sum::<usize>() == 3));
        }
        let text = first.text(Layout::Markdown);
        assert!(text.contains("| smr | black:3 |"), "{text}");
        let csv = first.tables().csv(TableName::Measured).unwrap();
        assert_eq!(csv.lines().count(), 1 + 2 * 3);
        assert!(csv.starts_with("tracker,fault,fault_frames,runs,"), "{csv}");
        let runs = first.0[0].runs.len();
        first.add(again);
        assert_eq!(first.0[0].runs.len(), 2 * runs);
    }
}
