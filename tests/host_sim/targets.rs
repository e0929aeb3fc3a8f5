//! Exported videos keep the recording's colors, times, shape of pixels and sound.

use crate::missing::{has, has_ffmpeg};
use crate::program::{host_sim, utf8};
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
