//! Tests across the crates. Each file of `tests/` has one subject.

/// Runs the example of the project's README as a test.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
