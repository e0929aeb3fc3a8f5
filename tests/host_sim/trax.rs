//! `host-sim trax` with the reference client of the protocol, vot-trax from PyPI.
//!
//! `SMR_TRAX_PYTHON` names a Python that has it; the default is `python3`. `.ci/run` makes one in `target/trax-python`; `host-sim/README.md` says how by hand.
//! If `vot-toolkit` is installed, the tests also run the VOT toolkit.

use crate::missing::{runs, skipped};
use crate::program::{PROGRAM, host_sim, utf8};
use serde_json::Value;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// A Python with these modules. If there is none, a note names the skipped test.
fn python(test: &str, modules: &str) -> Option<OsString> {
    let python = std::env::var_os("SMR_TRAX_PYTHON").unwrap_or_else(|| "python3".into());
    let has_modules = runs(Command::new(&python).args(["-c", &format!("import {modules}")]));
    if !has_modules {
        let python = python.to_string_lossy();
        skipped(test, format_args!("{python} has not all of {modules} (set SMR_TRAX_PYTHON)"));
    }
    has_modules.then_some(python)
}

/// The VOT toolkit, at work in `folder`. It must not ask the network for a newer version of itself: nobody listens there.
fn vot(python: &OsStr, folder: &Path) -> Command {
    let mut command = Command::new(python);
    command.args(["-m", "vot"]).current_dir(folder).env("https_proxy", "http://127.0.0.1:9");
    command
}

const FRAMES: usize = 12;

#[test]
fn the_real_client_gets_the_boxes_of_track_twice() {
    let Some(python) = python("the_real_client_gets_the_boxes_of_track_twice", "numpy, trax.client") else { return };
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join("frames");
    for format in ["png", "pgm"] {
        let out = folder.path().join(format);
        assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&out), "--format", format]).code, Some(0));
        fs::create_dir_all(&pictures).unwrap();
        for number in 1..=FRAMES {
            let name = format!("{number:05}.{format}");
            fs::rename(out.join(&name), pictures.join(&name)).unwrap();
        }
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/host_sim/trax/client.py");
    for method in ["smr", "robust"] {
        let tracked = host_sim(&["track", "synthetic", "--method", method, "--json"]).json_lines();
        let init = &tracked[0]["box"];
        let [x, y, width, height] = ["x", "y", "width", "height"].map(|side| init[side].to_string());
        for (protocol, way, form) in [
            ("1", "path", "rectangle"),
            ("2", "memory", "polygon"),
            ("3", "buffer", "rectangle"),
            ("4", "path", "polygon"),
            ("4", "memory", "rectangle"),
            ("4", "buffer", "polygon"),
        ] {
            let mut client = Command::new(&python);
            client.arg(&script).args([PROGRAM, method, protocol, way, form, utf8(&pictures), &FRAMES.to_string()]);
            let Output { status, stdout, stderr } = client.args([&x, &y, &width, &height]).output().unwrap();
            let case = format!("{method}, version {protocol}, {way}, {form}");
            assert!(status.success(), "{case}: {}", String::from_utf8_lossy(&stderr));
            let answers = String::from_utf8(stdout).unwrap();
            assert_eq!(answers.lines().count(), 2 * FRAMES, "{case}");
            for (answer, tracked) in answers.lines().zip(tracked[..FRAMES].iter().cycle()) {
                let numbers: Vec<f64> = answer.split(',').map(|number| number.parse().unwrap()).collect();
                let fine = ["x", "y", "width", "height"].map(|side| tracked["fine"][side].as_f64().unwrap());
                let confidence = tracked["confidence"].as_f64().unwrap_or(1.0);
                for (found, expected) in numbers.iter().zip(fine.iter().chain([&confidence])) {
                    assert!((found - expected).abs() < 1e-3, "{case}: {answer}, expected {tracked}");
                }
            }
        }
    }
}

/// Every section of the shipped file, on the toolkit's own short recording with three objects.
#[test]
fn the_vot_toolkit_runs_the_trackers_of_the_shipped_file() {
    let test = "the_vot_toolkit_runs_the_trackers_of_the_shipped_file";
    let Some(python) = python(test, "trax.client, vot.utilities.cli") else { return };
    let shipped = include_str!("../../host-sim/trackers.ini");
    let folder = tempfile::tempdir().unwrap();
    let commands = shipped.replace("command = host-sim", &format!("command = {PROGRAM}"));
    assert_ne!(commands, shipped);
    fs::write(folder.path().join("trackers.ini"), commands).unwrap();
    let names: Vec<&str> = shipped.lines().filter_map(|line| line.strip_prefix('[')?.strip_suffix(']')).collect();
    assert_eq!(names.len(), 3);
    for name in names {
        let run = vot(&python, folder.path()).args(["test", name]).output().unwrap();
        let said = String::from_utf8_lossy(&run.stdout) + String::from_utf8_lossy(&run.stderr);
        // The words of the toolkit.
        assert!(said.contains("Test concluded successfuly"), "{name}: {said}");
        assert!(!said.contains("trax.reason"), "{name}: {said}");
        assert!(said.matches("@@TRAX:state").count() >= 50, "{name}: {said}");
    }
}

/// A workspace with one experiment of the toolkit: three runs over each sequence. Its `supervised` and `multistart` end with an error of the toolkit
/// before the tracker has answered: `host-sim/README.md` says more.
const STACK: &str = "\
title: smr
experiments:
  unsupervised:
    type: unsupervised
    repetitions: 3
    early_stop: false
    analyses:
      - type: average_accuracy
        name: accuracy
";

const CONFIG: &str = "stack: ./stack.yaml\nregistry:\n  - ./trackers.ini\n";

/// A sequence of `convert` and the shipped trackers, from the runs to the report.
#[test]
fn the_vot_toolkit_evaluates_analyses_and_reports() {
    let test = "the_vot_toolkit_evaluates_analyses_and_reports";
    let Some(python) = python(test, "trax.client, vot.utilities.cli") else { return };
    let folder = tempfile::tempdir().unwrap();
    let sequence = folder.path().join("sequences/synthetic");
    let convert = ["convert", "synthetic", "--frames", "..30", "--format", "vot", "-o", utf8(&sequence)];
    assert_eq!(host_sim(&convert).code, Some(0));
    for (name, text) in
        [("trackers.ini", include_str!("../../host-sim/trackers.ini")), ("stack.yaml", STACK), ("config.yaml", CONFIG)]
    {
        fs::write(folder.path().join(name), text).unwrap();
    }
    // The shipped file calls host-sim by its name alone.
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let own = Path::new(PROGRAM).parent().unwrap().to_owned();
    let paths = std::env::join_paths([own].into_iter().chain(std::env::split_paths(&paths))).unwrap();
    let vot = |arguments: &[&str], expected: &str| {
        let run = vot(&python, folder.path()).args(arguments).env("PATH", &paths).output().unwrap();
        let said = String::from_utf8_lossy(&run.stdout) + String::from_utf8_lossy(&run.stderr);
        assert!(said.contains(expected), "{arguments:?}: {said}");
    };
    vot(&["test", "smr_robust"], "Test concluded successfuly");
    vot(&["evaluate", "--workspace", ".", "smr_robust"], "Evaluation concluded successfuly");
    vot(&["analysis", "--workspace", ".", "--name", "smr", "smr_robust"], "Analysis successful");
    vot(&["report", "--workspace", ".", "--name", "smr", "smr_robust"], "Report generation successful");

    let results = folder.path().join("results/smr_robust/unsupervised/synthetic");
    for run in 1..=3 {
        assert!(fs::metadata(results.join(format!("synthetic_00{run}.bin"))).unwrap().len() > 30);
        let confidences = fs::read_to_string(results.join(format!("synthetic_00{run}_confidence.value"))).unwrap();
        let confidences: Vec<f64> = confidences.lines().map(|line| line.parse().unwrap()).collect();
        assert!(confidences.len() == 30 && confidences.iter().all(|&confidence| confidence > 0.5), "{confidences:?}");
    }
    let analysis: Value = serde_json::from_slice(&fs::read(folder.path().join("analysis/smr.json")).unwrap()).unwrap();
    assert_eq!(analysis["sequences"]["synthetic"]["length"], 30);
    let accuracy = &analysis["results"]["unsupervised"]["results"][0][0][0];
    assert!(accuracy.as_f64() > Some(0.95) && accuracy.as_f64() <= Some(1.0), "{analysis}");
    let report = fs::read_to_string(folder.path().join("reports/smr/report.html")).unwrap();
    assert!(report.contains("smr robust") && report.contains(&format!("{:.3}</td>", accuracy.as_f64().unwrap())));
}

#[test]
fn violations_are_exit_code_2_and_the_client_hears_why() {
    let mut server = Command::new(PROGRAM);
    server.arg("trax").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut server = server.spawn().unwrap();
    server.stdin.take().unwrap().write_all(b"@@TRAX:frame \"file:///1.png\"\n").unwrap();
    let Output { status, stdout, stderr } = server.wait_with_output().unwrap();
    let (out, err) = (String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap());
    let reason = "frame before initialize: there is nothing to follow";
    assert_eq!((status.code(), err), (Some(2), format!("error: {reason}\n")));
    assert!(out.starts_with("@@TRAX:hello \"trax.version=4\" \"trax.name=smr\""), "{out}");
    assert!(out.ends_with(&format!("\n@@TRAX:quit \"trax.reason={reason}\"\n")), "{out}");
}
