//! Long runs and sudden ends: memory stays bounded; after a full disk, a closed pipe or a kill, printed lines are whole
//! and earlier output files are unchanged.

use crate::missing::{has, has_ffmpeg, runs, skipped};
use crate::program::{PROGRAM, host_sim, kill, utf8};
use smr_recordings::synthetic;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A process `host-sim track -` that gets the first frames of the built-in recording again and again.
struct Live {
    process: Child,
    input: ChildStdin,
    frames: std::iter::Cycle<std::vec::IntoIter<Vec<u8>>>,
}

const START: &str = "36,24,24,28";

impl Live {
    fn start(arguments: &[&str], output: Stdio) -> Self {
        let frames: Vec<_> = synthetic::frames().take(20).map(|frame| frame.pixels).collect();
        let frames = frames.into_iter().cycle();
        let mut process = command(arguments).stdin(Stdio::piped()).stdout(output).spawn().expect("host-sim runs");
        let mut input = process.stdin.take().expect("it is piped");
        let header = format!("YUV4MPEG2 W{} H{} F25:1 Cmono\n", synthetic::WIDTH, synthetic::HEIGHT);
        input.write_all(header.as_bytes()).expect("it reads");
        Self { process, input, frames }
    }

    fn send(&mut self, count: usize) {
        for pixels in self.frames.by_ref().take(count) {
            self.input.write_all(&[b"FRAME\n", &pixels[..]].concat()).expect("it reads");
        }
        self.input.flush().expect("it reads");
    }

    fn kill(mut self) {
        self.process.kill().expect("it runs");
        let _ = self.process.wait();
    }
}

fn wait_until(what: &str, mut there: impl FnMut() -> bool) {
    let start = Instant::now();
    while !there() {
        assert!(start.elapsed() < Duration::from_secs(120), "waited too long for {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[cfg(target_os = "linux")]
fn peak(process: &Child) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", process.id())).expect("it runs");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("Linux says it");
    line.trim().trim_end_matches("kB").trim().parse().expect("a number")
}

#[cfg(target_os = "linux")]
#[test]
fn live_input_takes_no_more_memory_with_time() {
    for method in ["paper", "robust"] {
        let window: &[&str] = if method == "paper" { &["--set", "window=8x8"] } else { &[] };
        let arguments = [&["track", "-", "--init", START, "--method", method, "--json"], window].concat();
        let mut live = Live::start(&arguments, Stdio::piped());
        let mut lines = BufReader::new(live.process.stdout.take().expect("it is piped")).lines();
        let mut answered = |live: &mut Live, count: usize| {
            for _ in 0..count / 10 {
                live.send(10);
                assert_eq!(lines.by_ref().take(10).filter(Result::is_ok).count(), 10);
            }
            peak(&live.process)
        };
        let early = answered(&mut live, 100);
        let late = answered(&mut live, 800);
        // A frame is 19 KiB: 800 frames kept in memory would be 15 MiB.
        assert!(late <= early + 2048, "{method}: {early} KiB after 100 frames, {late} KiB after 900");
        assert!(late < 128 * 1024, "{method}: {late} KiB");
        live.kill();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_and_leaves_nothing_half_written() {
    host_sim(&["track", "synthetic", "--frames", "1..5", "--out", "/dev/full"])
        .refuses(&["cannot write /dev/full", "No space left"]);
    for arguments in [
        &["track", "synthetic", "--frames", "1..5"][..],
        &["eval", "synthetic", "--frames", "1..5", "--json"],
        &["eval", "synthetic", "--fault", "black:1", "--frames", "1..40", "--method", "lk"],
        &["check", "periodic", "--frames", "..2"],
    ] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let output = command(arguments).stdout(full).output().expect("host-sim runs");
        let err = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {err}");
        assert!(err.contains("cannot write to standard output: No space left"), "{arguments:?}: {err}");
        assert_eq!(err.lines().count(), 1, "{arguments:?}: {err}");
    }
}

/// Limits the files of this process to 16 KiB, as if the disk became full during the run.
#[test]
fn a_disk_that_fills_up_leaves_the_former_file() {
    let folder = tempfile::tempdir().unwrap();
    let clip = folder.path().join("clip.y4m");
    fs::write(&clip, "former").unwrap();
    for out in [&clip, &folder.path().join("frames")] {
        let script = "trap '' XFSZ; ulimit -f 16; exec \"$0\" convert synthetic -o \"$1\"";
        let output = Command::new("sh").args(["-c", script, PROGRAM]).arg(out).output().expect("there is a shell");
        let err = String::from_utf8_lossy(&output.stderr);
        if out == &clip {
            assert_eq!(output.status.code(), Some(2), "{err}");
            assert!(err.contains("clip.y4m") && err.lines().count() == 1, "{err}");
        }
    }
    assert_eq!(fs::read_to_string(&clip).unwrap(), "former");
    assert_eq!(parts(folder.path()), 0, "nothing is left behind");
}

/// Writes each kind of output with files limited to ever more KiB (`ulimit -f`), up to the size that suffices.
#[test]
fn a_disk_that_fills_up_leaves_each_former_file() {
    let test = "a_disk_that_fills_up_leaves_each_former_file";
    let has_ffmpeg = has_ffmpeg(test);
    let folder = tempfile::tempdir().unwrap();
    let clip = folder.path().join("clip.mkv");
    if has_ffmpeg {
        let source = "-v error -f lavfi -i testsrc2=s=160x120:r=25:d=4 -f lavfi -i sine=d=4 -c:a pcm_s16le";
        let mut ffmpeg = Command::new("ffmpeg");
        assert!(runs(ffmpeg.args(source.split(' ')).args(["-c:v", "mjpeg", "-q:v", "5"]).arg(&clip)));
    }
    let (clip, init) = (utf8(&clip), ["--method", "paper", "--init", "60,50,30,30", "--frames"]);
    let (track, sound) = (
        ["track", "synthetic", "--method", "paper", "--frames", "..60"],
        [&["track", clip][..], &init, &["..60"]].concat(),
    );
    let report = ["report", "synthetic", "--frames", "..20", "--out"];
    let convert = ["convert", "synthetic", "--frames", "..20", "-o"];
    for (arguments, option, name) in [
        (&track[..], "-o", "boxes.csv"),
        (&track, "-o", "boxes.json"),
        (&track, "-o", "boxes.xml"),
        (&track, "--video", "film.mp4"),
        (&track, "--video", "film.mkv"),
        (&sound, "--video", "sound.mp4"),
        (&sound, "--video", "sound.mov"),
        (&sound, "--video", "sound.webm"),
        (&report[..4], "--out", "page.html"),
        (&convert[..4], "-o", "clip.y4m"),
        (&convert[..4], "-o", "clip.h"),
    ] {
        if option == "--video" && !has_ffmpeg {
            continue;
        }
        let below = tempfile::tempdir().unwrap();
        let out = below.path().join(name);
        let mut failed = 0;
        for limit in (0..).map(|step: u32| 3 * 3_u32.pow(step) / 2) {
            fs::write(&out, "former").unwrap();
            let script = format!("trap '' XFSZ; ulimit -f {limit}; exec \"$0\" \"$@\"");
            let mut shell = Command::new("sh");
            shell.args(["-c", &script, PROGRAM]).args(arguments).arg(option).arg(&out).stdout(Stdio::null());
            let output = shell.output().expect("there is a shell");
            let err = String::from_utf8_lossy(&output.stderr);
            assert_eq!(fs::read_dir(below.path()).unwrap().count(), 1, "{name}: nothing else is left: {err}");
            if output.status.success() {
                assert!(fs::metadata(&out).unwrap().len() > 512 && !err.contains("no sound"), "{name}, {limit}: {err}");
                break;
            }
            failed += 1;
            assert_eq!(output.status.code(), Some(2), "{name}, {limit}: {err}");
            assert_eq!(err.lines().filter(|line| line.starts_with("error: cannot write ")).count(), 1, "{name}: {err}");
            assert!(err.contains(name), "{name}: {err}");
            assert_eq!(fs::read_to_string(&out).unwrap(), "former", "{name}, {limit}");
        }
        assert!(failed > 0, "{name}: the test can fail");
    }
}

/// An ffmpeg that ends with success after half of the work, as on a full disk.
#[cfg(unix)]
#[test]
fn half_a_video_is_no_video() {
    use std::os::unix::fs::PermissionsExt;
    let test = "half_a_video_is_no_video";
    if !has_ffmpeg(test) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (programs, out) = (folder.path().join("programs"), folder.path().join("film.mp4"));
    fs::create_dir(&programs).unwrap();
    let path = std::env::var_os("PATH").unwrap();
    let real = std::env::split_paths(&path).map(|place| place.join("ffmpeg")).find(|file| file.is_file()).unwrap();
    let both = std::env::join_paths(std::iter::once(programs.clone()).chain(std::env::split_paths(&path))).unwrap();
    // Encoding is the only run that reads pictures from a pipe; its last argument is the file.
    let half = "for file; do :; done; \"$REAL\" \"$@\" && case \"$*\" in";
    for (damage, said) in [
        (
            "head -c 2000 \"$file\" > \"$file.half\"; cat \"$file.half\" > \"$file\"; rm \"$file.half\"",
            "is the disk full?",
        ),
        (
            "\"$REAL\" -v quiet -i \"$file\" -frames:v 7 -f mp4 \"$file.half\"; cat \"$file.half\" > \"$file\"; rm \"$file.half\"",
            "7 of 30 frames",
        ),
        (": > \"$file\"", "is the disk full?"),
    ] {
        let script = format!("#!/bin/sh\n{half} *'-i - '*) {damage};; esac; exit 0\n");
        fs::write(programs.join("ffmpeg"), script).unwrap();
        fs::set_permissions(programs.join("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
        fs::write(&out, "former").unwrap();
        let mut track = command(&["track", "synthetic", "--frames", "..30", "--video", utf8(&out)]);
        let output = track.env("PATH", &both).env("REAL", &real).output().unwrap();
        let err = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), err.lines().count()), (Some(2), 1), "{err}");
        assert!(err.starts_with("error: cannot write ") && err.contains(said), "{err}");
        assert_eq!(fs::read_to_string(&out).unwrap(), "former");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left behind");
    }
}

/// The reader of a FIFO ends after the first bytes: not all was written, which is an error.
#[cfg(unix)]
#[test]
fn a_file_whose_reader_goes_away_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, option, name) in [
        (&["track", "synthetic"][..], "-o", "boxes.csv"),
        (&["convert", "synthetic"], "-o", "clip.y4m"),
        (&["report", "synthetic", "--frames", "..20"], "--out", "page.html"),
    ] {
        let fifo = folder.path().join(name);
        assert!(runs(Command::new("mkfifo").arg(&fifo)));
        let process = command(arguments).arg(option).arg(&fifo).spawn().expect("host-sim runs");
        let mut reader = File::open(&fifo).unwrap();
        if name == "clip.y4m" {
            reader.read_exact(&mut [0; 100]).unwrap();
        }
        drop(reader);
        let output = process.wait_with_output().unwrap();
        let err = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {err}");
        let expected = format!("error: cannot write {}: its reader has ended before all was written\n", fifo.display());
        assert!(err.ends_with(&expected), "{err}");
    }
    // Standard output stays a case of its own, also by its name as a file.
    let (reader, writer) = std::io::pipe().expect("a pipe can be made");
    drop(reader);
    let output =
        Command::new(PROGRAM).args(["track", "periodic", "-o", "/dev/stdout"]).stdout(writer).output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0));
}

/// These variables make ffmpeg color its messages, log more, or write a report into the working folder.
#[test]
fn variables_of_ffmpeg_do_not_reach_the_writer() {
    if !has_ffmpeg("variables_of_ffmpeg_do_not_reach_the_writer") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut track = command(&["track", "synthetic", "--frames", "..5", "--video", "film.mp4"]);
    track.envs([("AV_LOG_FORCE_COLOR", "1"), ("FFREPORT", "file=report.log:level=48"), ("AV_LOG_FORCE_256COLOR", "1")]);
    let output = track.current_dir(&folder).output().unwrap();
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(0), ""));
    let names: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["film.mp4"]);
}

fn parts(folder: &Path) -> usize {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.starts_with(".smr-")).count()
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
fn a_closed_pipe_is_no_error_and_its_lines_are_whole() {
    for more in [&["--method", "paper"][..], &["--json"]] {
        let arguments = &[&["track", "synthetic", "--frames", "..30"], more].concat()[..];
        let expected = host_sim(arguments).out;
        let mut process = command(arguments).spawn().expect("host-sim runs");
        let mut lines = BufReader::new(process.stdout.take().expect("it is piped")).lines();
        let first: Vec<String> = lines.by_ref().take(3).map(Result::unwrap).collect();
        drop(lines);
        assert!(first.iter().map(String::as_str).eq(expected.lines().take(3)));
        let mut err = String::new();
        process.stderr.take().expect("it is piped").read_to_string(&mut err).unwrap();
        assert_eq!((process.wait().unwrap().code(), err.as_str()), (Some(0), ""), "{arguments:?}");
    }
}

#[test]
fn what_was_printed_before_a_kill_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let printed = folder.path().join("printed.txt");
    let mut live = Live::start(&["track", "-", "--init", START], File::create(&printed).unwrap().into());
    live.send(7);
    let lines = || fs::read_to_string(&printed).unwrap().lines().count();
    wait_until("seven lines", || lines() == 7);
    live.input.write_all(b"FRAME\nhalf").unwrap();
    live.kill();
    let text = fs::read_to_string(&printed).unwrap();
    assert!(text.ends_with('\n') && text.lines().all(|line| line.split(',').count() == 4), "{text}");
    assert_eq!(lines(), 7);
}

#[test]
fn a_kill_leaves_the_former_file() {
    let folder = tempfile::tempdir().unwrap();
    let (boxes, clip) = (folder.path().join("boxes.txt"), folder.path().join("clip.y4m"));
    fs::write(&boxes, "former\n").unwrap();
    for arguments in [&["track", "-", "--init", START, "--out", utf8(&boxes)][..], &["convert", "-", "-o", utf8(&clip)]]
    {
        let before = parts(folder.path());
        let mut live = Live::start(arguments, Stdio::null());
        live.send(15);
        wait_until("the file under way", || parts(folder.path()) > before);
        live.kill();
    }
    assert_eq!(fs::read_to_string(&boxes).unwrap(), "former\n");
    assert!(!clip.exists(), "there whole or not at all");
}

#[test]
fn a_disk_that_fills_up_ends_a_video_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("pictures");
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$0\" track synthetic --resize 2/1 --video \"$1\"";
    let output = Command::new("sh").args(["-c", script, PROGRAM]).arg(&out).output().expect("there is a shell");
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), err.lines().count()), (Some(2), 1), "{err}");
    assert!(err.starts_with(&format!("error: cannot write {}", out.display())), "{err}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
}

#[test]
fn a_closed_pipe_does_not_cost_the_video() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, piped) = (folder.path().join("whole"), folder.path().join("piped"));
    let arguments = ["track", "synthetic", "--frames", "1..30", "--video"];
    assert_eq!(host_sim(&[&arguments[..], &[utf8(&whole)]].concat()).code, Some(0));
    let mut process = command(&[&arguments[..], &[utf8(&piped)]].concat()).spawn().expect("host-sim runs");
    let mut first = String::new();
    let mut lines = BufReader::new(process.stdout.take().expect("it is piped"));
    lines.read_line(&mut first).unwrap();
    drop(lines);
    let output = process.wait_with_output().expect("host-sim ends");
    assert_eq!((first.as_str(), output.status.code(), output.stderr.len()), ("36,24,60,52\n", Some(0), 0));
    let pictures =
        |of: &Path| (1..=30).map(|number| fs::read(of.join(format!("{number:05}.png"))).unwrap()).collect::<Vec<_>>();
    assert!(pictures(&piped) == pictures(&whole), "the whole video is there");
}

fn started(name: &str, process: &Child) -> Option<String> {
    let found = Command::new("pgrep").args(["-P", &process.id().to_string(), name]).output().ok()?;
    String::from_utf8(found.stdout).ok()?.lines().next().map(str::to_owned)
}

#[test]
fn a_signal_removes_what_is_under_way_and_is_the_exit_code() {
    const TEST: &str = "a_signal_removes_what_is_under_way_and_is_the_exit_code";
    let mp4 = &format!("{TEST}, for MP4");
    let ffmpeg = has_ffmpeg(mp4) && has(mp4, "pgrep", &["-V"]);
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        if signal == "HUP" && ignores_hangup() {
            skipped(&format!("{TEST}, for HUP"), "this test runs under nohup");
            continue;
        }
        for (option, name) in [("--out", "boxes.txt"), ("--video", "pictures"), ("--video", "a.mp4")] {
            if name == "a.mp4" && !ffmpeg {
                continue;
            }
            let folder = tempfile::tempdir().unwrap();
            let out = folder.path().join(name);
            let mut live = Live::start(&["track", "-", "--init", START, option, utf8(&out)], Stdio::null());
            live.send(15);
            let mut child = None;
            wait_until("what is under way", || {
                child = started("ffmpeg", &live.process);
                parts(folder.path()) == 1 && (name != "a.mp4" || child.is_some())
            });
            assert!(kill(&format!("-{signal}"), &live.process.id().to_string()));
            let output = live.process.wait_with_output().expect("host-sim ends");
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!((output.status.code(), said.as_str()), (Some(code), ""), "{signal}, {name}");
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{signal}, {name}: nothing is left behind");
            if let Some(child) = child {
                assert!(!kill("-0", &child), "{signal}: ffmpeg runs on");
            }
        }
    }
}

/// Returns true if this process ignores SIGHUP; its children inherit that.
fn ignores_hangup() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}

#[cfg(target_os = "linux")]
#[test]
fn a_hangup_that_is_ignored_stays_so() {
    let folder = tempfile::tempdir().unwrap();
    let boxes = folder.path().join("boxes.txt");
    let mut process = Command::new("sh")
        .args(["-c", "trap '' HUP; exec \"$0\" \"$@\"", PROGRAM, "track", "-", "--init", START, "--out", utf8(&boxes)])
        .stdin(Stdio::piped())
        .spawn()
        .expect("there is a shell");
    let mut input = process.stdin.take().expect("it is piped");
    let header = format!("YUV4MPEG2 W{} H{} F25:1 Cmono\n", synthetic::WIDTH, synthetic::HEIGHT);
    let frame = synthetic::frames().next().unwrap();
    input.write_all(&[header.as_bytes(), b"FRAME\n", &frame.pixels].concat()).unwrap();
    wait_until("the file under way", || parts(folder.path()) == 1);
    assert!(kill("-HUP", &process.id().to_string()));
    std::thread::sleep(Duration::from_millis(100));
    drop(input);
    assert_eq!(process.wait().unwrap().code(), Some(0));
    assert_eq!(fs::read_to_string(&boxes).unwrap().lines().count(), 1);
}

#[test]
fn a_measurement_that_is_stopped_prints_what_it_has() {
    let methods = ["--method", "sad,robust", "--set", "window=4x4", "--starts", "every:4", "--format", "csv"];
    let arguments = [&["eval", "synthetic", "--frames", "..80", "--robustness"], &methods[..]].concat();
    // Lengthens the pause before the signal until it comes after the first tracker's end and before the second's.
    let mut pause = Duration::from_millis(100);
    loop {
        let stopped = command(&arguments).spawn().expect("host-sim runs");
        std::thread::sleep(pause);
        assert!(kill("-INT", &stopped.id().to_string()));
        let output = stopped.wait_with_output().expect("it ends");
        let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert_eq!(output.status.code(), Some(130), "{err}");
        assert!(err.starts_with("stopped: "), "{err}");
        if out.lines().count() == 2 {
            return;
        }
        assert_eq!(out.lines().count(), 1, "{out}");
        pause = pause * 4 / 3;
    }
}
