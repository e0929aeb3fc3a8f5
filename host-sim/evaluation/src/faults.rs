//! What trackers do when the camera fails for a moment: the state during the fault, how soon the box is right again, and how often
//! *tracking* was said and wrong.
//!
//! A fault is put into a recording at several places. Each is a run of its own: the tracker is locked on the ground truth's box
//! `LEAD` frames before the fault, and is watched for `WATCHED` frames after it. Without a fault the same runs are made once more, so
//! that what goes wrong anyway can be told apart.

use super::configs::ORIGIN;
use super::layout::header;
use super::robustness::recording::{self, Recording};
use super::tables::{Table, TableName, Tables, columns};
use super::{Layout, MethodKind, Origin, Variant, name_of};
use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;
use smr_core::State;
use smr_recordings::Sequence;
use smr_recordings::fault::Fault;

/// Frames between the lock and the fault.
const LEAD: usize = 10;
/// Frames after the fault in which the box may become right again.
const WATCHED: usize = 50;
/// Places in a recording, at most.
const PLACES: usize = 8;

/// One tracker and one fault, over all places of all recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub tracker: String,
    #[serde(flatten)]
    pub origin: Origin,
    /// As on the command line; `none` for the same runs without a fault.
    pub fault: String,
    /// Frames of the recording that it goes over.
    pub fault_frames: usize,
    /// Runs whose box was right in the frame before the fault; only these are counted.
    pub runs: usize,
    /// Frames that came during the fault, by state.
    pub tracking: usize,
    pub leaving: usize,
    pub uncertain: usize,
    pub lost: usize,
    /// Runs in which the box was right again within the frames that were watched.
    pub right_again: usize,
    /// Frames after the fault until then, in the median of those runs, and in the worst.
    pub frames_until_right: Option<usize>,
    pub most_frames_until_right: Option<usize>,
    /// Runs whose box was right in the last frame of those in which the target is visible.
    pub right_at_the_end: usize,
    /// Frames, from the first of the fault to the last that was watched, in which it said *tracking* although the box was wrong
    /// or the target hidden; and all these frames.
    pub tracking_while_wrong: usize,
    pub frames: usize,
}

/// What is counted of one run.
#[derive(Clone, Debug, Default)]
struct Run {
    states: [usize; 4],
    until_right: Option<usize>,
    right_at_the_end: bool,
    tracking_while_wrong: usize,
    frames: usize,
}

/// Every variant without a fault, then with each of the faults.
fn cases<'a>(variants: &'a [Variant], faults: &'a [Fault]) -> impl Iterator<Item = (&'a Variant, Option<&'a Fault>)> {
    variants.iter().flat_map(|variant| {
        let with_each = faults.iter().map(Some);
        std::iter::once(None).chain(with_each).map(move |fault| (variant, fault))
    })
}

/// Runs every variant without a fault, and through every fault, at every place of a recording.
/// Errors: No ground truth, a frame that cannot be read, or a method that fails.
pub fn measure(sequence: Sequence, variants: &[Variant], faults: &[Fault]) -> Result<Measured> {
    let recording = Recording::read(sequence, recording::MOST_BYTES)?;
    let longest = faults.iter().map(Fault::frames).max().unwrap_or(0);
    let places = places(&recording, longest);
    let jobs: Vec<_> =
        cases(variants, faults).flat_map(|case| places.iter().map(move |&place| (case, place))).collect();
    let run = |&((variant, fault), place): &((&Variant, Option<&Fault>), usize)| {
        run(&recording, variant, fault, longest, place).with_context(|| format!("{}: {}", recording.name, variant.name))
    };
    let runs: Result<Vec<_>> = jobs.par_iter().map(run).collect();
    let mut runs = runs?.into_iter();
    let of_case = |_| runs.by_ref().take(places.len()).flatten().collect();
    Ok(Measured(cases(variants, faults).map(of_case).collect()))
}

/// The runs of several recordings, case by case.
#[derive(Default)]
pub struct Measured(Vec<Vec<Run>>);

impl Measured {
    /// Takes in what was measured of another recording.
    pub fn add(&mut self, other: Self) {
        self.0.resize_with(other.0.len(), Vec::new);
        self.0.iter_mut().zip(other.0).for_each(|(runs, more)| runs.extend(more));
    }

    /// One row for each variant and fault; none if nothing was measured.
    pub fn rows(&self, variants: &[Variant], faults: &[Fault]) -> Vec<Row> {
        cases(variants, faults).zip(&self.0).map(|((variant, fault), runs)| Row::of(variant, fault, runs)).collect()
    }
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
) -> Result<Option<Run>> {
    let Recording { frames, truth, .. } = recording;
    let start = place - LEAD;
    let Some(target) = truth[start].and_then(|target| target.to_rect()) else { return Ok(None) };
    let mut watch = recording.watch(variant, start, target)?;
    let mut right = true;
    for (number, frame) in frames.iter().enumerate().take(place).skip(start + 1) {
        right = watch.update(number, frame)?.1;
    }
    if !right {
        return Ok(None);
    }
    let mut run = Run::default();
    // Without a fault as many frames are counted as with the longest.
    let end = place + fault.map_or(longest, Fault::frames);
    for number in place..end {
        let shown = match fault {
            None => Some(frames[number].clone()),
            Some(fault) => {
                let context = (&frames[place - 1], &frames[number - 1]);
                fault.of(number - place, &frames[number], context, place as u64)
            }
        };
        let Some(shown) = shown else { continue };
        let (state, right) = watch.update(number, &shown)?;
        run.states[state as usize] += 1;
        run.count(state, right);
    }
    for number in end..(end + WATCHED).min(frames.len()) {
        let (state, right) = watch.update(number, &frames[number])?;
        run.count(state, right);
        if right && run.until_right.is_none() {
            run.until_right = Some(number + 1 - end);
        }
        if truth[number].is_some() {
            run.right_at_the_end = right;
        }
    }
    Ok(Some(run))
}

impl Run {
    fn count(&mut self, state: State, right: bool) {
        self.frames += 1;
        self.tracking_while_wrong += usize::from(state == State::Tracking && !right);
    }
}

impl Row {
    fn of(variant: &Variant, fault: Option<&Fault>, runs: &[Run]) -> Self {
        let mut until: Vec<usize> = runs.iter().filter_map(|run| run.until_right).collect();
        until.sort_unstable();
        let sum = |of: fn(&Run) -> usize| runs.iter().map(of).sum();
        Self {
            tracker: variant.name.clone(),
            origin: variant.origin(),
            fault: fault.map_or("none".to_owned(), ToString::to_string),
            fault_frames: fault.map_or(0, Fault::frames),
            runs: runs.len(),
            tracking: sum(|run| run.states[0]),
            leaving: sum(|run| run.states[1]),
            uncertain: sum(|run| run.states[2]),
            lost: sum(|run| run.states[3]),
            right_again: until.len(),
            frames_until_right: until.get(until.len() / 2).copied(),
            most_frames_until_right: until.last().copied(),
            right_at_the_end: sum(|run| run.right_at_the_end.into()),
            tracking_while_wrong: sum(|run| run.tracking_while_wrong),
            frames: sum(|run| run.frames),
        }
    }

    const fn states(&self) -> [usize; 4] {
        [self.tracking, self.leaving, self.uncertain, self.lost]
    }
}

/// The tables of what is measured.
pub const TABLES: &[TableName] = &[TableName::Measured];

/// All rows for JSON and CSV.
pub fn tables(rows: &[Row]) -> Result<Tables> {
    let columns = [columns(COLUMNS), columns(ORIGIN)].concat();
    Ok(Tables(vec![Table::new(TableName::Measured, columns, rows)?]))
}

/// All rows as text or Markdown.
pub fn table(rows: &[Row], layout: Layout) -> String {
    let titles =
        "tracker|fault|state during it|runs|right again|after (median, most)|right at the end|tracking while wrong";
    let mut lines = vec![header(titles)];
    lines.extend(rows.iter().map(line));
    layout.table(&lines, 3)
}

fn line(row: &Row) -> Vec<String> {
    let percent = |part: usize, whole: usize| (100 * part + whole / 2).checked_div(whole).unwrap_or(0);
    let all = row.states().iter().sum();
    let share =
        |(state, &count): (State, &usize)| (count > 0).then(|| format!("{} {} %", name_of(state), percent(count, all)));
    let states: Vec<String> = State::ALL.into_iter().zip(&row.states()).filter_map(share).collect();
    let until = row.frames_until_right.zip(row.most_frames_until_right);
    vec![
        row.tracker.clone(),
        row.fault.clone(),
        if states.is_empty() { "no frame came".to_owned() } else { states.join(", ") },
        row.runs.to_string(),
        format!("{} %", percent(row.right_again, row.runs)),
        until.map_or("-".to_owned(), |(median, most)| format!("{median}, {most}")),
        format!("{} %", percent(row.right_at_the_end, row.runs)),
        format!("{:.1} %", 100.0 * row.tracking_while_wrong as f64 / row.frames.max(1) as f64),
    ]
}

const COLUMNS: &str = "tracker,fault,fault_frames,runs,tracking,leaving,uncertain,lost,right_again,frames_until_right,\
                       most_frames_until_right,right_at_the_end,tracking_while_wrong,frames";

/// What is measured if nothing is said: both trackers of smr-core.
pub const METHODS: [MethodKind; 2] = [MethodKind::Smr, MethodKind::Robust];

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::paper::Config;
    use smr_recordings::{BUILT_IN, OpenOptions, open};
    use std::path::Path;

    fn variants() -> Vec<Variant> {
        METHODS.map(|kind| Variant::new(kind, &Config::camera().into())).to_vec()
    }

    fn rows(name: &str, faults: &[Fault]) -> Vec<Row> {
        let mut sequence = open(Path::new(name), &OpenOptions::default()).unwrap();
        // Two of the built-in ones have none. What they have here is not right everywhere, but no tracker may panic for it.
        let still = vec![sequence.init; sequence.length.unwrap()];
        sequence.truth.get_or_insert(still);
        let variants = variants();
        measure(sequence, &variants, faults).unwrap().rows(&variants, faults)
    }

    /// Also that nothing panics: overflow checks are on in tests.
    fn every_fault_on(name: &str) -> Vec<Row> {
        let rows = rows(name, &Fault::all());
        for row in &rows {
            assert!(row.right_again <= row.runs && row.right_at_the_end <= row.runs, "{name}: {row:?}");
            assert!(row.tracking_while_wrong <= row.frames, "{name}: {row:?}");
            let came = row.states().iter().sum::<usize>();
            assert!(row.fault == "none" || came <= row.runs * row.fault_frames, "{name}: {row:?}");
            assert!(!row.fault.starts_with("gap") || came == 0, "{name}: {row:?}");
        }
        rows
    }

    #[test]
    fn every_fault_on_one_built_in_recording() {
        let rows = every_fault_on("synthetic");
        assert_eq!(rows.len(), 2 * 13);
        assert!(rows.iter().all(|row| row.runs > 0));
    }

    #[test]
    #[ignore = "half a minute: .ci/run nightly"]
    fn every_fault_on_the_other_built_in_recordings() {
        BUILT_IN.into_iter().filter(|&name| name != "synthetic").for_each(|name| drop(every_fault_on(name)));
    }

    #[test]
    fn the_same_again_and_no_fault_is_no_fault() {
        let faults = ["black:3", "gain:100"].map(|text| text.parse().unwrap());
        let first = rows("synthetic", &faults);
        assert!(rows("synthetic", &faults[..1]).iter().all(|again| first.contains(again)), "{first:?}");
        let of = |fault: &str, tracker: &str| {
            first.iter().find(|row| row.fault == fault && row.tracker == tracker).cloned().unwrap()
        };
        for tracker in ["smr", "robust"] {
            // A gain of 1 changes nothing.
            let (none, gain) = (of("none", tracker), of("gain:100", tracker));
            assert_eq!(Row { fault: none.fault.clone(), fault_frames: 0, ..gain }, none);
            // In the dark nothing is tracked for long.
            let black = of("black:3", tracker);
            assert_eq!(black.states().iter().sum::<usize>(), 3 * black.runs);
        }
        let table = table(&first, Layout::Markdown);
        assert!(table.contains("| smr | black:3 |"), "{table}");
        let csv = tables(&first).unwrap().csv(TableName::Measured).unwrap();
        assert_eq!(csv.lines().count(), 1 + first.len());
        assert!(csv.starts_with("tracker,fault,fault_frames,runs,"), "{csv}");
    }
}
