//! Tests across the crates: those in `tests/`, one file per subject.

/// The example in the project's README is a test, too.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
