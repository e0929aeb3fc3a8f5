//! `host-sim check` notices when smr-core is wrong.
//!
//! Each mutant is the project with one place of `core` changed, built and run on the built-in recordings. A check that
//! stays content with a mutant checks nothing there.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What is changed: file in `core/src`, the text that stands there once, and what replaces it.
const MUTANTS: [(&str, &str, &str, &str); 22] = [
    (
        "one table entry",
        "similarity/table.rs",
        "        table.fill(scale);",
        "table.fill(scale); table.entries[7] += 1;",
    ),
    ("strictness of the threshold", "similarity/table.rs", ".get(..threshold.into())", ".get(..=threshold.into())"),
    ("tie rule: distance", "search/mod.rs", "dx * dx + dy * dy", "dx * dx"),
    ("tie rule: order", "search/mod.rs", "candidate.y, candidate.x))", "candidate.x, candidate.y))"),
    ("padding", "similarity/scalar.rs", "pixel(0, g, table)", "pixel(1, g, table)"),
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

/// The same for the robust tracker.
const ROBUST: [(&str, &str, &str, &str); 20] = [
    ("cells of the filter", "robust/mod.rs", "const MOST_CELLS: usize = 200;", "const MOST_CELLS: usize = 190;"),
    ("a direction", "robust/features.rs", "(703, 256)", "(702, 256)"),
    ("the norm's floor", "robust/features.rs", "const FLOOR: u32 = 2 * 16 * 8;", "const FLOOR: u32 = 2 * 16 * 8 + 1;"),
    ("the norm's gain", "robust/features.rs", "const GAIN: u32 = 635;", "const GAIN: u32 = 634;"),
    ("pull", "robust/filter.rs", "const PULL: i64 = 5056;", "const PULL: i64 = 5055;"),
    ("coded numbers", "robust/filter.rs", "const CODED: u64 = 8191;", "const CODED: u64 = 4095;"),
    ("gathered errors", "robust/filter.rs", "const GATHERED: u64 = 16_383;", "const GATHERED: u64 = 8191;"),
    ("width of the label", "robust/label.rs", "* 4096 / 100)", "* 4096 / 99)"),
    ("the length of a step", "robust/filter.rs", "(5 * ((squared", "(6 * ((squared"),
    ("the table of the label", "robust/label.rs", "5 * FINE as usize", "2 * FINE as usize"),
    ("near", "robust/responses.rs", "const FAR: i64 = 77;", "const FAR: i64 = 128;"),
    ("velocity", "robust/track.rs", "self.place.x + self.right) >> 1", "self.place.x + self.right) >> 2"),
    ("first steps", "robust/tracker.rs", "const FIRST_STEPS: u32 = 25;", "const FIRST_STEPS: u32 = 24;"),
    ("scales", "robust/tracker.rs", "const SIZE_STEP: u64 = 66_847;", "const SIZE_STEP: u64 = 66_848;"),
    ("what other scales count", "robust/tracker.rs", "const SIZE_PART: i64 = 252;", "const SIZE_PART: i64 = 128;"),
    ("the early template", "robust/early.rs", "const RATE: u32 = 10;", "const RATE: u32 = 6;"),
    ("the part that counts", "robust/agreement.rs", "const RANK: usize = 4;", "const RANK: usize = 5;"),
    ("alpha's bound", "robust/light.rs", "clamp(8, 100)", "clamp(8, 9)"),
    ("trust", "robust/trust.rs", "const RATE: i32 = 77;", "const RATE: i32 = 76;"),
    ("caution", "robust/trust.rs", "const LEARNED: i32 = 29_500;", "const LEARNED: i32 = 80_000;"),
];

#[test]
#[ignore = "builds host-sim 35 times: `.ci/run nightly` runs it, or `cargo test -p smr-tests --test mutants -- --ignored`"]
fn check_fails_on_every_mutant() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the project");
    let copy = project.join("target/mutants/project");
    let _ = fs::remove_dir_all(&copy);
    for part in ["core", "host-sim", "tests", "Cargo.toml", "Cargo.lock"] {
        copy_all(&project.join(part), &copy.join(part));
    }
    let mut unnoticed: Vec<&str> = Vec::new();
    for (config, mutants) in [("paper", MUTANTS.as_slice()), ("robust", &ROBUST)] {
        let sane = check(&copy, config);
        assert!(sane.status.success(), "without a mutation the check holds:\n{}", text(&sane));
        unnoticed.extend(mutants.iter().filter(|mutant| !is_noticed(&copy, config, mutant)).map(|(name, ..)| name));
    }
    assert!(unnoticed.is_empty(), "check is content with: {unnoticed:?}");
}

fn is_noticed(copy: &Path, config: &str, &(name, file, from, to): &(&str, &str, &str, &str)) -> bool {
    let path = copy.join("core/src").join(file);
    let original = fs::read_to_string(&path).expect("the file is there");
    assert_eq!(original.matches(from).count(), 1, "{name}: {file} holds `{from}` once");
    fs::write(&path, original.replace(from, to)).expect("the copy can be written");
    let output = check(copy, config);
    fs::write(&path, original).expect("the copy can be written");
    match output.status.code() {
        Some(1) => true,
        Some(0) => false,
        _ => panic!("{name}: neither holds nor fails:\n{}", text(&output)),
    }
}

/// Builds the copy in a folder of its own, so that its dependencies are built once, and checks the built-in recordings.
fn check(project: &Path, config: &str) -> Output {
    let cargo = option_env!("CARGO").unwrap_or("cargo");
    Command::new(cargo)
        .args(["run", "--quiet", "--package", "host-sim", "--", "check", "--config", config])
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
