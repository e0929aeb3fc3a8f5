//! The programs of this package as maintainers run them.

use serde_json::Value;
use smr_core::robust;
use smr_evaluation::robustness::{self, Starts};
use smr_evaluation::{MethodKind, Variant};
use smr_recordings::OpenOptions;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub const VECTORS: &str = env!("CARGO_BIN_EXE_vectors");
const SOAK: &str = env!("CARGO_BIN_EXE_soak");
const ABLATION: &str = env!("CARGO_BIN_EXE_ablation");

pub fn output(program: &str, arguments: &[&str]) -> Output {
    Command::new(program).args(arguments).output().expect("it was built before this test")
}

/// Standard output of a program that has nothing to complain about.
#[track_caller]
pub fn said(program: &str, arguments: &[&str]) -> String {
    let output = output(program, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), error.as_ref()), (Some(0), ""), "{program} {arguments:?}");
    String::from_utf8(output.stdout).expect("programs write UTF-8")
}

/// Bad input or usage: exit code 2 and an error that contains all of `words`.
#[track_caller]
fn refuses(program: &str, arguments: &[&str], words: &[&str]) {
    let output = output(program, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(words.iter().all(|word| error.contains(word)), "{arguments:?}: {error}");
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("standard output is JSON")
}

#[test]
fn ablation_has_a_row_for_every_part() {
    let text = said(ABLATION, &["synthetic", "--frames", "..5"]);
    let names = text.lines().skip(1).map(|line| line.split("  ").next().unwrap());
    let expected = ["smr", "robust", "without velocity", "without distance-penalty", "without size"];
    assert_eq!(names.clone().take(5).collect::<Vec<_>>(), expected);
    assert_eq!(names.count(), 10);

    let report = json(&said(ABLATION, &["synthetic", "--starts-every", "150", "--json"]));
    let rows = |name: &str| report[name].as_array().unwrap().len();
    assert_eq!(["measured", "starts", "means", "paired", "calibration"].map(rows), [10, 20, 10, 0, 400]);
    assert_eq!(report["means"][9]["tracker"], "without opinion");
    // What `host-sim eval --robustness` measures.
    let whole = [Variant::new(MethodKind::Robust, &robust::Config::robust().into())];
    let open = |path: &Path| smr_recordings::open(path, &OpenOptions::default());
    let starts = Starts::Every(NonZeroUsize::new(150).unwrap());
    let alone = robustness::measure(&[PathBuf::from("synthetic")], open, &whole, starts, &|_| ());
    let alone = serde_json::to_value(alone.tables()).unwrap();
    assert_eq!(alone["means"][0]["mean_correct"], report["means"][1]["mean_correct"]);
}

#[test]
fn ablation_says_what_it_cannot_measure() {
    refuses(ABLATION, &["no/such/recording"], &["no/such/recording"]);
    refuses(ABLATION, &["periodic"], &["no ground truth"]);
    // It has no option for the tracker; the other trackers are measured.
    let folder = tempfile::tempdir().unwrap();
    let large = folder.path().join("large.raw");
    fs::write(&large, vec![7; 3 * 400 * 300]).unwrap();
    fs::write(folder.path().join("gt.txt"), "0,0,300,300\n".repeat(3)).unwrap();
    let arguments = [large.to_str().unwrap(), "--size", "400x300"];
    let box_ = "the box 0,0,300,300 ";
    refuses(ABLATION, &arguments, &[box_, "has 90000 pixels", "the tracker smr takes at most 65536", "--resize 1/2"]);
    let error = output(ABLATION, &arguments).stderr;
    assert!(!String::from_utf8_lossy(&error).contains("--method"));
}

#[test]
fn a_soak_holds_and_takes_little_memory() {
    let report = json(&said(SOAK, &["--frames", "520", "--reference-every", "2", "--json"]));
    assert_eq!(
        (&report["frames"], &report["sessions"], &report["reference_frames"]),
        (&520.into(), &2.into(), &50.into())
    );
    assert!(report["difference"].is_null() && report["method"] == "smr");
    if cfg!(target_os = "linux") {
        assert!(report["peak_kib"].as_u64().is_some_and(|kib| kib < 128 * 1024), "{report}");
    }
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene");
    said(SOAK, &["--frames", "12", "--seed", "3", "--write", scene.to_str().unwrap()]);
    let recording = smr_recordings::open(&scene, &OpenOptions::default()).unwrap();
    assert!(recording.start().is_ok());
    assert_eq!(recording.frames.count(), 12);
    let one = folder.path().join("one");
    refuses(SOAK, &["--frames", "1", "--write", one.to_str().unwrap()], &["at least 2"]);
    refuses(SOAK, &["--frames", "0"], &["--frames 0: expected a whole number, 1 or more"]);
}

#[test]
fn vectors_know_two_trackers() {
    refuses(VECTORS, &["--method", "ncc"], &["smr", "robust"]);
    refuses(VECTORS, &["--refiner"], &["--refiner is an option of robust"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said() {
    for (program, arguments) in [(SOAK, &["--frames", "20"][..]), (VECTORS, &[])] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = Command::new(program).args(arguments).stdout(full).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{program}: {error}");
        assert!(error.contains("cannot write to standard output: No space left"), "{program}: {error}");
    }
}
