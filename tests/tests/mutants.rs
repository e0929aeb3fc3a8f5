//! `host-sim check` notices when smr-core is wrong.
//!
//! Each mutant is the project with one place of `core` changed, built and run on the built-in recordings. A check that
//! stays content with a mutant checks nothing there.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What is changed: file in `core/src`, the text that stands there once, and what replaces it.
const MUTANTS: [(&str, &str, &str, &str); 22] = [
    ("one table entry", "similarity/table.rs", "        Self { entries }", "        entries[7] += 1; Self { entries }"),
    (
        "strictness of the threshold",
        "similarity/scalar.rs",
        "u16::from(difference) < threshold",
        "u16::from(difference) <= threshold",
    ),
    ("tie rule: distance", "search/mod.rs", "dx * dx + dy * dy", "dx * dx"),
    ("tie rule: order", "search/mod.rs", "candidate.y, candidate.x))", "candidate.x, candidate.y))"),
    ("padding", "similarity/scalar.rs", "pixel(0, g, table, threshold)", "pixel(1, g, table, threshold)"),
    ("rounding of alpha", "config.rs", ".div_ceil(", ".wrapping_div("),
    ("alpha of an unchanged template", "template.rs", "if largest > 0", "if true"),
    ("the peak's neighbourhood", "search/maxima.rs", "usize::from(neighbourhood) + 1", "usize::from(neighbourhood)"),
    ("the state of a leaving target", "tracker.rs", "if self.bounds.contains(target)", "if !target.is_empty()"),
    ("growth of the window", "tracker.rs", "saturating_mul(track.lost_for)", "saturating_mul(track.lost_for.min(1))"),
    (
        "when the runner-up decides",
        "tracker.rs",
        "ratio.numerator.cmp(&ratio.denominator)",
        "ratio.numerator.cmp(&(ratio.denominator + ratio.denominator / 50))",
    ),
    ("what a group can reach", "search/ranges.rs", "others + score)", "others + score / 2)"),
    ("the last groups of a tile", "search/scan.rs", "column >= new.0 && row", "column > new.0 && row"),
    (
        "the zone of updates: left",
        "config.rs",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }",
        "update_zone: Margins { left: 19, top: 20, right: 2, bottom: 2 }",
    ),
    (
        "the zone of updates: top",
        "config.rs",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }",
        "update_zone: Margins { left: 20, top: 21, right: 2, bottom: 2 }",
    ),
    (
        "the zone of updates: right",
        "config.rs",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }",
        "update_zone: Margins { left: 20, top: 20, right: 1, bottom: 2 }",
    ),
    (
        "the zone of updates: bottom",
        "config.rs",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 3 }",
    ),
    ("the window without an end", "config.rs", "Radius { x: u16::MAX, y: u16::MAX }", "Radius { x: 61, y: 51 }"),
    ("a peak must be larger than the runner-up", "config.rs", ") > u64::from(lower)", ") >= u64::from(lower)"),
    ("how long returning takes more", "tracker.rs", "edge: edge && !was_lost", "edge: state == State::Leaving"),
    ("the lead in every state", "tracker.rs", "let leads = peak", "let leads = self.state == State::Lost && peak"),
    (
        "the gate",
        "tracker.rs",
        "(_, State::Leaving) => config.gate.leaving",
        "(_, State::Leaving) => config.gate.returning",
    ),
];

#[test]
#[ignore = "builds host-sim 15 times: `.ci/run nightly` runs it, or `cargo test -p smr-tests --test mutants -- --ignored`"]
fn check_fails_on_every_mutant() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the project");
    let copy = project.join("target/mutants/project");
    let _ = fs::remove_dir_all(&copy);
    for part in ["core", "host-sim", "tests", "Cargo.toml", "Cargo.lock"] {
        copy_all(&project.join(part), &copy.join(part));
    }
    let sane = check(&copy);
    assert!(sane.status.success(), "without a mutation the check holds:\n{}", text(&sane));

    let mut unnoticed = Vec::new();
    for (name, file, from, to) in MUTANTS {
        let path = copy.join("core/src").join(file);
        let original = fs::read_to_string(&path).expect("the file is there");
        assert_eq!(original.matches(from).count(), 1, "{name}: {file} holds `{from}` once");
        fs::write(&path, original.replace(from, to)).expect("the copy can be written");
        let output = check(&copy);
        match output.status.code() {
            Some(1) => println!("{name}: noticed"),
            Some(0) => unnoticed.push(name),
            _ => panic!("{name}: neither holds nor fails:\n{}", text(&output)),
        }
        fs::write(&path, original).expect("the copy can be written");
    }
    assert!(unnoticed.is_empty(), "check is content with: {unnoticed:?}");
}

/// Builds the copy in a folder of its own, so that its dependencies are built once, and checks the built-in recordings.
fn check(project: &Path) -> Output {
    let cargo = option_env!("CARGO").unwrap_or("cargo");
    Command::new(cargo)
        .args(["run", "--quiet", "--package", "host-sim", "--", "check"])
        .current_dir(project)
        .env("CARGO_TARGET_DIR", project.with_file_name("build"))
        .output()
        .expect("cargo runs")
}

fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

fn copy_all(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).expect("a folder can be made");
        for entry in fs::read_dir(from).expect("a folder can be read") {
            let path: PathBuf = entry.expect("an entry can be read").path();
            copy_all(&path, &to.join(path.file_name().expect("an entry has a name")));
        }
    } else {
        fs::copy(from, to).expect("a file can be copied");
    }
}
