//! `host-sim` and input that is not as it should be: damage, options that do not fit, files that cannot be written.

mod program;

use program::{PROGRAM, host_sim, recordings, utf8};
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Ten frames as JPEGs with ground truth, the fourth of them cut.
fn cut_recording(folder: &Path) -> PathBuf {
    let written = folder.join("cut");
    assert_eq!(host_sim(&["synth", utf8(&written), "--format", "y4m"]).code, Some(0));
    let file = written.join("synthetic.y4m");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() - 100]).unwrap();
    written
}

#[test]
fn a_picture_without_pixels_is_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    for header in ["P5\n0 0\n255\n", "P5\n0 5\n255\n", "P6\n0 0\n255\n"] {
        let file = folder.path().join("1.pgm");
        fs::write(&file, header).unwrap();
        host_sim(&["track", utf8(&file), "--init", "0,0,1,1"]).refuses(&["1.pgm"]);
    }
}

/// A video as `arguments` of ffmpeg make it; `None`, and a word about it, without ffmpeg.
fn film(test: &str, file: &Path, arguments: &[&str]) -> Option<()> {
    let source = ["-v", "error", "-f", "lavfi", "-i"];
    let made = Command::new("ffmpeg").args(source).args(arguments).arg(file).status();
    if made.is_err() {
        // Not `println!`, which is not shown for a test that passes.
        let _ = writeln!(std::io::stderr(), "skipped: {test}: no ffmpeg");
        return None;
    }
    assert!(made.unwrap().success(), "{arguments:?}");
    Some(())
}

/// What phones make: turned by a note in the file, and frames as they come.
#[test]
fn videos_of_phones_are_shown_upright_and_whole() {
    const TEST: &str = "videos_of_phones_are_shown_upright_and_whole";
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let (plain, turned, uneven) = (file("plain.mp4"), file("turned.mp4"), file("uneven.mp4"));
    if film(TEST, &plain, &["testsrc=size=320x240:rate=30:duration=1", "-pix_fmt", "yuv420p"]).is_none() {
        return;
    }
    let note = ["-c", "copy", "-metadata:s:v:0", "rotate=90"];
    let copied = Command::new("ffmpeg").args(["-v", "error", "-i", utf8(&plain)]).args(note).arg(&turned).status();
    assert!(copied.unwrap().success());
    let picture = file("frame.png");
    let size = |video: &Path| {
        let said = host_sim(&["frame", utf8(video), "-o", utf8(&picture), "--json"]).json();
        (said["width"].as_u64().unwrap(), said["height"].as_u64().unwrap())
    };
    assert_eq!((size(&plain), size(&turned)), ((320, 240), (240, 320)));

    // Two of three frames are left out, those that stay keep their times: none is invented to fill the gaps.
    let some = ["testsrc=size=321x241:rate=30:duration=1", "-vf", "select=not(mod(n\\,3))", "-vsync", "vfr"];
    film(TEST, &uneven, &[&some[..], &["-pix_fmt", "yuv444p"]].concat()).unwrap();
    let said = host_sim(&["track", utf8(&uneven), "--init", "100,100,40,40"]);
    assert_eq!((said.code, said.out.lines().count()), (Some(0), 10), "{}", said.err);
    assert_eq!(size(&uneven), (321, 241));
}

#[test]
fn the_smallest_recording_can_be_shown() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["1.pgm", "2.pgm"] {
        fs::write(folder.path().join(name), b"P5 1 1 255\n\x50").unwrap();
    }
    let one = utf8(folder.path());
    let out = tempfile::tempdir().unwrap();
    let page = out.path().join("page.html");
    for command in [&["report", one, "-o", utf8(&page)][..], &["figures", one, "-o", utf8(out.path())], &["track", one]]
    {
        let said = host_sim(&[command, &["--init", "0,0,1,1"]].concat());
        assert_eq!(said.code, Some(0), "{command:?}: {}", said.err);
    }
    // Who does not know the box yet is told how to find it.
    host_sim(&["track", one]).refuses(&["no box to start from", "--init X,Y,W,H", "host-sim frame"]);
}

#[test]
fn damage_is_an_error_or_counted() {
    let folder = tempfile::tempdir().unwrap();
    let recording = cut_recording(folder.path());
    let file = utf8(&recording);
    host_sim(&["track", file]).refuses(&["frame 240", "cut short", "--lenient"]);
    let said = host_sim(&["track", file, "--lenient"]);
    assert_eq!((said.code, said.err.as_str()), (Some(0), "note: cut: a frame is damaged\n"));
    assert_eq!(said.out.lines().count(), 239);
}

#[test]
fn a_file_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let recording = cut_recording(folder.path());
    let boxes = folder.path().join("boxes.txt");
    fs::write(&boxes, "former").unwrap();
    host_sim(&["track", utf8(&recording), "--out", utf8(&boxes)]).refuses(&["frame 240"]);
    assert_eq!(fs::read_to_string(&boxes).unwrap(), "former");
    assert_eq!(host_sim(&["track", utf8(&recording), "--lenient", "--out", utf8(&boxes)]).code, Some(0));
    assert_eq!(fs::read_to_string(&boxes).unwrap().lines().count(), 239);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left over");
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("no").join("such").join("file.svg");
    let file = utf8(&file);
    // None of them comes to its frames, which are not there.
    let missing = folder.path().join("empty.y4m");
    fs::write(&missing, "YUV4MPEG2 W9 H9 Cmono\n").unwrap();
    let recording = utf8(&missing);
    for arguments in [
        &["track", recording, "--init", "0,0,4,4", "--out", file][..],
        &["report", recording, "--init", "0,0,4,4", "--png", file],
        &["eval", recording, "--robustness", "--calibration", file],
        &["bench", recording, "--plot", file],
    ] {
        host_sim(arguments).refuses(&["cannot write", file]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named() {
    host_sim(&["track", "periodic", "--out", "/dev/full"]).refuses(&["cannot write /dev/full", "No space left"]);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = Command::new(PROGRAM).args(["track", "periodic"]).stdout(full).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.starts_with("error: cannot write to standard output: No space left"), "{said}");
}

#[test]
fn boxes_to_start_from_have_their_numbers_in_messages() {
    host_sim(&["track", "synthetic", "--init", "-5,1,20,20"]).refuses(&["-5,1,20,20", "frame of", "inside the frame"]);
    host_sim(&["track", "synthetic", "--init", "0,0,70000,5"]).refuses(&["too large", "65535", "0,0,70000,5"]);
    let folder = tempfile::tempdir().unwrap();
    let large = folder.path().join("large.raw");
    fs::write(&large, vec![7; 2 * 400 * 300]).unwrap();
    let arguments = ["track", utf8(&large), "--size", "400x300", "--init", "0,0,300,300"];
    host_sim(&arguments).refuses(&["0,0,300,300", "90000 pixels", "at most 65536", "--method robust"]);
    for other in [&["--method", "sad"][..], &["--method", "lk"], &["--method", "robust"]] {
        let said = host_sim(&[&arguments[..], other].concat());
        assert_eq!((said.code, said.err.as_str()), (Some(0), ""), "{other:?}");
        assert_eq!(said.out.lines().count(), 2);
    }
}

#[test]
fn a_window_beyond_its_limit_has_its_numbers_in_messages() {
    let limit = ["track", "synthetic", "--window-limit"];
    host_sim(&[&limit[..], &["20x60"]].concat()).refuses(&["--window-limit 20x60", "60x50", "65535x65535"]);
    host_sim(&[&limit[..], &["60x49", "--window", "9x50"]].concat()).refuses(&["60x49", "9x50 to 65535x65535"]);
    assert_eq!(host_sim(&[&limit[..], &["9x50", "--window", "9x50"]].concat()).code, Some(0));
    let camera = ["track", "synthetic", "--config", "camera", "--window", "81x9"];
    host_sim(&camera).refuses(&["--window 81x9", "80x70", "--window-limit"]);
}

#[test]
fn options_that_nothing_takes_are_refused() {
    for command in ["track", "eval"] {
        host_sim(&[command, "synthetic", "--method", "sad", "--k", "1/2"]).refuses(&["--k", "smr"]);
        assert_eq!(host_sim(&[command, "synthetic", "--method", "sad", "--window", "9x9"]).code, Some(0));
    }
    assert_eq!(host_sim(&["eval", "synthetic", "--method", "sad,smr", "--k", "1/2"]).code, Some(0));
    host_sim(&["track", "synthetic", "--size", "9x9"]).refuses(&["--size", "synthetic"]);
    for command in [&["eval"][..], &["eval", "--robustness"], &["check"], &["bench"]] {
        host_sim(&[command, &["synthetic", "periodic", "--init", "1,1,9,9"]].concat()).refuses(&["--init", "2"]);
    }
    host_sim(&["check", "--init", "1,1,9,9"]).refuses(&["--init", "3"]);
}

#[test]
fn robustness_is_compared_with_what_was_measured_before() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("former.json");
    let arguments = ["eval", "synthetic", "noise", "--robustness", "--single-start", "--method", "sad,lk"];
    let former = host_sim(&[&arguments[..], &["--json"]].concat());
    assert_eq!((former.code, former.err.as_str()), (Some(0), ""));
    fs::write(&file, &former.out).unwrap();
    let former: Value = serde_json::from_str(&former.out).unwrap();
    assert_eq!(former["recordings"][0]["starts"].as_array().unwrap().len(), 1);
    assert_eq!((&former["paired"][0]["tracker"], &former["paired"][0]["against"]), (&"lk".into(), &"sad".into()));
    assert!(former["means"][0]["standard_error"]["mean_correct"].as_f64().is_some());

    let said = host_sim(&[&arguments[..], &["--against", utf8(&file), "--json"]].concat());
    let now: Value = serde_json::from_str(&said.out).unwrap();
    for paired in now["paired"].as_array().unwrap() {
        assert_eq!((&paired["recordings"], &paired["difference"]["f"]), (&2.into(), &Value::from(0.0)));
    }
    let text = host_sim(&[&arguments[..], &["--against", utf8(&file)]].concat()).out;
    assert!(text.contains("paired difference") && text.contains("  standard error"), "{text}");

    host_sim(&["eval", "synthetic", "--robustness", "--against", utf8(&file)]).refuses(&["other starts"]);
    host_sim(&["eval", "synthetic", "--robustness", "--against", "no/such.json"]).refuses(&["no/such.json"]);
    assert_eq!(host_sim(&["eval", "synthetic", "--against", utf8(&file)]).code, Some(2));
}

/// The recordings are not part of the project: see the README on `SMR_SEQUENCES`.
#[test]
fn the_papers_table_is_printed_whole() {
    let Some(sequence) = recordings("the_papers_table_is_printed_whole", "tld/03_pedestrian1") else { return };
    let text = host_sim(&["eval", utf8(&sequence)]).out;
    let table: Vec<Vec<&str>> = text
        .lines()
        .skip_while(|line| !line.starts_with("correct frames"))
        .map(|line| line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect())
        .collect();
    let expected = [
        ["correct frames", "source", "03_pedestrian1 /140"],
        ["Lim 2004 (incremental subspace)", "printed", "11"],
        ["Collins 2005 (online feature selection)", "printed", "6"],
        ["Avidan 2007 (ensemble tracking)", "printed", "22"],
        ["Babenko 2009 (MIL)", "printed", "101"],
        ["Kalal 2010 (forward-backward, MedianFlow)", "printed", "140"],
        ["SMR, the paper", "printed", "140"],
        ["smr", "measured", "87"],
        ["smr, k = 7/20, inclusive", "measured", "140"],
    ];
    assert_eq!(table[..9], expected);
    assert_eq!(table[9][0], "robust");
    let names: Vec<&str> = table[10..14].iter().map(|row| row[0]).collect();
    assert_eq!(names, ["sad", "ssd", "ncc", "lk"]);
    assert!(table[14..].iter().any(|row| row[..2] == ["OpenCV-5.0.0-TLD", "measured"]));

    let only = host_sim(&["eval", utf8(&sequence), "--method", "smr", "--json"]);
    let rows: Vec<Value> = serde_json::from_str(&only.out).unwrap();
    assert_eq!((rows.len(), &rows[0]["source"], &rows[6]["correct"]), (7, &"measured".into(), &140.into()));
}
