//! Documents say what holds: their examples compile and run, their commands can be run, their links lead to files, and
//! their figures are those of code and records.

mod commands;
mod examples;
mod figures;
mod links;

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
