//! Replays a flight record (frames and answers that firmware wrote) through smr-core, and reports the first difference.

use anyhow::{Context, Error, Result, anyhow, ensure};
use serde::Serialize;
use serde_json::{Value, json};
use smr_core::record::{self, Begin, Entry, Flaw, Player, Recorded, Tag, entries};
use smr_core::robust::Small;
use smr_core::similarity::Table;
use smr_core::{Answer, FineRect, Rect, Robust, Settings, State, Tracker, paper, robust};
use smr_evaluation::{Paper, name_of};
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::sync::LazyLock;

/// Largest offset of a record in its file, in MiB.
const MAX_OFFSET_MIB: u64 = 64;
/// Largest offset of a record's first line in a text log, in bytes.
const MAX_LOG_OFFSET: usize = 1 << 20;
const MAX_LINE_BYTES: u64 = 256 << 20;
/// Prefix of the record's bytes in a line of a text log.
const LOG_PREFIX: &[u8] = b"smr-record [";

#[derive(Clone, Debug, Default, Serialize)]
pub struct ReplayedRecord {
    /// One flight for each start of the firmware, which appends to the same record.
    pub flights: Vec<Flight>,
    /// Size of an incomplete last entry in bytes, where the record was cut off; else 0.
    pub cut_off: usize,
    /// Message about the damage at which the replay stopped.
    pub damage: Option<String>,
    /// First difference between recorded and replayed values; the replay stops there.
    pub difference: Option<Difference>,
}

/// Part of a record from one start of the firmware to the next.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Flight {
    /// Name of the tracker: `paper` or `robust`.
    pub method: &'static str,
    /// Number of locks, and number of answers, that equal the recorded ones.
    pub locks: u64,
    pub answers: u64,
    /// Number of camera turns that firmware reported, and number of saved targets that it restored.
    pub moved: u64,
    pub restored: u64,
    /// Updates that firmware began and cancelled.
    pub given_up: u64,
    /// Number of answers that equal the recorded ones, by state: the index is the state's code.
    pub states: [u64; State::ALL.len()],
    /// Size of the replayed entries in bytes, and number of pixels in these entries.
    pub bytes: u64,
    pub pixels: u64,
    /// Size of an incomplete entry at the flight's end in bytes; else 0.
    pub cut_off: usize,
    /// ReplayedRecord answer to the last update, if the record has none.
    pub unanswered: Option<Unanswered>,
    /// Tracker settings by name, each a list of values; null unless requested.
    pub settings: Value,
    /// Entries in record order, in the record's units and without pixels; empty unless requested.
    pub entries: Vec<Value>,
}

/// ReplayedRecord answer to an update that has no answer in the record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unanswered {
    pub frame: u64,
    pub state: &'static str,
    #[serde(rename = "box")]
    pub bbox: String,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// Flight number, counted from 1.
    pub flight: usize,
    /// Frame number in the flight, counted from 1. Every lock and every answer is one frame.
    pub frame: u64,
    /// Index of the entry in the flight, from 0.
    pub entry: u32,
    pub field: &'static str,
    pub recorded: String,
    pub replayed: String,
}

/// Replays the record up to the first difference, and calls `progress` for each entry; `every` adds settings and
/// entries to the report. Errors: The file is no record, or cannot be read. Later damage is in [`ReplayedRecord::damage`].
pub fn replay(source: impl Read, every: bool, progress: impl Fn()) -> Result<ReplayedRecord> {
    let record = bytes_of(source).context("cannot read the record")?;
    let mut report = ReplayedRecord::default();
    let mut running: Option<Box<dyn FlightReplay<'_> + '_>> = None;
    let mut all = entries(&record);
    while let Some(found) = all.next() {
        progress();
        let found = match found {
            Ok(found) => found,
            Err(damage) => {
                let begins = !report.flights.is_empty() || !matches!(damage.flaw, Flaw::NoEntry(_) | Flaw::Missing(_));
                ensure!(
                    begins || !record.starts_with(&Tag::Begin.bytes()),
                    "its first entry, SMRB, is damaged: nothing can be replayed"
                );
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

fn end(run: Option<Box<dyn FlightReplay<'_> + '_>>, report: &mut ReplayedRecord, cut_off: usize) {
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
                self.pixels += u64::from(window.area()) + u64::from(sweep.unwrap_or_default().area());
            }
            Entry::Answer(answer) => {
                self.answers += u64::from(alike);
                self.states[usize::from(answer.state.code())] += u64::from(alike);
            }
            Entry::Restored(_) => self.restored += 1,
        }
        if every {
            self.entries.push(entry_json(&found.entry));
        }
    }
}

/// Converts an entry to JSON; a box is an array of left, top, width, height.
fn entry_json(entry: &Entry<'_>) -> Value {
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
                "identity": answer.identity,
                "scale": answer.scale,
                "found_again": answer.found_again,
            })
        }
        Entry::Restored(saved) => json!({ "restored": saved.len() }),
    }
}

trait FlightReplay<'a> {
    /// Replays an entry. Returns true if it cancels an update. Errors: The replay differs, or the record is invalid.
    fn play(&mut self, entry: &Entry<'a>) -> (bool, Result<(), record::Difference>);

    fn settings(&self) -> Value;

    /// Returns state and box of the replayed answer to the last update, if the flight ends before that answer.
    fn unanswered(&mut self) -> Option<(&'static str, String)>;
}

struct Run<'a, T: Recorded> {
    tracker: Box<Tracker<T>>,
    player: Player<'a, T>,
}

/// Creates the replay of the tracker that the entry `begin` describes. Returns it with the tracker's name.
fn begin<'a>(begin: &Begin<'_>) -> Result<(Box<dyn FlightReplay<'a> + 'a>, &'static str)> {
    if begin.tracker == Paper::TRACKER {
        return Ok((run::<Paper>(begin, paper::Config::paper(), |config, table| config.table = table)?, "paper"));
    }
    let (standard, small) = (<Robust>::TRACKER, Robust::<Small>::TRACKER);
    let expected = [Paper::TRACKER, standard, small].map(char::from);
    let is_known = begin.tracker == standard || begin.tracker == small;
    ensure!(is_known, "tracker {}: expected {}, {} or {}", begin.tracker, expected[0], expected[1], expected[2]);
    let (rest, set) = (robust::Config::robust(), |config: &mut robust::Config, table| config.table = table);
    let run =
        if begin.tracker == small { run::<Robust<Small>>(begin, rest, set) } else { run::<Robust>(begin, rest, set) };
    Ok((run?, "robust"))
}

/// Similarity tables of all scales; static, because a configuration borrows its table for the life of the program.
static TABLES: LazyLock<Vec<Table>> =
    LazyLock::new(|| Table::SCALES.filter_map(|scale| Table::new(scale).ok()).collect());

/// Creates the replay with the recorded settings and similarity table. `rest` gives the settings that no record has.
fn run<'a, T: Recorded<Config: 'a> + 'a>(
    begin: &Begin<'_>,
    mut rest: T::Config,
    set: fn(&mut T::Config, &'static Table),
) -> Result<Box<dyn FlightReplay<'a> + 'a>> {
    let mut with = |table| {
        set(&mut rest, table);
        begin.config(&rest)
    };
    let config = with(&Table::PAPER).or_else(|| TABLES.iter().find_map(with));
    let config =
        config.context("its configuration is of another version, or its similarity table is not exp(-d / scale)")?;
    Ok(Box::new(Run::<T> { tracker: Box::new(Tracker::with(config)?), player: Player::new(config) }))
}

impl<'a, T: Recorded> FlightReplay<'a> for Run<'a, T> {
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

/// Returns the name of the value that differs, and its recorded and replayed text.
/// Errors: The record itself is invalid.
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

/// Values of an answer as text, each with its name in messages.
pub fn values(answer: &Answer) -> [(&'static str, String); 9] {
    let number = |number: Option<u16>| number.map_or("none".to_owned(), |number| number.to_string());
    [
        ("box in 1/256 pixel", described(answer.fine)),
        ("state", name_of(answer.state).to_owned()),
        ("confidence", answer.confidence.to_string()),
        ("ratio", answer.ratio.to_string()),
        ("runner-up's ratio", number(answer.runner_up_ratio)),
        ("alpha", number(answer.alpha)),
        ("identity", number(answer.identity)),
        ("scale", answer.scale.to_string()),
        ("whether it was found again", answer.found_again.to_string()),
    ]
}

fn described(FineRect { x, y, width, height }: FineRect) -> String {
    format!("{width}x{height} at ({x}, {y})")
}

/// Reads a record from `source`, which contains its raw bytes or a text log with lines of bytes.
fn bytes_of(mut source: impl Read) -> io::Result<Vec<u8>> {
    let has = |bytes: &[u8], part: &[u8]| bytes.windows(part.len()).any(|found| found == part);
    let mut bytes = Vec::new();
    source.by_ref().take(MAX_OFFSET_MIB << 20).read_to_end(&mut bytes)?;
    if !bytes.starts_with(b"SMR") && has(&bytes[..bytes.len().min(MAX_LOG_OFFSET)], LOG_PREFIX) {
        let mut lines = BufReader::new(Cursor::new(bytes).chain(source));
        let (mut record, mut line) = (Vec::new(), Vec::new());
        // The limit bounds the memory for input without line ends.
        while lines.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', &mut line)? > 0 {
            record.extend(bytes_in(&line));
            line.clear();
        }
        return Ok(record);
    }
    if has(&bytes, &Tag::Begin.bytes()) {
        source.read_to_end(&mut bytes)?;
    } else if bytes.len() as u64 == MAX_OFFSET_MIB << 20 {
        let words = format!("no entry SMRB in its first {MAX_OFFSET_MIB} MiB: expected a flight record");
        return Err(io::Error::new(io::ErrorKind::InvalidData, words));
    }
    Ok(bytes)
}

/// Parses the bytes of a line like `smr-record [53, 4d]`, up to the first invalid byte, because a log can be cut off.
fn bytes_in(line: &[u8]) -> Vec<u8> {
    let Some(start) = line.windows(LOG_PREFIX.len()).position(|part| part == LOG_PREFIX) else { return Vec::new() };
    let text = String::from_utf8_lossy(&line[start + LOG_PREFIX.len()..]);
    let numbers = text.split(']').next().unwrap_or_default().split(", ");
    numbers.map_while(|number| (number.len() == 2).then(|| u8::from_str_radix(number, 16).ok())?).collect()
}
