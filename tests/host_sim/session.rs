//! The outputs for the user: conversions, videos, live input and help.

use crate::missing::has_c_compiler;
use crate::program::{PROGRAM, host_sim, utf8};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};

#[test]
fn convert_reports_and_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let (small, again) = (folder.path().join("small"), folder.path().join("again.y4m"));
    let report = host_sim(&[
        "convert",
        "synthetic",
        "-o",
        utf8(&small),
        "--format",
        "raw",
        "--frames",
        "11..20",
        "--resize",
        "1/2",
        "--json",
    ])
    .json();
    let (width, height) = (report["width"].as_u64().unwrap(), report["height"].as_u64().unwrap());
    assert_eq!((&report["frames"], &report["format"]), (&Value::from(10), &Value::from("raw")));
    assert_eq!(report["bytes"], Value::from(10 * width * height));
    assert_eq!(report["boxes"], serde_json::json!(["init.txt", "gt.txt"]));
    assert_eq!(fs::read_to_string(small.join("gt.txt")).unwrap().lines().count(), 10);

    let size = format!("{width}x{height}");
    let said = host_sim(&["convert", utf8(&small), "--size", &size, "-o", utf8(&again)]);
    let start = "10 frames of ";
    assert!(said.out.contains(start) && said.out.contains("; it starts with --init "), "{}", said.out);
    let boxes = |path, more: &[&str]| host_sim(&[&["track", path, "--method", "robust"], more].concat()).out;
    let init = said.out.trim_end().rsplit(' ').next().unwrap();
    assert_eq!(boxes(utf8(&again), &["--init", init]), boxes(utf8(&small), &["--size", &size]));

    host_sim(&["convert", "synthetic", "-o", utf8(&small)]).refuses(&[utf8(&small), "is not empty"]);
    host_sim(&["convert", "synthetic", "-o", "a.raw", "--format", "pgm"]).refuses(&["--format pgm", "a.raw"]);
    let late = folder.path().join("late.raw");
    host_sim(&["convert", "synthetic", "-o", utf8(&late), "--frames", "9999.."]).refuses(&["no frame 9999"]);
    assert!(!late.exists());
}

#[test]
fn without_arguments_a_target_is_followed_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let run = Command::new(PROGRAM).current_dir(folder.path()).stdin(Stdio::null()).output().unwrap();
    let said = String::from_utf8(run.stdout).unwrap();
    assert!(run.status.success() && said.contains("smr-demo.html") && said.contains("--init"), "{said}");
    let page = fs::read_to_string(folder.path().join("smr-demo.html")).unwrap();
    assert!(page.contains("<html") && page.contains("robust"));
}

#[test]
fn a_recording_without_a_command_opens_the_window() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [["synthetic", "--no-open", "--json"], ["--no-open", "--json", "synthetic"]] {
        let mut window = Command::new(PROGRAM);
        window.args(arguments).env("TMPDIR", folder.path()).stdin(Stdio::null()).stdout(Stdio::piped());
        let mut window = window.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(window.stdout.take().unwrap()).read_line(&mut line).unwrap();
        window.kill().and_then(|()| window.wait()).unwrap();
        assert!(line.contains("http://127.0.0.1:"), "{arguments:?}: {line}");
    }
}

#[test]
fn convert_reports_what_it_wrote() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("frames");
    let said = host_sim(&["convert", "synthetic", "-o", utf8(&out), "--format", "y4m", "--json"]).json();
    assert_eq!((&said["frames"], &said["format"], &said["width"]), (&240.into(), &"y4m".into(), &160.into()));
    assert!(out.join("synthetic.y4m").exists());
}

#[test]
fn a_sequence_for_the_vot_toolkit_keeps_the_pixels_and_says_what_it_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let sequences = folder.path().join("sequences");
    let written = |name: &str, out: &str| {
        host_sim(&["convert", name, "--format", "vot", "--frames", "..15", "-o", utf8(&sequences.join(out))])
    };
    let whole = written("synthetic", "whole");
    assert_eq!((whole.code, whole.err.as_str()), (Some(0), ""));
    let tracked = |name: &str| host_sim(&["track", name, "--frames", "..15"]).out;
    assert_eq!(tracked(utf8(&sequences.join("whole"))), tracked("synthetic"));

    let bare = written("periodic", "bare");
    assert!(bare.code == Some(0) && bare.err.contains("periodic: no ground truth for each frame"), "{}", bare.err);
    assert!(bare.out.contains("groundtruth.txt, sequence; added to"), "{}", bare.out);
    assert_eq!(fs::read_to_string(sequences.join("bare/groundtruth.txt")).unwrap().lines().count(), 1);
    assert_eq!(fs::read_to_string(sequences.join("list.txt")).unwrap(), "whole\nbare\n");
    assert!(fs::read_to_string(folder.path().join("config.yaml")).unwrap().starts_with("registry:\n- trackers.ini\n"));

    let picture = folder.path().join("picture.pgm");
    fs::write(&picture, b"P5 2 2 255\n\x01\x02\x03\x04").unwrap();
    let otb = folder.path().join("otb");
    host_sim(&["convert", utf8(&picture), "--format", "otb", "-o", utf8(&otb)]).refuses(&["--format otb", "--init"]);
    assert!(!otb.exists());
}

#[test]
fn parts_are_shown_and_checked_as_they_are_followed() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("part.html");
    let said = host_sim(&["report", "synthetic", "--frames", "20..40", "-o", utf8(&page), "--json"]).json();
    assert_eq!(said["recordings"][0]["frames"], Value::from(21));
    let said = host_sim(&["check", "synthetic", "--frames", "20..40", "--json"]).json();
    assert_eq!(said[0]["frames"], Value::from(20), "one is locked on");
    host_sim(&["report", "synthetic", "--frames", "300..", "-o", utf8(&page)]).refuses(&["no frame 300"]);
    host_sim(&["check", "synthetic", "--frames", "7"]).refuses_usage("20..80");
}

/// Other trackers' results cover the whole recording. For a part of the recording, the same part of the results is compared.
#[test]
fn results_of_others_are_cut_with_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("clip");
    assert_eq!(
        host_sim(&["convert", "synthetic", "-o", utf8(&recording), "--frames", "1..30", "--format", "y4m"]).code,
        Some(0)
    );
    fs::create_dir(recording.join("trackers")).unwrap();
    fs::copy(recording.join("gt.txt"), recording.join("trackers/perfect.txt")).unwrap();
    let page = folder.path().join("page.html");
    let said = host_sim(&["report", utf8(&recording), "--frames", "11..", "-o", utf8(&page), "--json"]).json();
    let scores = said["scores"]["measured"].as_array().unwrap();
    let perfect = scores.iter().find(|score| score["method"] == "perfect" || score["tracker"] == "perfect");
    let perfect = perfect.unwrap_or_else(|| panic!("{scores:?}"));
    assert_eq!(perfect["correct"], 20, "{perfect}");
}

#[test]
fn a_part_is_measured_under_a_name_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    // In the form of a recording of the paper's table.
    let car = folder.path().join("deep/er/06_car");
    assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&car), "--format", "y4m"]).code, Some(0));
    let rows = host_sim(&["eval", utf8(folder.path()), "--frames", "5..24", "--json"]).json();
    let part = &rows["measured"][0];
    assert_eq!((&part["sequence"], &part["frames"]), (&"06_car 5..24".into(), &20.into()));
    let printed = |of: &Value| of["printed"].as_array().unwrap().len();
    assert_eq!(printed(&rows), 0, "nothing printed stands beside a part: {rows:?}");
    let whole = host_sim(&["eval", utf8(&car), "--method", "smr", "--json"]).json();
    assert_eq!(printed(&whole), 5);
}

#[test]
fn eval_prints_the_figures_of_otb_and_vot_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for (name, frames) in [("a", "1..12"), ("b", "5..20")] {
        let recording = folder.path().join(name);
        let convert = ["convert", "synthetic", "-o", utf8(&recording), "--format", "y4m", "--frames", frames];
        assert_eq!(host_sim(&convert).code, Some(0));
        // Another tracker that gives the ground truth in the first half of the frames, then no answer.
        let truth = fs::read_to_string(recording.join("gt.txt")).unwrap();
        let half: Vec<&str> = truth.lines().take(truth.lines().count() / 2).collect();
        fs::create_dir(recording.join("trackers")).unwrap();
        fs::write(recording.join("trackers/half.txt"), half.join("\n")).unwrap();
    }
    let eval = ["eval", utf8(folder.path()), "--method", "robust,sad", "--compare"];
    let said = |more: &[&str]| host_sim(&[&eval, more].concat());
    let json = said(&["--json"]).json();
    let rows = json["measured"].as_array().unwrap();
    assert_eq!((rows.len(), json["means"].as_array().unwrap().len()), (3 * 2, 3));
    let close = |value: &Value, to: f64| (value.as_f64().unwrap() - to).abs() < 1e-9;
    for row in &rows[4..6] {
        assert_eq!(row["tracker"], "half");
        assert!(close(&row["otb_auc"], 10.0 / 21.0) && close(&row["otb_precision"], 0.5), "{row}");
        assert!(close(&row["vot_f"], 2.0 / 3.0) && row["vot_threshold"].is_null(), "{row}");
    }
    assert!(rows[0]["vot_threshold"].is_f64() && rows[2]["vot_threshold"].is_null());
    let mean = &json["means"][2];
    assert_eq!((&mean["tracker"], &mean["recordings"]), (&"half".into(), &2.into()));
    assert!(close(&mean["otb_precision"], 0.5) && close(&mean["otb_precision_standard_error"], 0.0));

    let text = said(&[]).out;
    assert!(text.lines().next().unwrap().contains("OTB AUC  OTB P20  VOT F  threshold"), "{text}");
    assert!(text.contains("half     mean of 2 ") && text.contains("half       standard error "), "{text}");
    let csv = said(&["--format", "csv"]).out;
    assert_eq!(csv.lines().count(), 1 + 3 * 2);
    assert!(csv.starts_with("tracker,sequence,frames,") && csv.contains("\nhalf,b,16,"), "{csv}");
    let means = said(&["--format", "csv", "--part", "means"]).out;
    assert!(means.starts_with("tracker,recordings,") && means.contains("\nhalf,2,"), "{means}");
    let markdown = said(&["--format", "markdown"]).out;
    assert!(markdown.starts_with("| tracker | sequence |") && markdown.contains("| half | mean of 2 |"), "{markdown}");

    let unknown = said(&["--format", "html"]);
    assert!(unknown.code == Some(2) && unknown.err.contains("text, markdown, csv"), "{}", unknown.err);
    let both = said(&["--format", "csv", "--json"]);
    assert!(both.code == Some(2) && both.out.is_empty() && both.err.contains("--json"), "{}", both.err);
    host_sim(&["eval", "synthetic", "--part", "means"]).refuses(&["--part", "--format csv"]);
    let starts = ["eval", "synthetic", "--format", "csv", "--part", "starts"];
    host_sim(&starts).refuses(&["--part starts", "measured, means, printed"]);
    fs::write(folder.path().join("a/trackers/half.txt"), "1,2,three,4\n").unwrap();
    let broken = said(&["--format", "csv"]);
    assert_eq!(broken.code, Some(2));
    assert!(broken.err.contains("half.txt: line 1") && broken.out.contains("\nrobust,a,"), "{}", broken.err);
}

#[test]
fn a_c_array_compiles() {
    if !has_c_compiler("a_c_array_compiles") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (header, source) = (folder.path().join("my clip.h"), folder.path().join("main.c"));
    assert_eq!(host_sim(&["convert", "periodic", "-o", utf8(&header), "--frames", "1..3"]).code, Some(0));
    let text = "#include \"my clip.h\"\nint main(void) { return MY_CLIP_FRAMES == 3 && sizeof my_clip == 3 * MY_CLIP_WIDTH * MY_CLIP_HEIGHT ? 0 : 1; }\n";
    fs::write(&source, text).unwrap();
    let program = folder.path().join("program");
    let compiler =
        Command::new("cc").args(["-std=c99", "-Wall", "-Werror", "-pedantic", "-o"]).args([&program, &source]).status();
    assert!(compiler.unwrap().success());
    assert!(Command::new(program).status().unwrap().success());
    // Recordings that are called like something of the language or of its headers.
    for name in ["int", "default", "size", "time", "linux"] {
        let header = folder.path().join(format!("{name}.h"));
        assert_eq!(host_sim(&["convert", "periodic", "-o", utf8(&header), "--frames", "1..1"]).code, Some(0));
        let text = format!(
            "#include <limits.h>\n#include <stdint.h>\n#include <time.h>\n#include \"{name}.h\"\nconst unsigned char *first = frames_{name}[0];\n"
        );
        fs::write(&source, text).unwrap();
        let checked = Command::new("cc").args(["-Wall", "-Werror", "-fsyntax-only"]).arg(&source).status();
        assert!(checked.unwrap().success(), "{name}");
    }
}

#[test]
fn every_frame_is_answered_as_it_comes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("live.y4m");
    assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&file), "--frames", "1..6"]).code, Some(0));
    let expected = host_sim(&["track", "synthetic", "--frames", "1..6"]).out;
    let bytes = fs::read(&file).unwrap();
    let start = bytes.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    let frame = (bytes.len() - start) / 6;

    let [x, y, right, bottom] = expected
        .lines()
        .next()
        .unwrap()
        .split(',')
        .map(|number| number.parse::<i32>().unwrap())
        .collect::<Vec<_>>()[..]
    else {
        panic!()
    };
    let init = format!("{x},{y},{},{}", right - x, bottom - y);
    let mut live = Command::new(PROGRAM);
    let mut live =
        live.args(["track", "-", "--init", &init]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let (mut to, mut from) = (live.stdin.take().unwrap(), BufReader::new(live.stdout.take().unwrap()));
    to.write_all(&bytes[..start]).unwrap();
    for (number, expected) in expected.lines().enumerate() {
        to.write_all(&bytes[start + number * frame..][..frame]).unwrap();
        to.flush().unwrap();
        let mut line = String::new();
        // The next frame is sent after the answer. If answers were held back, this would wait forever.
        from.read_line(&mut line).unwrap();
        assert_eq!(line.trim_end(), expected);
    }
    drop(to);
    let mut rest = String::new();
    from.read_to_string(&mut rest).unwrap();
    assert_eq!((rest.as_str(), live.wait().unwrap().code()), ("", Some(0)));

    let mut refused = Command::new(PROGRAM);
    let refused = refused.args(["track", "-"]).stdin(fs::File::open(&file).unwrap()).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("standard input: no box to start from: give --init"));
}

#[test]
fn a_video_is_there_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join("boxes");
    let said = host_sim(&["track", "synthetic", "--frames", "1..5", "--video", utf8(&pictures)]);
    assert_eq!((said.code, said.out.lines().count()), (Some(0), 5), "{}", said.err);
    assert_eq!(fs::read_dir(&pictures).unwrap().count(), 5);
    host_sim(&["track", "synthetic", "--video", "a.avi"]).refuses(&["a.avi", ".mkv or .webm"]);

    let cut = folder.path().join("cut.y4m");
    assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&cut), "--frames", "1..4"]).code, Some(0));
    let bytes = fs::read(&cut).unwrap();
    fs::write(&cut, &bytes[..bytes.len() - 100]).unwrap();
    let video = folder.path().join("cut");
    let said = host_sim(&["track", utf8(&cut), "--init", "40,40,40,30", "--video", utf8(&video)]);
    assert_eq!((said.code, said.out.lines().count(), video.exists()), (Some(2), 3, false), "{}", said.err);
}

#[test]
fn the_extension_says_what_a_file_holds() {
    let folder = tempfile::tempdir().unwrap();
    for (name, beginning) in [
        ("boxes.csv", "frame,time,x,y,"),
        ("boxes.json", "{\"version\":"),
        ("boxes.xml", "<?xml version=\"1.0\""),
        ("boxes.txt", "36,24,60,52\n"),
    ] {
        let file = folder.path().join(name);
        assert_eq!(host_sim(&["track", "synthetic", "--frames", "..2", "-o", utf8(&file)]).code, Some(0));
        let text = fs::read_to_string(&file).unwrap();
        assert!(text.starts_with(beginning), "{name}: {text}");
    }
    let both = ["track", "synthetic", "-o", "a.mp4", "--video", "b.mp4"];
    host_sim(&both).refuses(&["--out and --video both name a video"]);
}

#[cfg(target_os = "linux")]
#[test]
fn on_a_terminal_a_film_comes_with_what_happens_instead_of_numbers() {
    if !crate::missing::has("on_a_terminal_a_film_comes_with_what_happens_instead_of_numbers", "script", &["--version"])
    {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let film = folder.path().join("film");
    let line = format!("'{PROGRAM}' track synthetic --frames ..20 --video '{}'", film.display());
    let output = Command::new("script").args(["-qec", &line, "/dev/null"]).stdin(Stdio::null()).output();
    let said = String::from_utf8_lossy(&output.unwrap().stdout).into_owned();
    assert!(said.contains("locked at frame 1") && said.contains(&format!("{}: 20 frames", film.display())), "{said}");
    assert!(said.contains("tracking 20") && said.contains("20 frames, ") && !said.contains("36,24,60,52"), "{said}");
    assert_eq!(fs::read_dir(&film).unwrap().count(), 20);
}

#[test]
fn options_are_echoed() {
    let options = ["--method", "smr", "--config", "camera", "--window", "20x16", "--exhaustive"];
    let said = host_sim(&[&["track", "synthetic", "--frames", "1..8", "--json"], &options[..]].concat());
    let expected = serde_json::json!({ "config": "camera", "window": "20x16", "exhaustive": true });
    assert_eq!(said.json_lines()[0]["options"], expected);
}

#[test]
fn each_command_has_an_example() {
    let help = host_sim(&["--help"]).out;
    let commands = help.split("Commands:").nth(1).unwrap().split("\n\n").next().unwrap().to_owned();
    let commands: Vec<&str> = commands.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.len() >= 7 && commands.contains(&"replay"), "{commands:?}");
    for command in commands.iter().filter(|&&command| command != "help") {
        let help = host_sim(&[command, "--help"]);
        assert!(help.out.contains("Example") && help.out.contains(&format!("host-sim {command}")), "{command}");
    }
}

#[test]
fn no_color_is_heeded() {
    let help = |variables: &[(&str, &str)]| {
        let mut command = Command::new(PROGRAM);
        // As on a terminal.
        command.env_remove("NO_COLOR").env("CLICOLOR_FORCE", "1").envs(variables.iter().copied());
        command.args(["track", "--help"]).output().unwrap().stdout
    };
    let escapes = |text: Vec<u8>| text.contains(&0x1B);
    assert!(escapes(help(&[])), "the test can fail");
    assert!(!escapes(help(&[("NO_COLOR", "1")])));
}
