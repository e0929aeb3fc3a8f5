//! Says by name which test is skipped on this machine, and why. Each test program includes this file.

#![allow(dead_code, reason = "no test program needs all of it")]

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Says that a test is skipped. Not by `println!`, which is shown only for tests that fail.
pub fn skipped(test: &str, why: impl Display) {
    // In one piece, so that no other line comes between.
    let _ = std::io::stderr().write_all(std::format!("skipped: {test}: {why}\n").as_bytes());
}

/// True if `program` runs with `arguments`, which ask for its version. If not, the test is skipped.
pub fn has(test: &str, program: &str, arguments: &[&str]) -> bool {
    let runs = runs(Command::new(program).args(arguments));
    if !runs {
        skipped(test, format_args!("no {program} on the PATH"));
    }
    runs
}

pub fn runs(command: &mut Command) -> bool {
    let command = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

pub fn has_ffmpeg(test: &str) -> bool {
    has(test, "ffmpeg", &["-version"])
}

/// True if `cc` compiles C. A `cc` that links Rust may not; then the test is skipped.
pub fn has_c_compiler(test: &str) -> bool {
    has(test, "cc", &["-fsyntax-only", "-x", "c", "/dev/null"])
}

/// A folder of recordings, which are not part of the project and may be videos: `host-sim/README.md` says where the tests expect them. `None`
/// if it is not there, or no ffmpeg: the test is skipped.
pub fn recordings(test: &str, folder: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/sequences");
    let found = std::env::var_os("SMR_SEQUENCES").map_or(beside, PathBuf::from).join(folder);
    if !found.is_dir() {
        skipped(test, format_args!("no {} (set SMR_SEQUENCES)", found.display()));
        return None;
    }
    has_ffmpeg(test).then_some(found)
}
