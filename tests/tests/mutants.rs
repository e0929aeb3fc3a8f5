//! `host-sim check` notices when smr-core is wrong.
//!
//! Each mutant is the project with one change in `core`, built and run on the built-in recordings. A check that passes with a mutant does
//! not test that place.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A mutant: its name, the file in `core/src`, a text that occurs there once, and its replacement.
type Mutant = (&'static str, &'static str, &'static str, &'static str);

const PAPER: [Mutant; 22] = [
    (
        "one table entry",
        "similarity/table.rs",
        "        table.fill(scale);",
        "table.fill(scale); table.entries[7] += 1;",
    ),
    ("strictness of the threshold", "kernels/cut_table.rs", "if d < threshold.into()", "if d + 1 < threshold.into()"),
    ("tie rule: distance", "search/peak.rs", "dx * dx + dy * dy", "dx * dx"),
    ("tie rule: order", "search/peak.rs", "dy, self.y, self.x)", "dy, self.x, self.y)"),
    ("padding", "kernels/plain/scores.rs", "table.of_pixels(0, g)", "table.of_pixels(1, g)"),
    ("rounding of alpha", "track/paper/config.rs", ".div_ceil(", ".wrapping_div("),
    ("alpha of an unchanged template", "track/paper/template.rs", "if largest > 0", "if true"),
    ("the peak's neighbourhood", "search/runner_up.rs", "usize::from(neighbourhood) + 1", "usize::from(neighbourhood)"),
    (
        "the state of a leaving target",
        "track/paper/gate.rs",
        "if self.bounds.contains(target)",
        "if !target.is_empty()",
    ),
    (
        "growth of the window",
        "track/paper/track.rs",
        "saturating_mul(self.lost_for)",
        "saturating_mul(self.lost_for.min(1))",
    ),
    (
        "when the runner-up decides",
        "track/paper/gate.rs",
        "ratio.numerator.cmp(&ratio.denominator)",
        "ratio.numerator.cmp(&(ratio.denominator + ratio.denominator / 50))",
    ),
    ("what a group can reach", "search/ranges.rs", "others + score)", "others + score / 2)"),
    ("the last groups of a tile", "search/tiles.rs", "column < new.0 || row", "column <= new.0 || row"),
    (
        "the zone of updates: left",
        "track/paper/config.rs",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }",
        "update_zone: Margins { left: 19, top: 20, right: 2, bottom: 2 }",
    ),
    (
        "the zone of updates: top",
        "track/paper/config.rs",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }",
        "update_zone: Margins { left: 20, top: 21, right: 2, bottom: 2 }",
    ),
    (
        "the zone of updates: right",
        "track/paper/config.rs",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }",
        "update_zone: Margins { left: 20, top: 20, right: 1, bottom: 2 }",
    ),
    (
        "the zone of updates: bottom",
        "track/paper/config.rs",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 2 }",
        "update_zone: Margins { left: 20, top: 20, right: 2, bottom: 3 }",
    ),
    (
        "the window without an end",
        "track/paper/config.rs",
        "Radius { x: u16::MAX, y: u16::MAX }",
        "Radius { x: 61, y: 51 }",
    ),
    (
        "a peak must be larger than the runner-up",
        "track/paper/config.rs",
        ") > u64::from(lower)",
        ") >= u64::from(lower)",
    ),
    (
        "how long returning takes more",
        "track/paper/gate.rs",
        "edge: edge && !was_lost",
        "edge: state == State::Leaving",
    ),
    (
        "the lead in every state",
        "track/paper/gate.rs",
        "let leads = peak",
        "let leads = self.state == State::Lost && peak",
    ),
    (
        "the gate",
        "track/paper/gate.rs",
        "(_, State::Leaving) => config.gate.leaving",
        "(_, State::Leaving) => config.gate.returning",
    ),
];

/// The same for the robust tracker.
const ROBUST: [Mutant; 29] = [
    ("cells of the filter", "track/robust/constants.rs", "MOST_CELLS: usize = 200;", "MOST_CELLS: usize = 190;"),
    ("a direction", "kernels/plain/gradients.rs", "(703, 256)", "(702, 256)"),
    (
        "the norm's floor",
        "track/robust/constants.rs",
        "NORM_FLOOR: u32 = 2 * 16 * 8;",
        "NORM_FLOOR: u32 = 2 * 16 * 8 + 1;",
    ),
    ("the norm's gain", "track/robust/constants.rs", "NORM_GAIN: u32 = 635;", "NORM_GAIN: u32 = 634;"),
    ("the regularisation", "track/robust/constants.rs", "REGULARISATION: i64 = 5056;", "REGULARISATION: i64 = 5055;"),
    ("coded numbers", "correlation/coded.rs", "LARGEST: u32 = 8191;", "LARGEST: u32 = 4095;"),
    ("coded errors", "track/robust/constants.rs", "MOST_CODED_ERROR: u32 = 16_383;", "MOST_CODED_ERROR: u32 = 8191;"),
    (
        "width of the label",
        "track/robust/constants.rs",
        "LABEL_WIDTH: [u32; 2] = [1, 100];",
        "LABEL_WIDTH: [u32; 2] = [1, 99];",
    ),
    ("the length of a step", "track/robust/config.rs", "learning_rate: 160,", "learning_rate: 161,"),
    ("where cells learn", "track/robust/constants.rs", "LEARNED_WIDTH: u64 = 32;", "LEARNED_WIDTH: u64 = 33;"),
    ("the table of the label", "track/robust/gaussian.rs", "5 * FINE as usize", "2 * FINE as usize"),
    (
        "the distance penalty",
        "track/robust/constants.rs",
        "DISTANCE_PENALTY: u32 = 77;",
        "DISTANCE_PENALTY: u32 = 128;",
    ),
    ("velocity", "track/robust/motion.rs", "self.place.x + right) >> 1", "self.place.x + right) >> 2"),
    ("first steps", "track/robust/constants.rs", "FIRST_STEPS: u32 = 25;", "FIRST_STEPS: u32 = 24;"),
    ("scales", "track/robust/constants.rs", "SCALE_STEP: i64 = 66_847;", "SCALE_STEP: i64 = 66_848;"),
    ("what other scales count", "track/robust/constants.rs", "SCALE_PENALTY: i64 = 252;", "SCALE_PENALTY: i64 = 128;"),
    ("the early template", "track/robust/config.rs", "early_rate: 1,", "early_rate: 16,"),
    ("the growth", "track/robust/refinement.rs", "-32 * solve([", "-16 * solve(["),
    ("slopes outward", "track/robust/refinement.rs", "+ down * v) >> 6", "- down * v) >> 6"),
    (
        "where place and size are refined",
        "track/robust/constants.rs",
        "REFINED_FROM: u16 = 55_000;",
        "REFINED_FROM: u16 = 65_535;",
    ),
    ("the part that counts", "track/robust/constants.rs", "RANK: usize = 4;", "RANK: usize = 5;"),
    ("alpha's bound", "track/robust/constants.rs", "MOST_ALPHA: u32 = 100;", "MOST_ALPHA: u32 = 9;"),
    ("confidence", "track/robust/config.rs", "patience: 179,", "patience: 180,"),
    ("gated learning", "track/robust/constants.rs", "LEARNED_FROM: i32 = 37_500;", "LEARNED_FROM: i32 = 98_304;"),
    (
        "the refiner's leak",
        "track/robust/refiner/correction.rs",
        "bounded(new)) * 15) >> 6",
        "bounded(new)) * 14) >> 6",
    ),
    ("its fading", "track/robust/refiner/correction.rs", "(3 * (side - ONE)) >> 2", "(3 * (side - ONE)) >> 3"),
    ("its crop", "track/robust/refiner/crop.rs", "(7 * i64::from(side)) >> 3", "(6 * i64::from(side)) >> 3"),
    ("its inputs", "track/robust/refiner/crop.rs", "(root(squares) + 128)", "(root(squares) + 127)"),
    ("a layer of its network", "track/robust/refiner/network.rs", "channels: 16, shift: 7", "channels: 16, shift: 6"),
];

/// Mutants that only a lost and returning target shows. The robust tracker loses none of the targets in the built-in recordings; the
/// tests of `check` have such a target.
const LOST: [Mutant; 5] = [
    ("how much is enough", "track/robust/constants.rs", "FOUND_FROM: i32 = 52_000;", "FOUND_FROM: i32 = 104_000;"),
    (
        "where a lost target is searched",
        "track/robust/redetection.rs",
        "(2 * i64::from(number) + 1)",
        "(2 * i64::from(number))",
    ),
    ("what is asked for", "track/robust/windows.rs", "reach + 2 * SCALE_REACH", "reach"),
    ("how fast light is followed", "track/robust/constants.rs", "FOLLOWED: u32 = 3;", "FOLLOWED: u32 = 2;"),
    ("the opinion's rate", "track/robust/refiner/opinion.rs", "(trust - self.0) >> 3", "(trust - self.0) >> 2"),
];

/// Mutants that no recording shows yet, but smr-core's own tests.
const OWN: [Mutant; 2] = [
    ("how much better", "track/robust/constants.rs", "FOUND_LEAD: i32 = 16_000;", "FOUND_LEAD: i32 = 0;"),
    (
        "how far the confidence leads",
        "track/robust/constants.rs",
        "CONFIDENCE_LEAD: i32 = 29_000;",
        "CONFIDENCE_LEAD: i32 = 98_304;",
    ),
];

/// How a mutant is tested: the arguments of `cargo`.
const CHECK_PAPER: [&str; 7] = ["run", "--quiet", "--package", "host-sim", "--", "check", "--method=smr"];
const CHECK_ROBUST: [&str; 7] = ["run", "--quiet", "--package", "host-sim", "--", "check", "--method=robust"];
const TEST_CORE: [&str; 6] = ["test", "--quiet", "--package=smr-core", "--lib", "--", "track::robust::confidence"];
const TEST_ROBUST: [&str; 6] = ["test", "--quiet", "--package=host-sim", "--lib", "--", "check::robust"];

#[test]
#[ignore = "builds host-sim 51 times: `.ci/run nightly` runs it, or `cargo test -p smr-tests --test crates mutants -- --ignored`"]
fn check_fails_on_every_mutant() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the project");
    let copy = project.join("target/mutants/project");
    let _ = fs::remove_dir_all(&copy);
    for part in ["core", "host-sim", "tests", "README.md", "Cargo.toml", "Cargo.lock"] {
        copy_all(&project.join(part), &copy.join(part));
    }
    let mut unnoticed: Vec<&str> = Vec::new();
    for (command, mutants) in
        [(&CHECK_PAPER[..], PAPER.as_slice()), (&CHECK_ROBUST, &ROBUST), (&TEST_ROBUST, &LOST), (&TEST_CORE, &OWN)]
    {
        let sane = cargo(&copy, command);
        assert!(sane.status.success(), "without a mutation it holds:\n{}", text(&sane));
        unnoticed.extend(mutants.iter().filter(|mutant| !is_noticed(&copy, command, mutant)).map(|(name, ..)| name));
    }
    assert!(unnoticed.is_empty(), "check is content with: {unnoticed:?}");
}

/// Every mutant can still be made: the test above does not run every day.
#[test]
fn every_mutant_can_be_made() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the project");
    for (name, file, from, to) in PAPER.iter().chain(&ROBUST).chain(&LOST).chain(&OWN) {
        let text = fs::read_to_string(project.join("core/src").join(file)).expect("the file is there");
        assert_eq!(text.matches(from).count(), 1, "{name}: {file} holds `{from}` once");
        assert_ne!(from, to, "{name}");
    }
}

fn is_noticed(copy: &Path, command: &[&str], &(name, file, from, to): &Mutant) -> bool {
    let path = copy.join("core/src").join(file);
    let original = fs::read_to_string(&path).expect("the file is there");
    fs::write(&path, original.replace(from, to)).expect("the copy can be written");
    let output = cargo(copy, command);
    fs::write(&path, original).expect("the copy can be written");
    println!("{name}: {}", output.status);
    match output.status.code() {
        // 101 is a failed test. A change that does not build is not a mutant.
        Some(1) => true,
        Some(101) => {
            let said = text(&output);
            assert!(said.contains("test result: FAILED"), "{name}: {said}");
            true
        }
        Some(0) => false,
        _ => panic!("{name}: neither holds nor fails:\n{}", text(&output)),
    }
}

/// Builds and runs the copy. It has a target folder of its own, so that its dependencies are built once.
fn cargo(project: &Path, command: &[&str]) -> Output {
    let cargo = option_env!("CARGO").unwrap_or("cargo");
    Command::new(cargo)
        .args(command)
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
