//! Checks that smr-core gives the answers recorded in `vectors/` with whole updates, with updates in steps, and with
//! the target saved and restored between frames. For the paper tracker, the float reference must give them, too.
//! `SMR_RECORD=1 cargo test -p smr-tests conformance` records the answers anew.

use host_sim::check::Check;
use smr_core::paper::{self, Fraction, Radius};
use smr_core::record::{Entry, Recorded, Recorder, Replayed, entries, replay};
use smr_core::robust::Small;
use smr_core::similarity::Table;
use smr_core::{Answer, Frame, Rect, Robust, Tracker, UpdateError, robust};
use smr_recordings::GrayFrame;
use smr_reference::Numbers;
use std::cell::RefCell;
use std::convert::Infallible;
use std::fs;
use std::path::{Path, PathBuf};

type Paper = smr_core::Paper<128, 121>;

/// Similarity table of `scale.smr`: exp(-d / 40) for two pixels that differ by d gray levels.
static STEEP: Table = match Table::new(40) {
    Ok(table) => table,
    Err(_) => panic!("40 is in range"),
};
/// File in `vectors/`, its number of flights, its number of answers.
const OF_PAPER: [(&str, u32, u32); 2] = [("paper.smr", 6, 61), ("scale.smr", 1, 4)];
const OF_ROBUST: [(&str, u32, u32); 2] = [("robust.smr", 13, 85), ("refined.smr", 3, 15)];
const OF_SMALL: (&str, u32, u32) = ("small.smr", 13, 85);

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("vectors").join(name)
}

fn record(name: &str) -> Vec<u8> {
    fs::read(path(name)).expect("it is beside the tests")
}

fn steep() -> paper::Config {
    let mut config = paper::Config::paper();
    config.table = &STEEP;
    config
}

fn small() -> robust::Config {
    robust::Config::robust().within::<Small>()
}

/// Copies the recorded windows into a whole frame; the other pixels are black.
fn whole(frame: &Frame<'_>, parts: &[Rect]) -> GrayFrame {
    let Rect { width, height, .. } = frame.bounds();
    let mut pixels = vec![0; usize::from(width) * usize::from(height)];
    for part in parts {
        let image = frame.patch(*part).expect("it is in the record");
        for (y, row) in (part.y..).zip(image.rows()) {
            let start = usize::try_from(y * i32::from(width) + part.x).expect("inside the frame");
            pixels[start..start + row.len()].copy_from_slice(row);
        }
    }
    GrayFrame { width, height, pixels }
}

fn saved<T: Recorded>(tracker: &Tracker<T>) -> Vec<u8> {
    let mut saved = vec![0; T::SAVED_SIZE];
    let size = tracker.save(&mut saved).expect("there is a target");
    saved.truncate(size);
    saved
}

/// Records smr-core on the frames of the record `old`, with the saved target at the end of each flight.
fn anew<T: Recorded>(old: &[u8], rest: T::Config) -> Vec<u8> {
    let bytes = RefCell::new(Vec::new());
    let write = |piece: &[u8]| {
        bytes.borrow_mut().extend_from_slice(piece);
        Ok::<_, Infallible>(())
    };
    let mut tracker = Box::new(Tracker::<T>::with(rest).expect("a good configuration"));
    let mut recorder = None;
    for found in entries(old) {
        let entry = found.expect("it is whole").entry;
        if let Entry::Begin(begin) = entry {
            let config = begin.config(&rest).expect("it is one of this tracker");
            *tracker = Tracker::with(config).expect("a good configuration");
            recorder = Recorder::begin(tracker.target(), &write).ok();
        }
        let recorder = recorder.as_mut().expect("it begins with a beginning");
        let Ok(()) = match entry {
            Entry::Lock { frame, window, bbox } => {
                let frame = whole(&frame, &[window]);
                tracker.lock(&frame.frame(), bbox).expect("a box in the frame");
                recorder.lock(tracker.target(), &frame.frame(), bbox)
            }
            Entry::Window { frame, window, sweep } => {
                let frame = whole(&frame, &[Some(window), sweep].into_iter().flatten().collect::<Vec<_>>());
                let Ok(()) = recorder.window(tracker.target(), &frame.frame());
                recorder.answer(&tracker.update(&frame.frame()).expect("a whole frame"))
            }
            Entry::Restored(_) => recorder.restored(&saved(&tracker)),
            Entry::Begin(_) | Entry::Answer(_) | Entry::Moved { .. } => Ok(()),
        };
    }
    bytes.into_inner()
}

fn replays<T: Recorded>(
    (name, flights, answers): (&str, u32, u32),
    rest: T::Config,
    update: fn(&mut Tracker<T>, &Frame<'_>) -> Result<Answer, UpdateError>,
) {
    let mut tracker = Box::new(Tracker::<T>::with(rest).expect("a good configuration"));
    let replayed = replay(&record(name), &mut tracker, update).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert_eq!(replayed, Replayed { flights, locks: flights, answers }, "{name}");
}

/// Runs the fastest backend on whole frames. Compares boxes, states, scores and saved targets with the vectors.
#[test]
fn smr_core_answers_as_the_vectors_say() {
    fn is<T: Recorded>(file: (&str, u32, u32), rest: T::Config) {
        let (old, new) = (record(file.0), anew::<T>(&record(file.0), rest));
        if std::env::var_os("SMR_RECORD").is_some() {
            fs::write(path(file.0), &new).expect("it can be written");
        } else if old != new {
            replays::<T>(file, rest, |tracker, frame| tracker.update(frame));
            panic!(
                "{}: every answer is the same, and the target that is saved at the end of a flight is another",
                file.0
            );
        }
    }
    OF_PAPER.into_iter().for_each(|file| is::<Paper>(file, steep()));
    OF_ROBUST.into_iter().for_each(|file| is::<Robust>(file, robust::Config::robust()));
    is::<Robust<Small>>(OF_SMALL, small());
}

#[test]
fn it_does_so_in_steps() {
    fn stepwise<T: Recorded>(tracker: &mut Tracker<T>, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        loop {
            if let Some(answer) = tracker.update_step(frame, 777)? {
                return Ok(answer);
            }
        }
    }
    OF_PAPER.into_iter().for_each(|file| replays::<Paper>(file, steep(), stepwise));
    OF_ROBUST.into_iter().for_each(|file| replays::<Robust>(file, robust::Config::robust(), stepwise));
    replays::<Robust<Small>>(OF_SMALL, small(), stepwise);
}

#[test]
fn it_does_so_saved_and_restored_after_every_frame() {
    fn restored<T: Recorded>(tracker: &mut Tracker<T>, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        let mut other = Tracker::<T>::with(*tracker.config()).expect("its own configuration");
        other.restore(&saved(tracker)).expect("its own bytes");
        *tracker = other;
        tracker.update(frame)
    }
    OF_PAPER.into_iter().for_each(|file| replays::<Paper>(file, steep(), restored));
    OF_ROBUST.into_iter().for_each(|file| replays::<Robust>(file, robust::Config::robust(), restored));
    replays::<Robust<Small>>(OF_SMALL, small(), restored);
}

#[test]
fn the_float_reference_answers_as_the_vectors_of_the_paper_say() {
    for (name, flights, answers) in OF_PAPER {
        let (record, mut config, mut check) = (record(name), steep(), None::<Check<smr_evaluation::Paper>>);
        let mut counts = (0, 0);
        for found in entries(&record) {
            match found.expect("it is whole").entry {
                Entry::Begin(begin) => config = begin.config(&steep()).expect("it is one of this tracker"),
                Entry::Lock { frame, window, bbox } => {
                    let both = (config, numbers(&config));
                    check = Check::lock(name, both, 5000, &whole(&frame, &[window]), bbox).ok();
                    counts.0 += 1;
                }
                Entry::Window { frame, window, .. } => {
                    let check = check.as_mut().expect("it is locked");
                    check.update(&whole(&frame, &[window])).expect("a whole frame");
                    counts.1 += 1;
                }
                Entry::Restored(_) => {
                    let check = check.take().expect("it is locked");
                    assert!(check.holds(), "{name}, flight {}: {:?}", counts.0, check.into_comparison().violation);
                }
                Entry::Answer(_) | Entry::Moved { .. } => {}
            }
        }
        assert_eq!((counts, check.is_none()), ((flights, answers), true), "{name}");
    }
}

fn numbers(config: &paper::Config) -> Numbers {
    let ratio = |ratio: Fraction| (ratio.numerator.into(), ratio.denominator.into());
    let radius = |radius: Radius| (radius.x.into(), radius.y.into());
    let mut numbers = Numbers::paper();
    numbers.scale = if *config.table == STEEP { 40.0 } else { 255.0 };
    numbers.k = ratio(config.k);
    if config.first_threshold != 13 {
        numbers.first_alpha = config.first_threshold.into();
    }
    numbers.padding = config.padding.into();
    numbers.window = radius(config.window);
    numbers.growth = config.growth.into();
    numbers.window_limit = Some(radius(config.window_limit));
    numbers.neighbourhood = config.neighbourhood.into();
    let zone = config.update_zone;
    numbers.zone = (zone.left.into(), zone.top.into(), zone.right.into(), zone.bottom.into());
    numbers.least_alpha = config.least_threshold.into();
    let gate = &mut numbers.gate;
    gate.tracking = ratio(config.gate_tracking);
    gate.border = ratio(config.gate_leaving);
    gate.been_at_border = ratio(config.gate_returning);
    gate.lost = ratio(config.gate_lost);
    gate.lead = config.gate_lead.into();
    gate.least_ratio = config.least_ratio.into();
    numbers.runner_up_always = config.runner_up_always;
    numbers
}
