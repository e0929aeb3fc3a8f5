//! Replays a flight record: passes the recorded frames to smr-core again, and names the first answer that differs.

use anyhow::{Context, Error, Result, anyhow, ensure};
use serde::Serialize;
use serde_json::{Value, json};
use smr_core::record::{self, Begin, Entry, Flaw, Player, Recorded, Tag, entries};
use smr_core::similarity::Table;
use smr_core::{Answer, FineRect, Rect, Robust, Settings, State, Tracker, paper, robust};
use smr_evaluation::{Paper, name_of};
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::sync::LazyLock;

/// The most MiB of a file before its record begins.
const MOST_BEFORE: u64 = 64;
/// A log must have its first line of a record within this many bytes.
const FIRST: usize = 1 << 20;
/// No line of a log is this long, in bytes.
const LINE: u64 = 256 << 20;
/// The text before the bytes in a line of a log.
const LOGGED: &[u8] = b"smr-record [";

/// The flights of a record, and the first answer that differs.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// One flight for each start of the firmware, which appends to its record.
    pub flights: Vec<Flight>,
    /// Bytes of an incomplete entry at the end: the record was cut off there.
    pub cut_off: usize,
    /// The reason why the rest of the record was not replayed.
    pub damage: Option<String>,
    /// The first answer that differs from the recorded one; the replay ends there.
    pub difference: Option<Difference>,
}

/// The part of a record from one start of the firmware to the next.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Flight {
    /// `smr` or `robust`.
    pub method: &'static str,
    /// Locks, and answers that are as recorded.
    pub locks: u64,
    pub answers: u64,
    /// Entries of each other kind.
    pub moved: u64,
    pub restored: u64,
    /// Updates that were begun and cancelled.
    pub given_up: u64,
    /// Frames in each state, by its code.
    pub states: [u64; State::ALL.len()],
    /// Bytes of all entries, and of the pixels in them.
    pub bytes: u64,
    pub pixels: u64,
    /// Bytes of an incomplete entry at the end of this flight.
    pub cut_off: usize,
    /// The answer of the last update, if the record ends before it.
    pub unanswered: Option<Unanswered>,
    /// The settings by name, each a list of values; null unless the caller asks for them.
    pub settings: Value,
    /// The entries in their order, in the units of the record and without pixels; empty unless the caller asks for them.
    pub entries: Vec<Value>,
}

/// An update without an answer in the record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unanswered {
    pub frame: u64,
    pub state: &'static str,
    #[serde(rename = "box")]
    pub bbox: String,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// Number of the flight, from 1.
    pub flight: usize,
    /// Number of the frame in the flight, from 1. Each lock and each answer belongs to one frame.
    pub frame: u64,
    /// Number of the entry in the flight, from 0.
    pub entry: u32,
    pub field: &'static str,
    pub recorded: String,
    pub replayed: String,
}

/// Replays the record in `source`, to its end or to the first difference, and calls `progress` after each entry. With `every` the report has
/// every entry.
/// Errors: The file is no record, or cannot be read. Later damage is in [`Report::damage`].
pub fn replay(source: impl Read, every: bool, progress: impl Fn()) -> Result<Report> {
    let record = bytes_of(source).context("cannot read the record")?;
    let mut report = Report::default();
    let mut running: Option<Box<dyn Runs<'_> + '_>> = None;
    let mut all = entries(&record);
    while let Some(found) = all.next() {
        progress();
        let found = match found {
            Ok(found) => found,
            Err(damage) => {
                let begins = !report.flights.is_empty() || !matches!(damage.flaw, Flaw::NoEntry(_) | Flaw::Missing(_));
                ensure!(begins, not_a_record());
                report.damage = Some(damage.to_string());
                break;
            }
        };
        let played = match found.entry {
            Entry::Begin(beginning) => {
                end(running.take(), &mut report, all.cut_off());
                begin(&beginning).map(|(run, method)| {
                    let settings = if every { run.settings() } else { Value::Null };
                    running = Some(run);
                    report.flights.push(Flight { method, settings, ..Flight::default() });
                })
            }
            _ => Ok(()),
        };
        let number = report.flights.len();
        let played = played.and_then(|()| {
            let (Some(run), Some(flight)) = (&mut running, report.flights.last_mut()) else { return Ok(None) };
            let frame = flight.locks + flight.answers + 1;
            let (gave_up, played) = run.play(&found.entry);
            let different = played.map_or_else(named, |()| Ok(None))?;
            flight.count(&found, gave_up, every, different.is_none());
            Ok(different.map(|(field, [recorded, replayed])| Difference {
                flight: number,
                frame,
                entry: found.number,
                field,
                recorded,
                replayed,
            }))
        });
        match played {
            Ok(None) => {}
            Ok(difference) => {
                report.difference = difference;
                return Ok(report);
            }
            Err(error) => {
                report.damage = Some(format!("entry {} at byte {}: {error:#}", found.number, found.at));
                break;
            }
        }
    }
    ensure!(!report.flights.is_empty() || report.damage.is_some(), not_a_record());
    if report.damage.is_none() {
        end(running, &mut report, 0);
        report.cut_off = all.cut_off();
    }
    Ok(report)
}

fn not_a_record() -> Error {
    anyhow!("it is not a flight record: expected an entry SMRB first, or lines of a log with `smr-record [`")
}

/// Ends a flight, whose last `cut_off` bytes are no entry.
fn end(run: Option<Box<dyn Runs<'_> + '_>>, report: &mut Report, cut_off: usize) {
    if let (Some(mut run), Some(flight)) = (run, report.flights.last_mut()) {
        let frame = flight.locks + flight.answers + 1;
        let answer = run.unanswered();
        flight.unanswered = answer.map(|(state, bbox)| Unanswered { frame, state, bbox });
        flight.cut_off = cut_off;
    }
}

impl Flight {
    fn count(&mut self, found: &record::Found<'_>, gave_up: bool, every: bool, alike: bool) {
        self.bytes += found.size as u64;
        self.given_up += u64::from(gave_up);
        match &found.entry {
            Entry::Begin(_) => {}
            Entry::Lock { window, .. } => {
                self.pixels += u64::from(window.area());
                self.locks += u64::from(alike);
            }
            Entry::Moved { .. } => self.moved += 1,
            Entry::Window { window, sweep, .. } => {
                self.pixels += u64::from(window.area() + sweep.unwrap_or_default().area());
            }
            Entry::Answer(answer) => {
                self.answers += u64::from(alike);
                self.states[usize::from(answer.state.code())] += u64::from(alike);
            }
            Entry::Restored(_) => self.restored += 1,
        }
        if every {
            self.entries.push(said(&found.entry));
        }
    }
}

/// An entry as JSON: boxes are left, top, width, height.
fn said(entry: &Entry<'_>) -> Value {
    let of = |Rect { x, y, width, height }: Rect| json!([x, y, width, height]);
    match entry {
        Entry::Begin(begin) => json!({ "begin": char::from(begin.tracker) }),
        Entry::Lock { frame, window, bbox } => {
            json!({ "lock": of(*bbox), "window": of(*window), "frame": of(frame.bounds()) })
        }
        Entry::Moved { right, down } => json!({ "moved": [right, down] }),
        Entry::Window { frame, window, sweep } => {
            json!({ "window": of(*window), "sweep_window": sweep.map(of), "frame": of(frame.bounds()) })
        }
        Entry::Answer(answer) => {
            let FineRect { x, y, width, height } = answer.fine;
            json!({
                "answer": [i64::from(x), i64::from(y), i64::from(width), i64::from(height)],
                "state": name_of(answer.state),
                "confidence": answer.confidence,
                "ratio": answer.ratio,
                "runner_up_ratio": answer.runner_up_ratio,
                "alpha": answer.alpha,
                "scale": answer.scale,
                "found_again": answer.found_again,
            })
        }
        Entry::Restored(saved) => json!({ "restored": saved.len() }),
    }
}

/// A tracker that replays a record.
trait Runs<'a> {
    /// Replays an entry. True if an update was begun before it and has no answer.
    fn play(&mut self, entry: &Entry<'a>) -> (bool, Result<(), record::Difference>);

    fn settings(&self) -> Value;

    /// State and box of the update that was begun and not answered.
    fn unanswered(&mut self) -> Option<(&'static str, String)>;
}

struct Run<'a, T: Recorded> {
    tracker: Box<Tracker<T>>,
    player: Player<'a, T>,
}

/// The tracker that a record begins with, and its name.
fn begin<'a>(begin: &Begin<'_>) -> Result<(Box<dyn Runs<'a> + 'a>, &'static str)> {
    if begin.tracker == Paper::TRACKER {
        return Ok((run::<Paper>(begin, paper::Config::paper(), |config, table| config.table = table)?, "smr"));
    }
    let expected = (char::from(Paper::TRACKER), char::from(Robust::TRACKER));
    ensure!(begin.tracker == Robust::TRACKER, "tracker {}: expected {} or {}", begin.tracker, expected.0, expected.1);
    Ok((run::<Robust>(begin, robust::Config::robust(), |config, table| config.table = table)?, "robust"))
}

/// Tables other than the paper's. A configuration borrows its table for the life of the program.
static TABLES: LazyLock<Vec<Table>> =
    LazyLock::new(|| Table::SCALES.filter_map(|scale| Table::new(scale).ok()).collect());

/// `rest`: the settings that a record does not have, except the table.
fn run<'a, T: Recorded<Config: 'a> + 'a>(
    begin: &Begin<'_>,
    mut rest: T::Config,
    set: fn(&mut T::Config, &'static Table),
) -> Result<Box<dyn Runs<'a> + 'a>> {
    let mut with = |table| {
        set(&mut rest, table);
        begin.config(&rest)
    };
    let config = with(&Table::PAPER).or_else(|| TABLES.iter().find_map(with));
    let config =
        config.context("it holds no configuration of this version, or its table is none of exp(-d / scale)")?;
    Ok(Box::new(Run::<T> { tracker: Box::new(Tracker::with(config)?), player: Player::new(config) }))
}

impl<'a, T: Recorded> Runs<'a> for Run<'a, T> {
    fn play(&mut self, entry: &Entry<'a>) -> (bool, Result<(), record::Difference>) {
        let gave_up = self.player.window().is_some() && !matches!(entry, Entry::Answer(_));
        (gave_up, self.player.play(&mut self.tracker, entry, |tracker, frame| tracker.update(frame)))
    }

    fn settings(&self) -> Value {
        let config = self.tracker.config();
        let values = T::Config::SETTINGS.iter().map(|setting| {
            let values = config.get(setting.name()).unwrap_or_default();
            (setting.name().to_owned(), json!(values[..setting.shape.count()]))
        });
        Value::Object(values.collect())
    }

    fn unanswered(&mut self) -> Option<(&'static str, String)> {
        let answer = self.tracker.update(self.player.window()?).ok()?;
        Some((name_of(answer.state), described(answer.fine)))
    }
}

/// The name of the value that differs, as recorded and as replayed.
/// Errors: The record itself is wrong.
fn named(difference: record::Difference) -> Result<Option<(&'static str, [String; 2])>> {
    use record::Difference as Is;
    let rect = |Rect { x, y, width, height }: Rect| format!("{width}x{height} at ({x}, {y})");
    let window = |window: Option<Rect>| window.map_or("none".to_owned(), rect);
    Ok(Some(match difference {
        Is::LockWindow(recorded, replayed) => ("lock window", [rect(recorded), rect(replayed)]),
        Is::Lock(error) => ("lock", ["locked".into(), error.to_string()]),
        Is::Window(recorded, replayed) => ("window", [window(recorded), window(replayed)]),
        Is::SweepWindow(recorded, replayed) => ("sweep window", [window(recorded), window(replayed)]),
        Is::Answer(recorded, replayed) => {
            let pairs = values(&recorded).into_iter().zip(values(&replayed));
            let mut differing = pairs.filter(|((_, recorded), (_, replayed))| recorded != replayed);
            let ((field, recorded), (_, replayed)) = differing.next().context("an answer has no other values")?;
            (field, [recorded, replayed])
        }
        Is::Restored(error) => ("restored target", ["restored".into(), error.to_string()]),
        other => return Err(other.into()),
    }))
}

/// Every value of an answer, by the name that people read.
pub fn values(answer: &Answer) -> [(&'static str, String); 8] {
    let number = |number: Option<u16>| number.map_or("none".to_owned(), |number| number.to_string());
    [
        ("box in 1/256 pixel", described(answer.fine)),
        ("state", name_of(answer.state).to_owned()),
        ("confidence", answer.confidence.to_string()),
        ("ratio", answer.ratio.to_string()),
        ("runner-up's ratio", number(answer.runner_up_ratio)),
        ("alpha", number(answer.alpha)),
        ("scale", answer.scale.to_string()),
        ("whether it was found again", answer.found_again.to_string()),
    ]
}

fn described(FineRect { x, y, width, height }: FineRect) -> String {
    format!("{width}x{height} at ({x}, {y})")
}

/// Reads the bytes of a record from `source`, which holds them raw or as lines of a log.
fn bytes_of(mut source: impl Read) -> io::Result<Vec<u8>> {
    let has = |bytes: &[u8], part: &[u8]| bytes.windows(part.len()).any(|found| found == part);
    let mut bytes = Vec::new();
    source.by_ref().take(MOST_BEFORE << 20).read_to_end(&mut bytes)?;
    if !bytes.starts_with(b"SMR") && has(&bytes[..bytes.len().min(FIRST)], LOGGED) {
        let mut lines = BufReader::new(Cursor::new(bytes).chain(source));
        let (mut record, mut line) = (Vec::new(), Vec::new());
        // A line without an end is not a log.
        while lines.by_ref().take(LINE).read_until(b'\n', &mut line)? > 0 {
            record.extend(bytes_in(&line));
            line.clear();
        }
        return Ok(record);
    }
    if has(&bytes, &Tag::Begin.bytes()) {
        source.read_to_end(&mut bytes)?;
    } else if bytes.len() as u64 == MOST_BEFORE << 20 {
        let words = format!("no entry SMRB in its first {MOST_BEFORE} MiB: expected a flight record");
        return Err(io::Error::new(io::ErrorKind::InvalidData, words));
    }
    Ok(bytes)
}

/// Parses the bytes in a line like `smr-record [53, 4d]`, anywhere in the line, up to the first word that is no byte: a log can be cut off within
/// a line.
fn bytes_in(line: &[u8]) -> Vec<u8> {
    let Some(start) = line.windows(LOGGED.len()).position(|part| part == LOGGED) else { return Vec::new() };
    let text = String::from_utf8_lossy(&line[start + LOGGED.len()..]);
    let numbers = text.split(']').next().unwrap_or_default().split(", ");
    numbers.map_while(|number| (number.len() == 2).then(|| u8::from_str_radix(number, 16).ok())?).collect()
}
