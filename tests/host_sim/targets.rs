//! Several targets in one pass, and videos that keep what the recording has: colors, times, shape and sound.

use crate::missing::{has, has_ffmpeg};
use crate::program::{host_sim, utf8};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The boxes of `synthetic` in these frames, as they are typed.
fn boxes(frames: &[usize]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("boxes");
    assert_eq!(host_sim(&["convert", "synthetic", "-o", utf8(&out), "--format", "raw"]).code, Some(0));
    let truth = fs::read_to_string(out.join("gt.txt")).unwrap();
    let lines: Vec<&str> = truth.lines().collect();
    let typed = |frame: &usize| {
        let corners: Vec<f64> = lines[frame - 1].split(',').map(|number| number.parse().unwrap()).collect();
        format!("{},{},{},{}", corners[0], corners[1], corners[2] - corners[0], corners[3] - corners[1])
    };
    frames.iter().map(typed).collect()
}

#[test]
fn each_of_several_targets_is_followed_as_if_it_were_alone() {
    let [first, tenth, late] = &boxes(&[1, 10, 25])[..] else { unreachable!() };
    let (a, b, again) = (format!("a={first}"), format!("b={tenth}@10"), format!("a@25={late}"));
    let part = ["track", "synthetic", "--frames", "1..40"];
    let together =
        host_sim(&[&part[..], &["--json", "--init", &a, "--init", &b, "--init", &again]].concat()).json_lines();
    let of = |name: &str| together.iter().filter(|line| line["target"] == name).cloned().collect::<Vec<_>>();
    assert_eq!((of("a").len(), of("b").len(), together.len()), (40, 31, 71));
    let alone = |init: &[&str]| host_sim(&[&part[..], &["--json"], init].concat()).json_lines();
    assert_eq!(of("a"), alone(&["--init", &a, "--init", &again]));
    assert_eq!(of("b"), alone(&["--init", &b]));
    assert_eq!((&of("b")[0]["frame"], &of("b")[0]["state"]), (&10.into(), &"tracking".into()));
    // Locked on anew.
    assert!(of("a")[24]["quality"].is_number() && of("a")[23]["quality"].is_null());

    let csv = host_sim(&[&part[..], &["--init", &a, "--init", &b]].concat());
    assert!(csv.out.starts_with("target,frame,time,x,y,width,height,state,"), "{}", csv.out);
    assert_eq!(csv.out.lines().count(), 1 + 40 + 31);
}

#[test]
fn frames_keep_the_numbers_of_the_recording() {
    let lines = host_sim(&["track", "synthetic", "--frames", "11..13", "--json"]).json_lines();
    assert_eq!(lines.iter().map(|line| line["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [11, 12, 13]);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("boxes");
    assert_eq!(host_sim(&["track", "synthetic", "--frames", "11..12", "--video", utf8(&out)]).code, Some(0));
    let mut names: Vec<_> = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["00011.png", "00012.png"]);
}

/// Runs a program of ffmpeg's; what it says.
fn run(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(["-v", "error"]).args(arguments).output().unwrap();
    assert!(output.status.success(), "{program} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Whether ffmpeg and ffprobe run.
fn has_both(test: &str) -> bool {
    has_ffmpeg(test) && has(test, "ffprobe", &["-version"])
}

/// The times of all frames, in seconds, from the first.
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

/// A clip with colors, sound, pixels that are not square, and frames at irregular times.
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
    // The bars of the test picture: red on the left, blue right of the middle.
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
