//! Exported videos keep the recording's colors, times, shape of pixels and sound.

use crate::missing::{has, has_ffmpeg};
use crate::program::{host_sim, utf8};
use smr_recordings::{GrayFrame, OpenOptions, synthetic};
use std::path::Path;
use std::process::Command;

fn run(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(["-v", "error"]).args(arguments).output().unwrap();
    assert!(output.status.success(), "{program} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn has_both(test: &str) -> bool {
    has_ffmpeg(test) && has(test, "ffprobe", &["-version"])
}

/// Returns the times of all frames in seconds from the first frame.
fn times(video: &Path) -> Vec<f64> {
    let asked = ["-select_streams", "v", "-show_entries", "frame=pts_time", "-of", "csv=p=0", utf8(video)];
    let said = run("ffprobe", &asked);
    let times: Vec<f64> = said.lines().filter_map(|line| line.trim_end_matches(',').parse().ok()).collect();
    times.iter().map(|time| time - times[0]).collect()
}

fn stream(video: &Path, which: &str, entry: &str) -> String {
    let entry = format!("stream={entry}");
    run("ffprobe", &["-select_streams", which, "-show_entries", &entry, "-of", "csv=p=0", utf8(video)])
        .trim()
        .to_owned()
}

#[test]
fn a_video_shows_what_is_chosen_and_is_cropped_to_the_target() {
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let track = ["track", "synthetic", "--frames", "..9", "--init", "car=36,24,24,28", "--video", utf8(&out)];
        let said = host_sim(&[&track, more].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        let frames = smr_recordings::open(&out, &OpenOptions::default()).unwrap().frames;
        frames.map(|frame| frame.unwrap().gray).collect::<Vec<_>>()
    };
    let plain: Vec<_> = synthetic::frames().take(9).collect();
    assert!(written("nothing", &["--draw", "nothing"]) == plain);
    let marked = ["box", "name", "trail"].map(|mark| written(mark, &["--draw", mark]));
    assert!(marked.iter().all(|frames| *frames != plain));
    assert!(marked[0] != marked[1] && marked[1] != marked[2] && marked[0] != marked[2]);
    assert!(written("usual", &[]) == written("both", &["--draw", "box,name"]));
    // Three times the longer side of the first box, enlarged to at least 480 pixels; the target stays in the middle.
    let cropped = written("cropped", &["--crop", "--draw", "nothing"]);
    assert!(cropped.iter().all(|frame| (frame.width, frame.height) == (6 * 84, 6 * 84)));
    assert_eq!(place_of(&cropped[0], &plain[0], 6), (6, 0), "48 - 42, and 38 - 42 is not in the frame");
    let other = written("other", &["--init", "other target=100,60,24,24", "--draw=nothing", "--crop=other target"]);
    assert_eq!(place_of(&other[0], &plain[0], 480_usize.div_ceil(72)), (76, 36), "112 - 36, and 72 - 36");
}

/// Returns the place (left, top) in `frame` of the picture that most resembles `part`, each pixel of which is `by` pixels
/// wide and high in `part`.
fn place_of(part: &GrayFrame, frame: &GrayFrame, by: usize) -> (usize, usize) {
    let at = |frame: &GrayFrame, x: usize, y: usize| frame.pixels[y * usize::from(frame.width) + x];
    let (width, height) = (usize::from(part.width) / by, usize::from(part.height) / by);
    let differs = |left: usize, top: usize| -> u32 {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let one = |(x, y)| at(frame, left + x, top + y).abs_diff(at(part, x * by + by / 2, y * by + by / 2));
        places.map(|place| u32::from(one(place))).sum()
    };
    let lefts = 0..=usize::from(frame.width) - width;
    let places = lefts.flat_map(|left| (0..=usize::from(frame.height) - height).map(move |top| (left, top)));
    places.min_by_key(|&(left, top)| differs(left, top)).unwrap()
}

/// Several recordings have a video each, and one that fails leaves none.
#[test]
fn several_recordings_have_a_video_each() {
    if !has_both("several_recordings_have_a_video_each") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let clips = ["Käfig 1.y4m", "b.y4m", "cut.y4m"].map(path);
    for clip in &clips {
        assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..4", "-o", utf8(clip)]).code, Some(0));
    }
    let bytes = std::fs::read(&clips[2]).unwrap();
    std::fs::write(&clips[2], &bytes[..bytes.len() - 9]).unwrap();
    let videos = path("videos");
    let track = |more: &[&str]| {
        let clips = clips.each_ref().map(|clip| utf8(clip));
        host_sim(&[&["track", "--init", "36,24,24,28", "--video", utf8(&videos)], &clips[..], more].concat())
    };
    let all = track(&["--frames", "..3"]);
    assert_eq!((all.code, all.out.lines().count()), (Some(0), 10), "{}", all.err);
    for name in ["Käfig 1.mp4", "b.mp4", "cut.mp4"] {
        assert_eq!(times(&videos.join(name)).len(), 3, "{name}");
    }
    std::fs::remove_file(videos.join("cut.mp4")).unwrap();
    let cut = track(&[]);
    assert_eq!((cut.code, cut.out.lines().count()), (Some(2), 9), "{}", cut.err);
    let last = cut.err.lines().last().unwrap();
    assert_eq!(last, "error: 1 of 3 recordings failed: see the errors above");
    let is_there = ["Käfig 1.mp4", "b.mp4", "cut.mp4"].map(|name| videos.join(name).exists());
    assert_eq!((is_there, times(&videos.join("b.mp4")).len()), ([true, true, false], 4));
    let refused = host_sim(&["track", utf8(&clips[1]), utf8(&videos.join("b.mp4")), "--video", utf8(&videos)]);
    refused.refuses(&["b.mp4 belongs to the recording that is read"]);
}

/// Writes a clip with colors, sound, pixels that are not square, and irregular frame times.
fn clip(folder: &Path) -> std::path::PathBuf {
    let clip = folder.join("clip.mp4");
    let filter = "testsrc2=s=320x180:r=30000/1001:d=2,select='not(eq(mod(n\\,5)\\,3))',setsar=4/3";
    run(
        "ffmpeg",
        &["-f", "lavfi", "-i", filter, "-f", "lavfi", "-i", "sine=d=2", "-fps_mode", "vfr", "-shortest", utf8(&clip)],
    );
    clip
}

#[test]
fn a_video_keeps_colors_times_shape_and_sound() {
    if !has_both("a_video_keeps_colors_times_shape_and_sound") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (clip, boxes) = (clip(folder.path()), folder.path().join("boxes.mp4"));
    let said = host_sim(&["track", utf8(&clip), "--init", "100,60,40,40", "--video", utf8(&boxes)]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let (before, after) = (times(&clip), times(&boxes));
    let csv = host_sim(&["track", utf8(&clip), "--init", "100,60,40,40", "--frames", "11..", "--format", "csv"]).out;
    let told = csv.lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse::<f64>().unwrap());
    assert!(
        told.zip(&before[10..]).all(|(told, time)| (told - time).abs() < 1e-5) && csv.lines().count() == 39,
        "{csv}"
    );
    assert_eq!((before.len(), after.len(), said.out.lines().count()), (48, 48, 48));
    assert!(before.iter().zip(&after).all(|(before, after)| (before - after).abs() < 1e-4), "{before:?} {after:?}");
    assert_eq!(stream(&boxes, "v", "sample_aspect_ratio,width,height"), "320,180,4:3");
    assert_eq!(stream(&boxes, "a", "codec_type"), "audio");
    // The test picture has a red bar on the left and a blue one right of the middle.
    let pixel = |x: usize| {
        let crop = format!("crop=4:4:{x}:90,scale=1:1");
        let arguments = [
            "-v",
            "error",
            "-i",
            utf8(&boxes),
            "-frames:v",
            "1",
            "-vf",
            &crop,
            "-pix_fmt",
            "rgb24",
            "-f",
            "rawvideo",
            "-",
        ];
        let output = Command::new("ffmpeg").args(arguments).output().unwrap();
        <[u8; 3]>::try_from(&output.stdout[..3]).unwrap()
    };
    let (red, blue) = (pixel(20), pixel(180));
    assert!(red[0] > 200 && red[2] < 60, "{red:?}");
    assert!(blue[2] > 200 && blue[0] < 60, "{blue:?}");

    let part = folder.path().join("part.mp4");
    let arguments = ["track", utf8(&clip), "--init", "100,60,40,40", "--frames", "11..20", "--video", utf8(&part)];
    assert_eq!(host_sim(&arguments).code, Some(0));
    let expected: Vec<f64> = before[10..20].iter().map(|time| time - before[10]).collect();
    assert!(times(&part).iter().zip(&expected).all(|(found, expected)| (found - expected).abs() < 1e-4));
    let seconds: f64 = stream(&part, "a", "duration").parse().unwrap();
    assert!((seconds - expected[9]).abs() < 0.1, "{seconds} s of sound for {} s", expected[9]);
}

/// Makes a recording of moving pictures and a sound with a beep from 1.0 s to 1.1 s of its own time.
fn beeping(file: &Path, pictures: &str, sound: &str, more: &[&str]) {
    let beep = format!("aevalsrc='0.8*sin(5000*t)*between(t,1,1.1)':s=44100:d={sound}");
    let source = format!("testsrc2=s=160x120:r=25:d={pictures}");
    let inputs = ["-f", "lavfi", "-i", &source];
    let (before, after): (Vec<&str>, Vec<&str>) = more.iter().partition(|word| word.starts_with("-itsoffset"));
    let before: Vec<&str> = before.iter().flat_map(|word| word.split('=')).collect();
    let pixels = if after.contains(&"mjpeg") { "yuvj420p" } else { "yuv420p" };
    let rest = ["-f", "lavfi", "-i", &beep, "-pix_fmt", pixels];
    run("ffmpeg", &[&inputs[..], &before, &rest, &after, &[utf8(file)]].concat());
}

/// Returns the length of a file's sound, and the time at which it gets loud, both in seconds.
fn sound(file: &Path) -> (f64, f64) {
    let decoded = |filter: &[&str]| {
        let rest = ["-map", "0:a:0", "-f", "s16le", "-ac", "1", "-ar", "44100", "-"];
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-v", "error", "-i", utf8(file)]).args(filter).args(rest).output().unwrap().stdout
    };
    let seconds = |samples: usize| samples as f64 / 44100.0;
    // Silence in front, so that the samples begin at the time 0 of the file.
    let samples = decoded(&["-af", "aresample=async=1:first_pts=0"]);
    let loud = samples.as_chunks().0.iter().position(|&sample| i16::from_le_bytes(sample).unsigned_abs() > 8000);
    (seconds(decoded(&[]).len() / 2), loud.map_or(f64::NAN, seconds))
}

fn pictures(file: &Path) -> usize {
    run("ffmpeg", &["-i", utf8(file), "-map", "0:v", "-c", "copy", "-f", "framecrc", "-"])
        .lines()
        .filter(|line| !line.starts_with('#'))
        .count()
}

/// Each case: recording, lengths of pictures and sound, ffmpeg options, video, frames, length of its sound (NaN: that
/// of the recording's, which has silence that AAC adds) and time of the beep in it.
#[test]
fn a_video_has_the_sound_of_its_frames() {
    if !has_ffmpeg("a_video_has_the_sound_of_its_frames") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let (mjpeg, h264) = (["-c:v", "mjpeg", "-c:a", "pcm_s16le"], ["-preset", "ultrafast", "-g", "12", "-bf", "2"]);
    let mpeg = ["-c:v", "mpeg2video", "-g", "12", "-c:a", "mp2"];
    let late = [&h264[..], &["-itsoffset=0.6"]].concat();
    for (name, lengths, options, video, frames, length, beep) in [
        ("a.avi", ("1.6", "1.6"), &mjpeg[..], "a.mp4", "..", 1.6, 1.0),
        ("b.mkv", ("1.6", "1.6"), &h264, "b.mkv", "..", 1.6, 1.0),
        ("c.ts", ("6", "6"), &h264, "c.webm", "..", 6.0, 1.0),
        ("d.mpg", ("3", "3"), &mpeg, "d.mov", "..", 3.0, 1.0),
        // The pictures do not cut the sound of a whole recording, and are not cut by it.
        ("long.mp4", ("1.2", "2.4"), &h264, "long.mp4", "..", 2.4, 1.0),
        ("short.mp4", ("3", "1.4"), &h264, "short.mkv", "..", 1.4, 1.0),
        ("late.mp4", ("2.4", "1.4"), &late, "late.mp4", "..", f64::NAN, 1.6),
        ("late.ts", ("2.4", "1.4"), &late, "late-ts.mp4", "..", f64::NAN, 1.6),
        ("part.avi", ("3", "3"), &mjpeg, "part.mp4", "16..35", 0.8, 0.4),
        ("part.ts", ("3", "3"), &h264, "part.mkv", "16..35", 0.8, 0.4),
        ("part.mpg", ("3", "3"), &mpeg, "part.webm", "16..35", 0.8, 0.4),
        ("end.mp4", ("3", "3"), &h264, "end.mp4", "21..", 2.2, 0.2),
    ] {
        let (recording, video) = (path(&format!("of-{name}")), path(video));
        beeping(&recording, lengths.0, lengths.1, options);
        let arguments =
            ["track", utf8(&recording), "--method", "paper", "--init", "60,50,30,30", "--video", utf8(&video)];
        let part = if frames == ".." { vec![] } else { vec!["--frames", frames] };
        let said = host_sim(&[&arguments[..], &part].concat());
        assert_eq!((said.code, said.err.contains("note")), (Some(0), false), "{name}: {}", said.err);
        assert_eq!(pictures(&video), said.out.lines().count(), "{name}");
        let (found, loud) = sound(&video);
        let length = if length.is_nan() { sound(&recording).0 } else { length };
        // A frame of sound has at most 1152 samples, 26 ms.
        assert!((found - length).abs() < 0.03, "{name}: {found} s of sound, expected {length}");
        assert!((loud - beep).abs() < 0.03, "{name}: the beep is at {loud} s, expected {beep}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 24, "nothing else is left");
}

#[test]
fn sound_that_cannot_be_read_costs_no_video() {
    if !has_ffmpeg("sound_that_cannot_be_read_costs_no_video") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // Without checksums, which would tell the changes below.
    beeping(&path("whole.mkv"), "2", "2", &["-c:v", "mjpeg", "-c:a", "ac3", "-write_crc32", "0"]);
    let bytes = std::fs::read(path("whole.mkv")).unwrap();
    let name = bytes.windows(5).position(|five| five == b"A_AC3").unwrap();
    let mut unknown = bytes.clone();
    unknown[name..name + 5].copy_from_slice(b"A_XYZ");
    std::fs::write(path("unknown.mkv"), unknown).unwrap();
    // Changes the head of an AC-3 frame in the middle, after its synchronization word.
    let heads: Vec<usize> = (0..bytes.len() - 1).filter(|&at| bytes[at..at + 2] == [0x0B, 0x77]).collect();
    let (mut damaged, at) = (bytes, heads[heads.len() / 2]);
    damaged[at..at + 40].fill(0xFF);
    std::fs::write(path("damaged.mkv"), damaged).unwrap();
    beeping(&path("short.mkv"), "2", "0.5", &["-c:v", "mjpeg", "-c:a", "ac3"]);
    run("ffmpeg", &["-i", utf8(&path("whole.mkv")), "-an", "-c", "copy", utf8(&path("silent.mkv"))]);
    for (recording, more, count, note) in [
        ("unknown", &[][..], 50, Some("that of FILE cannot be read, says ffmpeg: ")),
        ("damaged", &[], 50, Some("that of FILE cannot be read, says ffmpeg: ")),
        ("short", &["--frames", "26..45"], 20, Some("FILE has no sound in these frames")),
        ("silent", &[], 50, None),
    ] {
        for ending in ["mp4", "webm"] {
            let (file, video) = (path(&format!("{recording}.mkv")), path(&format!("{recording}.{ending}")));
            let arguments =
                ["track", utf8(&file), "--method", "paper", "--init", "60,50,30,30", "--video", utf8(&video)];
            let said = host_sim(&[&arguments[..], more].concat());
            let notes: Vec<&str> = said.err.lines().filter(|line| !line.starts_with("warning")).collect();
            assert_eq!((said.code, pictures(&video), notes.len()), (Some(0), count, usize::from(note.is_some())));
            if let Some(note) = note {
                let note = note.replace("FILE", utf8(&file));
                assert!(notes[0].starts_with(&format!("note: {} has no sound: {note}", video.display())), "{notes:?}");
            }
            let streams = run("ffmpeg", &["-i", utf8(&video), "-c", "copy", "-map", "0", "-f", "framecrc", "-"]);
            assert!(!streams.contains("audio"), "{recording}: {streams}");
        }
    }
}
