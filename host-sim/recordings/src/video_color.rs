//! The frames of a video in color, each with its time, as ffmpeg decodes them.
//!
//! A second ffmpeg decodes the same frames as [`super::video`], which says what is wrong with them. Sizes and times come from its filter
//! `showinfo`, on standard error.

use super::color::Moment;
use super::video::{Patient, command};
use super::{ColorFrame, GrayFrame, y4m};
use crate::cleanup::Process;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

/// The frames from the one with the number `first` on, no side longer than `side`. `None` if there is no ffmpeg.
pub(super) fn open(file: &Path, first: usize, side: u16, patience: Duration) -> Option<ColorStream> {
    let skip = first - 1;
    let filter = format!("select='gte(n,{skip})',{}", within(side));
    Some(ColorStream(Stream::start(file, &["-threads", "1"], &filter, "rgb24", patience)?))
}

/// The frames in color from the one on that is shown at `time` ([`super::frame_times`]), no side longer than `side`, without decoding all
/// that comes before it. `None` if there is no ffmpeg, or no such frame.
pub fn color_frames_at(file: &Path, time: f64, side: u16, patience: Duration) -> Option<ColorStream> {
    Stream::at(file, time, &within(side), "rgb24", patience).map(ColorStream)
}

/// The same frames in gray, as trackers see them.
pub fn gray_frames_at(
    file: &Path,
    time: f64,
    patience: Duration,
) -> Option<Box<dyn Iterator<Item = GrayFrame> + Send>> {
    if y4m::is_y4m(file) {
        return Some(Box::new(y4m::frames_at(file, time)?));
    }
    let mut stream = Stream::at(file, time, "null", "gray", patience)?;
    let gray = |Picture { size: (width, height), bytes: pixels, .. }| GrayFrame { width, height, pixels };
    Some(Box::new(std::iter::from_fn(move || stream.next().map(gray))))
}

/// The times of the frames that ffmpeg decodes.
pub(super) fn times(file: &Path, patience: Duration) -> Option<impl Iterator<Item = f64> + use<>> {
    // A pixel a frame: only the times are looked at.
    let mut stream = Stream::start(file, &FROM_ZERO, "scale=1:1:flags=neighbor", "gray", patience)?;
    Some(std::iter::from_fn(move || stream.next()?.moment).map(|moment| moment.seconds()))
}

/// Times begin with the file, not with the first picture, wherever reading begins.
pub(super) const FROM_ZERO: [&str; 2] = ["-copyts", "-start_at_zero"];

fn within(side: u16) -> String {
    format!("scale='min({side},iw)':'min({side},ih)':force_original_aspect_ratio=decrease")
}

/// Less than there is between two frames, in seconds: files in milliseconds round by half of that.
const NEAR: f64 = 0.0006;

/// Pictures as they come out of an ffmpeg, each with what is said of it.
struct Stream {
    pixels: Patient,
    shown: Receiver<Shown>,
    /// The first one, if it was looked at.
    first: Option<Shown>,
    bytes: usize,
    patience: Duration,
    _process: Process,
}

struct Picture {
    size: (u16, u16),
    moment: Option<Moment>,
    bytes: Vec<u8>,
}

impl Stream {
    fn start(file: &Path, options: &[&str], filter: &str, pixels: &str, patience: Duration) -> Option<Self> {
        let mut command = command("ffmpeg", "level+info", file, options);
        let filter = format!("{filter},showinfo=checksum=0");
        command.args(["-vf", &filter, "-pix_fmt", pixels, "-fps_mode", "passthrough", "-f", "rawvideo", "-"]);
        let process = Process::start(&mut command).ok()?;
        let (said, bytes) = (process.complaints()?, if pixels == "gray" { 1 } else { 3 });
        let pixels = Patient::new(process.output()?, patience);
        let (sender, shown) = channel();
        thread::spawn(move || {
            let mut base = None;
            for line in BufReader::new(said).split(b'\n').map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line);
                let Some((_, line)) = line.split_once("Parsed_showinfo") else { continue };
                base = line.split_once("time_base: ").and_then(|(_, base)| fraction(base)).or(base);
                if let Some(shown) = Shown::parse(line, base) {
                    // Everything is read, or ffmpeg would wait.
                    let _ = sender.send(shown);
                }
            }
        });
        Some(Self { pixels, shown, first: None, bytes, patience, _process: process })
    }

    /// Some files cannot be read from any place, and of some the place is not where a picture begins: then it begins earlier.
    fn at(file: &Path, time: f64, filter: &str, pixels: &str, patience: Duration) -> Option<Self> {
        let filter = format!("select='gte(t,{:.6})',{filter}", time - NEAR / 2.0);
        for before in [0.0001, 10.0] {
            let seek = format!("{:.6}", (time - before).max(0.0));
            let options = [FROM_ZERO.as_slice(), &["-ss", &seek]].concat();
            let mut stream = Self::start(file, &options, &filter, pixels, patience)?;
            stream.first = stream.shown.recv_timeout(patience).ok();
            let found = stream.first.as_ref().and_then(|first| first.moment);
            if found.is_some_and(|found| (found.seconds() - time).abs() < NEAR) {
                return Some(stream);
            }
        }
        let mut stream = Self::start(file, &FROM_ZERO, &filter, pixels, patience)?;
        stream.first = stream.shown.recv_timeout(patience).ok();
        stream.first.is_some().then_some(stream)
    }

    fn next(&mut self) -> Option<Picture> {
        // Said before the pixels are written.
        let first = self.first.take();
        let Shown { size, moment } = first.or_else(|| self.shown.recv_timeout(self.patience).ok())?;
        let mut bytes = vec![0; usize::from(size.0) * usize::from(size.1) * self.bytes];
        self.pixels.read_exact(&mut bytes).ok()?;
        Some(Picture { size, moment, bytes })
    }
}

pub struct ColorStream(Stream);

impl Iterator for ColorStream {
    type Item = (ColorFrame, Option<Moment>);

    fn next(&mut self) -> Option<Self::Item> {
        let Picture { size: (width, height), moment, bytes } = self.0.next()?;
        Some((ColorFrame { width, height, pixels: bytes.as_chunks().0.to_vec() }, moment))
    }
}

#[derive(Debug, PartialEq)]
struct Shown {
    size: (u16, u16),
    moment: Option<Moment>,
}

impl Shown {
    /// ` n:   1 pts:    512 pts_time:0.0333333 pos: 5000 fmt:yuv420p sar:1/1 s:640x480 i:P iskey:0 ...`
    fn parse(line: &str, base: Option<(u32, u32)>) -> Option<Self> {
        let field = |name: &str| line.split_once(name)?.1.split_whitespace().next();
        let (width, height) = field(" s:")?.split_once('x')?;
        let time = field(" pts:").and_then(|time| time.parse().ok());
        let aspect = field(" sar:").and_then(fraction).unwrap_or((1, 1));
        let moment = time.zip(base).map(|(time, base)| Moment { time, base, aspect });
        Some(Self { size: (width.parse().ok()?, height.parse().ok()?), moment })
    }
}

/// `1/15360` at the beginning of `text`; `None` if a number is 0.
pub(super) fn fraction(text: &str) -> Option<(u32, u32)> {
    let (numerator, rest) = text.split_once('/')?;
    let denominator = rest.split(|letter: char| !letter.is_ascii_digit()).next()?;
    let number = |text: &str| text.parse().ok().filter(|&number: &u32| number > 0);
    number(numerator).zip(number(denominator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_showinfo_says() {
        let line = "_0 @ 0x55d] [info] n:   1 pts:    512 pts_time:0.0333333 pos:     5000 fmt:yuv420p sar:12/11 s:720x576 i:P iskey:0 type:B mean:[16 128 128]";
        let moment = Moment { time: 512, base: (1, 15360), aspect: (12, 11) };
        assert_eq!(Shown::parse(line, Some((1, 15360))), Some(Shown { size: (720, 576), moment: Some(moment) }));
        let unknown = line.replace("    512", " NOPTS").replace("12/11", "0/1");
        assert_eq!(Shown::parse(&unknown, Some((1, 15360))), Some(Shown { size: (720, 576), moment: None }));
        assert_eq!(Shown::parse("_0 @ 0x55d] [info] config in time_base: 1/15360, frame_rate: 30/1", None), None);
        assert_eq!(fraction("1001/30000, frame_rate: 30/1"), Some((1001, 30000)));
        assert_eq!((fraction("0/1"), fraction("1/"), fraction("x")), (None, None, None));
    }
}
