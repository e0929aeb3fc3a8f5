//! Index of a video: the time of each frame in seconds, and whether a seek to that time finds the frame.
//!
//! Times are read from packets if each packet is one frame and times grow; otherwise the whole file is decoded.

use super::decoder::{MAX_TIME_JUMP, Use};
use super::facts::Video;
use super::packets::DISCARDED;
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
        let video = video(file, patience).map(Arc::new);
        if let Some(video) = &video {
            let _ = self.video.set(Arc::clone(video));
        }
        let listing = listing(file, video.as_deref());
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
    if let Listing::Frames(times) = listing(file, video(file, patience).as_ref()) { Some(times.len()) } else { None }
}

/// Returns the facts of a file; `None` if ffmpeg is not needed, or cannot read it.
fn video(file: &Path, patience: Duration) -> Option<Video> {
    (!y4m::is_y4m(file)).then(|| Video::of("ffmpeg", file, patience).ok())?
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

fn listing(file: &Path, video: Option<&Video>) -> Listing {
    if y4m::is_y4m(file) {
        return y4m::times(file).map_or(Listing::Unsure, |times| Listing::Frames(times.collect()));
    }
    let whole = video.filter(|video| video.facts.begins_at_key && video.input.end.is_none());
    whole.and_then(listed).unwrap_or(Listing::Unsure)
}

/// Classifies the packets; `None` for an unknown codec, an empty packet, no decodable frame, a leap in time, or packet
/// times that lack the time of a decoded frame.
fn listed(video: &Video) -> Option<Listing> {
    let codec = video.facts.codec.as_str();
    if SOME_HIDDEN.contains(&codec) {
        return shown_times(video, true).map(|_| Listing::Hidden);
    }
    let shown = ONE_EACH.contains(&codec).then(|| shown_times(video, false))??;
    let (unit, second) = video.facts.base?;
    let seconds = |time: i64| time as f64 * f64::from(unit) / f64::from(second);
    let mut times: Vec<f64> = shown.into_iter().map(seconds).collect();
    let tried: Vec<f64> = decoded(&video.input.file, video.input.patience).take(CHECKED_FRAMES).collect();
    let first = *tried.first()?;
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
        || tried.len() == CHECKED_FRAMES && tried.last() <= times.get(CHECKED_FRAMES - 1).map(|at| at + SAME).as_ref();
    Some(if are_all && least(&times) > 0.6 * least(&tried) { Listing::Frames(times) } else { Listing::Hidden })
}

/// Reads all packets, and returns the presentation times of those that are shown, sorted, in units of the stream.
/// Returns `None` if ffmpeg cannot be run or read, a time is missing, the DTS does not grow, two shown packets have the
/// same PTS, or a packet is empty, unless `may_be_empty`.
fn shown_times(video: &Video, may_be_empty: bool) -> Option<Vec<i64>> {
    video.facts.base?;
    let (mut packets, mut times, mut last) = (video.packets().ok()?, Vec::new(), i64::MIN);
    while let Some(packet) = packets.next().ok()? {
        let (sent, shown) = (packet.sent?, packet.shown?);
        if sent <= std::mem::replace(&mut last, sent) || packet.size == 0 && !may_be_empty {
            return None;
        }
        if packet.flags & DISCARDED == 0 {
            let at = times.len() - times.iter().rev().take_while(|&&time| time > shown).count();
            if at > 0 && times[at - 1] == shown {
                return None;
            }
            times.insert(at, shown);
        }
    }
    packets.ffmpeg.succeeded().ok()?.then_some(times)
}
