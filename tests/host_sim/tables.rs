//! What the commands that measure print as JSON and CSV goes into a data frame as it is: flat rows, equal columns, one type a column.

use crate::program::{host_sim, utf8};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;

/// A data frame has one of these types for a column. Whole numbers may stand among others where there are none at all.
fn kind(value: &Value) -> Option<&'static str> {
    match value {
        Value::Null => None,
        Value::Bool(_) => Some("bool"),
        Value::String(_) => Some("text"),
        Value::Number(number) if number.is_f64() => Some("number"),
        Value::Number(_) => Some("whole number"),
        Value::Array(_) | Value::Object(_) => Some("nested"),
    }
}

/// Rows have the same keys, and a key the same type in all rows.
fn is_flat(case: &str, rows: &[Value]) {
    let mut kinds = BTreeMap::new();
    let keys: Vec<&String> = rows[0].as_object().unwrap().keys().collect();
    for row in rows {
        assert_eq!(row.as_object().unwrap().keys().collect::<Vec<_>>(), keys, "{case}");
        for (key, value) in row.as_object().unwrap() {
            let Some(kind) = kind(value) else { continue };
            assert_ne!(kind, "nested", "{case}: {key}: {value}");
            assert_eq!(*kinds.entry(key.clone()).or_insert(kind), kind, "{case}: {key}: {value}");
        }
    }
}

/// The cells of CSV, in which a cell may be quoted, but has no line end.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '"' if quoted && characters.peek() == Some(&'"') => cells.last_mut().unwrap().extend(characters.next()),
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            other => cells.last_mut().unwrap().push(other),
        }
    }
    cells
}

fn as_cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// `csv` has the columns and the values of `rows`; without `varying`, which differ from run to run.
fn is_equal(case: &str, rows: &[Value], csv: &str, varying: &str) {
    let mut lines = csv.lines().map(cells);
    let header = lines.next().unwrap();
    let lines: Vec<Vec<String>> = lines.collect();
    assert_eq!(lines.len(), rows.len(), "{case}");
    for (row, line) in rows.iter().zip(lines) {
        assert_eq!((row.as_object().unwrap().len(), line.len()), (header.len(), header.len()), "{case}");
        for (column, cell) in header.iter().zip(&line).filter(|(column, _)| *column != varying) {
            assert_eq!(as_cell(&row[column]), *cell, "{case}: {column}");
        }
    }
}

/// All tables of a command; `expected` are their names with the numbers of their rows.
#[track_caller]
fn check(arguments: &[&str], expected: &[(&str, usize)]) {
    let tables = host_sim(&[arguments, &["--json"]].concat()).json();
    are_flat(&arguments.join(" "), &tables, expected);
    for (name, rows) in tables.as_object().unwrap().iter().filter(|(_, rows)| rows[0].is_object()) {
        let case = format!("{}: {name}", arguments.join(" "));
        let said = host_sim(&[arguments, &["--format", "csv", "--part", name]].concat());
        assert_eq!(said.code, Some(0), "{case}: {}", said.err);
        is_equal(&case, rows.as_array().unwrap(), &said.out, "microseconds_per_frame");
    }
}

/// The tables that a command printed as JSON; `expected` are their names with the numbers of their rows.
#[track_caller]
pub fn are_flat(case: &str, tables: &Value, expected: &[(&str, usize)]) {
    let sizes: BTreeMap<&str, usize> = tables
        .as_object()
        .unwrap()
        .iter()
        .map(|(name, rows)| (name.as_str(), rows.as_array().unwrap().len()))
        .collect();
    assert_eq!(sizes, expected.iter().copied().collect(), "{case}");
    for (name, rows) in tables.as_object().unwrap().iter().filter(|(_, rows)| rows[0].is_object()) {
        is_flat(&format!("{case}: {name}"), rows.as_array().unwrap());
    }
}

#[test]
fn every_table_is_flat_and_the_same_as_csv() {
    let folder = tempfile::tempdir().unwrap();
    // One has the name of a recording of the paper's table, and another tracker's results beside it.
    for name in ["a", "06_car"] {
        let recording = folder.path().join(name);
        assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&recording), "--frames", "..32"]).code, Some(0));
    }
    let other = folder.path().join("06_car/trackers");
    fs::create_dir(&other).unwrap();
    fs::copy(folder.path().join("06_car/gt.txt"), other.join("other, \"quoted\".txt")).unwrap();
    let recordings = utf8(folder.path());
    check(
        &["eval", recordings, "--method", "smr,robust,sad", "--window", "9x8", "--compare"],
        &[("measured", 7), ("means", 3), ("printed", 5)],
    );
    let robustness = ["eval", recordings, "--robustness", "--method", "robust,sad", "--starts-every", "30"];
    check(&robustness, &[("measured", 4), ("starts", 8), ("means", 2), ("paired", 1)]);
    let fault = ["eval", "synthetic", "--frames", "..90", "--fault", "black:3,gap:5", "--without", "size"];
    check(&fault, &[("measured", 6)]);
    // Its tables are looked at where the test of `--covered` runs it, because a run takes seconds.
    host_sim(&["eval", "--covered", "--format", "csv", "--part", "starts"]).refuses(&["one of measured, means"]);
}
