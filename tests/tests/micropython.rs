//! The exceptions of the module for MicroPython have the words of Rust's errors, and every status of the C interface has an exception.

use smr_core::readout::ReadoutError;
use smr_core::{ConfigError, ImageError, LockError, RestoreError, Setting, UpdateError};
use std::collections::{BTreeMap, BTreeSet};

const MODULE: &str = include_str!("../../core/micropython/smr/smr.c");
const HEADER: &str = include_str!("../../core/c/include/smr.h");

/// The line that an error of a line is about.
const LINE: u16 = 30;

/// Rust's words for each status that a call of the module can return.
fn rust() -> BTreeMap<&'static str, String> {
    let words: [(&str, &dyn std::fmt::Display); 22] = [
        ("SMR_ERROR_NOTHING_COUNTS", &ConfigError::NothingCounts),
        ("SMR_ERROR_LIMIT_BELOW_WINDOW", &ConfigError::LimitBelowWindow),
        ("SMR_ERROR_CONFIG_OUT_OF_RANGE", &ConfigError::OutOfRange),
        ("SMR_ERROR_REFINER_NOT_BUILT_IN", &ConfigError::RefinerNotBuiltIn),
        ("SMR_ERROR_FRAME_EMPTY", &ImageError::Empty),
        ("SMR_ERROR_STRIDE_TOO_SMALL", &ImageError::StrideTooSmall),
        ("SMR_ERROR_FRAME_TOO_SHORT", &ImageError::SliceTooShort),
        ("SMR_ERROR_OUTSIDE_FRAME", &ReadoutError::WindowOutsideFrame),
        ("SMR_ERROR_BOX_EMPTY", &LockError::BoxEmpty),
        ("SMR_ERROR_BOX_OUTSIDE_FRAME", &LockError::BoxOutsideFrame),
        ("SMR_ERROR_BOX_TOO_LARGE", &LockError::BoxTooLarge),
        ("SMR_ERROR_WINDOW_TOO_LARGE", &LockError::WindowTooLarge),
        ("SMR_ERROR_NOT_LOCKED", &UpdateError::NotLocked),
        ("SMR_ERROR_FRAME_SIZE_CHANGED", &UpdateError::FrameSizeChanged),
        ("SMR_ERROR_NOT_SAVED", &RestoreError::NotSaved),
        ("SMR_ERROR_OTHER_VERSION", &RestoreError::OtherVersion),
        ("SMR_ERROR_TRUNCATED", &RestoreError::Truncated),
        ("SMR_ERROR_DAMAGED", &RestoreError::Damaged),
        ("SMR_ERROR_OTHER_METHOD", &RestoreError::OtherTracker),
        ("SMR_ERROR_OTHER_CONFIG", &RestoreError::OtherConfig(Setting::Refiner)),
        ("SMR_ERROR_SAVED_TOO_LARGE", &RestoreError::TooLarge),
        ("SMR_ERROR_LINE_TOO_SHORT", &ReadoutError::LineTooShort(LINE)),
    ];
    words.into_iter().map(|(status, words)| (status, words.to_string())).collect()
}

/// What the module cannot cause: it checks or makes the pointers, the memory and the parts of frames itself, and has no steps, no tables and
/// no fractions. Its exception has only the name of the status.
const NEVER: [&str; 19] = [
    "SMR_ERROR_NULL",
    "SMR_ERROR_MISALIGNED",
    "SMR_ERROR_STORAGE_TOO_SMALL",
    "SMR_ERROR_WORKSPACE_TOO_SMALL",
    "SMR_ERROR_STORAGE_OVERLAPS_WORKSPACE",
    "SMR_ERROR_NOT_INITIALISED",
    "SMR_ERROR_SCALE_OUT_OF_RANGE",
    "SMR_ERROR_ZERO_DENOMINATOR",
    "SMR_ERROR_MEMORY_TOO_LARGE",
    "SMR_ERROR_OVERLAPS_TRACKER",
    "SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY",
    "SMR_ERROR_WINDOW_NOT_IN_MEMORY",
    "SMR_ERROR_NOT_BEGUN",
    "SMR_ERROR_BUFFER_TOO_SMALL",
    "SMR_ERROR_UNKNOWN",
    "SMR_ERROR_LINE_OUT_OF_ORDER",
    "SMR_ERROR_LINE_OUTSIDE_FRAME",
    "SMR_ERROR_LINE_MISSING",
    // Rust's formats are a type, so it has no words to compare with.
    "SMR_ERROR_FORMAT_UNKNOWN",
];

/// The table in the module.
fn module() -> BTreeMap<&'static str, String> {
    let lines = MODULE.lines().filter_map(|line| line.trim().strip_prefix("case SMR_ERROR_"));
    let entries = lines.filter_map(|line| line.strip_suffix("\");")?.split_once(": return MP_ERROR_TEXT(\""));
    let full = |status: &str| HEADER.find(&format!("SMR_ERROR_{status} = ")).expect("a status of the header");
    entries
        .map(|(status, words)| {
            (
                &HEADER[full(status)..][.."SMR_ERROR_".len() + status.len()],
                words.replace("%d", &LINE.to_string()).replace("%s", "refiner"),
            )
        })
        .collect()
}

#[test]
fn exceptions_have_the_words_of_rusts_errors() {
    let mut module = module();
    assert!(module.remove("SMR_ERROR_FORMAT_UNKNOWN").is_some(), "the format");
    assert_eq!(module, rust());
}

#[test]
fn every_status_has_an_exception() {
    let lines = HEADER.lines().filter_map(|line| line.trim().strip_suffix(',')?.split_once(" = "));
    let statuses: BTreeSet<&str> = lines.map(|(name, _)| name).filter(|name| name.starts_with("SMR_ERROR_")).collect();
    let rust = rust();
    let known: BTreeSet<&str> = rust.keys().copied().chain(NEVER).collect();
    assert_eq!(statuses, known);
}
