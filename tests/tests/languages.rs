//! Every language has the settings of both trackers, the states and the answer of smr-core. `core/c/tests/interface/errors.rs` has
//! its errors.
//!
//! What is in `smr-core.txt` and not in the files of a language fails here by name, unless [`OTHERWISE`] has the reason.

use std::fs;
use std::path::Path;

const CORE: &str = include_str!("../api/smr-core.txt");
const HEADER: &str = "core/c/include/smr.h";
const STUBS: &str = "core/python/package/smr/_smr.pyi";
const TYPES: &str = "core/web/smr.d.ts";
const MODULE: &str = "core/micropython/smr/smr.c";
const OPTIONS: &str = "host-sim/src/command/tracker_options.rs";

/// Where a language names the settings of a tracker, the parts of the answer or the states: what it names, the language, the file, and what
/// stands before and after the names.
const PLACES: &[(&str, &str, &str, &[&str], &str)] = &[
    ("paper", "C", HEADER, &["struct smr_gate {", "struct smr_paper_config {", "struct smr_config {"], "\n}"),
    ("paper", "Python", "core/python/src/options.rs", &["options! { paper::Config"], "\n}"),
    ("paper", "Python", STUBS, &["class Paper("], ") ->"),
    ("paper", "JavaScript", "core/web/config.js", &["const CONFIG = ", "const PAPER = {"], "}"),
    ("paper", "JavaScript", TYPES, &["interface PaperOptions {"], "\n}"),
    ("paper", "MicroPython", MODULE, &["options[] = {", "smr_config config_of("], "\n}"),
    ("paper", "host-sim", OPTIONS, &["struct TrackerOptions {"], "\n}"),
    ("robust", "C", HEADER, &["struct smr_robust_config {", "struct smr_config {"], "\n}"),
    ("robust", "Python", "core/python/src/options.rs", &["options! { robust::Config"], "\n}"),
    ("robust", "Python", STUBS, &["class Robust("], ") ->"),
    ("robust", "JavaScript", "core/web/config.js", &["const CONFIG = ", "const ROBUST = {"], "}"),
    ("robust", "JavaScript", TYPES, &["interface RobustOptions {"], "\n}"),
    ("robust", "MicroPython", MODULE, &["options[] = {"], "\n}"),
    ("robust", "host-sim", OPTIONS, &["struct TrackerOptions {", "enum Part {"], "\n}"),
    ("answer", "C", HEADER, &["struct smr_answer {"], "\n}"),
    ("answer", "Python", "core/python/package/smr/_answer.py", &["class Answer("], "\nclass"),
    ("answer", "JavaScript", "core/web/smr.js", &["  #answerOf({"], "\n  }"),
    ("answer", "JavaScript", TYPES, &["interface Answer {"], "\n}"),
    ("answer", "MicroPython", MODULE, &["mp_obj_t answer_of("], "\n}"),
    ("answer", "host-sim", "host-sim/pages/src/export/boxes.rs", &["struct JsonLine<'a> {"], "\n}"),
    ("state", "C", HEADER, &["\nenum smr_state\n"], "\n}"),
    ("state", "Python", "core/python/package/smr/_answer.py", &["class State("], "\n\n\n"),
    ("state", "JavaScript", "core/web/smr.js", &["const State = "], "}"),
    ("state", "JavaScript", TYPES, &["const State: {"], "\n}"),
    ("state", "MicroPython", MODULE, &["#define NUMBERS(NUMBER)"], "\n\n"),
    ("state", "host-sim", "host-sim/evaluation/src/method.rs", &["fn name_of("], "\n}"),
];

/// Deliberate differences: a language or a file ("": all that are not listed above), the names in smr-core, the name there ("": it has
/// none), and the reason.
const OTHERWISE: &[(&str, &[&str], &str, &str)] = &[
    ("", &["gate.least_ratio"], "least_ratio", "the name needs no gate to be understood"),
    ("", &["runner_up"], "runner_up_always", "with two values it is a switch"),
    ("host-sim", &["backend"], "backend", "it compares backends"),
    ("Python", &["backend"], "", "it changes only the time, and the fastest one is chosen"),
    ("", &["backend"], "plain_loop", "which of the others there are is for the library to find out"),
    ("host-sim", &["pruning"], "exhaustive", "it shows what pruning saves"),
    ("", &["pruning"], "", "it changes only the time, and off it is for measurements"),
    ("", &["robust.table"], "", "the other numbers were chosen with the paper's table"),
    ("host-sim", &["paper.table"], "scale", "it makes the table"),
    ("", &["paper.table"], "", "a table is memory that must stay where it is"),
    ("MicroPython", &["k", "update_zone"], "", "each option takes flash, and the presets have values"),
    ("host-sim", &["first_threshold", "update_zone"], "", "the presets have values"),
    ("MicroPython", GATE, "", "each option takes flash, and the presets have values"),
    ("host-sim", GATE, "", "the presets have values"),
    ("host-sim", &["least_threshold"], "least_alpha", "the paper calls the threshold alpha"),
    ("C", &["bbox"], "bbox", "its names are those of smr-core"),
    ("", &["bbox"], "box", "box is a keyword in Rust alone"),
    ("C", &["fine"], "fine", "its names are those of smr-core"),
    ("host-sim", &["fine"], "fine", "a line of JSON is short"),
    ("", &["fine"], "fine_box", "it says what it is"),
    ("host-sim", &["size"], "Size", "it is a part that --without leaves out"),
    ("host-sim", &["sweep"], "Sweep", "it is a part that --without leaves out"),
    ("host-sim", &["refiner"], "Refiner", "it is a part that --without leaves out"),
];
const GATE: &[&str] = &["gate.tracking", "gate.leaving", "gate.returning", "gate.lost", "gate.lead"];

/// The fields of a struct with their types, or the variants of an enum of smr-core.
fn items(path: &str) -> impl Iterator<Item = &'static str> {
    let own = move |line: &'static str| line.strip_prefix("pub smr_core::")?.strip_prefix(path)?.strip_prefix("::");
    CORE.lines().filter_map(own)
}

/// The settings of a tracker, or the states. Those of the gate are `gate.tracking` and so on.
fn named(what: &str) -> Vec<String> {
    let name = |item: &str| item.split([':', ' ']).next().unwrap_or(item).to_owned();
    match what {
        "state" => items("State").map(name).collect(),
        "answer" => items("Answer").map(name).collect(),
        "robust" => items("robust::Config").map(name).collect(),
        _ => {
            let own = items("paper::Config").map(name).filter(|field| field != "gate");
            own.chain(items("paper::Gate").map(|field| format!("gate.{}", name(field)))).collect()
        }
    }
}

/// `name` as it is spelled in a language.
fn spelled(what: &str, language: &str, name: &str) -> String {
    let mut words = name.split(['.', '_']);
    match (what, language) {
        ("state", "C") => format!("SMR_{}", name.to_uppercase()),
        ("answer", "MicroPython") => format!("MP_QSTR_{name}"),
        ("state", "host-sim") => name.to_lowercase(),
        ("state", _) => name.to_uppercase(),
        (_, "C") => name.rsplit('.').next().unwrap_or(name).to_owned(),
        (_, "JavaScript") => {
            let first = words.next().unwrap_or_default().to_owned();
            words.fold(first, |all, word| all + &word[..1].to_uppercase() + &word[1..])
        }
        _ => name.replace('.', "_"),
    }
}

/// Whether `word` stands in `text` after one of `before`, up to `end`, outside of comments.
fn has(text: &str, before: &[&str], end: &str, word: &str) -> bool {
    let is_name = |letter: char| letter.is_alphanumeric() || letter == '_';
    before.iter().any(|before| {
        let (_, after) = text.split_once(before).unwrap_or_else(|| panic!("no {before}"));
        let part = after.split(end).next().unwrap_or(after);
        // Without the texts of Python.
        let mut code = part
            .split("\"\"\"")
            .step_by(2)
            .flat_map(str::lines)
            .filter(|line| !line.trim_start().starts_with(['/', '*']));
        code.any(|line| line.split(|letter| !is_name(letter)).any(|found| found == word))
    })
}

/// What the languages lack, each with its name. `read` gives the text of a file.
fn lacking(read: impl Fn(&str) -> String) -> Vec<String> {
    let mut lacking = Vec::new();
    for (what, language, file, before, end) in PLACES {
        let text = read(file);
        for name in named(what) {
            let entry = OTHERWISE.iter().find(|(of, names, ..)| {
                ["", language, file].contains(of)
                    && names.iter().any(|listed| *listed == name || *listed == format!("{what}.{name}"))
            });
            let (told, reason) = entry.map_or((name.as_str(), ""), |(_, _, told, reason)| (*told, *reason));
            let has = |name: &str| has(&text, before, end, &spelled(what, language, name));
            match told {
                "" if has(&name) => lacking.push(format!("{language} has {name} of {what}, though: {reason}: {file}")),
                "" => {}
                told if has(told) => {}
                told => lacking.push(format!("{language} lacks {told} of {what}: {file}")),
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
    let [answer, paper, robust, states] = ["answer", "paper", "robust", "state"].map(named);
    assert!(!answer.is_empty() && !states.is_empty(), "smr-core.txt has them");
    for name in OTHERWISE.iter().flat_map(|(_, names, ..)| *names) {
        let name = name.trim_start_matches("paper.").trim_start_matches("robust.");
        assert!([&answer, &paper, &robust].iter().any(|known| known.contains(&name.to_owned())), "{name} is listed");
    }
}

#[test]
fn what_a_language_lacks_is_named() {
    let without = |file: &str, line: &str| {
        assert!(read(file).contains(line), "{file} has {line}");
        lacking(|wanted| if wanted == file { read(file).replace(line, "") } else { read(wanted) })
    };
    assert_eq!(without(HEADER, "  uint16_t growth;\n"), [format!("C lacks growth of paper: {HEADER}")]);
    assert_eq!(without(HEADER, "  uint16_t lost_below;\n"), [format!("C lacks lost_below of robust: {HEADER}")]);
    assert_eq!(without(HEADER, "  SMR_UNCERTAIN = 2,\n"), [format!("C lacks Uncertain of state: {HEADER}")]);
    assert_eq!(without(STUBS, "        reach: int = ...,\n"), [format!("Python lacks reach of robust: {STUBS}")]);
    assert_eq!(without(TYPES, "  gateLead?: number;\n"), [format!("JavaScript lacks gate.lead of paper: {TYPES}")]);
}
