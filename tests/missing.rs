//! Prints the name of each test that is skipped on this machine, and the reason. Each test program includes this file.

#![allow(dead_code, reason = "no test program needs all of it")]

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Prints that a test is skipped. `println!` would be shown only for failed tests.
pub fn skipped(test: &str, why: impl Display) {
    // One write, so that no other output comes between the parts of the message.
    let _ = std::io::stderr().write_all(std::format!("skipped: {test}: {why}\n").as_bytes());
}

/// Returns true if `program` with `arguments` ends without an error. Otherwise prints that the test is skipped.
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

/// Returns true if `cc` compiles C; on some systems it can only link. Otherwise prints that the test is skipped.
pub fn has_c_compiler(test: &str) -> bool {
    has(test, "cc", &["-fsyntax-only", "-x", "c", "/dev/null"])
}

/// Returns a folder of recordings that are not part of the project; `host-sim/README.md` says where tests look for
/// them. If the folder or ffmpeg is missing, prints that the test is skipped and returns `None`.
pub fn recordings(test: &str, folder: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/sequences");
    let found = std::env::var_os("SMR_SEQUENCES").map_or(beside, PathBuf::from).join(folder);
    if !found.is_dir() {
        skipped(test, format_args!("no {} (set SMR_SEQUENCES)", found.display()));
        return None;
    }
    has_ffmpeg(test).then_some(found)
}
