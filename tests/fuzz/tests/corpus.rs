//! Runs every committed input, seeds and former faults, through the fuzz target of its folder.

use smr_fuzz::TARGETS;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn corpus() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/corpus"))
}

#[test]
fn every_target_has_seeds_and_every_folder_a_target() {
    let folders = fs::read_dir(corpus()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let targets = TARGETS.iter().map(|(name, _)| (*name).to_owned());
    assert_eq!(folders.collect::<BTreeSet<_>>(), targets.collect::<BTreeSet<_>>());
}

#[test]
fn every_input_passes() {
    for (name, target) in TARGETS {
        let mut files: Vec<_> = fs::read_dir(corpus().join(name)).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        assert!(!files.is_empty(), "{name}");
        for file in files {
            println!("{}", file.display());
            target(&fs::read(&file).unwrap());
        }
    }
}

/// Runs each target on the empty input and on beginnings of a committed input: a fuzzer's inputs mostly end early.
#[test]
fn nothing_and_the_beginning_of_an_input_pass() {
    for (name, target) in TARGETS {
        target(&[]);
        let first = fs::read_dir(corpus().join(name)).unwrap().next().unwrap().unwrap().path();
        let bytes = fs::read(&first).unwrap();
        println!("{}", first.display());
        for end in (0..bytes.len()).step_by(bytes.len().div_ceil(16).max(1)) {
            target(&bytes[..end]);
        }
    }
}
