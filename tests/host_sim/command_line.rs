//! `host-sim` with input that `tests/cases` cannot describe: videos, links, pipes, odd names, the paper's recordings.

use crate::missing::{has_ffmpeg, recordings, runs};
use crate::program::{PROGRAM, host_sim, utf8};
use std::fs;
use std::path::Path;
use std::process::Command;

fn film(file: &Path, arguments: &[&str]) {
    let source = ["-v", "error", "-f", "lavfi", "-i"];
    assert!(runs(Command::new("ffmpeg").args(source).args(arguments).arg(file)), "{arguments:?}");
}

/// Phones record videos like these two: one is rotated by metadata, the other has a varying frame rate.
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
    assert!(runs(Command::new("ffmpeg").args(["-v", "error", "-i", utf8(&plain)]).args(note).arg(&turned)));
    let size = |video: &Path| {
        let said = host_sim(&["convert", utf8(video), "-o", utf8(&file("clip.y4m")), "--json"]).json();
        (said["width"].as_u64().unwrap(), said["height"].as_u64().unwrap())
    };
    assert_eq!((size(&plain), size(&turned)), ((320, 240), (240, 320)));

    // Keeps every third frame with its time: ffmpeg must not repeat frames to fill the gaps.
    let some = ["testsrc=size=321x241:rate=30:duration=1", "-vf", "select=not(mod(n\\,3))", "-vsync", "vfr"];
    film(&uneven, &[&some[..], &["-pix_fmt", "yuv444p"]].concat());
    let said = host_sim(&["track", utf8(&uneven), "--init", "100,100,40,40"]);
    assert_eq!((said.code, said.out.lines().count()), (Some(0), 10), "{}", said.err);
    assert_eq!(size(&uneven), (321, 241));
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
    // host-sim must refuse a file above the size limit of its format, and must not open it.
    fs::File::create(path("long.json")).unwrap().set_len(1 << 40).unwrap();
    against(utf8(&path("long.json"))).refuses(&["long.json", "64 MiB"]);
    let pipe = path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    against(utf8(&pipe)).refuses(&["pipe", "no data came for", "64 MiB"]);
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
    // Two versions of an ffmpeg that hangs: the first reads nothing, the second reads all input and never ends.
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
fn a_file_without_pictures_is_said_to_be_so() {
    let folder = tempfile::tempdir().unwrap();
    let (file, text) = (folder.path().join("song.wav"), folder.path().join("a.mp4"));
    if has_ffmpeg("a_file_without_pictures_is_said_to_be_so") {
        fs::write(&text, "no video").unwrap();
        host_sim(&["view", utf8(&text), "--no-open"]).refuses(&[utf8(&text)]);
        film(&file, &["sine=d=1"]);
        host_sim(&["track", utf8(&file), "--init", "0,0,9,9"]).refuses(&["song.wav holds no pictures", "a video"]);
    }
}

/// With several threads ffmpeg conceals damaged frames differently in every run.
#[test]
fn a_damaged_video_is_read_alike_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("clip.avi");
    let source = ["testsrc2=s=640x480:d=2", "-c:v", "mpeg4", "-q:v", "4"];
    if !has_ffmpeg("a_damaged_video_is_read_alike_every_time") {
        return;
    }
    film(&file, &source);
    let mut bytes = fs::read(&file).unwrap();
    let end = bytes.len() - 30_000;
    for at in (end / 2..end).step_by(7_001) {
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
    assert!((2..=3).all(|number| written(&format!("{number}.raw")) == first), "ffmpeg decodes on one thread");
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
    host_sim(&["track", &clip]).refuses(&["a\\u001b[31m\\u000a\\u009b: no initial box"]);
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
        ["paper", "measured", "87"],
        ["paper, k = 7/20, inclusive", "measured", "140"],
    ];
    assert_eq!(table[..9], expected);
    assert_eq!(table[9][0], "robust");
    let names: Vec<&str> = table[10..14].iter().map(|row| row[0]).collect();
    assert_eq!(names, ["sad", "ssd", "ncc", "lk"]);
    assert!(table[14..].iter().any(|row| row[..2] == ["OpenCV-5.0.0-TLD", "measured"]));

    let only = host_sim(&["eval", utf8(&sequence), "--method", "paper", "--json"]);
    let tables = only.json();
    let rows = |name: &str| tables[name].as_array().unwrap().len();
    assert_eq!((rows("measured"), rows("printed"), &tables["printed"][5]["correct"]), (1, 6, &140.into()));
}

/// Needs recordings that are not part of the project: `host-sim/README.md` says where the tests look for them.
#[test]
fn the_recorded_sequences_are_followed_as_the_readme_says() {
    let Some(tld) = recordings("the_recorded_sequences_are_followed_as_the_readme_says", "tld") else { return };
    let sequences = ["03_pedestrian1", "05_pedestrian3"].map(|name| tld.join(name));
    let rows = host_sim(&["eval", utf8(&sequences[0]), utf8(&sequences[1]), "--method", "paper", "--json"]).json();
    let correct = |row: usize| &rows["measured"][row]["correct"];
    assert_eq!((correct(0), correct(1)), (&87.into(), &52.into()));
}
