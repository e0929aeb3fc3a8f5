//! Damages input files in a few places, as a fuzzer does, in every run of the tests.

use smr_fuzz::target;
use smr_scene::random::Random;
use std::fs;
use std::path::Path;

/// Fuzz targets of host-sim's readers. The others are slow, or find faults only in a long run.
const READERS: [&str; 8] = ["pnm", "png", "jpeg", "picture", "y4m", "raw", "boxes", "words"];

/// Number of damaged copies of each file.
const TIMES: u32 = 60;

/// Changes up to three bytes, and cuts off the end in half of the copies.
fn damaged(whole: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..random.place(4) {
        let at = random.place(bytes.len());
        bytes[at] = random.place(256).to_le_bytes()[0];
    }
    if random.place(2) == 0 {
        bytes.truncate(random.place(whole.len() + 1));
    }
    bytes
}

#[test]
fn damaged_files_are_errors_or_frames() {
    let mut random = Random(0x5EED);
    let mut read = 0;
    for name in READERS {
        let reads = target(name).expect("there is such a target");
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
        let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        for file in files {
            let whole = fs::read(&file).unwrap();
            if whole.is_empty() {
                continue;
            }
            println!("{}", file.display());
            for _ in 0..TIMES {
                reads(&damaged(&whole, &mut random));
                read += 1;
            }
        }
    }
    assert!(read > 1000, "{read}");
}
