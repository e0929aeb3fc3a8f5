//! Checks that the figures (numbers) in documents equal those of measurements, code and scripts.
//! `SMR_RECORD=1 cargo test -p smr-tests --test crates figures` writes them into the documents.
//!
//! A figure in a sentence stands between `<!--=NAME-->` and `<!---->`. The name is that of a figure of
//! `tests/results/FILE.json` (`FILE/FIGURE`), of `tests/budgets.txt` (`budgets/...`), of a bound of work (`work/...`) or
//! of a limit in a script (`limits/...`); a unit may follow, such as `M.2` for millions with two decimals. The rows of a
//! table are those of `tests/results/FILE.json` if `<!-- results: FILE/ROWS -->` stands before its head.

#![allow(clippy::cast_precision_loss, reason = "bounds of work are far below 2^53")]

use super::root;
use serde_json::Value;
use smr_core::robust::Config;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

const DOCUMENTS: [&str; 15] = [
    "README.md",
    "core/README.md",
    "core/EVIDENCE.md",
    "core/SAFETY.md",
    "core/c/README.md",
    "core/c/packages/README.md",
    "core/examples/pico-pursuit/README.md",
    "core/micropython/README.md",
    "core/python/README.md",
    "core/src/image/readout.rs",
    "host-sim/FAULTS.md",
    "host-sim/README.md",
    "host-sim/RESULTS.md",
    "tests/chip/README.md",
    "tests/chip/cycles/README.md",
];

/// Before the name of a figure, and after the name; after the figure.
const MARK: [&str; 3] = ["<!--=", "-->", "<!---->"];
/// Before and after the name of the rows of a table.
const TABLE: [&str; 2] = ["<!-- results: ", " -->"];

/// All that documents can state, by name.
struct Known {
    numbers: BTreeMap<String, f64>,
    texts: BTreeMap<String, String>,
    tables: BTreeMap<String, Vec<String>>,
}

/// Returns the files of `tests/results`, by their names without the ending.
fn results() -> BTreeMap<String, Value> {
    let files = fs::read_dir(root().join("tests/results")).unwrap().map(|entry| entry.unwrap().path());
    let json = files.filter(|path| path.extension().is_some_and(|ending| ending == "json"));
    let read = |path: &Path| serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    json.map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), read(&path))).collect()
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_else(|| panic!("expected a text, not {value}")).to_owned()
}

fn known() -> Known {
    let (mut texts, mut tables) = (BTreeMap::new(), BTreeMap::new());
    for (file, result) in results() {
        for (name, figure) in result["figures"].as_object().unwrap() {
            texts.insert(format!("{file}/{name}"), text(figure));
        }
        for (name, rows) in result["rows"].as_object().unwrap() {
            tables.insert(format!("{file}/{name}"), rows.as_array().unwrap().iter().map(text).collect());
        }
    }
    Known { numbers: numbers(), texts, tables }
}

fn numbers() -> BTreeMap<String, f64> {
    // `.ci/firmware --record` writes the budgets.
    let budgets = include_str!("../../budgets.txt").lines().filter(|line| !line.starts_with('#'));
    let budgets = budgets.filter_map(|line| line.rsplit_once(' '));
    let mut numbers: BTreeMap<String, f64> =
        budgets.map(|(name, value)| (format!("budgets/{name}"), value.parse().unwrap())).collect();
    for (name, config) in [("robust", Config::robust()), ("refined", Config::refined())] {
        let mut followed = config;
        followed.sweep = 0;
        numbers.insert(format!("work/{name} followed"), followed.most_work().update as f64);
        numbers.insert(format!("work/{name} lost"), config.most_work().update as f64);
        numbers.insert(format!("work/{name} lock"), config.most_work().lock as f64);
        numbers.insert(format!("work/{name} step"), config.most_work().beyond_a_step as f64);
    }
    numbers.extend(limits());
    numbers
}

/// Returns the limits of `.ci/c` in bytes: of the stack of each tracker, and of the flash of more and more of its calls.
fn limits() -> BTreeMap<String, f64> {
    let script = include_str!("../../../.ci/c");
    let mut limits = BTreeMap::new();
    for (name, beginning) in [
        ("paper", "one_tracker paper "),
        ("robust", "one_tracker robust "),
        ("refined", "one_tracker refined "),
        ("init", "deepest \"$name\" "),
    ] {
        let line = script.lines().find_map(|line| line.trim_start().strip_prefix(beginning)).expect("a line");
        let mut numbers = line.split([' ', '\'']).filter_map(|word| word.parse::<u32>().ok()).map(f64::from);
        limits.insert(format!("limits/stack {name}"), numbers.next().expect("a limit"));
        let flash = (1..).zip(numbers).map(|(calls, limit)| (format!("limits/flash {name} {calls}"), limit));
        limits.extend(flash);
    }
    limits
}

/// Writes a number with the unit after its name: none (a whole number), `,` (with commas), or `M.2` (millions with two
/// decimals), also `K` (thousands) and `C` (hundreds).
fn written(number: f64, unit: &str) -> String {
    let (scale, decimals) = match unit.split_once('.') {
        Some(("M", decimals)) => (1e6, decimals),
        Some(("K", decimals)) => (1e3, decimals),
        Some(("C", decimals)) => (1e2, decimals),
        _ => (1.0, "0"),
    };
    let mut text = format!("{:.*}", decimals.parse().expect("decimals"), number / scale);
    if unit == "," {
        for at in (1..text.len()).rev().filter(|at| (text.len() - at).is_multiple_of(3)).collect::<Vec<_>>() {
            text.insert(at, ',');
        }
    }
    text
}

impl Known {
    /// Returns the figure of a name with or without a unit.
    fn figure(&self, name: &str) -> Option<String> {
        let number = || {
            let (name, unit) = name.rsplit_once(' ')?;
            Some(written(*self.numbers.get(name)?, unit))
        };
        let whole = || self.numbers.get(name).map(|number| written(*number, ""));
        self.texts.get(name).cloned().or_else(whole).or_else(number)
    }

    /// Returns a document with the right figures and rows. Adds the names that it has to `used`.
    fn filled(&self, document: &str, text: &str, used: &mut BTreeSet<String>) -> String {
        let with_figures = self.with_figures(document, text, used);
        let mut filled = String::new();
        let mut lines = with_figures.split_inclusive('\n').peekable();
        while let Some(line) = lines.next() {
            filled.push_str(line);
            let name = line.trim_end().split_once(TABLE[0]).and_then(|(_, rest)| rest.strip_suffix(TABLE[1]));
            let Some(name) = name else { continue };
            used.insert(name.to_owned());
            let rows = self.tables.get(name).unwrap_or_else(|| panic!("{document}: tests/results has no rows {name}"));
            let begin = line.split_once(TABLE[0]).unwrap().0;
            filled.extend(lines.by_ref().take(1).filter(|line| line.trim_end() == begin.trim_end()));
            filled.extend(lines.by_ref().take(2));
            while lines.next_if(|line| line.starts_with(&format!("{begin}|"))).is_some() {}
            filled.extend(rows.iter().map(|row| format!("{begin}| {row} |\n")));
        }
        filled
    }

    fn with_figures(&self, document: &str, text: &str, used: &mut BTreeSet<String>) -> String {
        let [before, after, end] = MARK;
        let mut parts = text.split(before);
        let mut filled = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (name, rest) = part.split_once(after).expect("a mark ends");
            let (_, rest) = rest.split_once(end).unwrap_or_else(|| panic!("{document}: {name}: no {end} follows"));
            used.insert(name.to_owned());
            let figure = self.figure(name).unwrap_or_else(|| panic!("{document}: there is no figure {name}"));
            filled.push_str(&[before, name, after, &figure, end, rest].concat());
        }
        filled
    }
}

#[test]
fn figures_of_documents_are_those_measured() {
    let (known, mut used) = (known(), BTreeSet::new());
    for name in DOCUMENTS {
        let path = root().join(name);
        let text = fs::read_to_string(&path).unwrap();
        let right = known.filled(name, &text, &mut used);
        if std::env::var_os("SMR_RECORD").is_some() {
            fs::write(&path, &right).unwrap();
            continue;
        }
        for (is, should) in text.lines().zip(right.lines()) {
            assert_eq!(is, should, "{name}: SMR_RECORD=1 cargo test -p smr-tests --test crates figures writes it");
        }
        assert_eq!(text.len(), right.len(), "{name} has other rows than tests/results");
    }
    let mut unused = known.tables.keys().filter(|name| !used.contains(*name));
    assert_eq!(unused.next(), None, "no document has these rows");
}

/// Returns the first digits of the recorded hashes of these trackers, as `tests/results/measure` does.
fn answers(trackers: &[Value]) -> String {
    let trackers: Vec<String> = trackers.iter().map(text).collect();
    let lines = include_str!("../../kit/answers.txt").lines();
    let is_of = |line: &&str| line.split_whitespace().nth(1).is_some_and(|word| trackers.iter().any(|own| own == word));
    lines.filter(is_of).map(|line| &line[..4]).collect::<Vec<_>>().concat()
}

#[test]
fn figures_are_of_the_present_trackers() {
    let old: Vec<String> = results()
        .into_iter()
        .filter(|(_, result)| result["answers"] != answers(result["trackers"].as_array().unwrap()))
        .map(|(table, _)| table)
        .collect();
    assert!(
        old.is_empty(),
        "the trackers answer otherwise than when these tables were measured: tests/results/measure {}",
        old.join(" ")
    );
}

/// The header for C is made from comments of Rust, which have no marks.
#[test]
fn the_header_states_the_bounds_of_work() {
    let millions = |config: Config, sweep| {
        let mut config = config;
        config.sweep = sweep;
        written(config.most_work().update as f64, "M.1")
    };
    let [many, once] = [4, 1].map(|sweep| [Config::robust(), Config::refined()].map(|config| millions(config, sweep)));
    let words = format!(
        "at most {} million units ({} with the refiner), or {} ({}) with a `sweep` of 1",
        many[0], many[1], once[0], once[1]
    );
    let header = fs::read_to_string(root().join("core/c/include/smr.h")).unwrap().replace("\n *", "");
    let header = header.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(header.contains(&words), "smr.h: expected: {words}");
}

/// Each table of results has its command, and a table with figures is a table of results.
#[test]
fn figures_in_tables_come_from_results() {
    for name in ["host-sim/RESULTS.md", "host-sim/FAULTS.md"] {
        let text = fs::read_to_string(root().join(name)).unwrap();
        let blocks: Vec<&str> = text.split("\n\n").collect();
        for pair in blocks.windows(2).filter(|pair| pair[1].starts_with('|')) {
            let is_result = pair[0].starts_with(TABLE[0]) || pair[1].contains(MARK[0]);
            let figures = pair[1].lines().skip(2).flat_map(str::chars).filter(char::is_ascii_digit).count();
            assert!(is_result || figures < 30, "{name}: a table without {}:\n{}", TABLE[0], pair[1]);
        }
    }
}

#[test]
fn figures_and_rows_are_found_and_written() {
    let known = Known {
        numbers: [("work/step".to_owned(), 128_000.0)].into(),
        texts: [("a/b".to_owned(), "0.5".to_owned())].into(),
        tables: [("a/all".to_owned(), vec!["x | 2".to_owned(), "y | 3".to_owned()])].into(),
    };
    let text = "It is <!--=a/b-->1<!---->, at most <!--=work/step ,-->7<!----> (<!--=work/step M.1-->7<!---->).\n\n\
        <!-- results: a/all -->\n\n| | n |\n|---|---|\n| x | 1 |\nMore.\n";
    let right = "It is <!--=a/b-->0.5<!---->, at most <!--=work/step ,-->128,000<!----> (<!--=work/step M.1-->0.1<!---->).\n\n\
        <!-- results: a/all -->\n\n| | n |\n|---|---|\n| x | 2 |\n| y | 3 |\nMore.\n";
    assert_eq!(known.filled("a document", text, &mut BTreeSet::new()), right);
}
