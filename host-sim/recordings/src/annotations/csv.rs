//! CSV with column names, as `host-sim track`, spreadsheets, R and pandas write it: comma, semicolon or tab, quotes,
//! any order of columns, any case of their names. Columns without a meaning here are ignored.

use super::track::{Entry, Seen, Track, frame, line_of, number, shown};
use crate::annotations::start::checked_name;
use crate::bounding_box::BoundingBox;
use ::csv::{Reader, ReaderBuilder, StringRecord, Trim};
use anyhow::{Context, Result, bail, ensure};
use std::collections::HashMap;

const REQUIRED: [&str; 5] = ["frame", "x", "y", "width", "height"];
const OPTIONAL: [&str; 3] = ["target", "state", "confidence"];
/// States of `host-sim track`. In a frame in which the target is lost there is no box to lock on.
const STATES: [&str; 4] = ["tracking", "leaving", "uncertain", LOST];
const LOST: &str = "lost";

/// Parses CSV. Rows with a box become locks, except *lost* rows and trackers' answers (rows with a confidence): if
/// answers became locks, the one after a user's correction would replace the correction after a single frame. With a
/// column `state`, a target is gone in frames without a row for it.
pub(super) fn tracks(text: &str) -> Result<Vec<Track>> {
    let mut rows = Rows::new(text);
    let (at, names) = rows.next()?.context("it has no line with the names of columns")?;
    let columns = Columns::of(&names).with_context(|| line_of(text, at))?;
    let (mut all, mut places) = (Vec::new(), HashMap::new());
    while let Some((at, row)) = rows.next()? {
        let (name, entry) = columns.entry(at, &row).with_context(|| line_of(text, at))?;
        let place = *places.entry(name).or_insert_with_key(|name| {
            all.push(Track { name: name.clone(), entries: Vec::new(), is_line: false });
            all.len() - 1
        });
        all[place].entries.push(entry);
    }
    if columns.place("state").is_some() {
        let end = all.iter().flat_map(|track| &track.entries).map(|entry| entry.frame).max().unwrap_or(0);
        for track in &mut all {
            track.sort(text)?;
            track.add_gone(end);
        }
    }
    Ok(all)
}

impl Track {
    /// Adds an entry *gone* to each first frame of a gap between entries, and behind the last one up to frame `end`.
    fn add_gone(&mut self, end: usize) {
        let after = self.entries.iter().skip(1).map(|entry| entry.frame).chain([end + 1]);
        let gaps = self.entries.iter().zip(after).filter(|(entry, after)| entry.frame + 1 < *after);
        let gone: Vec<_> =
            gaps.map(|(entry, _)| Entry { frame: entry.frame + 1, at: entry.at, seen: Seen::Gone }).collect();
        self.entries.extend(gone);
    }
}

/// The rows of a text that are not empty, each with its position.
struct Rows<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    /// Position of the reader's first byte in the text.
    begin: usize,
}

impl<'a> Rows<'a> {
    fn new(text: &'a str) -> Self {
        // Excel writes the separator into a line of its own: `sep=;`.
        let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
        let told = first.trim_matches('"').strip_prefix("sep=").and_then(|of| of.bytes().find(u8::is_ascii));
        let begin = if told.is_some() { text.len() - rest.len() } else { 0 };
        let reader = |separator| {
            let mut builder = ReaderBuilder::new();
            builder.has_headers(false).flexible(true).trim(Trim::All).delimiter(separator);
            builder.from_reader(&text.as_bytes()[begin..])
        };
        let known = |separator: &u8| {
            let mut names = StringRecord::new();
            let read = reader(*separator).read_record(&mut names);
            let is_known = |name: &&str| REQUIRED.iter().chain(&OPTIONAL).any(|known| is_called(name, known));
            (read.is_ok(), names.iter().filter(is_known).count())
        };
        // Of equals, `max_by_key` takes the last.
        let separator = told.or_else(|| [b'\t', b';', b','].into_iter().max_by_key(known));
        Self { text, reader: reader(separator.unwrap_or(b',')), begin }
    }

    fn next(&mut self) -> Result<Option<(usize, StringRecord)>> {
        let mut row = StringRecord::new();
        loop {
            let begin = self.position();
            if !self.reader.read_record(&mut row)? {
                return Ok(None);
            }
            let raw = &self.text[begin..self.position()];
            let at = begin + raw.len() - raw.trim_start_matches('\n').len();
            // A quote without its partner would hide the rows up to the next quote.
            ensure!(
                raw.matches('"').count().is_multiple_of(2),
                "{}: a quote is missing: expected quotes in pairs",
                line_of(self.text, at)
            );
            if row.iter().any(|field| !field.is_empty()) {
                return Ok(Some((at, row)));
            }
        }
    }

    fn position(&self) -> usize {
        self.begin + usize::try_from(self.reader.position().byte()).unwrap_or(usize::MAX)
    }
}

fn is_called(name: &str, known: &str) -> bool {
    unquoted(name).eq_ignore_ascii_case(known)
}

/// Removes the quotes of a field that has blanks around them, which CSV takes for a part of the field.
fn unquoted(field: &str) -> &str {
    field.strip_prefix('"').and_then(|field| field.strip_suffix('"')).map_or(field, str::trim)
}

struct Columns {
    count: usize,
    /// Index of each column that is read.
    places: HashMap<&'static str, usize>,
}

impl Columns {
    fn of(names: &StringRecord) -> Result<Self> {
        let mut places = HashMap::new();
        for known in REQUIRED.iter().chain(&OPTIONAL) {
            let mut all = (0..).zip(names).filter(|(_, name)| is_called(name, known)).map(|(at, _)| at);
            places.extend(all.next().map(|at| (*known, at)));
            ensure!(all.next().is_none(), "there are two columns {known}: expected one");
        }
        if let Some(missing) = REQUIRED.iter().find(|name| !places.contains_key(*name)) {
            let found = names.iter().map(unquoted).collect::<Vec<_>>().join(", ");
            bail!(
                "there is no column {missing}: expected CSV with the columns frame, x, y, width and height (and target), CVAT XML, or JSON of Label Studio, found the columns {}",
                shown(&found)
            );
        }
        Ok(Self { count: names.len(), places })
    }

    fn place(&self, column: &str) -> Option<usize> {
        self.places.get(column).copied()
    }

    fn entry(&self, at: usize, row: &StringRecord) -> Result<(Option<String>, Entry)> {
        let (count, found) = (self.count, row.len());
        ensure!(count == found, "expected {count} fields as in the line of names, found {found}");
        let field = |column: &str| self.place(column).map(|place| unquoted(&row[place]));
        let of = |column: &'static str| (field(column).unwrap_or_default(), move || format!("column {column}"));
        let (text, column) = of("frame");
        let frame = frame(text, 1).with_context(column)? as usize;
        let name = field("target").map(checked_name).transpose().context("column target")?;
        let state = field("state");
        if let Some(state) = state.filter(|state| !STATES.contains(state)) {
            bail!("column state: expected one of {}, found {}", STATES.join(", "), shown(state));
        }
        let confidence = field("confidence").filter(|confidence| !confidence.is_empty());
        confidence.map(number).transpose().context("column confidence")?;
        let [_, sides @ ..] = REQUIRED;
        let is_empty = sides.iter().all(|side| field(side).is_some_and(str::is_empty));
        let bbox = if is_empty { None } else { Some(bbox(sides.map(of))?) };
        let has_box = state != Some(LOST) && confidence.is_none();
        let seen = bbox.filter(|_| has_box).map_or(Seen::Answer, Seen::Box);
        Ok((name, Entry { frame, at, seen }))
    }
}

fn bbox<C: FnOnce() -> String + Copy>(sides: [(&str, C); 4]) -> Result<BoundingBox> {
    let side = |at: usize| {
        let (text, column) = sides[at];
        let value = number(text).with_context(column)?;
        if at >= 2 && value <= 0.0 {
            bail!("{}: expected a number above 0, found {}", column(), shown(text));
        }
        Ok(value)
    };
    Ok(BoundingBox { x: side(0)?, y: side(1)?, width: side(2)?, height: side(3)? })
}
