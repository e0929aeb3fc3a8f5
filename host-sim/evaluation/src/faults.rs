//! Test of camera faults: counts states during a fault, frames from its end to a right box, and false *tracking*.
//!
//! A fault is inserted at several frames of a recording, in a run each. The tracker is locked on the ground truth
//! `LEAD` frames before the fault, and runs until `WATCHED` frames after it. The same runs without a fault are the
//! control.

use super::matrix::{self, Case, Intervention, Measured, Progress, Protocol, Record, Recording};
use super::table::{Column, Table, TableName, Tables};
use super::{MethodKind, Origin, Run, Variant, name_of};
use anyhow::{Result, ensure};
use serde_json::Value;
use smr_core::{Rect, State};
use smr_recordings::away::Away;
use smr_recordings::fault::Fault;
use smr_recordings::{Sequence, Trajectory};
use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Frames from the lock to the fault.
pub(super) const LEAD: usize = 10;
const WATCHED: usize = 50;
/// Maximum number of runs per tracker, fault and recording; in each run the fault begins at a different frame.
const MAX_PLACES: usize = 8;

/// The default trackers: the two of smr-core.
pub const METHODS: [MethodKind; 2] = [MethodKind::Paper, MethodKind::Robust];

#[derive(Debug)]
struct FaultFigures {
    tracker: String,
    origin: Origin,
    /// The fault; `None` for the same runs without a fault.
    fault: Option<Fault>,
    /// Counts of the runs whose box was right in the frame before the fault.
    runs: Vec<Counts>,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Counts {
    /// Number of frames delivered during the fault in each state of the tracker.
    states: [usize; 4],
    /// Number of frames delivered during the fault for which the ground truth has a box.
    visible: usize,
    /// Frames during the fault in which the box was right.
    right: usize,
    /// First frame after the fault, counted from 1, in which the box was right again; `None` if it never was.
    until_right: Option<usize>,
    /// True if, after the fault, the box was right in the last frame in which the target is visible.
    right_at_the_end: bool,
    /// Number of frames delivered from the start of the fault to the end of the run.
    frames: usize,
    /// Number of `frames` with the state *tracking* although the box was wrong or the target hidden.
    tracking_while_wrong: usize,
}

struct Faults<'a> {
    /// Faults to insert at each chosen frame, one per run; the first, `None`, is the control run without a fault.
    cases: Vec<Option<&'a Fault>>,
    longest: usize,
}

/// Runs every variant without a fault, and through each of `faults`, at several frames of each recording.
pub fn measure(
    paths: &[PathBuf],
    open: impl Fn(&Path) -> Result<Sequence> + Sync,
    variants: &[Variant],
    faults: &[Fault],
    progress: &(dyn Fn(Progress) + Sync),
) -> Measured {
    let faults = Faults::new(faults);
    let (records, failures) = matrix::measure(&faults, paths.len(), |place| open(&paths[place]), variants, progress);
    let rows = faults.rows(&records, variants);
    let origins = rows.iter().map(|row| Some(row.origin.clone()));
    let table = Table::of(TableName::Measured, 3, COLUMNS, &rows).and(Origin::COLUMNS, origins);
    let tables = Ok(Tables { tables: vec![table], ..Tables::default() });
    Measured { tables, failures, notes: Vec::new(), is_empty: records.is_empty() }
}

impl<'f> Faults<'f> {
    fn new(faults: &'f [Fault]) -> Self {
        let longest = faults.iter().map(Fault::frames).max().unwrap_or(0);
        Self { cases: std::iter::once(None).chain(faults.iter().map(Some)).collect(), longest }
    }

    /// Returns the first frame after a fault that begins in frame `place`; with `None`, after the longest fault.
    fn end(&self, place: usize, fault: Option<&Fault>) -> usize {
        place + fault.map_or(self.longest, Fault::frames)
    }

    fn rows(&self, records: &[Record<'_, Option<Counts>>], variants: &[Variant]) -> Vec<FaultFigures> {
        let cases = variants.iter().flat_map(|variant| self.cases.iter().map(move |&fault| (variant, fault.copied())));
        let row = |(variant, fault): (&Variant, Option<Fault>)| {
            let own = records.iter().filter(|record| record.variant.name == variant.name);
            let of_fault = |(case, _): &&(Case, _)| case.intervention.fault() == fault;
            let runs =
                own.flat_map(|record| record.runs.iter().filter(of_fault).filter_map(|(_, counts)| counts.clone()));
            FaultFigures { tracker: variant.name.clone(), origin: variant.origin(), fault, runs: runs.collect() }
        };
        cases.filter(|_| !records.is_empty()).map(row).collect()
    }
}

impl Protocol for Faults<'_> {
    /// `None` if the box was not right in the frame before the fault.
    type Figures = Option<Counts>;
    const IS_COMMON: bool = true;

    fn cases(&self, _: usize, recording: &Recording) -> Result<Vec<Case>> {
        let places = places(recording, self.longest);
        let (name, most) = (&recording.name, self.longest);
        ensure!(!places.is_empty(), "{name}: a fault of {most} frames fits nowhere: expected more frames with a box");
        let cases = self.cases.iter().flat_map(|&fault| {
            places.iter().map(move |&(place, target)| {
                let (frame, end) = (place - LEAD, self.end(place, fault));
                let last = (end + WATCHED).min(recording.frames.len());
                let intervention = fault.map_or(Intervention::None, |&fault| {
                    let start = if fault.is_there_at_the_lock() { frame } else { place };
                    let away = Away::new(&recording.truth, place..end, recording.bounds());
                    Intervention::Fault(start, if fault.is_away() { last } else { end }, fault, away)
                });
                Case { name: String::new(), frame, target, end: last, intervention }
            })
        });
        Ok(cases.collect())
    }

    fn figures(&self, _: &Variant, recording: &Recording, case: &Case, run: &Run) -> Result<Option<Counts>> {
        let place = case.frame + LEAD;
        let truth = truth(recording, case);
        Ok(Counts::of(run, place..self.end(place, case.intervention.fault().as_ref()), &truth))
    }
}

/// Returns the runs with each of `faults`, without those of the control. Errors: They fit nowhere in the recording.
pub(super) fn runs(faults: &[Fault], recording: &Recording) -> Result<Vec<Case>> {
    let mut cases = Faults::new(faults).cases(0, recording)?;
    cases.retain(|case| case.intervention.fault().is_some());
    Ok(cases)
}

/// Returns the boxes of the frames that the tracker gets.
pub(super) fn truth<'a>(recording: &'a Recording, case: &Case) -> Cow<'a, Trajectory> {
    match &case.intervention {
        Intervention::Fault(.., fault, away) if fault.is_away() => away.truth(&recording.truth).into(),
        _ => Cow::Borrowed(&recording.truth),
    }
}

/// Returns the frames where faults begin, with the box for the lock `LEAD` frames earlier. They are spread evenly over
/// all frames that allow the longest fault: the target is visible there, one frame before and, wholly, at the lock.
fn places(recording: &Recording, longest: usize) -> Vec<(usize, Rect)> {
    let visible = |frame: usize| recording.truth.get(frame).is_some_and(Option::is_some);
    let bounds = recording.bounds();
    let start = |frame: usize| {
        let start = recording.truth[frame - LEAD].and_then(|target| target.to_rect());
        start.filter(|&start| visible(frame - 1) && visible(frame) && bounds.contains(start))
    };
    let last = recording.frames.len().saturating_sub(longest + 1);
    let good: Vec<_> = (LEAD..last).filter_map(|frame| Some((frame, start(frame)?))).collect();
    let count = MAX_PLACES.min(good.len());
    (0..count).map(|number| good[(2 * number + 1) * good.len() / (2 * count)]).collect()
}

impl Counts {
    fn answered(&self) -> usize {
        self.states.iter().sum::<usize>() - self.states[State::Lost as usize]
    }

    fn of(run: &Run, fault: Range<usize>, truth: &Trajectory) -> Option<Self> {
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

/// Table columns. Frames until the box was right again: median and maximum over the runs in which it was right again.
const COLUMNS: &[Column<FaultFigures>] = &[
    ("tracker", "tracker", 0, |row| row.tracker.as_str().into()),
    ("fault", "fault", 0, |row| row.fault.map_or("none".to_owned(), |fault| fault.to_string()).into()),
    ("fault_frames", "", 0, |row| row.fault.map_or(0, |fault| fault.frames()).into()),
    ("", "state during it", 0, FaultFigures::states),
    ("runs", "runs", 0, |row| row.runs.len().into()),
    ("tracking", "", 0, |row| row.sum(|run| run.states[0]).into()),
    ("leaving", "", 0, |row| row.sum(|run| run.states[1]).into()),
    ("uncertain", "", 0, |row| row.sum(|run| run.states[2]).into()),
    ("lost", "", 0, |row| row.sum(|run| run.states[3]).into()),
    ("answered", "", 0, |row| row.sum(Counts::answered).into()),
    ("", "answered", 0, |row| percent(row.sum(Counts::answered), row.sum(|run| run.states.iter().sum())).into()),
    ("right", "", 0, |row| row.sum(|run| run.right).into()),
    ("visible", "", 0, |row| row.sum(|run| run.visible).into()),
    ("", "right during it", 0, |row| percent(row.sum(|run| run.right), row.sum(|run| run.visible)).into()),
    ("right_again", "", 0, |row| row.until_right().len().into()),
    ("", "right again", 0, |row| percent(row.until_right().len(), row.runs.len()).into()),
    ("frames_until_right", "", 0, |row| median(&row.until_right()).into()),
    ("most_frames_until_right", "", 0, |row| row.until_right().last().copied().into()),
    ("", "after (median, most)", 0, |row| {
        let all = row.until_right();
        median(&all).zip(all.last()).map(|(median, most)| format!("{median}, {most}")).into()
    }),
    ("right_at_the_end", "", 0, |row| row.sum(|run| run.right_at_the_end.into()).into()),
    ("", "right at the end", 0, |row| percent(row.sum(|run| run.right_at_the_end.into()), row.runs.len()).into()),
    ("tracking_while_wrong", "", 0, |row| row.sum(|run| run.tracking_while_wrong).into()),
    ("frames", "", 0, |row| row.sum(|run| run.frames).into()),
    ("", "tracking while wrong", 0, |row| {
        let (wrong, all) = (row.sum(|run| run.tracking_while_wrong), row.sum(|run| run.frames));
        (all > 0).then(|| format!("{:.1} %", 100.0 * wrong as f64 / all as f64)).into()
    }),
];

fn percent(part: usize, whole: usize) -> Option<String> {
    (100 * part + whole / 2).checked_div(whole).map(|percent| format!("{percent} %"))
}

fn median(sorted: &[usize]) -> Option<usize> {
    sorted.get(sorted.len() / 2).copied()
}

impl FaultFigures {
    fn sum(&self, of: fn(&Counts) -> usize) -> usize {
        self.runs.iter().map(of).sum()
    }

    fn until_right(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.runs.iter().filter_map(|run| run.until_right).collect();
        all.sort_unstable();
        all
    }

    /// Returns the percentage of each state in the frames during the fault.
    fn states(&self) -> Value {
        let of = |state: State| self.runs.iter().map(|run| run.states[state as usize]).sum::<usize>();
        let all = State::ALL.into_iter().map(of).sum();
        let came = State::ALL.into_iter().filter(|&state| of(state) > 0);
        let share = |state| Some(format!("{} {}", name_of(state), percent(of(state), all)?));
        let shares: Vec<String> = came.filter_map(share).collect();
        if shares.is_empty() { "no frame came".into() } else { shares.join(", ").into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::paper::Config;
    use smr_recordings::{BUILT_IN, OpenOptions};

    fn open(name: &Path) -> Result<Sequence> {
        let mut sequence = smr_recordings::open(name, &OpenOptions::default())?;
        // Without ground truth, the start box is the truth of every frame: it may be wrong, but no tracker may panic.
        let still = vec![sequence.init; sequence.length.unwrap()];
        sequence.truth.get_or_insert(still);
        Ok(sequence)
    }

    fn variants() -> [Variant; 2] {
        METHODS.map(|kind| Variant::new(kind, &Config::camera().into()))
    }

    /// Runs every fault. Tests have overflow checks, so that an overflow is found as a panic.
    fn every_fault_on(name: &str) {
        let (list, variants) = ("all".parse().unwrap(), variants());
        let smr_recordings::fault::Faults::List(mut all) = list else { panic!("all are a list") };
        all.push("away:40".parse().unwrap());
        let faults = Faults::new(&all);
        let (records, failures) = matrix::measure(&faults, 1, |_| open(Path::new(name)), &variants, &|_| ());
        let rows = faults.rows(&records, &variants);
        assert_eq!((rows.len(), failures.len()), (2 * 14, 0));
        for row in &rows {
            assert!(name != "synthetic" || !row.runs.is_empty());
            for run in &row.runs {
                let came = run.states.iter().sum::<usize>();
                assert!(run.tracking_while_wrong <= run.frames, "{name}: {row:?}");
                let Some(fault) = row.fault else { continue };
                assert!(came <= fault.frames(), "{name}: {row:?}");
                assert!(!fault.to_string().starts_with("gap") || came == 0, "{name}: {row:?}");
                assert!(!fault.is_away() || came == 40 && run.visible + run.right == 0, "{name}: {row:?}");
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
        let measured = |recordings| {
            measure(&vec!["synthetic".into(); recordings], open, &variants(), &faults, &|_| ()).tables.unwrap()
        };
        let [one, two] = [1, 2].map(measured);
        let columns = |tables: &Tables, wanted: fn(&str) -> bool| -> Vec<Vec<Value>> {
            let columns = tables.columns(TableName::Measured).filter(|(key, _)| wanted(key));
            columns.map(|(_, values)| values.into_iter().cloned().collect()).collect()
        };
        assert_eq!(columns(&one, |_| true).len(), 20);
        for column in columns(&one, |key| !key.starts_with("fault")) {
            let [none, _, gain, robust_none, _, robust_gain] = &column[..] else { panic!("{column:?}") };
            assert_eq!((none, robust_none), (gain, robust_gain), "a gain of 1 changes nothing");
        }
        for (one, two) in columns(&one, |key| key == "runs").iter().zip(columns(&two, |key| key == "runs")) {
            let twice: Vec<_> = one.iter().map(|runs| Value::from(2 * runs.as_u64().unwrap())).collect();
            assert_eq!(two, twice);
        }
        let lost = |key: &str| ["tracking", "leaving", "uncertain", "lost"].contains(&key);
        let black = |row: usize| columns(&one, lost).iter().map(|column| column[row].as_u64().unwrap()).sum::<u64>();
        let runs = columns(&one, |key| key == "runs").concat();
        assert_eq!([black(1), black(4)], [1, 4].map(|row| 3 * runs[row].as_u64().unwrap()));
    }
}
