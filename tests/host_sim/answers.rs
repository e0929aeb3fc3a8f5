//! Compares the trackers' answers on built-in recordings with `tests/kit/answers.txt`. `tests/kit/answers` does so for all
//! recordings, and `tests/kit/answers --record` writes the file.

use crate::program::host_sim;
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// The built-in recordings except `street`, whose drawing takes seconds.
const RECORDINGS: [&str; 5] = ["synthetic", "periodic", "border", "noise", "tiles"];

fn hash(text: &str) -> String {
    Sha256::digest(text).iter().fold(String::new(), |mut digits, byte| {
        write!(digits, "{byte:02x}").expect("a String takes it");
        digits
    })
}

/// Tables of `tests/results` name the answers with which they were measured, so the file must be that of this tracker.
#[test]
fn the_answers_are_those_recorded() {
    let recorded = include_str!("../kit/answers.txt");
    for method in ["paper", "robust"] {
        for recording in RECORDINGS {
            let said = host_sim(&["track", recording, "--method", method, "--json"]);
            assert_eq!(said.code, Some(0), "{}", said.err);
            let answers: String =
                said.out.split_inclusive('\n').filter(|line| !line.contains("microseconds_per_frame")).collect();
            let line = format!("{}  {method} {recording}", hash(&answers));
            let is_recorded = recorded.lines().any(|recorded| recorded == line);
            assert!(is_recorded, "{method} on {recording} has new answers: tests/kit/answers --record writes them");
        }
    }
}
