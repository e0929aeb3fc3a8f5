//! The errors of the JavaScript module have the words of Rust's errors.

use smr_core::similarity::TableError;
use smr_core::{ConfigError, ImageError, LockError, RestoreError, Setting, UpdateError};
use std::collections::BTreeMap;

const MODULE: &str = include_str!("../../core/web/errors.js");

/// Rust's words for each status that a call of the module can return.
fn rust() -> BTreeMap<&'static str, String> {
    let words: [(&str, &dyn std::fmt::Display); 21] = [
        ("SMR_ERROR_SCALE_OUT_OF_RANGE", &TableError::ScaleOutOfRange),
        ("SMR_ERROR_ZERO_DENOMINATOR", &ConfigError::ZeroDenominator),
        ("SMR_ERROR_NOTHING_COUNTS", &ConfigError::NothingCounts),
        ("SMR_ERROR_LIMIT_BELOW_WINDOW", &ConfigError::LimitBelowWindow),
        ("SMR_ERROR_CONFIG_OUT_OF_RANGE", &ConfigError::OutOfRange),
        ("SMR_ERROR_FRAME_EMPTY", &ImageError::Empty),
        ("SMR_ERROR_STRIDE_TOO_SMALL", &ImageError::StrideTooSmall),
        ("SMR_ERROR_FRAME_TOO_SHORT", &ImageError::SliceTooShort),
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
    ];
    words.into_iter().map(|(status, words)| (status, words.to_string())).collect()
}

#[test]
fn errors_have_the_words_of_rusts_errors() {
    let lines = MODULE.lines().filter_map(|line| line.trim().strip_suffix("\",")?.split_once(": \""));
    let module: BTreeMap<&str, String> =
        lines.map(|(status, words)| (status, words.replace("{}", "refiner"))).collect();
    assert_eq!(module, rust());
}
