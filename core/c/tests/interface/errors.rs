//! Checks that every error of smr-core has a status in C. `SMR_RECORD=1 cargo test -p smr-c` writes the texts of the
//! errors to `core/web/words.js` and `core/micropython/smr/words.h`, for JavaScript and MicroPython.

use smr::{STATUSES, smr_status};
use smr_core::readout::ReadoutError;
use smr_core::{ConfigError, FrameError, ImageError, LockError, RestoreError, SaveError, UpdateError};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::path::Path;

/// The line number and the setting's name that the texts of `errors` contain, until `quoted` puts placeholders there.
const LINE: u16 = 54_321;
const SETTING: &str = "early_rate";

type Error = (&'static str, smr_status, String);

fn error(name: &'static str, error: impl Display + Copy + Into<smr_status>) -> Error {
    (name, error.into(), error.to_string())
}

/// Every error that a call from another language can return.
fn errors() -> Vec<Error> {
    macro_rules! each {
        ($($kind:ident { $($reason:ident $(($of:expr))? $({ $($field:ident: $value:expr),+ })?),+ })+) => {
            vec![$($(error(concat!(stringify!($kind), "::", stringify!($reason)), $kind::$reason $(($of))? $({ $($field: $value),+ })?)),+),+]
        };
    }
    each! {
        ImageError { Empty, StrideTooSmall, SliceTooShort }
        FrameError { OutsideFrame }
        ReadoutError {
            WindowOutsideFrame, BufferTooSmall, LineOutOfOrder(LINE), LineTooShort(LINE), LineOutsideFrame(LINE), LineMissing(LINE)
        }
        ConfigError {
            OutOfRange { name: SETTING, lowest: 1, highest: 2, found: 3 }, LimitBelowWindow, UncertainBelowLost,
            WindowTooLarge, RefinerNotBuiltIn, UnknownSetting, WrongCount { name: SETTING, count: 1 }
        }
        LockError {
            BoxEmpty, BoxOutsideFrame, BoxTooLarge, WindowTooLarge, LockWindowNotInMemory
        }
        UpdateError { NotLocked, FrameSizeChanged, WindowNotInMemory }
        SaveError { NotLocked, BufferTooSmall }
        RestoreError { NotSaved, OtherVersion, Truncated, Damaged, OtherTracker, OtherConfig(SETTING), TooLarge }
    }
}

/// Errors that `words` omits: `(language or "" for all, errors, reason)`. Without a text, users get the status's name.
const NEVER: &[(&str, &[&str], &str)] = &[
    ("JavaScript", &["ConfigError::RefinerNotBuiltIn"], "the module has the refiner"),
    ("JavaScript", READOUT, "a browser gives frames, not lines"),
    ("JavaScript", &["ReadoutError::WindowOutsideFrame", "ReadoutError::LineTooShort"], "the same"),
    ("MicroPython", READOUT, "the module gives all lines in their order, and makes the memory"),
    (
        "",
        &["ConfigError::OutOfRange", "ConfigError::UnknownSetting", "ConfigError::WrongCount"],
        "the module checks each option",
    ),
    ("", &["FrameError::OutsideFrame", "LockError::LockWindowNotInMemory"], "the module cuts the windows"),
    ("", &["UpdateError::WindowNotInMemory"], "the module cuts the windows"),
    ("", &["SaveError::BufferTooSmall"], "the module makes the memory"),
    ("", &["ConfigError::WindowTooLarge"], "its status has the words of the lock"),
];
const READOUT: &[&str] = &[
    "ReadoutError::BufferTooSmall",
    "ReadoutError::LineOutOfOrder",
    "ReadoutError::LineOutsideFrame",
    "ReadoutError::LineMissing",
];

/// Errors in `core`, the list of smr-core's public items. Omits enums of other errors, and the modules `pursuit`
/// and `similarity`: a call from another language never returns their errors.
fn listed(core: &str) -> BTreeSet<String> {
    let paths = core.lines().filter_map(|line| line.strip_prefix("pub smr_core::")?.split(['(', ' ']).next());
    let named = |path: &str| {
        let mut parts = path.rsplit("::");
        let (reason, kind) = (parts.next()?, parts.next()?);
        (kind.ends_with("Error") && !["Error", "WindowError"].contains(&kind)).then(|| format!("{kind}::{reason}"))
    };
    paths.filter(|path| !path.starts_with("pursuit::") && !path.starts_with("similarity::")).filter_map(named).collect()
}

/// Returns name and text, by its number, of each status that users of `language` can get.
fn words(language: &str) -> BTreeMap<i32, (&'static str, String)> {
    let is_never = |name: &str| NEVER.iter().any(|(of, names, _)| ["", language].contains(of) && names.contains(&name));
    let mut words = BTreeMap::new();
    for (name, status, text) in errors().into_iter().filter(|(name, ..)| !is_never(name)) {
        let (_, constant, _) = STATUSES.iter().find(|(listed, ..)| *listed == status).expect("all are listed");
        let before = words.insert(status as i32, (constant.trim_end_matches('\0'), text.clone()));
        assert!(before.is_none_or(|(_, before)| before == text), "{language}: {name} has the status of another text");
    }
    words
}

/// A text as a string literal of C and JavaScript, with `setting` and `number` as placeholders.
fn quoted(text: &str, setting: &str, number: &str) -> String {
    format!("\"{}\"", text.replace(SETTING, setting).replace(&LINE.to_string(), number))
}

fn is_recorded(file: &str, now: &str) -> bool {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    if std::env::var_os("SMR_RECORD").is_some() {
        std::fs::write(&path, now).expect("a file of the project");
    }
    std::fs::read_to_string(&path).is_ok_and(|before| before == now)
}

#[test]
fn every_error_of_smr_core_has_a_status() {
    let errors = errors();
    let known = errors.iter().map(|(name, ..)| (*name).to_owned()).collect();
    assert_eq!(listed(include_str!("../../../../tests/api/smr-core.txt")), known);
    let unknown = errors.iter().filter(|(_, status, _)| *status == smr_status::SMR_ERROR_UNKNOWN);
    assert_eq!(unknown.map(|(name, ..)| *name).collect::<Vec<_>>(), [""; 0]);
    assert_eq!(listed("pub smr_core::new::NewError::Found(u16)"), ["NewError::Found".to_owned()].into());
}

#[test]
fn javascript_has_the_words() {
    let words = words("JavaScript").into_values();
    let lines: String = words.map(|(status, text)| format!("  {status}: {},\n", quoted(&text, "{}", "{}"))).collect();
    let now = format!(
        "// Messages of the Rust library's errors, by the name of the C status. core/c/tests/interface/errors.rs generates them.\n\n\
         export const WORDS = {{\n{lines}}};\n"
    );
    assert!(is_recorded("core/web/words.js", &now), "core/web/words.js: SMR_RECORD=1 cargo test -p smr-c");
}

#[test]
fn micropython_has_the_words() {
    let mut words = words("MicroPython");
    // In Rust an unknown format cannot exist, so smr-core has no text for it.
    let formats = "the format is none of smr's: GRAY8, YUYV, UYVY, RGB565_BE, RGB565_LE, BAYER8, GRAY10";
    words.insert(smr_status::SMR_ERROR_FORMAT_UNKNOWN as i32, ("SMR_ERROR_FORMAT_UNKNOWN", formats.to_owned()));
    let case = |(status, text): (&str, String)| {
        format!("        case {status}: return MP_ERROR_TEXT({});\n", quoted(&text, "%s", "%d"))
    };
    let now = format!(
        "// The texts of Rust's errors; NULL for a status that no call of the module can cause. core/c/tests/interface/errors.rs writes them.\n\
         static mp_rom_error_text_t words(smr_status status) {{\n    switch (status) {{\n{}        default: return NULL;\n    }}\n}}\n",
        words.into_values().map(case).collect::<String>()
    );
    let file = "core/micropython/smr/words.h";
    assert!(is_recorded(file, &now), "{file}: SMR_RECORD=1 cargo test -p smr-c");
}
