//! `host-sim` from its user's view: exit codes, one clear line on errors, JSON, complete output.

use crate::missing::recordings;
use crate::program::{PROGRAM, host_sim, utf8};
use crate::tables;
use serde_json::{Value, json};
use std::fs;
use std::process::Command;

#[test]
fn check_reports_as_json() {
    let reports = host_sim(&["check", "periodic", "--config", "camera", "--json"]).json();
    let report = &reports[0];
    assert_eq!(report["sequence"], "periodic");
    assert_eq!(report["frames"], 18);
    assert_eq!(report["violation"], Value::Null);
    assert_eq!(report["runners_up"], 13, "in five frames the gate does not ask for it");
    assert!(report["largest_difference"].as_f64() <= report["bound"].as_f64());
    let always = host_sim(&["check", "periodic", "--config", "camera", "--runner-up-always", "--json"]).json();
    assert_eq!(always[0]["runners_up"], 18);
    let text = host_sim(&["check", "periodic", "--config", "camera"]).out;
    assert!(text.contains("templates; the runner-up in 13 frames, where it is asked for\n"), "{text}");
}

#[test]
fn a_reader_that_goes_away_does_not_change_the_verdict() {
    for arguments in [&["check", "periodic"][..], &["check", "periodic", "--json"], &["track", "periodic"]] {
        let (reader, writer) = std::io::pipe().expect("a pipe can be made");
        drop(reader);
        let mut command = Command::new(PROGRAM);
        let output = command.args(arguments).stdout(writer).output().expect("host-sim runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), said.as_ref()), (Some(0), ""), "{arguments:?}");
    }
}

#[test]
fn eval_of_the_written_recording_is_that_of_the_built_in_one() {
    let folder = tempfile::tempdir().unwrap();
    let written = folder.path().join("synthetic");
    assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&written)]).code, Some(0));
    host_sim(&["convert", "synthetic", "-o", utf8(&written)]).refuses(&[utf8(&written), "empty"]);

    let built_in = host_sim(&["eval", "synthetic", "--method", "smr,sad", "--json"]);
    let rows = built_in.json();
    let files = host_sim(&["eval", utf8(folder.path()), "--method", "smr,sad", "--json"]);
    assert_eq!(built_in.out, files.out, "byte for byte");
    let keys = [
        "tracker",
        "sequence",
        "frames",
        "visible",
        "answered",
        "correct",
        "correct_50",
        "precision",
        "recall",
        "mean_iou",
        "first_failure",
    ];
    let rows = rows["measured"].as_array().unwrap();
    for row in rows {
        assert!(keys.iter().all(|key| row.get(key).is_some()), "{row}");
    }
    assert_eq!(rows[0]["tracker"], "smr");
    assert_eq!((&rows[0]["visible"], &rows[0]["correct"]), (&Value::from(213), &Value::from(213)));
}

#[test]
fn the_results_have_the_figures_of_the_built_in_recording() {
    let iou = |more: &[&str]| {
        let said = host_sim(&[&["eval", "synthetic", "--method", "robust", "--json"], more].concat()).json();
        said["measured"][0]["mean_iou"].as_f64().unwrap()
    };
    let falls = format!("falls from {:.3} to {:.3}", iou(&["--without", "refiner"]), iou(&[]));
    assert!(include_str!("../../host-sim/RESULTS.md").contains(&falls), "host-sim/RESULTS.md: the mean IoU {falls}");
}

#[test]
fn eval_from_many_starts_reports_as_json() {
    let report = host_sim(&["eval", "synthetic", "--robustness", "--starts-every", "100", "--json"]).json();
    let recording = &report["measured"][0];
    assert_eq!((&recording["tracker"], &recording["sequence"]), (&Value::from("smr"), &Value::from("synthetic")));
    // The target is visible in frames 1 to 173 and again from 201 on.
    let frames: Vec<_> = report["starts"].as_array().unwrap().iter().map(|start| &start["frame"]).collect();
    assert_eq!(frames, [1, 101, 228]);
    assert_eq!(recording["worst_correct"], 1.0);
    for key in ["mean_correct", "mean_iou", "precision", "work_per_frame", "microseconds_per_frame"] {
        assert!(recording[key].as_f64() > Some(0.0), "{key}: {recording}");
    }
    assert!(recording["answered_hidden"].as_u64() <= recording["hidden"].as_u64());
    assert_eq!((&report["means"][0]["recordings"], &report["means"][0]["folder"]), (&Value::from(1), &Value::Null));
    assert_eq!(report["means"][0]["mean_correct"], recording["mean_correct"]);
}

/// On the five generated recordings.
#[test]
fn eval_of_a_covered_lens_reports_as_json() {
    let said = host_sim(&["eval", "--covered", "--method", "robust", "--json"]);
    assert_eq!(said.code, Some(0));
    let report = said.json();
    tables::are_flat("eval --covered", &report, &[("measured", 25), ("means", 5)]);
    let covers = report["means"].as_array().unwrap();
    let names: Vec<_> = covers.iter().map(|row| &row["cover"]).collect();
    assert_eq!(names, ["black", "white", "gray", "noise", "frozen"]);
    let black = &covers[0];
    assert_eq!((&black["tracker"], &black["recordings"]), (&Value::from("robust"), &Value::from(5)));
    assert_eq!((&black["tracking_most"], &black["lost_in_time"]), (&Value::from(0), &Value::from(5)));
    let runs = report["measured"].as_array().unwrap();
    assert_eq!(runs.len(), 5 * 5);
    for run in runs.iter().filter(|run| run["cover"] == "black") {
        assert_eq!(run["tracking"], 0, "{run}");
        assert!(run["lost_at"].as_u64() <= Some(30) && run["right_before"] == true, "{run}");
    }
}

/// Every command that runs a tracker takes every method by its name.
const METHODS: [&str; 6] = ["smr", "robust", "sad", "ssd", "ncc", "lk"];

#[test]
fn every_method_has_its_rows_in_one_table() {
    let all = METHODS.join(",");
    let rows = host_sim(&["eval", "synthetic", "--method", &all, "--backend", "scalar", "--json"]).json();
    let rows = rows["measured"].as_array().unwrap();
    assert_eq!(rows.len(), METHODS.len());
    for (row, method) in rows.iter().zip(METHODS) {
        assert_eq!((&row["tracker"], &row["method"]), (&method.into(), &method.into()));
        assert_eq!(row["version"], env!("CARGO_PKG_VERSION"));
        let options = if METHODS[..2].contains(&method) { "{\"backend\":\"scalar\"}" } else { "{}" };
        assert_eq!(row["options"], options, "{method}");
    }
    let text = host_sim(&["eval", "synthetic", "--method", "robust,smr"]).out;
    let names: Vec<&str> = text.lines().skip(1).take(2).map(|line| line.split("  ").next().unwrap()).collect();
    assert_eq!(names, ["robust", "smr"]);
}

/// The keys of an answer, in their order.
const KEYS: [&str; 16] = [
    "version",
    "method",
    "options",
    "frame",
    "time",
    "state",
    "box",
    "fine",
    "confidence",
    "ratio",
    "runner_up_ratio",
    "alpha",
    "scale",
    "found_again",
    "work",
    "quality",
];

#[test]
fn every_method_answers_with_the_same_fields() {
    for method in METHODS {
        let said = host_sim(&["track", "periodic", "--method", method, "--json"]);
        let places = KEYS.map(|key| said.out.find(&format!("\"{key}\":")).expect("the key is there"));
        assert!(places.is_sorted(), "{method}: {places:?}");
        let lines = said.json_lines();
        assert_eq!(lines.len(), 19);
        for line in &lines {
            assert_eq!(line.as_object().unwrap().len(), KEYS.len(), "{line}");
            assert_eq!((&line["method"], &line["options"]), (&method.into(), &json!({})));
            let lost = line["state"] == "lost";
            assert_eq!((line["box"].is_null(), line["fine"].is_null()), (lost, lost), "{line}");
        }
        let quality = lines.iter().map(|line| !line["quality"].is_null());
        assert!(quality.eq((0..19).map(|number| number == 0 && METHODS[..2].contains(&method))), "{method}");
        // For the first frame only the box is known.
        assert_eq!((&lines[0]["confidence"], &lines[0]["state"]), (&Value::Null, &"tracking".into()));
        let known = |key: &str| lines[1..].iter().all(|line| !line[key].is_null());
        for key in ["confidence", "ratio", "scale", "found_again", "work"] {
            assert_eq!(known(key), METHODS[..2].contains(&method), "{method}: {key}");
        }
        assert_eq!(known("alpha"), method == "smr", "{method}");
    }
}

#[test]
fn the_robust_tracker_is_a_method_like_the_others() {
    let lines = host_sim(&["track", "synthetic", "--method", "robust", "--json"]).json_lines();
    assert_eq!(lines.len(), 240);
    let known = ["tracking", "uncertain", "lost"].map(Value::from);
    assert!(lines.iter().all(|line| known.contains(&line["state"])));
    let finer = |line: &Value| line["fine"]["x"].as_f64().is_some_and(|x| x.fract() != 0.0);
    assert!(lines.iter().any(finer), "boxes are finer than a pixel");
    assert!(lines.iter().all(|line| line["box"]["x"].is_null() || line["box"]["x"].is_i64()));
    assert!(lines.iter().any(|line| line["scale"].as_f64().is_some_and(|scale| scale != 1.0)));

    let checked = host_sim(&["check", "periodic", "--method", "robust", "--without", "size,sweep", "--json"]).json();
    assert_eq!((&checked[0]["method"], &checked[0]["violation"]), (&"robust".into(), &Value::Null));
    assert_eq!(checked[0]["options"], json!({ "without": ["size", "sweep"] }));
    assert!(checked[0]["responses"].as_u64() > Some(0));

    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let methods = METHODS.join(",");
    let report = host_sim(&["report", "synthetic", "--method", &methods, "--out", utf8(&page), "--json"]).json();
    for (place, method) in METHODS.iter().enumerate() {
        assert_eq!(report["scores"]["measured"][place]["tracker"], *method);
        assert_eq!(report["methods"][place]["method"], *method);
        let page = fs::read_to_string(&page).unwrap();
        assert!(page.contains(&format!("</svg>{}</span></th>", method.to_uppercase())), "{method}");
    }
}

#[test]
fn steps_change_no_answer() {
    let without_work = |said: crate::program::Said| -> Vec<Value> {
        let mut lines = said.json_lines();
        for line in &mut lines {
            (line["work"], line["options"]) = (Value::Null, Value::Null);
        }
        lines
    };
    for method in ["smr", "robust"] {
        let whole = without_work(host_sim(&["track", "border", "--method", method, "--json"]));
        let stepped = without_work(host_sim(&["track", "border", "--method", method, "--step", "1000", "--json"]));
        assert_eq!(whole, stepped, "{method}");
        assert_eq!(host_sim(&["check", "periodic", "--method", method, "--step", "1"]).code, Some(0));
    }
}

#[test]
fn report_says_what_it_wrote() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("a page.html");
    let said = host_sim(&["report", "periodic", "--out", utf8(&page), "--json"]).json();
    assert_eq!(said["recordings"][0]["frames"], 19);
    assert_eq!(said["recordings"][0]["pictures"], json!({ "frames": 19, "longest_side": 64 }));
    assert_eq!(said["files"][0]["bytes"], fs::metadata(&page).unwrap().len());
    let again = format!("host-sim report periodic --out '{}' --json", utf8(&page));
    let shown = fs::read_to_string(&page).unwrap().replace("&#x27;", "'").replace("&#x2f;", "/");
    assert!(shown.contains(&again), "{again}");
    assert_eq!(host_sim(&["report", "periodic"]).code, Some(2));
    host_sim(&["report", "no/such/recording", "--out", utf8(&page)]).refuses(&["no/such/recording"]);
    fs::create_dir(folder.path().join("taken.html")).unwrap();
    let taken = folder.path().join("taken.html");
    host_sim(&["report", "periodic", "--out", utf8(&taken)]).refuses(&["cannot write", utf8(&taken)]);
}

#[test]
fn track_writes_a_json_object_a_frame() {
    let lines = host_sim(&["track", "periodic", "--method", "smr", "--json"]).json_lines();
    assert_eq!(lines.len(), 19);
    assert_eq!(lines[6]["frame"], 7);
    assert_eq!((&lines[6]["state"], &lines[6]["box"]), (&Value::from("lost"), &Value::Null));
}

/// The recordings are not part of the project: `host-sim/README.md` says where the tests expect them.
#[test]
fn the_recorded_sequences_are_followed_as_the_readme_says() {
    let Some(tld) = recordings("the_recorded_sequences_are_followed_as_the_readme_says", "tld") else { return };
    let sequences = ["03_pedestrian1", "05_pedestrian3"].map(|name| tld.join(name));
    let rows = host_sim(&["eval", utf8(&sequences[0]), utf8(&sequences[1]), "--json"]).json();
    let correct = |row: usize| &rows["measured"][row]["correct"];
    assert_eq!((correct(0), correct(1)), (&Value::from(87), &Value::from(52)));
}
