//! Facts from ffmpeg: which pictures of a recording are whole. Each test runs with the ffmpeg on the PATH, and with the
//! one in the folder `SMR_OTHER_FFMPEG`, if that is set: another version says the same things in other words.

use crate::missing::{has_ffmpeg, runs, skipped};
use crate::program::{PROGRAM, utf8};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folders of ffmpeg, in front of the PATH.
fn versions(test: &str) -> Vec<Option<PathBuf>> {
    if !has_ffmpeg(test) {
        return Vec::new();
    }
    let other = std::env::var_os("SMR_OTHER_FFMPEG").map(PathBuf::from);
    if other.is_none() {
        skipped(test, "the part with another version of ffmpeg (set SMR_OTHER_FFMPEG to its folder)");
    }
    [None].into_iter().chain(other.map(Some)).collect()
}

fn with(version: Option<&Path>, program: &str) -> Command {
    let mut command = Command::new(program);
    if let Some(folder) = version {
        let paths = std::env::var_os("PATH").unwrap_or_default();
        let paths = [folder.to_owned()].into_iter().chain(std::env::split_paths(&paths));
        command.env("PATH", std::env::join_paths(paths).unwrap());
    }
    command
}

/// Encodes a test video of 48 pictures of 176x144; false if this ffmpeg cannot.
fn encode(file: &Path, options: &str) -> bool {
    let input = "-v error -y -nostdin -f lavfi -i testsrc2=s=176x144:r=25:d=1.92,noise=alls=10:allf=t,format=yuv420p";
    let sound = "-f lavfi -i sine=d=1.92 -map 0:v";
    let words = [input, sound, options].into_iter().flat_map(str::split_whitespace);
    runs(Command::new("ffmpeg").args(words).arg(file))
}

/// Result of `host-sim convert`: exit code, messages, and the pictures that were written.
struct Converted {
    code: Option<i32>,
    said: String,
    pictures: Vec<Vec<u8>>,
}

fn convert(command: &mut Command, file: &Path, frames: &str) -> Converted {
    let out = file.with_extension("y4m");
    let _ = fs::remove_file(&out);
    let run = command.args(["convert", utf8(file), "--frames", frames, "-o", utf8(&out)]).output().unwrap();
    let bytes = fs::read(&out).unwrap_or_default();
    let head = bytes.iter().position(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    let pictures = bytes[head..].chunks(6 + 176 * 144).map(<[u8]>::to_vec).collect();
    Converted { code: run.status.code(), said: String::from_utf8(run.stderr).unwrap(), pictures }
}

fn convert_with(version: Option<&PathBuf>, file: &Path) -> Converted {
    convert(&mut with(version.map(PathBuf::as_path), PROGRAM), file, "1..")
}

/// Numbers from 0 to `below`, equal in each run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self, below: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from((self.0 >> 33) % below as u64).unwrap()
    }
}

/// Damages a file in one of five ways: 1, 300 or 3000 bytes with other values, some that are missing, or the end.
fn damage(bytes: &mut Vec<u8>, way: usize, numbers: &mut Numbers) {
    let (length, from) = (bytes.len(), bytes.len() / 10);
    match way {
        0..3 => {
            let count = [1, 300, 3000][way];
            let at = from + numbers.next(length - from - count);
            for byte in &mut bytes[at..at + count] {
                *byte ^= 1 + u8::try_from(numbers.next(255)).unwrap();
            }
        }
        3 => {
            // Whole packets of MPEG-TS, as a network loses them.
            let (at, count) = ((from + numbers.next(length - from - 2000)) / 188 * 188, 188 * (1 + numbers.next(10)));
            bytes.drain(at..at + count);
        }
        _ => bytes.truncate(length / 4 + numbers.next(length / 2)),
    }
}

/// True if ffmpeg itself, asked for the whole file, ends with an error or complains.
fn complains(version: Option<&Path>, file: &Path) -> bool {
    let strict = "-nostdin -v level+error -xerror -err_detect explode -threads 1 -i";
    let sink = "-map 0:v:0 -fps_mode passthrough -threads 1 -f null -";
    let mut command = with(version, "ffmpeg");
    let run = command.args(strict.split(' ')).arg(file).args(sink.split(' ')).output().unwrap();
    !run.status.success() || String::from_utf8_lossy(&run.stderr).contains("[error]")
}

const CORPUS: [(&str, &str); 21] = [
    ("mpeg1.mpg", "-c:v mpeg1video -bf 2 -g 12 -b:v 600k"),
    ("mpeg1.mkv", "-c:v mpeg1video -bf 2 -g 12 -b:v 600k"),
    ("mpeg2.ts", "-c:v mpeg2video -bf 2 -g 12 -b:v 600k"),
    ("mpeg2.mp4", "-c:v mpeg2video -bf 2 -g 12 -b:v 600k"),
    ("mpeg4.mp4", "-c:v mpeg4 -bf 2 -g 12 -b:v 500k"),
    ("mpeg4.avi", "-c:v mpeg4 -g 12 -b:v 500k"),
    ("h264.mp4", "-c:v libx264 -bf 3 -g 24 -crf 26"),
    ("h264.ts", "-c:v libx264 -bf 3 -g 24 -crf 26"),
    ("h264.mkv", "-c:v libx264 -bf 3 -g 24 -crf 26"),
    ("h264.flv", "-c:v libx264 -bf 3 -g 24 -crf 26"),
    ("h264.avi", "-c:v libx264 -bf 0 -g 24 -crf 26"),
    ("hevc.mp4", "-c:v libx265 -preset fast -x265-params keyint=24:log-level=none -crf 28"),
    ("hevc.ts", "-c:v libx265 -preset fast -x265-params keyint=24:log-level=none -crf 28"),
    ("hevc.mkv", "-c:v libx265 -preset fast -x265-params keyint=24:log-level=none -crf 28"),
    ("vp8.webm", "-c:v libvpx -b:v 500k -g 24 -deadline realtime -cpu-used 4"),
    ("vp9.webm", "-c:v libvpx-vp9 -b:v 400k -g 24 -deadline realtime -cpu-used 6"),
    ("vp9.mp4", "-c:v libvpx-vp9 -b:v 400k -g 24 -deadline realtime -cpu-used 6"),
    ("mjpeg.avi", "-c:v mjpeg -q:v 5 -pix_fmt yuvj420p"),
    ("mjpeg.mkv", "-c:v mjpeg -q:v 5 -pix_fmt yuvj420p"),
    ("ffv1.mkv", "-c:v ffv1 -level 3 -g 1 -slicecrc 1"),
    ("ffv1.avi", "-c:v ffv1 -level 3 -g 1 -slicecrc 1"),
];

/// Damages files of every codec and container. A wrong picture passes as right only where ffmpeg itself notices nothing,
/// and the frames that a message advises are right. Damage of a head can make a wrong picture long before the complaint,
/// so one such piece of advice in a hundred is allowed. `SMR_DAMAGES` is the number of damaged copies of each file;
/// without it, every fourth file is damaged once.
#[test]
fn no_wrong_picture_passes_as_right() {
    let test = "no_wrong_picture_passes_as_right";
    let copies = std::env::var("SMR_DAMAGES").ok().map(|count| count.parse().unwrap());
    let corpus: Vec<_> = CORPUS.iter().step_by(if copies.is_some() { 1 } else { 4 }).collect();
    let folder = tempfile::tempdir().unwrap();
    for version in versions(test) {
        let (mut told, mut wrong_advice) = (0, Vec::new());
        let mut numbers = Numbers(7);
        for (nth, (name, options)) in corpus.iter().enumerate() {
            let file = folder.path().join(name);
            if !file.exists() && !encode(&file, options) {
                skipped(test, format_args!("this ffmpeg does not write {name}"));
                continue;
            }
            let whole = convert_with(version.as_ref(), &file);
            assert_eq!((whole.code, whole.pictures.len(), whole.said.as_str()), (Some(0), 48, ""), "{name}");
            let is_right = |pictures: &[Vec<u8>]| whole.pictures.starts_with(pictures);
            for copy in 0..copies.unwrap_or(1) {
                let mut bytes = fs::read(&file).unwrap();
                damage(&mut bytes, (nth + copy) % 5, &mut numbers);
                let damaged = folder.path().join(format!("damaged-{name}"));
                fs::write(&damaged, bytes).unwrap();
                let read = convert_with(version.as_ref(), &damaged);
                if read.code == Some(0) {
                    let is_from_later = !read.said.is_empty() && whole.pictures.ends_with(&read.pictures);
                    let is_noticed = || complains(version.as_deref(), &damaged);
                    assert!(is_right(&read.pictures) || is_from_later || !is_noticed(), "{name}, copy {copy}");
                    continue;
                }
                assert_eq!((read.code, read.pictures.len()), (Some(2), 0), "{name}: {}", read.said);
                let Some((_, advice)) = read.said.split_once("--frames ..") else { continue };
                let frames = advice.split(' ').next().unwrap();
                let part = convert(&mut with(version.as_deref(), PROGRAM), &damaged, &format!("..{frames}"));
                assert_eq!(
                    (part.code, part.pictures.len()),
                    (Some(0), frames.parse().unwrap()),
                    "{name}: {}",
                    part.said
                );
                told += 1;
                if !is_right(&part.pictures) {
                    wrong_advice.push(format!("{name}, copy {copy}: {}", read.said));
                }
            }
        }
        assert!(wrong_advice.len() <= told / 100 + 1, "{} of {told}: {wrong_advice:?}", wrong_advice.len());
    }
}

/// Writes recordings that are whole, about which ffmpeg complains all the same: their names, and frames that are read.
fn complained_about(folder: &Path) -> Vec<(&'static str, usize)> {
    let path = |name: &str| folder.join(name);
    let h264 = "-c:v libx264 -g 12 -bf 2 -qp 20";
    let mut files = Vec::new();
    if encode(&path("part.ts"), h264) {
        // Two recordings in one file; a capture of a running stream; a camera without a microphone.
        let part = fs::read(path("part.ts")).unwrap();
        fs::write(path("joined.ts"), part.repeat(2)).unwrap();
        files.push(("joined.ts", 96));
        assert!(encode(&path("sound.ts"), &format!("{h264} -map 1:a -c:a aac -mpegts_start_pid 256")));
        let packets = fs::read(path("sound.ts")).unwrap();
        let is_sound = |packet: &&[u8]| u16::from_be_bytes([packet[1] & 31, packet[2]]) == 257;
        let mute: Vec<&[u8]> = packets.chunks(188).filter(|packet| !is_sound(packet)).collect();
        fs::write(path("mute.ts"), mute.concat()).unwrap();
        files.push(("mute.ts", 48));
        // A second sound in a codec that ffmpeg does not know.
        assert!(encode(&path("two.mov"), &format!("{h264} -map 1:a -map 1:a -c:a:0 aac -c:a:1 pcm_mulaw")));
        let replaced = replaced(&fs::read(path("two.mov")).unwrap(), b"ulaw", b"apac");
        fs::write(path("phone.mov"), replaced).unwrap();
        files.push(("phone.mov", 48));
        // Equal sizes and pixel formats, with other color tags.
        let tagged = |tag: &str| {
            assert!(encode(&path(tag), &format!("{h264} -colorspace {tag} -f mpegts")));
            fs::read(path(tag)).unwrap()
        };
        fs::write(path("tags.ts"), [tagged("bt709"), tagged("smpte170m")].concat()).unwrap();
        files.push(("tags.ts", 96));
    }
    assert!(encode(&path("plain.avi"), "-map 1:a -c:v mjpeg -q:v 3 -pix_fmt yuvj420p -c:a pcm_s16le"));
    let mut bytes = fs::read(path("plain.avi")).unwrap();
    let found = |bytes: &[u8], word: &[u8]| bytes.windows(word.len()).position(|part| part == word).unwrap();
    let sound = found(&bytes, b"auds");
    let format = sound + found(&bytes[sound..], b"strf") + 8;
    bytes[format..format + 2].copy_from_slice(&[0x33, 0x77]);
    fs::write(path("mute.avi"), bytes).unwrap();
    files.push(("mute.avi", 48));
    // An application's marker of a wrong length in each JPEG.
    assert!(encode(&path("plain.mjpeg"), "-c:v mjpeg -q:v 3 -pix_fmt yuvj420p"));
    let marked = replaced(&fs::read(path("plain.mjpeg")).unwrap(), b"\xFF\xD8\xFF", b"\xFF\xD8\xFF\xE4\x00\x00\xFF");
    fs::write(path("marked.mjpeg"), marked).unwrap();
    files.push(("marked.mjpeg", 48));
    files
}

fn replaced(bytes: &[u8], word: &[u8], by: &[u8]) -> Vec<u8> {
    let mut rest = bytes;
    let mut all = Vec::new();
    while let Some(at) = rest.windows(word.len()).position(|part| part == word) {
        all.extend([&rest[..at], by].concat());
        rest = &rest[at + word.len()..];
    }
    all.extend(rest);
    all
}

#[test]
fn a_complaint_about_what_is_not_decoded_refuses_nothing() {
    for version in versions("a_complaint_about_what_is_not_decoded_refuses_nothing") {
        let folder = tempfile::tempdir().unwrap();
        for (name, frames) in complained_about(folder.path()) {
            let read = convert_with(version.as_ref(), &folder.path().join(name));
            assert_eq!((read.code, read.pictures.len(), read.said.as_str()), (Some(0), frames, ""), "{name}");
        }
    }
}

/// Captures of a running stream begin anywhere.
#[test]
fn a_capture_is_read_from_its_first_key_frame_on() {
    for version in versions("a_capture_is_read_from_its_first_key_frame_on") {
        let folder = tempfile::tempdir().unwrap();
        for (name, options) in CORPUS.iter().filter(|(name, _)| ["mpeg2.ts", "h264.ts", "hevc.ts"].contains(name)) {
            let (file, capture) = (folder.path().join(name), folder.path().join(format!("capture-{name}")));
            if !encode(&file, options) {
                skipped(
                    "a_capture_is_read_from_its_first_key_frame_on",
                    format_args!("this ffmpeg does not write {name}"),
                );
                continue;
            }
            let whole = convert_with(version.as_ref(), &file).pictures;
            let bytes = fs::read(&file).unwrap();
            for packet in [20, 57, 100] {
                fs::write(&capture, &bytes[188 * packet..]).unwrap();
                let read = convert_with(version.as_ref(), &capture);
                assert!(read.said.contains("begins between two key frames"), "{name}: {}", read.said);
                assert!(read.code == Some(0) && read.pictures.len() >= 12, "{name}: {}", read.pictures.len());
                assert!(whole.ends_with(&read.pictures), "{name} from packet {packet}");
            }
        }
    }
}

/// Variables that change ffmpeg's messages, and a parent that ignores the end of its children.
#[cfg(unix)]
#[test]
fn what_a_parent_sets_changes_nothing() {
    for version in versions("what_a_parent_sets_changes_nothing") {
        let folder = tempfile::tempdir().unwrap();
        let (file, report) = (folder.path().join("a.mpg"), folder.path().join("report"));
        assert!(encode(&file, "-c:v mpeg1video"));
        let mut command = with(version.as_deref(), PROGRAM);
        for name in ["AV_LOG_FORCE_COLOR", "AV_LOG_FORCE_NOCOLOR", "AV_LOG_FORCE_256COLOR"] {
            command.env(name, "1");
        }
        command.env("FFREPORT", format!("file={}:level=56", utf8(&report)));
        let read = convert(&mut command, &file, "1..");
        assert_eq!((read.code, read.pictures.len(), report.exists()), (Some(0), 48, false), "{}", read.said);

        let mut shell = with(version.as_deref(), "sh");
        shell.args(["-c", "trap '' CHLD; exec \"$0\" \"$@\"", PROGRAM]);
        let read = convert(&mut shell, &file, "1..");
        assert_eq!((read.code, read.pictures.len()), (Some(0), 48), "{}", read.said);
    }
}
