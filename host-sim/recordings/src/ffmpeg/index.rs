//! Index of a video: the time of each frame in seconds, and whether a seek to that time finds the frame.
//!
//! Times are read from packets if each packet is one frame and times grow; otherwise the whole file is decoded.

use super::decoder::{FROM_ZERO, MAX_TIME_JUMP, Use};
use super::facts::Video;
use super::packets::{DISCARDED, Packets};
use super::reading;
use crate::formats::y4m;
use smr_files::locked;
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

/// Times of a video's frames by number, filled in by a thread.
#[derive(Default)]
pub(crate) struct Index {
    found: Mutex<Found>,
    grown: Condvar,
    video: OnceLock<Arc<Video>>,
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
        if !y4m::is_y4m(file)
            && let Ok(video) = Video::of("ffmpeg", file, patience)
        {
            let _ = self.video.set(Arc::new(video));
        }
        let listing = listing(file, self.video.get(), patience);
        self.change(|found| found.can_seek = Some(listing != Listing::Unsure));
        if let Listing::Frames(times) = listing {
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

    /// Returns the facts of the file; `None` until they are known, or if ffmpeg cannot read it.
    pub fn video(&self) -> Option<Arc<Video>> {
        self.video.get().cloned()
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
    let video = if y4m::is_y4m(file) { None } else { Some(Arc::new(Video::of("ffmpeg", file, patience).ok()?)) };
    if let Listing::Frames(times) = listing(file, video.as_ref(), patience) { Some(times.len()) } else { None }
}

fn decoded(file: &Path, patience: Duration) -> impl Iterator<Item = f64> {
    reading::good(file, Use::Times, patience).map_while(|image| image.seconds())
}

/// Result of reading the packets of a file, with only the first frames decoded.
#[derive(Debug, PartialEq)]
enum Listing {
    /// Presentation times of all frames in seconds, sorted; each packet is one frame.
    Frames(Vec<f64>),
    /// Times grow, but some packets may show no frame of their own.
    Hidden,
    /// Times are missing, wrong, repeat, go back or leap, a packet is empty, the codec is not known, reading failed, or
    /// the file does not begin with a key frame or is not whole.
    Unsure,
}

/// Codecs with one shown frame in each packet, whose decoding can start at every key frame.
const ONE_EACH: [&str; 9] = ["h264", "hevc", "av1", "vp9", "mpeg1video", "mpeg2video", "mjpeg", "prores", "rawvideo"];
/// Codecs whose decoding can start at every key frame, but whose packets without a shown frame cannot be recognised.
const SOME_HIDDEN: [&str; 2] = ["vp8", "mpeg4"];

/// Count of frames that are decoded to verify the times of the packets.
const CHECKED_FRAMES: usize = 48;

fn listing(file: &Path, video: Option<&Arc<Video>>, patience: Duration) -> Listing {
    if y4m::is_y4m(file) {
        return y4m::times(file).map_or(Listing::Unsure, |times| Listing::Frames(times.collect()));
    }
    let read = video
        .filter(|video| video.facts.begins_at_key && video.input.end.is_none())
        .and_then(|video| read_packets(video));
    read.and_then(|read| read.checked(file, patience)).unwrap_or(Listing::Unsure)
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

/// Reads all packets. Returns `None` if ffmpeg cannot be run or read, a time is missing, the DTS does not grow, or two
/// shown packets have the same PTS.
fn read_packets(video: &Video) -> Option<Read> {
    let facts = &video.facts;
    let mut packets = Packets::of(&video.input, &FROM_ZERO, &["-map", &format!("0:V:{}", facts.stream)]).ok()?;
    let (unit, second) = facts.base?;
    let base = (unit.into(), second.into());
    let mut read = Read { codec: facts.codec.clone(), base, times: Vec::new(), has_empty: false };
    let mut last = i64::MIN;
    while let Some(packet) = packets.next().ok()? {
        let (sent, shown) = (packet.sent?, packet.shown?);
        if sent <= std::mem::replace(&mut last, sent) {
            return None;
        }
        read.has_empty |= packet.size == 0;
        if packet.flags & DISCARDED == 0 {
            let at = read.times.len() - read.times.iter().rev().take_while(|&&time| time > shown).count();
            if at > 0 && read.times[at - 1] == shown {
                return None;
            }
            read.times.insert(at, shown);
        }
    }
    packets.ffmpeg.succeeded().ok()?.then_some(read)
}

impl Read {
    /// Classifies the packets; `None` for an unknown codec, an empty packet, no decodable frame, a leap in time, or
    /// packet times that lack the time of a decoded frame.
    fn checked(mut self, file: &Path, patience: Duration) -> Option<Listing> {
        if SOME_HIDDEN.contains(&self.codec.as_str()) {
            return Some(Listing::Hidden);
        }
        if self.has_empty || !ONE_EACH.contains(&self.codec.as_str()) {
            return None;
        }
        let seconds = |&time: &i64| time as f64 * self.base.0 / self.base.1;
        let tried: Vec<f64> = decoded(file, patience).take(CHECKED_FRAMES).collect();
        let first = *tried.first()?;
        let mut times: Vec<f64> = self.times.drain(..).map(|time| seconds(&time)).collect();
        times.drain(..times.partition_point(|&time| time < first - SAME));
        let is_there =
            |time: &f64| times.get(times.partition_point(|at| at + SAME < *time)).is_some_and(|at| at - time < SAME);
        let has_leap = times.windows(2).any(|pair| pair[1] - pair[0] > f64::from(MAX_TIME_JUMP));
        if has_leap || !tried.iter().all(is_there) {
            return None;
        }
        // The two fields of an interlaced frame may be two packets, with half a frame interval between their times.
        let least = |times: &[f64]| times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let are_all = tried.len() == times.len()
            || tried.len() == CHECKED_FRAMES
                && tried.last() <= times.get(CHECKED_FRAMES - 1).map(|at| at + SAME).as_ref();
        Some(if are_all && least(&times) > 0.6 * least(&tried) { Listing::Frames(times) } else { Listing::Hidden })
    }
}
