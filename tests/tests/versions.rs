//! Checks the version: `Cargo.toml` of the workspace has it, and files for readers without Cargo repeat it.

use std::fs;
use std::path::Path;

/// Each file, and the text before the version in it.
const REPEATED: &[(&str, &str)] = &[
    ("core/web/package.json", "\"version\": \""),
    ("core/c/packages/README.md", "FetchContent_Declare(smr URL smr-c-"),
    ("core/c/packages/arduino/README.md", "SMRTracker-"),
    ("core/c/packages/arduino/library.json", "\"version\": \""),
    ("core/c/packages/arduino/library.properties", "\nversion="),
    ("core/c/packages/cmsis/SMR.Tracker.pdsc", "<release version=\""),
    ("core/c/packages/cmsis/SMR.Tracker.pdsc", "Cversion=\""),
    ("core/c/packages/esp-idf/idf_component.yml", "version: \""),
];

const CRATES: &str = "core core/c core/python host-sim host-sim/files host-sim/scene host-sim/recordings \
                      host-sim/reference host-sim/evaluation host-sim/pages";

fn read(file: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
    fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// Returns the text after `before`, up to the first character that a version cannot contain.
fn after<'a>(text: &'a str, before: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(before)?;
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
    Some(rest[..end].trim_end_matches('.'))
}

#[test]
fn the_version_stands_once() {
    let version = env!("CARGO_PKG_VERSION");
    let workspace = read("Cargo.toml");
    assert_eq!(after(&workspace, "[workspace.package]\nversion = \""), Some(version));
    for line in workspace.lines().filter(|line| line.contains("path = \"")) {
        assert_eq!(after(line, "version = \""), Some(version), "Cargo.toml: {line}");
    }
    for folder in CRATES.split(' ') {
        assert!(read(&format!("{folder}/Cargo.toml")).contains("\nversion.workspace = true\n"), "{folder}/Cargo.toml");
    }
    assert!(read("core/python/pyproject.toml").contains("\ndynamic = [\"version\"]\n"), "core/python/pyproject.toml");
    for (file, before) in REPEATED {
        assert_eq!(after(&read(file), before), Some(version), "{file}: after {before:?}");
    }
    let header = read("core/c/include/smr.h");
    let number = |name| after(&header, &format!("#define SMR_VERSION_{name} ")).expect("a number in smr.h").to_owned();
    assert_eq!([number("MAJOR"), number("MINOR"), number("PATCH")].join("."), version, "core/c/include/smr.h");
}
