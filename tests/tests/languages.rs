//! Checks that the interface of every language, and `host-sim`, have all states and all answer fields of smr-core.
//! `core/c/tests/interface/errors.rs` checks the errors, `tests/api` the settings.

use std::fs;
use std::path::Path;

const CORE: &str = include_str!("../api/smr-core.txt");
const HEADER: &str = "core/c/include/smr.h";
const TYPES: &str = "core/web/smr.d.ts";
const MODULE: &str = "core/micropython/smr/smr.c";

/// Each list of answer fields or states in a file: kind, language, file, text before the list, text after it.
const PLACES: &[(&str, &str, &str, &str, &str)] = &[
    ("answer", "C", HEADER, "struct smr_answer {", "\n}"),
    ("answer", "Python", "core/python/package/smr/_answer.py", "class Answer(", "\nclass"),
    ("answer", "JavaScript", "core/web/smr.js", "  #answerOf({", "\n  }"),
    ("answer", "JavaScript", TYPES, "interface Answer {", "\n}"),
    ("answer", "MicroPython", MODULE, "mp_obj_t answer_of(", "\n}"),
    ("answer", "host-sim", "host-sim/pages/src/export/boxes.rs", "struct JsonLine<'a> {", "\n}"),
    ("state", "C", HEADER, "\nenum smr_state\n", "\n}"),
    ("state", "Python", "core/python/package/smr/_answer.py", "class State(", "\n\n\n"),
    ("state", "JavaScript", "core/web/smr.js", "const State = ", "}"),
    ("state", "JavaScript", TYPES, "const State: {", "\n}"),
    ("state", "MicroPython", MODULE, "#define STATES(STATE)", "\n"),
    ("state", "host-sim", "core/src/track/answer.rs", "pub const fn name(self)", "\n    }"),
];

fn spelled(what: &str, language: &str, name: &str) -> String {
    let told = match (name, language) {
        ("bbox" | "fine", "C") | ("fine", "host-sim") => name,
        ("bbox", _) => "box",
        ("fine", _) => "fine_box",
        _ => name,
    };
    match (what, language) {
        ("state", "C") => format!("SMR_{}", told.to_uppercase()),
        ("answer", "MicroPython") => format!("MP_QSTR_{told}"),
        ("state", "host-sim") => told.to_lowercase(),
        ("state", _) => told.to_uppercase(),
        (_, "JavaScript") => {
            let mut words = told.split('_');
            let first = words.next().unwrap_or_default().to_owned();
            words.fold(first, |all, word| all + &word[..1].to_uppercase() + &word[1..])
        }
        _ => told.to_owned(),
    }
}

/// Returns true if `word` is in `text` between `before` and `end`, outside of comments.
fn has(text: &str, before: &str, end: &str, word: &str) -> bool {
    let is_name = |letter: char| letter.is_alphanumeric() || letter == '_';
    let (_, after) = text.split_once(before).unwrap_or_else(|| panic!("no {before}"));
    let part = after.split(end).next().unwrap_or(after);
    let lines = part.split("\"\"\"").step_by(2).flat_map(str::lines);
    let mut code = lines.filter(|line| !line.trim_start().starts_with(['/', '*']));
    code.any(|line| line.split(|letter| !is_name(letter)).any(|found| found == word))
}

/// Returns a message for each answer field or state that a language lacks. `read` returns the text of a file.
fn lacking(read: impl Fn(&str) -> String) -> Vec<String> {
    let mut lacking = Vec::new();
    for (what, language, file, before, end) in PLACES {
        let (text, path) =
            (read(file), if *what == "state" { "pub smr_core::State::" } else { "pub smr_core::Answer::" });
        let names = CORE.lines().filter_map(|line| line.strip_prefix(path)?.split([':', ' ']).next());
        for name in names.map(|name| spelled(what, language, name)) {
            if !has(&text, before, end, &name) {
                lacking.push(format!("{language} lacks {name} of {what}: {file}"));
            }
        }
    }
    lacking
}

fn read(file: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

#[test]
fn every_language_has_what_smr_core_has() {
    assert_eq!(lacking(read), [""; 0]);
    let without = |line: &str| lacking(|file| read(file).replace(line, ""));
    assert_eq!(without("  SMR_UNCERTAIN = 2,\n"), [format!("C lacks SMR_UNCERTAIN of state: {HEADER}")]);
    assert_eq!(without("  fineBox: Rect;\n"), [format!("JavaScript lacks fineBox of answer: {TYPES}")]);
}
