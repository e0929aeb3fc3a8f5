//! Writes the record for the firmware `tests/chip/replay`, and parses the firmware's output.

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use host_sim::replay::values;
use smr_core::record::{Entry, Recorded, Recorder, entries};
use smr_core::{Answer, FineRect, Robust, State, Tracker, paper, robust};
use smr_evaluation::{CoreKind, Paper, Refused};
use smr_recordings::Sequence;
use std::convert::Infallible;
use std::fmt;
use std::fs;
use std::num::NonZeroU32;
use std::path::Path;

const VERSION: u32 = 5;
const RADIUS: u16 = 16;

/// Tracks a recording on the host. Returns the flight record, with the saved target after each answer, so that the
/// firmware also compares templates and weights.
pub fn record(sequence: Sequence, method: CoreKind, refiner: bool) -> Result<Vec<u8>> {
    match method {
        CoreKind::Paper => of::<Paper>(paper::Config::camera_within(RADIUS), sequence, method),
        CoreKind::Robust if refiner => of::<Robust>(robust::Config::refined(), sequence, method),
        CoreKind::Robust => of::<Robust>(robust::Config::robust(), sequence, method),
    }
}

fn of<T: Recorded>(config: T::Config, sequence: Sequence, method: CoreKind) -> Result<Vec<u8>> {
    let (start, name, mut bytes, mut frames) = (sequence.start()?, sequence.name, Vec::new(), 0);
    let mut tracker = Box::new(Tracker::<T>::with(config)?);
    let Ok(mut recorder) = Recorder::begin(tracker.target(), |piece: &[u8]| -> Result<(), Infallible> {
        bytes.extend_from_slice(piece);
        Ok(())
    });
    let mut saved = vec![0; T::SAVED_SIZE];
    for frame in sequence.frames {
        let frame = frame?.gray;
        let frame = frame.frame();
        frames += 1;
        if frames == 1 {
            let locked = tracker.lock(&frame, start);
            let refused = |error| Refused::or(Error::from(error), method.into(), start, frame.bounds());
            locked.map_err(refused).with_context(|| name.clone())?;
            let Ok(()) = recorder.lock(tracker.target(), &frame, start);
            continue;
        }
        let Ok(()) = recorder.window(tracker.target(), &frame);
        let answer = tracker.update(&frame).with_context(|| name.clone())?;
        let Ok(()) = recorder.answer(&answer);
        let size = tracker.save(&mut saved)?;
        let Ok(()) = recorder.restored(&saved[..size]);
    }
    ensure!(frames > 1, "{name}: only one frame, which is locked on: there is nothing to compare");
    Ok(bytes)
}

pub fn write(record: &[u8], step: Option<NonZeroU32>, folder: &Path) -> Result<()> {
    fs::write(folder.join("record.smr"), record).context("cannot write record.smr for QEMU")?;
    let step = step.map_or(Ok(()), |step| fs::write(folder.join("step.smr"), step.get().to_le_bytes()));
    step.context("cannot write step.smr for QEMU")
}

/// Result and cost of the firmware's replay of a record.
pub struct ReplayedRecord {
    /// Bytes of a target, of a workspace, and of the buffer for one entry.
    memory: [u32; 3],
    /// First difference: number of the frame (from 1); name of the value, the firmware's value, the recorded value.
    pub difference: Option<(usize, (&'static str, String, String))>,
    work: [u64; 3],
    /// Instructions of an update and of its longest step: median, 95th percentile, largest.
    pub updates: [u64; 3],
    longest: [u64; 3],
    /// Instructions of each update, and of the lock.
    pub counts: Vec<u64>,
    lock: u64,
    /// Largest stack in bytes, of the whole run and of an update.
    pub stack: u32,
    of_update: u32,
}

impl ReplayedRecord {
    /// Parses the firmware's output file in `folder`. Fails if the firmware refused or did not finish the record, if
    /// its timer stood still, or if the file has another format.
    pub fn of(folder: &Path, record: &[u8]) -> Result<Self> {
        let bytes = fs::read(folder.join("said.smr")).unwrap_or_default();
        let words = |line: &[u8; 64]| {
            let mut words = [0; 16];
            words.iter_mut().zip(line.as_chunks().0).for_each(|(word, bytes)| *word = u32::from_le_bytes(*bytes));
            words
        };
        let mut lines = bytes.as_chunks().0.iter().map(words);
        let mut next = || lines.next().context("the firmware ended before the record did");
        let hello = next()?;
        if hello[0] == 5 {
            refusal(&hello, record)?;
        }
        let [1, VERSION, buffer, target, workspace, in_loop, ticks, ..] = hello else {
            bail!("the firmware does not say hello by version {VERSION} of the protocol: is it tests/chip/replay?")
        };
        ensure!(ticks > 0, "the firmware's timer stands still: QEMU does not emulate it, or not with -icount");
        let rounded = |ticks_of: u32| u64::from(ticks_of) * u64::from(in_loop) + u64::from(ticks) / 2;
        let instructions = |ticks_of: u32| rounded(ticks_of) / u64::from(ticks);
        let (mut work, mut longest, mut counts) = (vec![], vec![], vec![]);
        let (difference, (stack, of_update), lock) = loop {
            match next()? {
                [2, taken, in_ticks, ..] => {
                    work.push(u64::from(taken));
                    counts.push(instructions(in_ticks));
                }
                [3, of_step, ..] => longest.push(instructions(of_step)),
                [4, stack, _, of_update, lock, ..] => break (None, (stack, of_update), instructions(lock)),
                line => break (Some(refusal(&line, record)?), (0, 0), 0),
            }
        };
        let answers = entries(record).flatten().filter(|found| matches!(found.entry, Entry::Answer(_))).count();
        ensure!(difference.is_some() || counts.len() == answers, "the firmware ended before the record did");
        let memory = [target, workspace, buffer];
        let [work, updates, longest] = [&work, &counts, &longest].map(|figures| crate::spread(figures));
        Ok(Self { memory, difference, work, updates, longest, counts, stack, of_update, lock })
    }
}

impl fmt::Display for ReplayedRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { memory: [target, workspace, buffer], work, updates, longest, counts, lock, of_update, .. } = self;
        if let Some((frame, (what, target, recorded))) = &self.difference {
            return writeln!(f, "FAILED in frame {frame}: {what}\n    target:   {target}\n    recorded: {recorded}");
        }
        writeln!(f, "{} frames answered as recorded, bit for bit", counts.len())?;
        writeln!(f, "  target {target} bytes, workspace {workspace}, buffer {buffer}, stack of an update {of_update}")?;
        writeln!(f, "  instructions of the lock: {lock}")?;
        let ([median, p95, max], mean) = (updates, counts.iter().sum::<u64>() / (counts.len() as u64).max(1));
        writeln!(f, "  instructions of an update: median {median}, mean {mean}, 95 % below {p95}, at most {max}")?;
        if longest[2] > 0 {
            let [median, _, max] = longest;
            writeln!(f, "  in steps, too; instructions of the longest of an update: median {median}, at most {max}")?;
        }
        writeln!(f, "  work of an update: median {}, at most {}", work[0], work[2])
    }
}

/// Parses the firmware's line about a difference into the fields of `ReplayedRecord::difference`. Fails if the firmware refused
/// the frame, or if the line has another format.
fn refusal(line: &[u32; 16], record: &[u8]) -> Result<(usize, (&'static str, String, String))> {
    let [5, at, why, x, y, width, height, state, confidence, ratio, runner_up, alpha, scale, again, identity, _] =
        *line
    else {
        bail!("the firmware says {line:?}: expected what an update took")
    };
    // The lock counts as the first frame's entry.
    let of_frame = |entry: &Entry<'_>| matches!(entry, Entry::Lock { .. } | Entry::Answer(_));
    let before = entries(record).flatten().take_while(|found| found.at < at as usize);
    let frame = 1 + before.filter(|found| of_frame(&found.entry)).count();
    let entry = entries(record).flatten().map(|found| found.entry);
    let recorded = entry.filter(of_frame).nth(frame - 1);
    let (6, Some(Entry::Answer(recorded))) = (why, recorded) else {
        return Err(anyhow!("the firmware refuses frame {frame}: {}", reason(why)));
    };
    let fine = FineRect { x: x.cast_signed(), y: y.cast_signed(), width, height };
    let some = |word: u32| (word != u32::MAX).then(|| u16::try_from(word)).transpose();
    let state = u8::try_from(state).ok().and_then(State::from_code).context("the firmware gives no state: 0 to 3")?;
    let mut answer = Answer::new(fine, state);
    answer.confidence = confidence.try_into()?;
    answer.ratio = ratio.try_into()?;
    answer.runner_up_ratio = some(runner_up)?;
    answer.alpha = some(alpha)?;
    answer.identity = some(identity)?;
    (answer.scale, answer.found_again) = (scale, again != 0);
    let pairs = values(&answer).into_iter().zip(values(&recorded));
    let mut differ = pairs.filter_map(|((what, target), (_, host))| (target != host).then_some((what, target, host)));
    differ.next().map(|values| (frame, values)).context("the firmware gives the recorded answer as another one")
}

/// Returns the text of an error code of `tests/chip/replay`.
fn reason(why: u32) -> &'static str {
    match why {
        1 => "it finds no entry of a record where it expects one",
        2 => "an entry of the record is larger than its buffer",
        3 => "it is built without this tracker, or has no room for its window",
        4 => "it cannot lock on the box, or reads other pixels for it: the box may be too large for its template",
        5 => "it cannot search the frame, or reads other pixels",
        7 => "its target is saved as other bytes",
        _ => "it cannot write what it has found",
    }
}
