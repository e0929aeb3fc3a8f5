//! Runs each host-sim command in the ```sh blocks of the READMEs, in a folder with the files that the READMEs name:
//! `clip.mp4`, `video.mp4`, both with a session of `view`, `sequences`, a flight record. `NOT_RUN` lists the exceptions with their reasons.

use crate::markdown;
use crate::missing::{has_ffmpeg, runs, skipped};
use crate::program::{PROGRAM, host_sim, utf8};
use serde_json::json;
use smr_core::record::Recorder;
use smr_core::{Robust, Tracker, robust};
use smr_recordings::synthetic;
use std::collections::HashSet;
use std::convert::Infallible;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

const READMES: [(&str, &str); 3] = [
    ("README.md", include_str!("../../README.md")),
    ("host-sim/README.md", include_str!("../../host-sim/README.md")),
    ("core/examples/README.md", include_str!("../../core/examples/README.md")),
];

const NOT_RUN: [(&str, &str); 9] = [
    ("git clone", "it was cloned"),
    ("cargo test", "it runs this test"),
    ("cargo install", "it builds everything once more"),
    ("cargo bench -p smr-bench", "it takes minutes"),
    ("cargo run --target", "it needs a compiler for the chip: .ci/firmware"),
    ("ffmpeg -v error -f v4l2", "it needs a camera"),
    ("host-sim track /dev/video0", "it needs a camera"),
    ("host-sim track rtsp://", "it needs a camera"),
    ("host-sim view", "it serves until it is ended; tests of its own run it"),
];

/// Returns the arguments of host-sim in a line; `None` if `NOT_RUN` lists the line.
fn arguments(line: &str) -> Option<Vec<&str>> {
    if NOT_RUN.iter().any(|(beginning, _)| line.starts_with(beginning)) {
        return None;
    }
    let called = line.strip_prefix("host-sim").or_else(|| line.strip_prefix("cargo run --release -p host-sim"));
    let rest = called.unwrap_or_else(|| panic!("`{line}`: expected a call of host-sim, or an entry in NOT_RUN"));
    assert!(!rest.contains(['"', '\'', '|', '\\']), "`{line}`: this test has no shell");
    Some(rest.split_whitespace().filter(|&word| word != "--").collect())
}

/// Writes a flight record of a few frames, once as bytes and once as text in a log.
fn record(folder: &Path) {
    let (mut bytes, mut tracker) = (Vec::new(), Box::new(Tracker::<Robust>::with(robust::Config::refined()).unwrap()));
    let write = |piece: &[u8]| -> Result<(), Infallible> {
        bytes.extend_from_slice(piece);
        Ok(())
    };
    let Ok(mut recorder) = Recorder::begin(tracker.target(), write);
    let start = synthetic::truth(0).unwrap().to_rect().unwrap();
    for (number, frame) in synthetic::frames().take(4).enumerate() {
        let frame = frame.frame();
        if number == 0 {
            tracker.lock(&frame, start).unwrap();
            let Ok(()) = recorder.lock(tracker.target(), &frame, start);
        } else {
            let Ok(()) = recorder.window(tracker.target(), &frame);
            let answer = tracker.update(&frame).unwrap();
            let Ok(()) = recorder.answer(&answer);
        }
    }
    fs::write(folder.join("flight.smr"), &bytes).unwrap();
    let log: String = bytes.chunks(32).map(|piece| format!("smr-record {piece:02x?}\nanother line\n")).collect();
    fs::write(folder.join("log.txt"), log).unwrap();
}

fn clip(folder: &Path) {
    let frames = folder.join("clip.y4m");
    assert_eq!(
        host_sim(&["convert", "synthetic", "--frames", "..64", "--resize", "320x240", "-o", utf8(&frames)]).code,
        Some(0)
    );
    let clip = folder.join("clip.mp4");
    assert!(runs(Command::new("ffmpeg").args(["-v", "error", "-i", utf8(&frames), utf8(&clip)])));
    fs::remove_file(&frames).unwrap();
    fs::copy(&clip, folder.join("video.mp4")).unwrap();
    for name in ["clip", "video"] {
        let mouse = json!({ "id": 1, "name": "mouse", "locks": [{ "frame": 1, "box": [72, 48, 48, 56] }] });
        let session = json!({
            "smr_session": 1, "recording": name, "method": "robust", "options": {}, "targets": [mouse], "frame": 1,
        });
        fs::write(folder.join(format!("{name}.mp4.smr.json")), session.to_string()).unwrap();
    }
}

#[test]
fn the_commands_of_the_readmes_run_as_they_stand() {
    let folder = tempfile::tempdir().unwrap();
    let has_clip = has_ffmpeg("the_commands_of_the_readmes_run_as_they_stand, for videos");
    if has_clip {
        clip(folder.path());
    }
    record(folder.path());
    for name in ["sequences/car", "sequences/tld/one"] {
        let out = folder.path().join(name);
        assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..20", "-o", utf8(&out)]).code, Some(0));
    }
    // Skips lines that have run already, and host-sim without arguments, which `tests/cases/report.md` runs.
    let mut done = HashSet::from([vec![]]);
    let blocks: Vec<_> = READMES.iter().map(|(name, text)| (name, markdown::blocks(text, "sh").concat())).collect();
    let lines = blocks.iter().flat_map(|(name, block)| markdown::commands(block).map(move |line| (name, line)));
    for (readme, line) in lines {
        let Some(mut arguments) = arguments(line) else { continue };
        if !has_clip && arguments.iter().any(|argument| argument.ends_with(".mp4")) {
            skipped(&format!("`{line}` of {readme}"), "no ffmpeg");
            continue;
        }
        if !done.insert(arguments.clone()) {
            continue;
        }
        let mut command = Command::new(PROGRAM);
        // Shortens the run: `.ci/reference` checks all frames.
        if arguments[0] == "check" || arguments.contains(&"street") {
            arguments.extend(["--frames", "..4"]);
        }
        let said = command.args(&arguments).current_dir(folder.path()).stdin(Stdio::null()).output().unwrap();
        let error = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(0), "{readme}: `{line}`: {error}");
    }
    assert!(done.len() >= 10, "{} lines were run", done.len());
}

#[test]
fn every_line_that_is_not_run_is_still_in_a_readme() {
    let readmes = READMES.map(|(_, text)| text).concat();
    for (beginning, _) in NOT_RUN {
        assert!(readmes.contains(&format!("\n{beginning}")), "{beginning}");
    }
}
