//! The firmware `core/examples/replay` in QEMU on a recording, answer by answer against the host.
//!
//! - [`protocol`]: the bytes that both sides exchange.
//! - [`qemu`]: the emulator as a process that ends whatever happens.
//! - [`firmware`]: how the firmware is built, and what it takes of a chip.
//! - [`cycles`]: an estimate of its cycles, by the blocks of code that QEMU traces.
//!
//! The firmware says at its start what it has room for, and with which window it searches: the host does the same.

pub mod cycles;
pub mod firmware;
pub mod protocol;
pub mod qemu;

use crate::percentiles::Spread;
use anyhow::{Context, Result, anyhow, bail, ensure};
use protocol::{Header, Hello, Record, Remembered, Stack, Taken};
use qemu::Qemu;
use serde::Serialize;
use serde_json::Map;
use smr_core::{Rect, Robust, Target, Tracker, paper, robust};
use smr_evaluation::{CoreKind, Origin, Paper, Refused};
use smr_recordings::GrayFrame;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, Write};
use std::path::Path;

/// What was compared, and what the firmware took for it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    #[serde(flatten)]
    pub origin: Origin,
    /// The recording's name.
    pub sequence: String,
    /// Frames answered alike: all but the first, which is locked on.
    pub frames: u32,
    /// The first frame whose answers differ.
    pub difference: Option<Difference>,
    /// Bytes of a target and of its workspace, and of the buffer for pixels.
    pub target_bytes: u32,
    pub workspace_bytes: u32,
    pub buffer_bytes: u32,
    /// Work of an update, in each frame, in the units of `Update::step`.
    pub work: Spread<u64>,
    /// Instructions of the lock. Only known if the firmware came to its end.
    pub lock_instructions: Option<u64>,
    /// Instructions of an update, in each frame.
    pub instructions: Spread<u64>,
    /// Those of the longest step of each update.
    pub longest_step: Spread<u64>,
    /// The same, one by one.
    #[serde(skip)]
    pub counts: Vec<u64>,
    /// Only known if the firmware came to its end.
    pub stack: Option<Stack>,
}

/// An answer that is not the host's.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The frame, counted from 1.
    pub frame: u32,
    pub what: &'static str,
    pub target: String,
    pub host: String,
}

/// Which tracker follows, and how.
#[derive(Clone, Copy, Debug)]
pub struct Follow {
    pub method: CoreKind,
    /// The robust tracker with its refiner.
    pub refiner: bool,
    /// The work of a step; 0 is all at once.
    pub step: u32,
}

impl Follow {
    /// Errors: a refiner for another tracker than the robust one.
    pub fn check(self) -> Result<()> {
        ensure!(!self.refiner || self.method == CoreKind::Robust, "--refiner: expected --method robust");
        Ok(())
    }

    /// What a report says of it.
    fn parameters(self) -> Map<String, serde_json::Value> {
        let step = (self.step > 0).then(|| ("step".to_owned(), self.step.into()));
        let refiner = self.refiner.then(|| ("refiner".to_owned(), true.into()));
        step.into_iter().chain(refiner).collect()
    }
}

/// A recording as the firmware gets it: written into QEMU's folder.
pub struct Recording {
    name: String,
    header: Header,
}

impl Recording {
    /// Writes `frames` into `folder`.
    /// Errors: The frames', fewer than two of them, or the disk's.
    pub fn write(
        name: &str,
        follow: Follow,
        frames: impl Iterator<Item = Result<GrayFrame>>,
        target: Rect,
        folder: &Path,
    ) -> Result<Self> {
        let cannot_write = || format!("cannot write {} for QEMU", protocol::FRAMES);
        let mut file = BufWriter::new(File::create(folder.join(protocol::FRAMES)).with_context(cannot_write)?);
        let mut header = Header { follow, width: 0, height: 0, frames: 0, target };
        file.write_all(&header.bytes()).with_context(cannot_write)?;
        for frame in frames {
            let frame = frame?;
            (header.width, header.height) = (frame.width, frame.height);
            header.frames += 1;
            file.write_all(&frame.pixels).with_context(cannot_write)?;
        }
        ensure!(header.frames > 1, "{name}: only one frame, which is locked on: expected two or more");
        file.rewind()
            .and_then(|()| file.write_all(&header.bytes()))
            .and_then(|()| file.flush())
            .with_context(cannot_write)?;
        Ok(Self { name: name.to_owned(), header })
    }

    /// Follows the target here, and compares with what `qemu`, that runs in `folder`, answers. Ends with the first
    /// difference.
    /// Errors: QEMU ends early, says nothing for too long, or says something else; the firmware has no room for the
    /// box.
    pub fn compare(&self, qemu: &mut Qemu, folder: &Path) -> Result<Report> {
        let mut answers = Answers { file: None, folder };
        let Record::Hello(hello) = answers.next(qemu)? else {
            bail!(
                "the firmware does not say hello first: it is not core/examples/replay, or built without the tracker"
            );
        };
        hello.check(&self.header)?;
        let mut host = Host::lock(self.header, hello.radius, folder).with_context(|| self.name.clone())?;
        let mut report = Report {
            origin: Origin::new(self.header.follow.method.into(), self.header.follow.parameters()),
            sequence: self.name.clone(),
            frames: 0,
            difference: None,
            target_bytes: hello.target,
            workspace_bytes: hello.workspace,
            buffer_bytes: hello.buffer,
            work: Spread::default(),
            lock_instructions: None,
            instructions: Spread::default(),
            longest_step: Spread::default(),
            counts: Vec::new(),
            stack: None,
        };
        let (mut work, mut longest) = (Vec::new(), Vec::new());
        for number in 2..=self.header.frames {
            let (answered, taken) = self.answer(number, &hello, answers.next(qemu)?)?;
            work.push(u64::from(taken.work));
            report.counts.push(hello.instructions(taken.ticks));
            longest.push(hello.instructions(taken.longest));
            report.difference = difference(number, &answered, &host.update()?);
            if report.difference.is_some() {
                break;
            }
            report.frames += 1;
        }
        report.instructions = Spread::of(&report.counts);
        (report.work, report.longest_step) = (Spread::of(&work), Spread::of(&longest));
        if report.difference.is_none() {
            let (stack, lock) = end(answers.next(qemu)?)?;
            report.stack = Some(stack);
            report.lock_instructions = Some(hello.instructions(lock));
            qemu.finish()?;
        }
        Ok(report)
    }

    fn answer(&self, number: u32, hello: &Hello, record: Record) -> Result<(Remembered, Taken)> {
        match record {
            Record::Answer { frame, answered, taken } if frame == number => Ok((answered, taken)),
            Record::Refused { frame, why } => {
                Err(hello.refusal(why, &self.header)).with_context(|| format!("{}, frame {frame}", self.name))
            }
            other => Err(anyhow!("expected the answer to frame {number}, the firmware sent {other:?}")),
        }
    }
}

fn end(record: Record) -> Result<(Stack, u32)> {
    match record {
        Record::End(stack, lock) => Ok((stack, lock)),
        other => bail!("expected the end, the firmware sent {other:?}"),
    }
}

fn difference(frame: u32, target: &Remembered, host: &Remembered) -> Option<Difference> {
    let mut pairs = target.described().zip(host.described());
    let differing = |((what, target), (_, host)): ((&'static str, String), (_, String))| {
        (target != host).then_some(Difference { frame, what, target, host })
    };
    pairs.find_map(differing)
}

/// A tracker on this side.
trait Follows {
    fn lock(&mut self, frame: &GrayFrame, target: Rect) -> Result<()>;

    fn update(&mut self, frame: &GrayFrame) -> Result<Remembered>;
}

impl<T: Target> Follows for Tracker<T> {
    fn lock(&mut self, frame: &GrayFrame, target: Rect) -> Result<()> {
        Self::lock(self, &frame.frame(), target)?;
        Ok(())
    }

    fn update(&mut self, frame: &GrayFrame) -> Result<Remembered> {
        let answer = Self::update(self, &frame.frame())?;
        Remembered::of(&answer, self)
    }
}

/// The tracker as the firmware has it.
fn tracker(follow: Follow, radius: u16) -> Result<Box<dyn Follows>> {
    Ok(match follow.method {
        CoreKind::Smr => Box::new(Tracker::<Paper>::new(paper::Config::camera_within(radius))?),
        CoreKind::Robust if follow.refiner => Box::new(Tracker::<Robust>::new(robust::Config::refined())?),
        CoreKind::Robust => Box::new(Tracker::<Robust>::new(robust::Config::robust())?),
    })
}

/// The tracker on this side, reading the very file that the firmware reads.
struct Host {
    tracker: Box<dyn Follows>,
    frames: BufReader<File>,
    frame: GrayFrame,
}

impl Host {
    fn lock(header: Header, radius: u16, folder: &Path) -> Result<Self> {
        let mut frames = BufReader::new(File::open(folder.join(protocol::FRAMES))?);
        frames.read_exact(&mut header.bytes())?;
        let pixels = vec![0; usize::from(header.width) * usize::from(header.height)];
        let frame = GrayFrame { width: header.width, height: header.height, pixels };
        let mut host = Self { tracker: tracker(header.follow, radius)?, frames, frame };
        host.read()?;
        let bounds = host.frame.frame().bounds();
        let refused = |error| Refused::or(error, header.follow.method.into(), header.target, bounds);
        host.tracker.lock(&host.frame, header.target).map_err(refused)?;
        Ok(host)
    }

    fn read(&mut self) -> Result<()> {
        self.frames.read_exact(&mut self.frame.pixels).with_context(|| format!("cannot read {} back", protocol::FRAMES))
    }

    fn update(&mut self) -> Result<Remembered> {
        self.read()?;
        self.tracker.update(&self.frame)
    }
}

/// `answers.smr`, read while the firmware writes it.
struct Answers<'a> {
    file: Option<File>,
    folder: &'a Path,
}

impl Answers<'_> {
    /// Waits for the next record.
    fn next(&mut self, qemu: &mut Qemu) -> Result<Record> {
        let mut bytes = [0; protocol::RECORD];
        let mut filled = 0;
        qemu.wait_for("an answer of the firmware", || {
            if self.file.is_none() {
                self.file = File::open(self.folder.join(protocol::ANSWERS)).ok();
            }
            let Some(file) = &mut self.file else { return Ok(false) };
            filled += file.read(&mut bytes[filled..])?;
            Ok(filled == bytes.len())
        })?;
        Record::read(&bytes)
    }
}
