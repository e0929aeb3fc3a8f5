//! Driver of all measurements: runs each tracker through every case (a start, an end, maybe a fault) of each recording.
//! A [`Protocol`] lists the cases of a recording and computes the figures of a run.

use super::{Follower, Run, Tables, Variant};
use anyhow::{Context, Error, Result, anyhow, ensure};
use rayon::prelude::*;
use smr_core::Rect;
use smr_files::signals;
use smr_recordings::away::Away;
use smr_recordings::cover::Cover;
use smr_recordings::fault::Fault;
use smr_recordings::{BoundingBox, GrayFrame, Sequence, misfit};
use std::borrow::Cow;
use std::sync::Arc;

/// Memory limit for the frames of one recording: 1 GiB, some 14000 frames of 320x240 pixels. Once the frames of all
/// recordings in memory add up to this size, these recordings are measured before more are read.
const MAX_BYTES: u64 = 1 << 30;
const MIB: u64 = 1 << 20;

pub struct Measured {
    pub tables: Result<Tables>,
    /// Errors of runs and recordings; always empty if a signal has requested a stop.
    pub failures: Vec<Error>,
    pub notes: Vec<String>,
    pub is_empty: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Announces further frames and recordings to measure.
    Expected {
        frames: u64,
        recordings: usize,
    },
    Done,
}

pub(super) trait Protocol: Sync {
    type Figures: Send;

    /// True if a recording counts only if every tracker was measured on it.
    const IS_COMMON: bool;

    /// Returns the cases to run with each tracker on the recording with index `place`.
    fn cases(&self, place: usize, recording: &Recording) -> Result<Vec<Case>>;

    fn figures(&self, variant: &Variant, recording: &Recording, case: &Case, run: &Run) -> Result<Self::Figures>;
}

/// A run that every tracker makes on a recording. Frames count from 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Case {
    /// Name of the start in JSON and in errors; may be empty.
    pub name: String,
    /// Frame in which the tracker locks on `target`.
    pub frame: usize,
    pub target: Rect,
    /// The run ends before this frame.
    pub end: usize,
    pub intervention: Intervention,
}

/// A change of the frames on their way from the recording to the tracker.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Intervention {
    None,
    /// A camera fault. The fields are its first frame, the frame after its last, the fault, and data for fault `away`.
    Fault(usize, usize, Fault, Away),
    /// A covered lens: inserts covered frames before a frame of the recording. The fields are the number of this frame,
    /// the number of covered frames, the cover, and a frame of another scene.
    Cover(usize, usize, Cover, Arc<GrayFrame>),
}

impl Intervention {
    pub const fn fault(&self) -> Option<Fault> {
        if let Self::Fault(.., fault, _) = *self { Some(fault) } else { None }
    }

    /// Returns the frames that the tracker gets in place of frame `place`.
    fn shown<'a>(&'a self, frames: &'a [GrayFrame], place: usize) -> Box<dyn Iterator<Item = Cow<'a, GrayFrame>> + 'a> {
        let own = std::iter::once(Cow::Borrowed(&frames[place]));
        match *self {
            Self::Fault(at, end, fault, ref away) if (at..end).contains(&place) => {
                let before = (&frames[at.saturating_sub(1)], &frames[place.saturating_sub(1)]);
                Box::new(fault.of(place - at, &frames[place], before, at as u64, away).map(Cow::Owned).into_iter())
            }
            Self::Cover(at, count, cover, ref other) if at == place => {
                Box::new((0..count).map(move |index| Cow::Owned(cover.frame(index, other))).chain(own))
            }
            _ => Box::new(own),
        }
    }
}

pub(super) struct Record<'a, F> {
    pub place: usize,
    pub sequence: String,
    pub variant: &'a Variant,
    pub runs: Vec<(Case, F)>,
}

struct Held {
    place: usize,
    recording: Recording,
    cases: Vec<Case>,
}

/// Runs every variant through all cases of `count` recordings; `open` opens a recording by index.
///
/// Recordings, variants and cases run in parallel. Records are sorted by recording, then in the order of `variants`. If
/// a case fails, its variant has no record of the recording. After a signal only complete records are returned.
pub(super) fn measure<'a, P: Protocol>(
    protocol: &P,
    count: usize,
    open: impl Fn(usize) -> Result<Sequence> + Sync,
    variants: &'a [Variant],
    progress: &(dyn Fn(Progress) + Sync),
) -> (Vec<Record<'a, P::Figures>>, Vec<Error>) {
    let read = |&place: &usize| {
        let recording = Recording::read(open(place)?, MAX_BYTES)?;
        Ok(Held { place, cases: protocol.cases(place, &recording)?, recording })
    };
    let record = |&(held, variant): &(&Held, &'a Variant)| {
        let name = &held.recording.name;
        let run = |case: &Case| {
            let run = held.recording.run(variant, case, || progress(Progress::Done));
            let figures = run.and_then(|run| protocol.figures(variant, &held.recording, case, &run));
            let start = if case.name.is_empty() { String::new() } else { format!(": start {}", case.name) };
            Ok((case.clone(), figures.with_context(|| format!("{name}: {}{start}", variant.name))?))
        };
        // Each thread takes one run at a time, because runs differ in length.
        let runs: Vec<Result<_>> = held.cases.par_iter().with_max_len(1).map(run).collect();
        let runs = runs.into_iter().collect::<Result<_>>()?;
        Ok(Record { place: held.place, sequence: name.clone(), variant, runs })
    };

    let (mut records, mut failures, mut all_held) = (Vec::new(), Vec::new(), Vec::new());
    let places: Vec<usize> = (0..count).collect();
    let mut parts = places.chunks(rayon::current_num_threads()).peekable();
    while let Some(part) = parts.next()
        && !signals::is_stopped()
    {
        separate(part.par_iter().map(read).collect(), &mut all_held, &mut failures);
        let bytes: u64 = all_held.iter().map(|held| held.recording.bytes()).sum();
        if bytes < MAX_BYTES && parts.peek().is_some() {
            continue;
        }
        let pairs: Vec<_> =
            all_held.iter().flat_map(|held| variants.iter().map(move |variant| (held, variant))).collect();
        let frames = pairs.iter().flat_map(|(held, _)| &held.cases).map(|case| (case.end - case.frame) as u64).sum();
        progress(Progress::Expected { frames, recordings: all_held.len() });
        let mut done = pairs.par_iter().with_max_len(1).map(record).collect::<Vec<_>>().into_iter();
        for _ in &all_held {
            let of_one: Vec<_> = done.by_ref().take(variants.len()).collect();
            if !P::IS_COMMON || of_one.iter().all(Result::is_ok) {
                separate(of_one, &mut records, &mut failures);
            } else {
                failures.extend(of_one.into_iter().find_map(Result::err));
            }
        }
        all_held.clear();
    }
    if signals::is_stopped() {
        failures.clear();
    }
    (records, failures)
}

fn separate<T>(results: Vec<Result<T>>, good: &mut Vec<T>, failures: &mut Vec<Error>) {
    results.into_iter().for_each(|result| match result {
        Ok(one) => good.push(one),
        Err(error) => failures.push(error),
    });
}

/// A recording with all its frames in memory, so that it is decoded once for many runs.
pub(super) struct Recording {
    pub name: String,
    /// One frame for each entry of `truth`; at least one.
    pub frames: Vec<GrayFrame>,
    pub init: BoundingBox,
    pub truth: Vec<Option<BoundingBox>>,
}

impl Recording {
    /// Reads all frames. Errors: No start box; no ground truth; a target that is never visible; more or fewer boxes in
    /// the ground truth than frames; a frame that cannot be read; more than `most_bytes` of frames.
    pub fn read(sequence: Sequence, most_bytes: u64) -> Result<Self> {
        let start = sequence.start();
        let Sequence { name, frames, init, truth, .. } = sequence;
        let truth = truth_of(&name, truth)?;
        start?;
        let init = init.context("no initial box")?;
        ensure!(truth.iter().any(Option::is_some), "{name}: the target is visible in no frame of the ground truth");
        let boxes = truth.len();
        let mut kept = Vec::with_capacity(boxes);
        let mut count = 0;
        for frame in frames {
            let frame = frame?.gray;
            if count == 0 {
                let bytes = boxes as u64 * frame.pixels.len() as u64;
                let (width, height, need, most) = (frame.width, frame.height, bytes.div_ceil(MIB), most_bytes / MIB);
                let need = format!("its frames ({boxes} of {width}x{height}) need {need} MiB of memory");
                ensure!(bytes <= most_bytes, "{name}: {need}: at most {most} MiB are used for a recording");
            }
            count += 1;
            // Frames beyond the ground truth are an error and may be many, so they are only counted.
            if count <= boxes {
                kept.push(frame);
            }
        }
        misfit(count, boxes).map_or(Ok(()), |misfit| Err(anyhow!("{name}: {misfit}")))?;
        Ok(Self { name, frames: kept, init, truth })
    }

    /// Runs a case; calls `progress` for each frame. Errors: The tracker cannot be built, fails, or a signal stops it.
    fn run(&self, variant: &Variant, case: &Case, progress: impl Fn()) -> Result<Run> {
        let mut follower = Follower::new(variant.build()?, vec![(case.frame + 1, Some(case.target))]);
        let mut run = Run::default();
        for place in case.frame..case.end {
            ensure!(!signals::is_stopped(), "it was stopped");
            for frame in case.intervention.shown(&self.frames, place) {
                run.add(&mut follower, place, &frame)?;
            }
            progress();
        }
        Ok(run)
    }

    pub fn bounds(&self) -> Rect {
        self.frames.first().map_or(Rect::default(), |frame| frame.frame().bounds())
    }

    fn bytes(&self) -> u64 {
        self.frames.iter().map(|frame| frame.pixels.len() as u64).sum()
    }
}

pub(super) fn truth_of<T>(name: &str, truth: Option<T>) -> Result<T> {
    truth.with_context(|| format!("{name}: no ground truth beside it: expected gt.txt, groundtruth_rect.txt or groundtruth.txt (`track` needs none)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence() -> Sequence {
        let frame = GrayFrame { width: 1024, height: 512, pixels: vec![0; 1 << 19] };
        let at: BoundingBox = "3,4,5,6".parse().unwrap();
        Sequence::made("moving", vec![frame; 3].into_iter(), vec![Some(at), None, Some(at)])
    }

    #[test]
    fn a_recording_is_kept_whole() {
        let recording = Recording::read(sequence(), MAX_BYTES).unwrap();
        assert_eq!((recording.frames.len(), recording.bytes()), (3, 3 << 19));
        assert_eq!(recording.bounds(), Rect::new(0, 0, 1024, 512));
    }

    #[test]
    fn an_intervention_shows_other_frames() {
        let frames: Vec<GrayFrame> =
            (0..6).map(|pixel| GrayFrame { width: 1, height: 1, pixels: vec![pixel] }).collect();
        let shown = |intervention: Intervention| {
            let of = |place| intervention.shown(&frames, place).map(move |frame| (place, frame.pixels[0]));
            (1..6).flat_map(of).collect::<Vec<_>>()
        };
        let white = Arc::new(GrayFrame { pixels: vec![255], ..frames[0].clone() });
        let (gap, repeated): (Fault, Fault) = ("gap:2".parse().unwrap(), "repeated:2".parse().unwrap());
        assert_eq!(shown(Intervention::None), [(1, 1), (2, 2), (3, 3), (4, 4), (5, 5)]);
        let away = || Away::new(&[None; 6], 2..4, Rect::new(0, 0, 1, 1));
        assert_eq!(shown(Intervention::Fault(2, 4, gap, away())), [(1, 1), (4, 4), (5, 5)]);
        assert_eq!(shown(Intervention::Fault(2, 4, repeated, away())), [(1, 1), (2, 1), (3, 1), (4, 4), (5, 5)]);
        let covered = shown(Intervention::Cover(4, 2, Cover::Black, white));
        assert_eq!(covered, [(1, 1), (2, 2), (3, 3), (4, 0), (4, 0), (4, 4), (5, 5)]);
    }

    #[test]
    fn what_cannot_be_measured_is_named() {
        let two = sequence().truth.map(|truth| truth[..2].to_vec());
        for (sequence, expected) in [
            (sequence(), ": its frames (3 of 1024x512) need 2 MiB of memory: at most 1 MiB are used for a recording"),
            (Sequence { truth: None, ..sequence() }, ": no ground truth"),
            (Sequence { init: None, ..sequence() }, ": no initial box"),
            (
                Sequence { truth: two, ..sequence() },
                ": there are 3 frames, but the ground truth has 2 boxes for them: say which",
            ),
            (Sequence { truth: Some(vec![None; 3]), ..sequence() }, ": the target is visible in no frame"),
        ] {
            let error = format!("{:#}", Recording::read(sequence, 1 << 20).err().unwrap());
            assert!(error.starts_with(&format!("moving{expected}")), "{error}");
        }
    }
}
