//! The trackers' inputs reach all cases: the committed inputs, and some random ones, the same in every run.

use smr_fuzz::reached;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Bytes of xorshift.
fn random(seed: u32) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9E37_79B9) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state.to_be_bytes()[0]
    };
    (0..64 + seed % 192).map(|_| next()).collect()
}

/// The cases that the inputs of these targets did not reach. The number beside a name is that of its random inputs.
fn missed(targets: &[(&str, u32)], never: &[&str]) -> Vec<&'static str> {
    let before: BTreeMap<_, _> = reached().into_iter().collect();
    for (name, inputs) in targets {
        let target = smr_fuzz::target(name).expect("a target");
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
        for file in fs::read_dir(folder).expect("seeds") {
            target(&fs::read(file.expect("a seed").path()).expect("a seed"));
        }
        (1..=*inputs).for_each(|seed| target(&random(seed)));
    }
    let now = reached().into_iter().filter(|(name, times)| before[name] == *times && !never.contains(name));
    now.map(|(name, _)| name).collect()
}

/// Cases that the paper's tracker does not have; the boxes it locks on always fit in memory.
const NOT_OF_THE_PAPER: &[&str] = &[
    "lock: LockWindowNotInMemory",
    "answer: uncertain",
    "frame: two parts",
    "restore: to start with",
    "lock: another error",
    "other size: another error",
];

#[test]
fn calls_of_the_papers_tracker() {
    assert_eq!(missed(&[("paper", 100), ("paper-short", 4000)], NOT_OF_THE_PAPER), [""; 0]);
}

/// Cases that the robust tracker does not have: it resamples any box, and reads more than one pixel.
const NOT_OF_THE_ROBUST: &[&str] = &[
    "answer: leaving",
    "lock: BoxTooLarge",
    "lock: WindowTooLarge",
    "other size: taken",
    // This needs a frame larger than the memory of these inputs: `tests/tests/readout.rs` has such locks.
    "lock: LockWindowNotInMemory",
    "lock: another error",
    "other size: another error",
];

#[test]
fn calls_of_the_robust_tracker() {
    assert_eq!(missed(&[("robust", 30), ("robust-short", 2000)], NOT_OF_THE_ROBUST), [""; 0]);
}
