//! Decodes the images of a video, and judges whether they are whole.

use super::facts::Video;
use super::nut::{Nut, Packet};
use super::process::{self, FROM_ZERO, Ffmpeg, Line, MARK};
use super::tones::Tones;
use crate::frame::Frame;
use crate::frame::Moment;
use crate::raster::{ColorFrame, GrayFrame, MAX_PIXELS};
use anyhow::{Context, Result, ensure};
use smr_files::input::Patient;
use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::Stdio;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Use {
    Gray,
    /// Color frames for display, scaled down to at most this many pixels on a side.
    Color(u16),
    Times,
}

pub(crate) struct Image {
    size: (u16, u16),
    pub moment: Option<Moment>,
    bytes: Vec<u8>,
}

impl Image {
    pub fn seconds(&self) -> Option<f64> {
        self.moment.map(|moment| moment.seconds())
    }

    pub fn gray(self, number: usize) -> Frame {
        let (seconds, (width, height)) = (self.seconds(), self.size);
        Frame::new(number, seconds, GrayFrame { width, height, pixels: self.bytes })
    }

    pub fn color(self) -> (ColorFrame, Option<Moment>) {
        let (width, height) = self.size;
        (ColorFrame { width, height, pixels: self.bytes.as_chunks().0.to_vec() }, self.moment)
    }

    pub(super) fn hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        (self.size, &self.bytes).hash(&mut hasher);
        hasher.finish()
    }
}

/// End of a video's images.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum End {
    Whole,
    /// ffmpeg failed, or complained, after this many images. Its words are only quoted.
    Doubtful {
        decoded: usize,
        words: String,
    },
}

/// Part of a file that is decoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    Whole,
    /// Images from a time in seconds on, after a seek to a time at or before it.
    From {
        seek: f64,
        time: f64,
    },
    /// At most this many packets from the first key frame on: another ffmpeg copies them into NUT. Copying joins the times of joined
    /// files, and drops packets in front of the first key frame. It loses a rotation that only the container states.
    Packets(usize),
}

/// Number of decoded images that are held back until more have been decoded without a doubt: damage can show itself
/// some images late.
pub(super) const HELD: usize = 4;

/// Filter by which times ascend, since a time that does not is an error of ffmpeg; [`MARK`] prints the true times.
const ASCENDING: &str = "setpts='if(eq(N,0),if(isnan(PTS),0,PTS),if(isnan(PTS),PREV_OUTPTS+1,max(PTS,PREV_OUTPTS+1)))'";

/// Seconds added to times in NUT, which cannot be negative.
const NUT_OFFSET: u32 = 1000;

/// Length of a frame interval without a known rate, in parts of a second.
const UNKNOWN_BASE: (u32, u32) = (1, 1_000_000);

pub(crate) struct Decoder {
    ffmpeg: Ffmpeg,
    /// The ffmpeg that copies packets, for [`Part::Packets`].
    copier: Option<Ffmpeg>,
    nut: Nut<Patient>,
    /// Images that wait for their row, and rows that wait for their image.
    unpaired: [VecDeque<Packet>; 2],
    /// Count of complaints that are no doubt: those before the first packet, or all for MJPEG, whose decoder complains
    /// about the data of applications.
    allowed: usize,
    depth: usize,
    tones: Option<Tones>,
    base: (u32, u32),
    aspect: (u32, u32),
    /// Time of the start of the stream, in units of `base`.
    zero: i64,
    times: Continued,
    held: VecDeque<Image>,
    /// Number of images that are held back.
    holds: usize,
    decoded: usize,
    /// True if the file goes on behind the part that is read, because a checksum is wrong there.
    is_cut: bool,
    /// True if only the first packets are decoded.
    is_first_part: bool,
    end: Option<End>,
}

impl Decoder {
    pub(super) fn start(video: &Video, wanted: Use, part: Part) -> Result<Self> {
        let allowed = match part {
            _ if video.facts.codec == "mjpeg" => usize::MAX,
            Part::Packets(_) => 0,
            Part::Whole | Part::From { .. } => video.facts.notes,
        };
        Self::run(video, wanted, part, &STRICT, allowed, HELD)
    }

    /// Starts to decode images that are known to be right, and later ones that may not be: nothing is a doubt.
    pub(super) fn lenient(video: &Video, wanted: Use, part: Part) -> Result<Self> {
        Self::run(video, wanted, part, &ONE_THREAD, usize::MAX, 0)
    }

    fn run(video: &Video, wanted: Use, part: Part, strict: &[&str], allowed: usize, holds: usize) -> Result<Self> {
        let Video { input, facts, .. } = video;
        let tones = match wanted {
            Use::Color(_) => video.transfer().map(Tones::of),
            Use::Gray | Use::Times => None,
        };
        let base = facts.base.unwrap_or(UNKNOWN_BASE);
        let (mut command, copier) = match part {
            Part::Packets(most) => {
                let copier = copier(video, most)?;
                let mut command = process::command(&input.program);
                command.args(strict).args(["-copyts", "-f", "nut", "-i", "-"]).stdin(Stdio::from(copier.pipe()));
                (command, Some(copier))
            }
            Part::Whole => (input.command(&[&FROM_ZERO[..], strict].concat()), None),
            Part::From { seek, .. } => {
                let seek = format!("{:.6}", seek.max(0.0));
                (input.command(&[&FROM_ZERO[..], strict, &["-ss", &seek]].concat()), None)
            }
        };
        let stream = if copier.is_some() { 0 } else { facts.stream };
        let (filters, depth) = filters(wanted, part, base, tones.is_some());
        // The second output has one row, whose length is the width: a change of size is no secret.
        let graph = format!("[0:V:{stream}]{filters},split[all][b];[b]crop=iw:1:0:0[row]");
        command.args(["-filter_complex", &graph, "-map", "[all]", "-map", "[row]", "-noautoscale"]);
        command.args(["-fps_mode", "passthrough", "-enc_time_base", &format!("{}:{}", base.0, base.1)]);
        command.args(["-c:v", "rawvideo", "-threads", "1", "-f", "nut", "-"]);
        let ffmpeg = input.run(&mut command)?;
        let zero = if copier.is_some() { i64::from(NUT_OFFSET) * i64::from(base.1) / i64::from(base.0) } else { 0 };
        Ok(Self {
            nut: Nut::new(ffmpeg.output()),
            unpaired: Default::default(),
            ffmpeg,
            copier,
            allowed,
            depth,
            tones,
            base,
            aspect: facts.aspect,
            zero,
            times: Continued::default(),
            held: VecDeque::new(),
            holds,
            decoded: 0,
            is_cut: input.end.is_some(),
            is_first_part: matches!(part, Part::Packets(..usize::MAX)),
            end: None,
        })
    }

    /// Returns the next image, once [`HELD`] later ones or the end of a whole stream have been decoded without a
    /// doubt. After `None`, [`Self::end`] says why there is no other.
    pub fn next(&mut self) -> Result<Option<Image>> {
        while self.held.len() <= self.holds && self.end.is_none() {
            match self.decode()? {
                Some(image) => {
                    self.decoded += 1;
                    self.held.push_back(image);
                }
                None => self.end = Some(self.verdict()?),
            }
        }
        let is_sure = self.held.len() > self.holds || self.end == Some(End::Whole);
        Ok(if is_sure { self.held.pop_front() } else { None })
    }

    pub fn decoded(&self) -> usize {
        self.decoded
    }

    /// True after the last image of a whole stream.
    pub fn is_whole(&self) -> bool {
        self.end == Some(End::Whole)
    }

    /// Returns the end; `None` before it.
    pub(super) fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }

    /// Returns the hash of the next image that is still held back.
    pub(super) fn first_held(&self) -> Option<u64> {
        self.held.front().map(Image::hash)
    }

    fn decode(&mut self) -> Result<Option<Image>> {
        let Some(image) = self.packets()? else { return Ok(None) };
        // The line of an image is written before its packet, and after every complaint about the image.
        loop {
            match self.ffmpeg.line()? {
                Some(Line::Image(time)) => {
                    let is_good = self.ffmpeg.complaints <= self.allowed;
                    return Ok(is_good.then(|| self.timed(image, time)));
                }
                Some(_) => {}
                None => return Ok(None),
            }
        }
    }

    fn timed(&mut self, image: Image, time: Option<i64>) -> Image {
        let (base, aspect) = (self.base, self.aspect);
        let second = i64::from(base.1.div_ceil(base.0));
        let time = time.map(|time| self.times.next(time - self.zero, second));
        Image { moment: time.map(|time| Moment { time, base, aspect }), ..image }
    }

    /// Reads the two packets of an image: all of it, and its first row. A newer ffmpeg may write them in any order.
    fn packets(&mut self) -> Result<Option<Image>> {
        let depth = self.depth as u64;
        while self.unpaired.iter().any(VecDeque::is_empty) {
            let Some(packet) = self.nut.packet(MAX_PIXELS * depth)? else { return Ok(None) };
            let stream = usize::try_from(packet.stream).ok().and_then(|stream| self.unpaired.get_mut(stream));
            stream.context("ffmpeg has written an unknown stream")?.push_back(packet);
        }
        let [all, row] = self.unpaired.each_mut().map(VecDeque::pop_front);
        let (Some(Packet { length, bytes, .. }), Some(row)) = (all, row) else { return Ok(None) };
        let width = row.length / depth;
        ensure!(width > 0, "ffmpeg's pictures have no width");
        let height = length / depth / width;
        let sides = u16::try_from(width).ok().zip(u16::try_from(height).ok());
        let (size, bytes) = sides.zip(bytes).with_context(|| {
            format!("it is {width}x{height}: expected sides of at most 65535 and at most {MAX_PIXELS} pixels")
        })?;
        let bytes = self.tones.as_ref().map(|tones| tones.of_all(&bytes)).unwrap_or(bytes);
        Ok(Some(Image { size, moment: None, bytes }))
    }

    /// Judges the whole stream: waits for the end of ffmpeg, unless it has already complained.
    fn verdict(&mut self) -> Result<End> {
        let is_doubted = self.ffmpeg.complaints > self.allowed;
        if is_doubted || !self.ffmpeg.succeeded()? || self.ffmpeg.complaints > self.allowed {
            return Ok(self.doubt(self.ffmpeg.words()));
        }
        // A copier of the first packets may end in the middle of the next one.
        if self.is_first_part {
            return Ok(End::Whole);
        }
        if let Some(copier) = &mut self.copier
            && !copier.succeeded()?
        {
            let words = copier.words();
            return Ok(self.doubt(words));
        }
        Ok(if self.is_cut { self.doubt(String::new()) } else { End::Whole })
    }

    fn doubt(&self, words: String) -> End {
        End::Doubtful { decoded: self.decoded, words }
    }
}

/// Returns the filters that turn what is decoded into what is wanted, and the number of bytes for each pixel.
fn filters(wanted: Use, part: Part, base: (u32, u32), is_hdr: bool) -> (String, usize) {
    let (scale, format, depth) = match wanted {
        Use::Gray => (String::new(), "gray", 1),
        Use::Color(side) => {
            let scale = format!("scale='min({side},iw)':'min({side},ih)':force_original_aspect_ratio=decrease,");
            if is_hdr { (scale, "rgb48le", 6) } else { (scale, "rgb24", 3) }
        }
        Use::Times => ("scale=1:1:flags=neighbor,".to_owned(), "gray", 1),
    };
    let select = match part {
        Part::From { time, .. } => format!("select='gte(t,{time:.6})',"),
        Part::Whole | Part::Packets(_) => String::new(),
    };
    (format!("{select}settb={}/{},{MARK},{ASCENDING},{scale}format={format}", base.0, base.1), depth)
}

/// Starts an ffmpeg that copies packets into NUT.
fn copier(Video { input, facts, .. }: &Video, most: usize) -> Result<Ffmpeg> {
    let mut command = input.command(&["-fflags", "+genpts"]);
    command.args(["-map", &facts.map(), "-c", "copy"]);
    if most < usize::MAX {
        command.args(["-frames:v", &most.to_string()]);
    }
    command.args(["-output_ts_offset", &NUT_OFFSET.to_string(), "-f", "nut", "-"]);
    input.run(&mut command)
}

/// ffmpeg options by which a decoder ends at the first error that it notices. With several threads it would fill
/// damaged areas with other pixels in each run.
const STRICT: [&str; 5] = ["-xerror", "-err_detect", "explode", "-threads", "1"];
const ONE_THREAD: [&str; 2] = ["-threads", "1"];

/// Largest step in seconds between the times of successive frames of one video. A larger step is a join of two videos:
/// where times go back in MPEG-TS, ffmpeg assumes a clock overflow and turns this into a large step forward.
pub(super) const MAX_TIME_JUMP: u32 = 43_200;

/// Times that never go back: in a file of joined videos, each video continues the times of the one before.
#[derive(Default)]
struct Continued {
    last: Option<i64>,
    step: i64,
    /// Offset added to the times of the file, in their unit.
    shift: i64,
}

impl Continued {
    /// Returns `time` continued over joined videos; `second` is one second in the unit of `time`.
    fn next(&mut self, time: i64, second: i64) -> i64 {
        let mut now = time.saturating_add(self.shift);
        if let Some(last) = self.last {
            // A step back by less than `step`, the frame interval, is a wrong time stamp, not the start of a video.
            if now <= last - self.step || now - last > i64::from(MAX_TIME_JUMP) * second {
                now = last + self.step;
                self.shift = now.saturating_sub(time);
            }
            now = now.max(last);
            self.step = if now > last { now - last } else { self.step };
        }
        self.last = Some(now);
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_go_on_where_a_file_begins_anew() {
        let mut times = Continued::default();
        let found = [0, 40, 80, 0, 40, 40, 30, 5000, 50_000_000].map(|time| times.next(time, 1000));
        assert_eq!(found, [0, 40, 80, 120, 160, 160, 160, 5120, 10_080]);
    }
}
