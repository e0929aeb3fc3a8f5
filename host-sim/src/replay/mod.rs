//! A flight record, run again: what firmware saw goes through smr-core once more, and the first answer that differs is named.
//!
//! - [`entries`]: the entries of a record.
//! - [`config`]: the configuration in it.
//! - [`answer_values`]: an answer, as it is compared.

pub mod answer_values;
pub mod config;
pub mod entries;

use answer_values::described;
use anyhow::{Context, Result, anyhow, bail, ensure};
use config::configuration;
use entries::{Entries, Entry, Next};
use serde::Serialize;
use smr_core::record::{Recorded, Tag, VERSION};
use smr_core::{Answer, FineRect, Frame, Image, Rect, Robust, State, Target, Tracker};
use smr_evaluation::name_of;
use std::io::Read;

/// What a record holds, and whether it was answered alike.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// One for each beginning: firmware that starts again appends to its record.
    pub flights: Vec<Flight>,
    /// Bytes at the end that are no whole entry: the record was cut off there.
    pub cut_off: u64,
    /// Why the rest was not replayed, though there is more of it.
    pub damage: Option<String>,
    /// The first answer that is not the recorded one; nothing was replayed after it.
    pub difference: Option<Difference>,
}

/// What was replayed of one beginning.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Flight {
    /// `smr` or `robust`.
    pub method: &'static str,
    /// Frames that were locked on, and answered alike.
    pub locks: u64,
    pub answers: u64,
    /// Entries of the other kinds.
    pub moved: u64,
    pub restored: u64,
    /// Updates that were begun and given up.
    pub given_up: u64,
    /// The number of frames in each state, by its code.
    pub states: [u64; State::ALL.len()],
    /// Bytes of all entries, and those of them that are pixels.
    pub bytes: u64,
    pub pixels: u64,
    /// Bytes of an incomplete entry at the end of this flight.
    pub cut_off: u64,
    /// What the last update answers here, if the record ends before its answer.
    pub unanswered: Option<Unanswered>,
}

/// An update without an answer in the record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unanswered {
    pub frame: u64,
    pub state: &'static str,
    #[serde(rename = "box")]
    pub bbox: String,
}

/// What is not as it was recorded.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The flight, from 1.
    pub flight: usize,
    /// The frame in it, from 1: each lock and each answer is of one.
    pub frame: u64,
    /// The entry in it, from 0.
    pub entry: u32,
    pub field: &'static str,
    pub recorded: String,
    pub replayed: String,
}

/// Replays the record in `source`, to its end or to the first difference. `progress` is called after each entry.
/// Errors: The file is no record, or cannot be read. What is wrong further on is [`Report::damage`].
pub fn replay(source: impl Read + 'static, progress: impl Fn()) -> Result<Report> {
    let mut entries = Entries::new(entries::bytes_of(source)?);
    let mut report = Report::default();
    let mut running: Option<Box<dyn Runs>> = None;
    let mut skipped = None;
    loop {
        progress();
        match entries.read()? {
            Next::Skipped { at, bytes } => skipped = Some((at, bytes)),
            Next::End => break,
            Next::Entry(entry) => {
                if let Some((at, bytes)) = skipped.take() {
                    ensure!(!report.flights.is_empty() || entry.tag == Tag::Begin, not_a_record());
                    if entry.tag != Tag::Begin {
                        report.damage = Some(format!("{bytes} bytes at byte {at} are damaged: no entry"));
                        break;
                    }
                    if let Some(flight) = report.flights.last_mut() {
                        flight.cut_off = bytes;
                    }
                }
                match of_entry(&mut running, &entry, &mut report) {
                    Ok(true) => {}
                    Ok(false) => break,
                    Err(error) => {
                        report.damage = Some(format!("entry {} at byte {}: {error:#}", entry.number, entry.at));
                        break;
                    }
                }
            }
        }
    }
    ensure!(!report.flights.is_empty() || report.damage.is_some(), not_a_record());
    if report.difference.is_none() && report.damage.is_none() {
        if let (Some(mut last), Some(flight)) = (running, report.flights.last_mut()) {
            flight.unanswered = last.unanswered();
        }
        report.cut_off = skipped.map_or(0, |(_, bytes)| bytes);
    }
    Ok(report)
}

fn not_a_record() -> anyhow::Error {
    anyhow!("it is not a flight record: expected an entry SMRB first, or lines of a log with `smr-record [`")
}

/// False after a difference.
fn of_entry(running: &mut Option<Box<dyn Runs>>, entry: &Entry, report: &mut Report) -> Result<bool> {
    if entry.tag == Tag::Begin {
        ensure!(entry.number == 0, "it begins a record, but is not number 0");
        if let (Some(mut former), Some(flight)) = (running.take(), report.flights.last_mut()) {
            flight.unanswered = former.unanswered();
        }
        let (run, method) = begin(&entry.holds)?;
        *running = Some(run);
        report.flights.push(Flight { method, ..Flight::default() });
    }
    let number = report.flights.len();
    let (Some(run), Some(flight)) = (running, report.flights.last_mut()) else { bail!("no entry SMRB before it") };
    let expected = run.next_number();
    ensure!(entry.number == expected, "entry {expected} is missing");
    flight.bytes += (smr_core::record::AROUND + entry.holds.len()) as u64;
    let frame = flight.locks + flight.answers + 1;
    let different = run.entry(entry, flight)?;
    report.difference = different.map(|found| Difference { flight: number, frame, entry: entry.number, ..found });
    Ok(report.difference.is_none())
}

impl Difference {
    /// The caller fills in the flight, the frame and the entry.
    fn new(field: &'static str, recorded: impl ToString, replayed: impl ToString) -> Self {
        let (recorded, replayed) = (recorded.to_string(), replayed.to_string());
        Self { field, recorded, replayed, ..Self::default() }
    }
}

/// A tracker on its way through a record.
trait Runs {
    /// The number that the next entry must have.
    fn next_number(&mut self) -> u32;

    fn entry(&mut self, entry: &Entry, flight: &mut Flight) -> Result<Option<Difference>>;

    /// The update that was begun and not answered.
    fn unanswered(&mut self) -> Option<Unanswered>;
}

struct Run<T: Target> {
    tracker: Box<Tracker<T>>,
    numbers: u32,
    window: Option<Window>,
    frames: u64,
}

/// What an update looks at.
struct Window {
    /// The frame's.
    size: (u16, u16),
    parts: [Option<Part>; 2],
}

/// A rectangle of a frame, and its pixels.
struct Part {
    rect: Rect,
    pixels: Vec<u8>,
}

/// The tracker that a record begins with, and its name.
fn begin(holds: &[u8]) -> Result<(Box<dyn Runs>, &'static str)> {
    let mut from = Fields(holds);
    let version = from.u16()?;
    ensure!(version == VERSION, "version {version} of the record: expected {VERSION}");
    let [tracker, _] = from.take()?;
    let numbers: Vec<u16> = from.0.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    match tracker {
        smr_evaluation::Paper::TRACKER => Ok((run::<smr_evaluation::Paper>(&numbers)?, "smr")),
        Robust::TRACKER => Ok((run::<Robust>(&numbers)?, "robust")),
        other => bail!("tracker {other}: expected {} or {}", smr_evaluation::Paper::TRACKER, Robust::TRACKER),
    }
}

fn run<T: Recorded + 'static>(numbers: &[u16]) -> Result<Box<dyn Runs>> {
    let tracker = Box::new(Tracker::<T>::with(configuration::<T::Config>(numbers)?)?);
    Ok(Box::new(Run { tracker, numbers: 0, window: None, frames: 0 }))
}

impl<T: Recorded> Runs for Run<T> {
    fn next_number(&mut self) -> u32 {
        let number = self.numbers;
        self.numbers = number.wrapping_add(1);
        number
    }

    fn entry(&mut self, entry: &Entry, flight: &mut Flight) -> Result<Option<Difference>> {
        let mut from = Fields(&entry.holds);
        if entry.tag != Tag::Answer && self.window.take().is_some() {
            flight.given_up += 1;
        }
        let different = match entry.tag {
            Tag::Begin => None,
            Tag::Lock => {
                let different = self.lock(&mut from, flight)?;
                flight.locks += u64::from(different.is_none());
                different
            }
            Tag::Moved => {
                flight.moved += 1;
                let (right, down) = (from.i32()?, from.i32()?);
                self.tracker.moved(right, down);
                None
            }
            Tag::Window => self.window(&mut from, flight)?,
            Tag::Answer => {
                let different = self.answer(&mut from, flight)?;
                flight.answers += u64::from(different.is_none());
                different
            }
            Tag::Restored => {
                flight.restored += 1;
                self.restore(from.rest())?
            }
        };
        self.frames = flight.locks + flight.answers;
        if different.is_none() && entry.tag != Tag::Begin {
            ensure!(from.0.is_empty(), "it holds {} bytes more than expected", from.0.len());
        }
        Ok(different)
    }

    fn unanswered(&mut self) -> Option<Unanswered> {
        let window = self.window.take()?;
        let answer = self.update(&window).ok()?;
        let (frame, state) = (self.frames + 1, name_of(answer.state));
        Some(Unanswered { frame, state, bbox: described(answer.fine) })
    }
}

impl<T: Target> Run<T> {
    fn lock(&mut self, from: &mut Fields<'_>, flight: &mut Flight) -> Result<Option<Difference>> {
        let (width, height) = (from.u16()?, from.u16()?);
        let (target, window) = (from.rect()?, from.rect()?);
        let expected = self.tracker.lock_window(Rect::new(0, 0, width, height), target);
        if expected != window {
            return Ok(different("lock window", window, expected));
        }
        let part = from.part(window)?.context("it locks on no pixels")?;
        flight.pixels += part.pixels.len() as u64;
        let locked = self.tracker.lock(&part.frame((width, height))?, target);
        Ok(locked.err().map(|error| Difference::new("lock", "locked", error)))
    }

    fn window(&mut self, from: &mut Fields<'_>, flight: &mut Flight) -> Result<Option<Difference>> {
        let size = (from.u16()?, from.u16()?);
        let (first, second) = (from.rect()?, from.rect()?);
        let wanted = |rect: Option<Rect>| rect.filter(|rect| !rect.is_empty()).unwrap_or_default();
        ensure!(self.tracker.window().is_some(), "an update without a target: expected SMRL or SMRS before it");
        let (near, elsewhere) = (wanted(self.tracker.window()), wanted(self.tracker.sweep_window()));
        if near != first {
            return Ok(different("window", first, near));
        }
        if elsewhere != second {
            return Ok(different("sweep window", second, elsewhere));
        }
        let parts = [from.part(first)?, from.part(second)?];
        flight.pixels += parts.iter().flatten().map(|part| part.pixels.len() as u64).sum::<u64>();
        self.window = Some(Window { size, parts });
        Ok(None)
    }

    fn answer(&mut self, from: &mut Fields<'_>, flight: &mut Flight) -> Result<Option<Difference>> {
        let window = self.window.take().context("an answer without a window before it")?;
        let recorded = read_answer(from)?;
        let replayed = self.update(&window)?;
        let pairs = answer_values::values(&recorded).into_iter().zip(answer_values::values(&replayed));
        let differing = |((field, recorded), (_, replayed)): ((&'static str, String), (_, String))| {
            (recorded != replayed).then(|| Difference::new(field, recorded, replayed))
        };
        let different = pairs.into_iter().find_map(differing);
        if different.is_none() {
            flight.states[usize::from(recorded.state.code())] += 1;
        }
        Ok(different)
    }

    fn update(&mut self, window: &Window) -> Result<Answer> {
        let nothing = Part { rect: Rect::new(0, 0, 1, 1), pixels: vec![0] };
        let [first, second] = &window.parts;
        let mut frame = first.as_ref().unwrap_or(&nothing).frame(window.size)?;
        if let Some(second) = second {
            let (image, x, y) = second.image()?;
            frame = frame.and_part(image, x, y)?;
        }
        Ok(self.tracker.update(&frame)?)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<Option<Difference>> {
        let restored = self.tracker.restore(saved);
        Ok(restored.err().map(|error| Difference::new("restored target", "restored", error)))
    }
}

/// An answer as it is recorded.
fn read_answer(from: &mut Fields<'_>) -> Result<Answer> {
    let fine = FineRect { x: from.i32()?, y: from.i32()?, width: from.u32()?, height: from.u32()? };
    let [state, flags] = from.take()?;
    ensure!(flags < 8, "flags {flags}: expected 0 to 7");
    let (confidence, ratio, runner_up, alpha) = (from.u16()?, from.u16()?, from.u16()?, from.u16()?);
    let if_there = |bit: u8, number: u16| (flags & bit != 0).then_some(number);
    Ok(Answer {
        bbox: fine.whole(),
        fine,
        state: answer_values::state(state.into())?,
        confidence,
        ratio,
        runner_up_ratio: if_there(2, runner_up),
        alpha: if_there(4, alpha),
        scale: from.u32()?,
        found_again: flags & 1 != 0,
    })
}

fn different(field: &'static str, recorded: Rect, replayed: Rect) -> Option<Difference> {
    let text = |Rect { x, y, width, height }: Rect| format!("{width}x{height} at ({x}, {y})");
    Some(Difference::new(field, text(recorded), text(replayed)))
}

impl Part {
    fn image(&self) -> Result<(Image<'_>, u16, u16)> {
        let Rect { x, y, width, height } = self.rect;
        Ok((Image::new(&self.pixels, width, height)?, u16::try_from(x)?, u16::try_from(y)?))
    }

    /// The frame of this size with no more than this part in memory.
    fn frame(&self, (width, height): (u16, u16)) -> Result<Frame<'_>> {
        let (image, x, y) = self.image()?;
        Ok(Frame::part(image, x, y, width, height)?)
    }
}

/// Numbers, one after the other.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk().context("it holds fewer bytes than expected")?;
        self.0 = rest;
        Ok(*first)
    }

    fn u16(&mut self) -> Result<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn i32(&mut self) -> Result<i32> {
        self.take().map(i32::from_le_bytes)
    }

    fn rect(&mut self) -> Result<Rect> {
        let (x, y) = (self.u16()?.into(), self.u16()?.into());
        Ok(Rect::new(x, y, self.u16()?, self.u16()?))
    }

    /// The pixels of a part; `None` if it has none.
    fn part(&mut self, rect: Rect) -> Result<Option<Part>> {
        if rect.is_empty() {
            return Ok(None);
        }
        let pixels = self.0.split_at_checked(rect.area() as usize).context("it holds fewer pixels than expected")?;
        self.0 = pixels.1;
        Ok(Some(Part { rect, pixels: pixels.0.to_vec() }))
    }

    const fn rest(&mut self) -> &'a [u8] {
        let rest = self.0;
        self.0 = &[];
        rest
    }
}
