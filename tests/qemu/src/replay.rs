//! The talk of host and firmware, byte by byte, as `core/examples/replay/main.rs` describes it, and the target followed on the host, too.

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use host_sim::replay::answer_values::{state, values};
use smr_core::{Answer, FineRect, Rect, Robust, Target, Tracker, paper, robust};
use smr_evaluation::{CoreKind, Paper, Refused};
use smr_recordings::{GrayFrame, Sequence};
use std::fmt;
use std::fs::{self, File};
use std::io::{BufWriter, Seek, Write};
use std::num::NonZeroU32;
use std::path::Path;

const VERSION: u32 = 4;
const FRAMES: &str = "frames.smr";
const ANSWERS: &str = "answers.smr";
/// The window of smr, to each side.
const RADIUS: u16 = 16;

/// An answer, and a hash of the target as it is saved after it: templates, weights, track.
type Answered = (Answer, u32);

/// A tracker on this side. It locks in the first frame, and answers in the others.
type Host = Box<dyn FnMut(&GrayFrame) -> Result<Option<Answered>>>;

fn host<T: Target + 'static>(config: T::Config, start: Rect, method: CoreKind) -> Result<Host>
where
    T::Config: 'static,
{
    let mut tracker = Tracker::<T>::with(config)?;
    let mut saved = vec![0; T::SAVED_SIZE];
    let mut is_locked = false;
    Ok(Box::new(move |frame| {
        let frame = frame.frame();
        if !std::mem::replace(&mut is_locked, true) {
            let locked = tracker.lock(&frame, start);
            locked.map_err(|error| Refused::or(error.into(), method.into(), start, frame.bounds()))?;
            return Ok(None);
        }
        let answer = tracker.update(&frame)?;
        let size = tracker.save(&mut saved)?;
        // FNV-1a
        let hash = |hash: u32, byte: &u8| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
        Ok(Some((answer, saved[..size].iter().fold(0x811C_9DC5, hash))))
    }))
}

/// Writes the recording into `folder`, and follows its target: the answers that the firmware shall give.
pub fn write(
    sequence: Sequence,
    method: CoreKind,
    refiner: bool,
    step: Option<NonZeroU32>,
    folder: &Path,
) -> Result<Vec<Answered>> {
    let (start, name) = (sequence.start()?, sequence.name);
    let (number, mut host) = match method {
        CoreKind::Smr => (0, host::<Paper>(paper::Config::camera_within(RADIUS), start, method)?),
        CoreKind::Robust if refiner => (2, host::<Robust>(robust::Config::refined(), start, method)?),
        CoreKind::Robust => (1, host::<Robust>(robust::Config::robust(), start, method)?),
    };
    let header = |width: u16, height: u16, frames| {
        let [left, top] = [start.x, start.y].map(i32::cast_unsigned);
        let [width, height, across, down] = [width, height, start.width, start.height].map(u32::from);
        let step = step.map_or(0, NonZeroU32::get);
        let magic = u32::from_le_bytes(*b"SMRF");
        [magic, VERSION, number, step, width, height, frames, left, top, across, down].map(u32::to_le_bytes).concat()
    };
    let cannot_write = || format!("cannot write {FRAMES} for QEMU");
    let mut file = BufWriter::new(File::create(folder.join(FRAMES)).with_context(cannot_write)?);
    file.write_all(&header(0, 0, 0)).with_context(cannot_write)?;
    let (mut expected, mut size, mut count) = (Vec::new(), (0, 0), 0);
    for frame in sequence.frames {
        let frame = frame?;
        (size, count) = ((frame.width, frame.height), count + 1);
        file.write_all(&frame.pixels).with_context(cannot_write)?;
        expected.extend(host(&frame).with_context(|| name.clone())?);
    }
    ensure!(count > 1, "{name}: only one frame, which is locked on: there is nothing to compare");
    let first = header(size.0, size.1, count);
    file.rewind().and_then(|()| file.write_all(&first)).and_then(|()| file.flush()).with_context(cannot_write)?;
    Ok(expected)
}

/// Answers of the firmware, and their cost.
pub struct Report {
    /// Bytes of a target, of its workspace, and of the buffer for pixels.
    memory: [u32; 3],
    /// The first frame, from 1, with a value that is not the host's: its name, the firmware's and the host's.
    pub difference: Option<(u32, (&'static str, String, String))>,
    work: [u64; 3],
    /// Instructions of an update, and of its longest step.
    pub updates: [u64; 3],
    longest: [u64; 3],
    /// Instructions of each update, and of the lock.
    pub counts: Vec<u64>,
    lock: u64,
    /// Bytes used.
    pub stack: u32,
}

impl Report {
    /// Reads what the firmware has left in `folder`.
    /// Errors: it refuses, or has said something else than answers to all frames.
    pub fn of(folder: &Path, expected: &[Answered]) -> Result<Self> {
        let bytes = fs::read(folder.join(ANSWERS)).unwrap_or_default();
        let words = |record: &[u8; 80]| {
            let mut words = [0; 20];
            words.iter_mut().zip(record.as_chunks().0).for_each(|(word, bytes)| *word = u32::from_le_bytes(*bytes));
            words
        };
        let mut records = bytes.as_chunks().0.iter().map(words);
        let mut next = || match records.next() {
            Some([4, frame, why, ..]) => Err(refusal(frame, why)),
            record => record.context("the firmware ended before it had answered every frame"),
        };
        let [1, VERSION, _, _, _, buffer, target, workspace, in_loop, ticks, ..] = next()? else {
            bail!("the firmware does not say hello by version {VERSION} of the protocol: is it core/examples/replay?")
        };
        ensure!(ticks > 0, "the firmware's timer stands still: QEMU does not emulate it, or not with -icount");
        let rounded = |ticks_of: u32| u64::from(ticks_of) * u64::from(in_loop) + u64::from(ticks) / 2;
        let instructions = |ticks_of: u32| rounded(ticks_of) / u64::from(ticks);
        let (mut work, mut longest, mut counts, mut difference) = (vec![], vec![], vec![], None);
        for (number, host) in (2..).zip(expected) {
            let record = next()?;
            ensure!(record[..2] == [2, number], "the firmware sent {record:?}: expected the answer to frame {number}");
            let [taken, in_ticks, of_step] = [record[14], record[15], record[16]];
            work.push(u64::from(taken));
            counts.push(instructions(in_ticks));
            longest.push(instructions(of_step));
            let pairs = described(&answered(&record)?).into_iter().zip(described(host));
            let differs =
                |((what, target), (_, host)): (_, (_, String))| (target != host).then_some((what, target, host));
            difference = difference.or_else(|| pairs.filter_map(differs).next().map(|values| (number, values)));
        }
        let [3, _, stack, _, lock, ..] = next()? else { bail!("the firmware does not come to its end") };
        let memory = [target, workspace, buffer];
        let [work, updates, longest] = [&work, &counts, &longest].map(|figures| crate::spread(figures));
        Ok(Self { memory, difference, work, updates, longest, counts, stack, lock: instructions(lock) })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { memory: [target, workspace, buffer], work, updates, longest, counts, lock, stack, .. } = self;
        match &self.difference {
            None => writeln!(f, "{} frames answered as on the host, bit for bit", counts.len())?,
            Some((frame, (what, target, host))) => {
                writeln!(f, "FAILED in frame {frame}: {what}\n    target: {target}\n    host:   {host}")?;
            }
        }
        let more = stack.saturating_sub(target + workspace + buffer);
        writeln!(f, "  target {target} bytes, workspace {workspace}, pixels {buffer}, {more} more on the stack")?;
        writeln!(f, "  instructions of the lock: {lock}")?;
        let [median, p95, max] = updates;
        writeln!(f, "  instructions of an update: median {median}, 95 % below {p95}, at most {max}")?;
        if longest != updates {
            let [median, _, max] = longest;
            writeln!(f, "  instructions of its longest step: median {median}, at most {max}")?;
        }
        writeln!(f, "  work of an update: median {}, at most {}", work[0], work[2])
    }
}

/// The answer in a record.
fn answered(record: &[u32; 20]) -> Result<Answered> {
    let [_, _, x, y, width, height, code, confidence, ratio, runner_up, alpha, scale, again, hash, ..] = *record;
    let fine = FineRect { x: x.cast_signed(), y: y.cast_signed(), width, height };
    let some = |word: u32| (word != u32::MAX).then(|| u16::try_from(word)).transpose();
    let answer = Answer {
        bbox: fine.whole(),
        fine,
        state: state(code).context("from the firmware")?,
        confidence: confidence.try_into()?,
        ratio: ratio.try_into()?,
        runner_up_ratio: some(runner_up)?,
        alpha: some(alpha)?,
        scale,
        found_again: again != 0,
    };
    Ok((answer, hash))
}

/// Every value, by the name that people read.
fn described((answer, hash): &Answered) -> Vec<(&'static str, String)> {
    let hash = ("hash of the saved target", format!("{hash:08x}"));
    values(answer).into_iter().chain([hash]).collect()
}

/// The reason that the firmware gives as the number `why`, as `core/examples/replay` has it.
fn refusal(frame: u32, why: u32) -> Error {
    let reason = match why {
        1 => "it cannot read the recording, or is built without this tracker",
        2 => "the box has more pixels than its template",
        3 => "the window around the box has more pixels than its buffer",
        4 => "it cannot lock on the box",
        5 => "it cannot search the frame",
        _ => "it cannot write its answers",
    };
    anyhow!("the firmware refuses frame {frame}: {reason}")
}
