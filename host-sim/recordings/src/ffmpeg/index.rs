//! Index of a video: the time of each frame in seconds, and whether a seek to that time finds the frame.
//!
//! Times are read from packets if each packet is one frame and times grow; otherwise the whole file is decoded.

use super::pictures::{self, FROM_ZERO, Use};
use super::{Ffmpeg, command, fraction, input};
use crate::cleanup::locked;
use crate::y4m;
use std::io::BufRead;
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Times of a video's frames by number, filled in by a thread.
#[derive(Default)]
pub(crate) struct Index {
    found: Mutex<Found>,
    grown: Condvar,
}

#[derive(Default)]
struct Found {
    times: Vec<f64>,
    /// True if a seek to a time finds the frame of that time; `None` while unknown.
    can_seek: Option<bool>,
    /// True if no more times will be added.
    is_whole: bool,
}

impl Index {
    pub fn unknown() -> Arc<Self> {
        let index = Arc::<Self>::default();
        index.change(|found| found.is_whole = true);
        index
    }

    pub fn of(file: &Path, patience: Duration) -> Arc<Self> {
        let (index, file) = (Arc::<Self>::default(), file.to_owned());
        let found = Arc::clone(&index);
        thread::spawn(move || {
            found.fill(&file, patience);
            found.change(|found| found.is_whole = true);
        });
        index
    }

    fn fill(&self, file: &Path, patience: Duration) {
        let packets = packets(file, patience);
        self.change(|found| found.can_seek = Some(packets != Packets::Unsure));
        if let Packets::Frames(times) = packets {
            return self.change(|found| (found.times, found.is_whole) = (times, true));
        }
        for time in decoded(file, patience) {
            self.change(|found| {
                if found.times.last().is_some_and(|&last| last >= time) {
                    found.can_seek = Some(false);
                }
                found.times.push(time);
            });
        }
    }

    fn change(&self, change: impl FnOnce(&mut Found)) {
        change(&mut locked(&self.found));
        self.grown.notify_all();
    }

    /// Returns the times of all frames; `None` until all are known.
    pub fn times(&self) -> Option<Vec<f64>> {
        let found = locked(&self.found);
        (found.is_whole && !found.times.is_empty()).then(|| found.times.clone())
    }

    /// Waits until the time of a frame is known and returns it; `None` if a seek by time does not find the frame.
    pub fn sought(&self, number: usize) -> Option<f64> {
        let mut found = locked(&self.found);
        while !found.is_whole && found.can_seek != Some(false) && found.times.len() < number {
            found = self.grown.wait(found).unwrap_or_else(PoisonError::into_inner);
        }
        found.times.get(number - 1).copied().filter(|_| found.can_seek == Some(true))
    }

    pub fn has(&self, number: usize, time: Option<f64>) -> bool {
        self.sought(number).zip(time).is_some_and(|(expected, time)| (expected - time).abs() < SAME)
    }

    /// True if the video certainly has no frame `number`.
    pub fn ends_before(&self, number: usize) -> bool {
        let found = locked(&self.found);
        found.is_whole && found.can_seek == Some(true) && found.times.len() < number
    }
}

/// Difference in seconds below which two times are equal.
const SAME: f64 = 1e-6;

/// Returns the number of frames in a file; `None` if only decoding the whole file would give this number.
pub(crate) fn count(file: &Path, patience: Duration) -> Option<usize> {
    if let Packets::Frames(times) = packets(file, patience) { Some(times.len()) } else { None }
}

fn decoded(file: &Path, patience: Duration) -> impl Iterator<Item = f64> {
    pictures::good(file, Use::Times, patience).map_while(|picture| picture.seconds())
}

/// Result of reading the packets of a file, with only the first frames decoded.
#[derive(Debug, PartialEq)]
enum Packets {
    /// Presentation times of all frames in seconds, sorted; each packet is one frame.
    Frames(Vec<f64>),
    /// Times grow, but some packets may show no frame of their own.
    Hidden,
    /// Times are missing, wrong, repeat, go back or leap, a packet is empty, the codec is not known, or reading failed.
    Unsure,
}

/// Codecs with one shown frame in each packet, whose decoding can start at every key frame.
const ONE_EACH: [&str; 9] = ["h264", "hevc", "av1", "vp9", "mpeg1video", "mpeg2video", "mjpeg", "prores", "rawvideo"];
/// Codecs whose decoding can start at every key frame, but whose packets without a shown frame cannot be recognised.
const SOME_HIDDEN: [&str; 2] = ["vp8", "mpeg4"];

/// Count of frames that are decoded to verify the times of the packets.
const CHECKED_FRAMES: usize = 48;

fn packets(file: &Path, patience: Duration) -> Packets {
    if y4m::is_y4m(file) {
        return y4m::times(file).map_or(Packets::Unsure, |times| Packets::Frames(times.collect()));
    }
    read_packets(file, patience).and_then(|read| read.checked(file, patience)).unwrap_or(Packets::Unsure)
}

/// Facts about a file's packets; no two shown packets have the same presentation time.
struct Read {
    codec: String,
    /// Unit of `times` in seconds, as a fraction.
    base: (f64, f64),
    /// Presentation times of the shown packets (those without the flag `DISCARDED`), sorted.
    times: Vec<i64>,
    has_empty: bool,
}

/// Flag of packets that are decoded but not shown, because an edit list cuts them.
const DISCARDED: u32 = 4;

/// Reads ffmpeg's line of each packet: `stream, DTS, PTS, duration, size, sum[, F=flags]`. Returns `None` if ffmpeg
/// cannot be run or read, a time is missing, the DTS does not grow, or two shown packets have the same PTS.
fn read_packets(file: &Path, patience: Duration) -> Option<Read> {
    let mut command = command("ffmpeg", "quiet", &input(file), &FROM_ZERO);
    command.args(["-c", "copy", "-copyinkf", "-copypriorss", "1", "-f", "framecrc", "-"]);
    let mut ffmpeg = Ffmpeg::run(&mut command, "", patience).ok()?;
    let mut lines = ffmpeg.output();
    let mut read = Read { codec: String::new(), base: (0.0, 1.0), times: Vec::new(), has_empty: false };
    let (mut line, mut last) = (String::new(), i64::MIN);
    while lines.read_line(&mut line).ok()? > 0 {
        if let Some(head) = line.strip_prefix('#') {
            let value = |name: &str| head.strip_prefix(name).map(str::trim);
            read.base = value("tb 0:").and_then(fraction).map_or(read.base, |(n, d)| (n.into(), d.into()));
            read.codec = value("codec_id 0:").map_or(read.codec, str::to_owned);
        } else {
            let fields: Vec<&str> = line.split(',').map(str::trim).collect();
            // ffmpeg prints `i64::MIN` for an unknown time.
            let number = |at: usize| fields.get(at)?.parse().ok().filter(|&number| number != i64::MIN);
            let flags = fields.iter().find_map(|field| u32::from_str_radix(field.strip_prefix("F=0x")?, 16).ok());
            let (sent, shown) = (number(1)?, number(2)?);
            if sent <= std::mem::replace(&mut last, sent) {
                return None;
            }
            read.has_empty |= number(4) == Some(0);
            if flags.is_none_or(|flags| flags & DISCARDED == 0) {
                let at = read.times.len() - read.times.iter().rev().take_while(|&&time| time > shown).count();
                if at > 0 && read.times[at - 1] == shown {
                    return None;
                }
                read.times.insert(at, shown);
            }
        }
        line.clear();
    }
    Some(read)
}

impl Read {
    /// Classifies the packets; `None` for an unknown codec, an empty packet, no decodable frame, a leap in time, or
    /// packet times that lack the time of a decoded frame.
    fn checked(mut self, file: &Path, patience: Duration) -> Option<Packets> {
        if SOME_HIDDEN.contains(&self.codec.as_str()) {
            return Some(Packets::Hidden);
        }
        if self.has_empty || !ONE_EACH.contains(&self.codec.as_str()) {
            return None;
        }
        let seconds = |&time: &i64| time as f64 * self.base.0 / self.base.1;
        let tried: Vec<f64> = decoded(file, patience).take(CHECKED_FRAMES).collect();
        // Packets before the first decoded frame cannot be decoded: the recording began between two key frames.
        let first = *tried.first()?;
        let mut times: Vec<f64> = self.times.drain(..).map(|time| seconds(&time)).collect();
        times.drain(..times.partition_point(|&time| time < first - SAME));
        let is_there =
            |time: &f64| times.get(times.partition_point(|at| at + SAME < *time)).is_some_and(|at| at - time < SAME);
        let has_leap = times.windows(2).any(|pair| pair[1] - pair[0] > f64::from(pictures::MAX_TIME_JUMP));
        if has_leap || !tried.iter().all(is_there) {
            return None;
        }
        // The two fields of an interlaced frame may be two packets, with half a frame interval between their times.
        let least = |times: &[f64]| times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let are_all = tried.len() == times.len()
            || tried.len() == CHECKED_FRAMES
                && tried.last() <= times.get(CHECKED_FRAMES - 1).map(|at| at + SAME).as_ref();
        Some(if are_all && least(&times) > 0.6 * least(&tried) { Packets::Frames(times) } else { Packets::Hidden })
    }
}
