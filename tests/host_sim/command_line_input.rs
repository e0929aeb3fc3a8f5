//! `host-sim` with bad input: damaged files, options that do not fit, files that cannot be written.

use crate::missing::{has_ffmpeg, recordings};
use crate::program::{PROGRAM, host_sim, utf8};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Ten frames as JPEGs with ground truth, the fourth of them cut.
fn cut_recording(folder: &Path) -> PathBuf {
    let written = folder.join("cut");
    assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&written), "--format", "y4m"]).code, Some(0));
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

/// Twelve frames with the boxes of the last seven, as OTB has them of David.
#[test]
fn ground_truth_that_begins_later_is_said_and_mended() {
    let folder = tempfile::tempdir().unwrap();
    let david = folder.path().join("David");
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..12", "-o", utf8(&david)]).code, Some(0));
    let boxes = fs::read_to_string(david.join("gt.txt")).unwrap();
    let boxes: Vec<&str> = boxes.lines().collect();
    let run = |words: &[&str]| host_sim(&[&words[..1], &[utf8(&david)], &words[1..]].concat());
    let (page, lengths) =
        (folder.path().join("page.html"), "there are 12 frames, but the ground truth has 7 boxes for them");
    let evaluated = |words: &[&str]| run(&[&["eval", "--method", "robust", "--json"], words].concat());
    let recall = |words: &[&str]| evaluated(words).json()["measured"][0]["recall"].as_f64();
    let whole = run(&["track"]);
    assert_eq!((whole.err.as_str(), recall(&[])), ("", Some(1.0)));
    fs::write(david.join("gt.txt"), boxes[5..].join("\r")).unwrap();
    let said = run(&["track"]);
    assert_eq!((said.code, said.err.lines().count()), (Some(0), 1), "{}", said.err);
    assert!(
        said.err.starts_with(&format!(
            "warning: David: {lengths}: say which frame the first box is of (--truth-from N), or"
        )),
        "{}",
        said.err
    );
    evaluated(&[]).refuses(&[lengths, "--truth-from"]);
    run(&["report", "-o", utf8(&page)]).refuses(&[lengths, "--truth-from"]);
    for mended in [&["--truth-from", "6"][..], &["--frames", "6.."]] {
        let tracked = run(&[&["track"], mended].concat());
        assert_eq!(tracked.out.lines().next(), Some(boxes[5]), "{mended:?}");
        assert_eq!(tracked.err.lines().count(), usize::from(mended[0] == "--frames"), "{}", tracked.err);
        assert_eq!(recall(mended), Some(1.0), "{mended:?}");
        assert_eq!(run(&[&["report", "-o", utf8(&page)], mended].concat()).code, Some(0));
    }
    for frames in ["8..10", "..10"] {
        assert_eq!(recall(&["--truth-from", "6", "--frames", frames]), Some(1.0), "{frames}");
    }
    for frames in ["2..10", "..5"] {
        run(&["eval", "--truth-from", "6", "--frames", frames]).refuses(&["expected frame 6 or later"]);
    }
    run(&["track", "--truth-from", "13"]).refuses(&["there is no frame 13 (--truth-from): expected 1 to 12"]);
    fs::write(david.join("gt.txt"), [&boxes[..], &boxes[..1]].concat().join("\n")).unwrap();
    assert!(run(&["track"]).err.contains("the ground truth has 13 boxes for them: expected a box a frame"));
    // A file that does not say how many frames it has.
    let film = folder.path().join("film.y4m");
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..12", "-o", utf8(&film)]).code, Some(0));
    fs::write(folder.path().join("gt.txt"), boxes[5..].join("\n")).unwrap();
    assert_eq!(host_sim(&["eval", utf8(&film), "--frames", "6.."]).code, Some(0));
    host_sim(&["eval", utf8(&film), "--truth-from", "13"]).refuses(&["there is no frame 13 (--truth-from)"]);
}

/// The target is followed in spite of it.
#[test]
fn a_target_that_cannot_be_told_from_its_surroundings_is_said_to_be_so() {
    let folder = tempfile::tempdir().unwrap();
    for (name, texture) in [("flat", 0), ("textured", 97)] {
        let pixels: Vec<u8> = (0..40 * 30_u32).map(|at| (90 + at / 3 * texture % 120).to_le_bytes()[0]).collect();
        let frames = folder.path().join(name);
        fs::create_dir(&frames).unwrap();
        for number in 1..=2 {
            let picture = [b"P5\n40 30\n255\n".as_slice(), &pixels].concat();
            fs::write(frames.join(format!("{number}.pgm")), picture).unwrap();
        }
        for method in ["smr", "robust"] {
            let said = host_sim(&["track", utf8(&frames), "--init", "10,10,12,12", "--json", "--method", method]);
            assert_eq!(said.code, Some(0), "{}", said.err);
            assert_eq!(
                said.err.contains("warning: flat: the target can hardly be told"),
                name == "flat",
                "{}",
                said.err
            );
            let lines: Vec<Value> = said.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
            assert_eq!(lines[0]["quality"].as_f64() == Some(0.0), name == "flat", "{}", lines[0]);
            assert!(lines[1]["quality"].is_null(), "{}", lines[1]);
        }
    }
}

/// Makes a video with ffmpeg.
fn film(file: &Path, arguments: &[&str]) {
    let source = ["-v", "error", "-f", "lavfi", "-i"];
    let made = Command::new("ffmpeg").args(source).args(arguments).arg(file).status();
    assert!(made.unwrap().success(), "{arguments:?}");
}

/// A video as phones make it: rotated by metadata, with a varying frame rate.
#[test]
fn videos_of_phones_are_shown_upright_and_whole() {
    if !has_ffmpeg("videos_of_phones_are_shown_upright_and_whole") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let (plain, turned, uneven) = (file("plain.mp4"), file("turned.mp4"), file("uneven.mp4"));
    film(&plain, &["testsrc=size=320x240:rate=30:duration=1", "-pix_fmt", "yuv420p"]);
    let note = ["-c", "copy", "-metadata:s:v:0", "rotate=90"];
    let copied = Command::new("ffmpeg").args(["-v", "error", "-i", utf8(&plain)]).args(note).arg(&turned).status();
    assert!(copied.unwrap().success());
    let size = |video: &Path| {
        let said = host_sim(&["convert", utf8(video), "-o", utf8(&file("clip.y4m")), "--json"]).json();
        (said["width"].as_u64().unwrap(), said["height"].as_u64().unwrap())
    };
    assert_eq!((size(&plain), size(&turned)), ((320, 240), (240, 320)));

    // Two of three frames are left out and the others keep their times. No frame is invented to fill the gaps.
    let some = ["testsrc=size=321x241:rate=30:duration=1", "-vf", "select=not(mod(n\\,3))", "-vsync", "vfr"];
    film(&uneven, &[&some[..], &["-pix_fmt", "yuv444p"]].concat());
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
    for command in
        [&["report", one, "-o", utf8(&page)][..], &["report", one, "--figures", utf8(out.path())], &["track", one]]
    {
        let said = host_sim(&[command, &["--init", "0,0,1,1"]].concat());
        assert_eq!(said.code, Some(0), "{command:?}: {}", said.err);
    }
    // The message says how to find the box.
    host_sim(&["track", one]).refuses(&["no box to start from", "--init X,Y,W,H", "host-sim view"]);
}

#[test]
fn damage_is_an_error_that_says_how_to_read_what_lies_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let recording = cut_recording(folder.path());
    let file = utf8(&recording);
    let said = host_sim(&["track", file]);
    said.refuses(&["frame 240", "cut short", "(--frames ..239 takes the frames before it)"]);
    let part = host_sim(&["track", file, "--frames", "..239"]);
    assert_eq!((part.code, part.err.as_str(), &part.out), (Some(0), "", &said.out));
}

#[test]
fn a_file_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let recording = cut_recording(folder.path());
    let boxes = folder.path().join("boxes.txt");
    fs::write(&boxes, "former").unwrap();
    host_sim(&["track", utf8(&recording), "--out", utf8(&boxes)]).refuses(&["frame 240"]);
    assert_eq!(fs::read_to_string(&boxes).unwrap(), "former");
    assert_eq!(host_sim(&["track", utf8(&recording), "--frames", "..239", "--out", utf8(&boxes)]).code, Some(0));
    assert_eq!(fs::read_to_string(&boxes).unwrap().lines().count(), 239);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left over");
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("no").join("such").join("file.txt");
    let boxes = utf8(&file);
    // It fails before it reads its frames, which do not exist.
    let missing = folder.path().join("empty.y4m");
    fs::write(&missing, "YUV4MPEG2 W9 H9 Cmono\n").unwrap();
    let recording = utf8(&missing);
    host_sim(&["track", recording, "--init", "0,0,4,4", "--out", boxes]).refuses(&["cannot write", boxes]);
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
    let texture = |at: u32| (at / 5 * 97 % 200).to_le_bytes()[0];
    fs::write(&large, (0..2 * 400 * 300).map(texture).collect::<Vec<u8>>()).unwrap();
    let arguments = ["track", utf8(&large), "--size", "400x300", "--init", "0,0,300,300"];
    let paper = host_sim(&[&arguments[..], &["--method", "smr"]].concat());
    paper.refuses(&["0,0,300,300", "90000 pixels", "at most 65536", "--method robust"]);
    for other in [&["--method", "sad"][..], &["--method", "lk"], &[]] {
        let said = host_sim(&[&arguments[..], other].concat());
        assert_eq!((said.code, said.err.as_str()), (Some(0), ""), "{other:?}");
        assert_eq!(said.out.lines().count(), 2);
    }
}

#[test]
fn a_window_beyond_its_limit_has_its_numbers_in_messages() {
    let limit = ["track", "synthetic", "--method", "smr", "--window-limit"];
    host_sim(&[&limit[..], &["20x60"]].concat()).refuses(&["--window-limit 20x60", "60x50", "65535x65535"]);
    host_sim(&[&limit[..], &["60x49", "--window", "9x50"]].concat()).refuses(&["60x49", "9x50 to 65535x65535"]);
    assert_eq!(host_sim(&[&limit[..], &["9x50", "--window", "9x50"]].concat()).code, Some(0));
    let camera = ["track", "synthetic", "--method", "smr", "--config", "camera", "--window", "81x9"];
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
    for command in [&["eval"][..], &["eval", "--robustness"], &["check"]] {
        host_sim(&[command, &["synthetic", "periodic", "--init", "1,1,9,9"]].concat()).refuses(&["--init", "2"]);
    }
    host_sim(&["check", "--init", "1,1,9,9"]).refuses(&["--init", "3"]);
}

#[test]
fn robustness_is_compared_with_what_was_measured_before() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("former.json");
    let arguments =
        ["eval", "synthetic", "noise", "--frames", "..60", "--robustness", "--single-start", "--method", "sad,lk"];
    let former = host_sim(&[&arguments[..], &["--json"]].concat());
    assert_eq!((former.code, former.err.as_str()), (Some(0), ""));
    fs::write(&file, &former.out).unwrap();
    let former: Value = serde_json::from_str(&former.out).unwrap();
    assert_eq!(former["measured"][0]["starts"], 1);
    assert_eq!((&former["paired"][0]["tracker"], &former["paired"][0]["against"]), (&"lk".into(), &"sad".into()));
    assert!(former["means"][0]["mean_correct_standard_error"].as_f64().is_some());

    let said = host_sim(&[&arguments[..], &["--against", utf8(&file), "--json"]].concat());
    let now: Value = serde_json::from_str(&said.out).unwrap();
    for paired in now["paired"].as_array().unwrap() {
        assert_eq!((&paired["recordings"], &paired["f"]), (&2.into(), &Value::from(0.0)));
    }
    let text = host_sim(&[&arguments[..], &["--against", utf8(&file)]].concat()).out;
    assert!(text.contains("paired difference") && text.contains("  standard error"), "{text}");

    host_sim(&["eval", "synthetic", "--robustness", "--against", utf8(&file)]).refuses(&["other starts"]);
    host_sim(&["eval", "synthetic", "--robustness", "--against", "no/such.json"]).refuses(&["no/such.json"]);
    assert_eq!(host_sim(&["eval", "synthetic", "--against", utf8(&file)]).code, Some(2));
}

#[test]
fn two_outputs_are_two_files_and_none_is_the_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| utf8(&folder.path().join(name)).to_owned();
    let (clip, frames, one) = (path("clip.y4m"), path("frames"), path("one.mp4"));
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "1..3", "-o", &clip]).code, Some(0));
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "1..3", "-o", &frames]).code, Some(0));
    let (picture, truth) = (format!("{frames}/00001.png"), format!("{frames}/gt.txt"));
    let files = || [&clip, &picture, &truth].map(|file| fs::read(file).unwrap());
    let before = files();

    host_sim(&["track", &clip, "--init", "9,9,9,9", "--video", &one, "--out", &one])
        .refuses(&["--out", "--video", &one, "two"]);
    for arguments in [
        &["convert", &clip, "-o", &clip][..],
        &["track", &clip, "--init", "9,9,9,9", "--out", &clip],
        &["track", &frames, "--out", &truth],
    ] {
        let output = arguments.last().unwrap();
        host_sim(arguments).refuses(&[output, "belongs to the recording"]);
    }
    assert_eq!(files(), before);
    assert!(!Path::new(&one).exists());
    // A device accepts any amount.
    assert_eq!(host_sim(&["track", &frames, "--out", "/dev/null"]).code, Some(0));
}

#[cfg(unix)]
#[test]
fn what_never_ends_is_refused_with_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["endless.png", "gt.txt"] {
        std::os::unix::fs::symlink("/dev/zero", path(name)).unwrap();
    }
    fs::write(path("clip.y4m"), b"YUV4MPEG2 W4 H4 F25:1 Cmono\nFRAME\n0123456789abcdef").unwrap();
    let (endless, clip) = (utf8(&path("endless.png")).to_owned(), utf8(&path("clip.y4m")).to_owned());
    host_sim(&["track", &clip, "--init", "0,0,2,2"]).refuses(&["gt.txt", "64 MiB", "a box a line"]);
    fs::remove_file(path("gt.txt")).unwrap();
    host_sim(&["track", &endless, "--init", "0,0,2,2"]).refuses(&["endless.png", "512 MiB", "PNG"]);
    let against = |former: &str| host_sim(&["eval", "synthetic", "--robustness", "--against", former]);
    against("/dev/zero").refuses(&["/dev/zero", "64 MiB"]);
    host_sim(&["replay", "/dev/zero"]).refuses(&["/dev/zero", "no entry in 64 MiB"]);
    host_sim(&["track", "/dev/zero", "--size", "60000x60000", "--init", "0,0,2,2"])
        .refuses(&["60000x60000", "at most 268435456"]);
    // A file that is too long for its kind is not opened.
    fs::File::create(path("long.json")).unwrap().set_len(1 << 40).unwrap();
    against(utf8(&path("long.json"))).refuses(&["long.json", "64 MiB"]);
    let pipe = path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    against(utf8(&pipe)).refuses(&["pipe", "nothing comes out of it", "64 MiB"]);
}

#[cfg(unix)]
#[test]
fn an_ffmpeg_that_hangs_while_it_writes_is_ended() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (ffmpeg, video) = (folder.path().join("ffmpeg"), folder.path().join("video.mp4"));
    let path = std::env::join_paths(
        std::iter::once(folder.path().to_owned()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    // It reads no frame, or reads all of them and does not end.
    for script in ["exec sleep 60", "cat > /dev/null; exec sleep 60"] {
        fs::write(&ffmpeg, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&ffmpeg, fs::Permissions::from_mode(0o755)).unwrap();
        let start = std::time::Instant::now();
        let mut command = Command::new(PROGRAM);
        command.args(["track", "synthetic", "--ffmpeg-timeout", "1", "--video"]).arg(&video);
        let output = command.env("PATH", path.as_ref().unwrap()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let expected =
            format!("error: cannot write {}: ffmpeg has done nothing for 1 s (--ffmpeg-timeout)\n", video.display());
        assert_eq!((output.status.code(), said), (Some(2), expected), "{script}");
        assert!(start.elapsed().as_secs() < 30, "{script}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
    }
}

#[test]
fn a_box_that_is_refused_has_the_same_words_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| utf8(&folder.path().join(name)).to_owned();
    let (large, page, figures) = (path("large.raw"), path("page.html"), path("figures"));
    fs::write(&large, vec![7; 3 * 400 * 300]).unwrap();
    fs::write(path("gt.txt"), "0,0,300,300\n".repeat(3)).unwrap();
    let size = ["--size", "400x300"];
    let said = ["the box 0,0,300,300 ", "has 90000 pixels", "the tracker smr takes at most 65536", "--resize 1/2"];
    for (command, has_method) in [
        (&["track", &large, "--method", "smr"][..], true),
        (&["check", &large], true),
        (&["eval", &large], true),
        (&["report", &large, "-o", &page, "--method", "smr"], true),
        (&["report", &large, "--figures", &figures], true),
    ] {
        let answer = host_sim(&[command, &size].concat());
        answer.refuses(&said);
        assert_eq!(answer.err.contains("--method robust"), has_method, "{}", answer.err);
        host_sim(&[command, &size, &["--init", "390,9,20,20"]].concat()).refuses(&[
            "the box 390,9,20,20 ",
            "not wholly inside the frame of 400x300",
            "--init",
        ]);
    }
    host_sim(&[
        "track",
        &large,
        "--method",
        "smr",
        "--size",
        "400x300",
        "--padding",
        "60000",
        "--window-limit",
        "6000x6000",
        "--init",
        "0,0,9,9",
    ])
    .refuses(&["0,0,9,9", "4096", "--window-limit", "--padding"]);
}

/// No message contains words that only the author of a library understands.
#[test]
fn messages_are_in_peoples_words() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, holds: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, holds).unwrap();
        utf8(&path).to_owned()
    };
    let track = |arguments: &[&str]| host_sim(&[&["track", "synthetic"], arguments].concat());
    for option in ["--growth", "--scale", "--padding", "--neighbourhood", "--step", "--ffmpeg-timeout", "--least-alpha"]
    {
        for value in ["", "abc", "1.5", "-1", "99999999999999999999"] {
            let said = track(&[&format!("{option}={value}"), "--video", "x.mp4"]);
            said.refuses(&[option, "expected a whole number from "]);
        }
    }
    track(&["--method", "kcf"]).refuses(&["--method kcf: expected one of smr, robust, sad, ssd, ncc, lk"]);
    host_sim(&["eval", "synthetic", "--robustness", "--starts-every", "0"])
        .refuses(&["--starts-every 0: expected a whole number, 1 or more"]);
    track(&["--out", "no/such/boxes.txt"]).refuses(&["cannot write no/such/boxes.txt: there is no folder no/such"]);
    track(&["--size", "99999x99999"]).refuses(&["--size 99999x99999: expected two whole numbers", "at most 65535"]);
    track(&["--resize", "99999x99999"]).refuses(&["--resize 99999x99999: expected a size", "from 1 to 65535"]);
    track(&["--resize", "1/1000"]).refuses(&["--resize 1/1000", "smaller than a pixel: expected larger frames"]);
    track(&["--resize", "1000/1"]).refuses(&["--resize 1000/1 of 160x120: expected at most 65535 pixels on each side"]);
    for command in ["check", "eval"] {
        host_sim(&[command, "rtsp://me:secret@camera/1?key=2"]).refuses(&[
            "rtsp://camera/1 is a live source",
            "`track`",
            "expected a recording",
        ]);
    }
    host_sim(&["track", "udp://127.0.0.1:9", "--frames", "..9"]).refuses(&["--frames is for recordings", "Ctrl-C"]);
    #[cfg(unix)]
    host_sim(&["track", "/dev/null", "--init", "0,0,2,2"]).refuses(&["/dev/null is a device", "`host-sim track -`"]);
    host_sim(&["track", "no/such"])
        .refuses(&["cannot open no/such: expected a folder, a file, or one of street", "there is no such file"]);
    for (name, holds, expected) in [
        ("cut.pgm", &b"P5 9 9 255\nabc"[..], "it is cut short"),
        ("bad.png", b"not a picture", "it begins like none of them"),
        ("bad.jpg", b"\xFF\xD8\xFF\xE0junk", "it is damaged"),
        ("bad.y4m", b"YUV4MPEG2 W2 H2 Fx Cmono\nFRAME\nabcd", "its header is not understood"),
        ("frame.y4m", b"YUV4MPEG2 W2 H2 F25:1 Cmono\nFRAMX\nabcd", "expected a line FRAME before its pixels"),
    ] {
        let path = file(name, holds);
        let said = host_sim(&["track", &path, "--init", "0,0,1,1"]);
        said.refuses(&[name, expected]);
        // Before the first frame there is none to take.
        assert!(!said.err.contains("--frames"), "{}", said.err);
    }
    let former = file("former.json", b"{\"measured\":[{\"tracker\":1}]}");
    host_sim(&["eval", "synthetic", "--robustness", "--against", &former])
        .refuses(&["former.json: line 1: expected what `host-sim eval --robustness --json` writes"]);
}

#[test]
fn an_audio_file_is_said_to_have_no_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("song.wav");
    if has_ffmpeg("an_audio_file_is_said_to_have_no_pictures") {
        film(&file, &["sine=d=1"]);
        host_sim(&["track", utf8(&file), "--init", "0,0,9,9"]).refuses(&["song.wav holds no pictures", "a video"]);
    }
}

/// With several threads ffmpeg puts something else in place of damage in every run.
#[test]
fn a_damaged_video_is_read_alike_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("clip.avi");
    let source = ["testsrc2=s=640x480:d=4", "-c:v", "mpeg4", "-q:v", "4"];
    if !has_ffmpeg("a_damaged_video_is_read_alike_every_time") {
        return;
    }
    film(&file, &source);
    let mut bytes = fs::read(&file).unwrap();
    let end = bytes.len() - 30_000;
    for at in (8_000..end).step_by(7_001) {
        bytes[at] ^= 0x5a;
    }
    fs::write(&file, &bytes).unwrap();
    let damaged = host_sim(&["convert", utf8(&file), "-o", utf8(&folder.path().join("0.raw"))]);
    damaged.refuses(&["is damaged, says ffmpeg", "--frames .."]);
    let before = damaged.err.split_once("--frames ").and_then(|(_, part)| part.split_once(' ')).unwrap().0;
    let written = |name: &str| {
        let out = folder.path().join(name);
        let said = host_sim(&["convert", utf8(&file), "--frames", before, "-o", utf8(&out)]);
        assert_eq!((said.code, said.err.as_str()), (Some(0), ""));
        fs::read(&out).unwrap()
    };
    let first = written("1.raw");
    assert!((2..=5).all(|number| written(&format!("{number}.raw")) == first), "ffmpeg decodes on one thread");
}

#[cfg(unix)]
#[test]
fn the_name_of_a_file_does_not_steer_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| utf8(&folder.path().join(name)).to_owned();
    let (clip, page) = (path("a\u{1b}[31m\n\u{9b}.y4m"), path("\u{1b}c.pdf"));
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "1..3", "-o", &clip]).code, Some(0));
    for arguments in [
        &["report", &clip, "-o", &page, "--init", "1,1,9,9"][..],
        &["track", &clip],
        &["eval", &clip],
        &["track", "synthetic", "--method", "\u{1b}[2J"],
        &["track", "\u{1b}[2J"],
    ] {
        let said = host_sim(arguments);
        let all = said.out + &said.err;
        assert!(
            all.contains("\\u001b") && !all.contains(|letter: char| letter.is_control() && letter != '\n'),
            "{all:?}"
        );
    }
    host_sim(&["track", &clip]).refuses(&["a\\u001b[31m\\u000a\\u009b: no box to start from"]);
}

#[cfg(unix)]
#[test]
fn a_pipe_among_pictures_is_not_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let frames = folder.path().join("frames");
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "1..3", "-o", utf8(&frames)]).code, Some(0));
    let pipe = |file: &Path| assert!(Command::new("mkfifo").arg(file).status().unwrap().success());
    fs::remove_file(frames.join("00002.png")).unwrap();
    pipe(&frames.join("00002.png"));
    for command in ["track", "eval"] {
        host_sim(&[command, utf8(&frames)]).refuses(&["00002.png (frame 2) is a pipe or a device: expected a file"]);
    }
    let alone = folder.path().join("alone");
    fs::create_dir(&alone).unwrap();
    pipe(&alone.join("clip.y4m"));
    host_sim(&["track", utf8(&alone)]).refuses(&["clip.y4m is a pipe or a device"]);
}

#[test]
fn the_name_of_an_output_says_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| utf8(&folder.path().join(name)).to_owned();
    for (command, option, name, expected) in [
        ("report", "--out", "r.pdf", "ends in .html, or a folder"),
        ("convert", "--out", "r.foo", "ends in .y4m, .raw, .gray, .bin, .y8 or .h, or a folder"),
        ("report", "--figures", "f.png", "a folder"),
        ("track", "--out", "b.avi", ".txt, .csv, .json, .jsonl, .xml, .mp4, .mov, .mkv or .webm, or has no ending"),
        ("track", "--out", "b.m4v", "ends in .txt"),
        ("track", "--out", "b.xlsx", "ends in .txt"),
        ("track", "--out", "b.", "ends in .txt"),
        ("track", "--video", "b.avi", "ends in .mp4, .mov, .mkv or .webm, or a folder"),
    ] {
        host_sim(&[command, "synthetic", option, &path(name)]).refuses(&[option, name, expected]);
    }
    for (command, name, format, expected) in [
        ("track", "b.csv", "json", "expected a file that ends in .json, .jsonl or .txt, or has no ending"),
        ("track", "b.JSON", "csv", "expected a file that ends in .csv or .txt"),
        ("track", "b.csv", "tld", "expected a file that ends in .txt"),
        ("track", "b.xml", "coco", "expected a file that ends in .json or .txt"),
        ("convert", "b.y4m", "raw", "expected a folder, or a file with the extension of the format"),
    ] {
        let said = host_sim(&[command, "periodic", "--format", format, "-o", &path(name)]);
        said.refuses(&[&format!("--format {format} into"), name, expected]);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    for (name, format) in [("b.txt", "json"), ("b", "otb"), ("b.JSON", "coco"), ("c.jsonl", "json")] {
        assert_eq!(host_sim(&["track", "periodic", "--format", format, "-o", &path(name)]).code, Some(0), "{name}");
    }
    let convert = |out: &str| host_sim(&["convert", "synthetic", "--frames", "1..2", "-o", out]).code;
    assert_eq!(convert(&path("run.7/")), Some(0));
    assert!(folder.path().join("run.7/00002.png").is_file());
    let sequence = ["convert", "synthetic", "--format", "vot", "-o", &path("jogging.1")];
    assert_eq!(host_sim(&sequence).code, Some(0));
}

#[test]
fn an_empty_folder_is_filled_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(PROGRAM);
    let convert = command.args(["convert", "synthetic", "--frames", "1..2", "-o", "."]).current_dir(folder.path());
    assert_eq!(convert.output().unwrap().status.code(), Some(0));
    let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["00001.png", "00002.png", "gt.txt", "init.txt"]);
}

#[test]
fn many_poor_targets_are_one_warning() {
    let folder = tempfile::tempdir().unwrap();
    let flat = folder.path().join("flat.raw");
    fs::write(&flat, vec![90; 2 * 40 * 30]).unwrap();
    let boxes: Vec<String> = (1..=25).map(|number| format!("--init=t{number}=1,1,9,9")).collect();
    let boxes: Vec<&str> = boxes.iter().map(String::as_str).collect();
    let said = host_sim(&[&["track", utf8(&flat), "--size", "40x30"][..], &boxes].concat());
    assert_eq!((said.code, said.err.lines().count()), (Some(0), 1), "{}", said.err);
    assert!(said.err.starts_with("warning: flat: each of 25 targets can hardly be told"), "{}", said.err);
    assert!(said.err.ends_with(": t1, t2, t3, t4, t5, t6, t7, t8, t9, t10, t11, t12, t13, t14, t15, t16, t17, t18, t19, t20, t21, t22, t23, t24, t25\n"));
}

#[test]
fn usage_is_told_without_misleading_advice() {
    let folder = tempfile::tempdir().unwrap();
    let boxes = folder.path().join("boxes.txt");
    assert_eq!(host_sim(&["track", "periodic", "-o", utf8(&boxes)]).code, Some(0));
    assert_eq!(fs::read_to_string(&boxes).unwrap(), host_sim(&["track", "periodic"]).out);
}

/// One line for each kind of line that cannot be read: the word, what was expected, and what was probably meant.
#[test]
fn a_command_line_that_cannot_be_read_is_mended() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("clip.y4m");
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..3", "-o", utf8(&file)]).code, Some(0));
    let clip = utf8(&file);
    for (line, expected) in [
        // No command, or another word in its place.
        ("no.mp4", "no.mp4: there is no such file and no such command: expected a recording, or one of view, track"),
        ("Trak clip", "did you mean track?"),
        ("CLIP --metod smr", "view has no option --metod: did you mean --method?"),
        ("CLIP -o b.csv", "view has no option -o: it belongs to track, convert, report"),
        ("CLIP track", "track is a command: expected it first, as in host-sim track"),
        ("--method smr track CLIP", "--method stands before the command: expected one of view, track"),
        // Parts of a value as words of their own.
        (
            "CLIP --init 142 125 90 39",
            "--init 142 125 90 39: expected one value, with commas and without blanks: --init 142,125,90,39",
        ),
        ("track CLIP --init 36, 24, 24, 28", "with commas and without blanks: --init 36,24,24,28"),
        ("track --init 36 24 24 28 CLIP", "did you mean --init 36,24,24,28?"),
        (
            "check CLIP --init 36 24 24 28",
            "four numbers with commas, width and height above 0; did you mean --init 36,24,24,28?",
        ),
        ("track CLIP --size 320 240", "with an x and without blanks: --size 320x240"),
        ("track CLIP --frames 1 2", "with two dots and without blanks: --frames 1..2"),
        ("track CLIP --k 1 4", "with a slash and without blanks: --k 1/4"),
        ("track CLIP --without size sweep", "with commas and without blanks: --without size,sweep"),
        // Other separators.
        (
            "track CLIP --init 142;125;90;39",
            "four numbers with commas, width and height above 0; did you mean --init 142,125,90,39?",
        ),
        ("track CLIP --init (142,125,90,39)", "did you mean --init 142,125,90,39?"),
        ("track CLIP --size 320,240", "did you mean --size 320x240?"),
        ("track CLIP --window=16*16", "did you mean --window 16x16?"),
        ("track CLIP --frames 20-80", "did you mean --frames 20..80?"),
        ("track CLIP --method SMR", "did you mean --method smr?"),
        ("track CLIP --frames -5..", "--frames -5..: expected frames like 20..80"),
        ("track CLIP --k -1/4", "--k -1/4: expected a fraction like 1/4"),
        ("track CLIP --init 1,2,-3,4", "width and height above 0\n"),
        // Words, options and values that are too many or too few.
        (
            "track CLIP 36 24 24 28",
            "36 is one word too many: expected host-sim track [OPTIONS] <SEQ>; did you mean --init 36,24,24,28?",
        ),
        ("convert CLIP out.y4m", "did you mean --out out.y4m?"),
        ("track CLIP -o x.csv y.csv", "y.csv is one word too many: expected host-sim track"),
        ("track CLIP synthetic", "synthetic is one word too many: expected host-sim track [OPTIONS] <SEQ>\n"),
        ("track CLIP --fault black:3", "track has no option --fault: it belongs to eval"),
        ("eval CLIP -o x", "eval has no option -o: it prints, and `> FILE` keeps that"),
        ("track CLIP --verbose", "track has no option --verbose: `host-sim track --help` lists those that it has"),
        ("track CLIP --init", "--init has no value: expected --init <[NAME=]X,Y,W,H[@FRAME]>"),
        ("track", "<SEQ> is missing: expected host-sim track <SEQ> (`host-sim track --help` has examples)"),
        ("track CLIP --json --json", "--json is given more than once: expected it once"),
        ("track CLIP --json --format csv", "--json does not go with --format <FORMAT>: expected one of them"),
        ("track CLIP --json=yes", "--json takes no value"),
        // Lines that can be read, and mean nothing.
        ("track CLIP --method smr --window 0x0", "--window 0x0: the target is looked for nowhere else"),
        ("track synthetic --init 1,1,9,9@999", "synthetic: there is no frame 999 (--init): expected 1 to 240"),
        ("synthetic --init 1,1,9,9@999", "synthetic: there is no frame 999 (--init): expected 1 to 240"),
        (
            "CLIP --init 150,110,90,39",
            "clip: the box 150,110,90,39 (x,y,width,height) is not wholly inside the frame of 160x120",
        ),
        ("track CLIP --size 9x9", "--size is for raw dumps: "),
    ] {
        let words: Vec<&str> = line.split(' ').map(|word| if word == "CLIP" { clip } else { word }).collect();
        host_sim(&words).refuses(&["error: ", expected]);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

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
    let tables = only.json();
    let rows = |name: &str| tables[name].as_array().unwrap().len();
    assert_eq!((rows("measured"), rows("printed"), &tables["printed"][5]["correct"]), (1, 6, &140.into()));
}
