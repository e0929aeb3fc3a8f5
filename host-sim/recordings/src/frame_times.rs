//! When the frames of a file are shown, in seconds, without decoding them.

use super::video::{self, Patient};
use super::{video_color, y4m};
use crate::cleanup::Process;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::io::BufRead;
use std::path::Path;
use std::time::Duration;

/// The times of all frames in the order in which they are shown: what [`super::color_frames_at`] and [`super::gray_frames_at`] find a frame by,
/// and `ffmpeg -ss TIME -i FILE`. `None` if they are not known: the file is no video, there is no ffmpeg, or it cannot read it.
pub fn frame_times(file: &Path, patience: Duration) -> Option<Box<dyn Iterator<Item = f64> + Send>> {
    if y4m::is_y4m(file) {
        return Some(Box::new(y4m::times(file)?));
    }
    let times = packet_times(file, patience)?;
    // Of VP8, packets without a picture look like all others.
    if times.codec == "vp8" {
        return Some(Box::new(video_color::times(file, patience)?));
    }
    Some(Box::new(times))
}

/// Enough for each codec: H.264 and H.265 show a frame at most 16 later than they send it.
const REORDERED: usize = 32;

struct Times {
    packets: Packets,
    codec: String,
    /// Those that were read, and not shown yet.
    waiting: BinaryHeap<Earliest>,
    /// Of the first frame that is decoded.
    first: f64,
    /// How much later than sent a frame is shown, of files that do not say of each when it is shown.
    delay: Option<f64>,
}

fn packet_times(file: &Path, patience: Duration) -> Option<Times> {
    let mut command = video::command("ffmpeg", "quiet", file, &video_color::FROM_ZERO);
    command.args(["-map", "0:v:0", "-c", "copy", "-copyinkf", "-copypriorss", "1", "-f", "framecrc", "-"]);
    let process = Process::start(&mut command).ok()?;
    let mut lines = Patient::new(process.output()?, patience);
    let (mut base, mut codec) = (None, String::new());
    let mut line = read_line(&mut lines)?;
    while let Some(head) = line.strip_prefix('#') {
        let value = |name: &str| head.strip_prefix(name).map(str::trim);
        base = value("tb 0:").and_then(video_color::fraction).or(base);
        codec = value("codec_id 0:").map_or(codec, str::to_owned);
        line = read_line(&mut lines)?;
    }
    let (numerator, denominator) = base?;
    let mut packets = Packets {
        lines,
        next: Some(line),
        base: (f64::from(numerator), f64::from(denominator)),
        end: 0.0,
        _process: process,
    };
    let first = video_color::times(file, patience)?.next()?;
    let begin: Vec<Packet> = packets.by_ref().take(REORDERED).collect();
    let mut times = Times { packets, codec, waiting: BinaryHeap::new(), first, delay: None };
    if begin.iter().any(|packet| packet.shown.is_none()) {
        let sent = begin.iter().map(|packet| packet.sent).fold(f64::INFINITY, f64::min);
        times.delay = Some(first - sent);
    }
    begin.into_iter().for_each(|packet| times.add(packet));
    Some(times)
}

impl Times {
    fn add(&mut self, Packet { sent, shown }: Packet) {
        let time = self.delay.map_or_else(|| shown.unwrap_or(sent), |delay| sent + delay);
        // What comes before cannot be decoded: the recording was begun between two whole pictures.
        if time > self.first - 1e-6 {
            self.waiting.push(Earliest(time));
        }
    }
}

impl Iterator for Times {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        while self.waiting.len() < REORDERED
            && let Some(packet) = self.packets.next()
        {
            self.add(packet);
        }
        Some(self.waiting.pop()?.0)
    }
}

struct Packet {
    sent: f64,
    shown: Option<f64>,
}

/// The heap gives the earliest first.
struct Earliest(f64);

impl Ord for Earliest {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0)
    }
}

impl PartialOrd for Earliest {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Earliest {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Earliest {}

/// What ffmpeg says of each packet: `stream, sent, shown, duration, size, sum[, F=flags]`.
struct Packets {
    lines: Patient,
    next: Option<String>,
    /// In seconds, as a fraction.
    base: (f64, f64),
    /// When the packet before ends.
    end: f64,
    _process: Process,
}

/// As ffmpeg writes a time that is not known.
const UNKNOWN: i64 = i64::MIN;

/// The flag of packets that are decoded and not shown: an edit list cuts them.
const DISCARDED: u32 = 4;

impl Iterator for Packets {
    type Item = Packet;

    fn next(&mut self) -> Option<Packet> {
        loop {
            let line = self.next.take().or_else(|| read_line(&mut self.lines))?;
            let fields: Vec<&str> = line.split(',').map(str::trim).collect();
            let number = |at: usize| fields.get(at)?.parse::<i64>().ok();
            let flags = fields.iter().find_map(|field| u32::from_str_radix(field.strip_prefix("F=0x")?, 16).ok());
            let seconds = |time: i64| time as f64 * self.base.0 / self.base.1;
            let known = |at: usize| number(at).filter(|&time| time != UNKNOWN).map(seconds);
            let (sent, shown) = (known(1).unwrap_or(self.end), known(2));
            self.end = sent + number(3).map_or(0.0, seconds);
            if flags.is_none_or(|flags| flags & DISCARDED == 0) {
                return Some(Packet { sent, shown });
            }
        }
    }
}

/// `None` at the end.
fn read_line(lines: &mut Patient) -> Option<String> {
    let mut line = String::new();
    lines.read_line(&mut line).ok().filter(|&length| length > 0)?;
    Some(line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::missing::{has_ffmpeg, runs};
    use crate::{ColorFrames, FFMPEG_PATIENCE, GrayFrame, OpenOptions, color_frames_at, gray_frames_at, open};
    use std::process::Command;
    use tempfile::TempDir;

    const SOURCE: &str = "testsrc2=size=160x120:rate=30:duration=3";
    const H264: &str = "-c:v libx264 -g 30 -bf 3 -flags +cgop -preset fast";

    /// A folder with a file of this name, made of `SOURCE` with such options; `None` if this ffmpeg cannot write it.
    fn made(name: &str, options: &str) -> Option<TempDir> {
        let folder = tempfile::tempdir().unwrap();
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-nostdin", "-v", "error", "-f", "lavfi", "-i", SOURCE, "-f", "lavfi", "-i", "sine=duration=3"]);
        let is_made = runs(ffmpeg.args(options.split_whitespace()).arg(folder.path().join(name)));
        is_made.then_some(folder)
    }

    fn times_of(file: &Path) -> Vec<f64> {
        frame_times(file, FFMPEG_PATIENCE).unwrap().collect()
    }

    fn decoded(file: &Path) -> Vec<f64> {
        video_color::times(file, FFMPEG_PATIENCE).unwrap().collect()
    }

    fn assert_same(name: &str, found: &[f64], expected: &[f64]) {
        let pairs = found.iter().zip(expected);
        let apart = pairs.map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max);
        assert!(found.len() == expected.len() && apart < 1e-4, "{name}, {apart}: {found:?}, expected {expected:?}");
    }

    #[test]
    fn times_are_those_of_the_frames_that_are_decoded() {
        let test = "times_are_those_of_the_frames_that_are_decoded";
        if !has_ffmpeg(test) {
            return;
        }
        for (name, options) in [
            ("a.mp4", format!("{H264} -c:a aac")),
            ("varying.mkv", format!("-vf select=not(mod(n\\,3))+not(mod(n\\,7)) -fps_mode vfr {H264}")),
            ("from-1.4.ts", format!("{H264} -c:a aac")),
            ("a.webm", "-c:v libvpx-vp9 -deadline realtime -cpu-used 8 -auto-alt-ref 1 -lag-in-frames 16".to_owned()),
            ("vp8.webm", "-c:v libvpx -deadline realtime -auto-alt-ref 1 -lag-in-frames 16".to_owned()),
            ("sent.avi", format!("{H264} -an")),
            ("some.avi", "-c:v mpeg4 -bf 2 -an".to_owned()),
            ("a.mpg", "-c:v mpeg2video -bf 2 -g 12".to_owned()),
            ("a.y4m", String::new()),
        ] {
            let Some(folder) = made(name, &options) else {
                crate::missing::skipped(test, format_args!("this ffmpeg does not write {name}"));
                continue;
            };
            let file = folder.path().join(name);
            assert_same(name, &times_of(&file), &decoded(&file));
        }
    }

    #[test]
    fn what_an_edit_list_cuts_has_no_time() {
        let Some(folder) = made("whole.mp4", H264) else {
            return crate::missing::skipped("what_an_edit_list_cuts_has_no_time", "no ffmpeg with libx264");
        };
        let (whole, cut) = (folder.path().join("whole.mp4"), folder.path().join("cut.mp4"));
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-nostdin", "-v", "error", "-ss", "0.7", "-i"]).arg(whole).args(["-c", "copy"]).arg(&cut);
        assert!(runs(&mut ffmpeg));
        let times = times_of(&cut);
        assert_same("cut.mp4", &times, &decoded(&cut));
        assert_eq!(times.len(), 90 - 21);
    }

    #[test]
    fn a_frame_that_is_sought_is_that_of_the_sequence() {
        let test = "a_frame_that_is_sought_is_that_of_the_sequence";
        for (name, options) in [
            ("a.mp4", format!("{H264} -c:a aac")),
            ("a.ts", format!("{H264} -c:a aac")),
            ("open.mkv", "-c:v libx264 -g 30 -bf 3 -x264-params open-gop=1 -r 10".to_owned()),
            ("sent.avi", format!("{H264} -an")),
            ("a.y4m", String::new()),
        ] {
            let Some(folder) = made(name, &options) else {
                crate::missing::skipped(test, format_args!("no ffmpeg that writes {name}"));
                continue;
            };
            let file = folder.path().join(name);
            let sequence = open(&file, &OpenOptions::default()).unwrap();
            let frames: Vec<GrayFrame> = sequence.frames.map(Result::unwrap).collect();
            let times = times_of(&file);
            assert_eq!(frames.len(), times.len(), "{name}");
            for number in [0, 1, frames.len() / 3 - 1, frames.len() / 3, frames.len() / 3 + 1, frames.len() - 2] {
                let sought: Vec<GrayFrame> = gray_frames_at(&file, times[number], FFMPEG_PATIENCE).unwrap().collect();
                assert!(sought == frames[number..], "{name}, {number}: {} frames", sought.len());
                let (color, _) =
                    color_frames_at(&file, times[number], u16::MAX, FFMPEG_PATIENCE).unwrap().next().unwrap();
                let mut all: ColorFrames = sequence.colors.clone().open(number + 1, FFMPEG_PATIENCE);
                assert!(color == all.next(&frames[number]).0, "{name}, {number} in color");
            }
        }
    }
}
