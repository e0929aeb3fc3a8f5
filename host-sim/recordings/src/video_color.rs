//! The frames of a video in color, each with its time, as ffmpeg decodes them.
//!
//! A second ffmpeg decodes the same frames as [`super::video`], which says what is wrong with them. Sizes and times come from its filter
//! `showinfo`, on standard error.

use super::ColorFrame;
use super::color::Moment;
use super::video::{Patient, command};
use crate::cleanup::Process;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

/// The frames from the one with the number `first` on, no side longer than `side`. `None` if there is no ffmpeg.
pub(super) fn open(file: &Path, first: usize, side: u16, patience: Duration) -> Option<Frames> {
    let mut command = command("ffmpeg", "level+info", file);
    let skip = first - 1;
    let within = format!("scale='min({side},iw)':'min({side},ih)':force_original_aspect_ratio=decrease");
    let filter = format!("select='gte(n,{skip})',{within},showinfo=checksum=0");
    command.args(["-vf", &filter, "-pix_fmt", "rgb24", "-fps_mode", "passthrough", "-f", "rawvideo", "-"]);
    let process = Process::start(&mut command).ok()?;
    let (said, pixels) = (process.complaints()?, Patient::new(process.output()?, patience));
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
    Some(Frames { pixels, shown, patience, _process: process })
}

pub(super) struct Frames {
    pixels: Patient,
    shown: Receiver<Shown>,
    patience: Duration,
    _process: Process,
}

impl Iterator for Frames {
    type Item = (ColorFrame, Option<Moment>);

    fn next(&mut self) -> Option<Self::Item> {
        // Said before the pixels are written.
        let Shown { size: (width, height), moment } = self.shown.recv_timeout(self.patience).ok()?;
        let mut bytes = vec![0; usize::from(width) * usize::from(height) * 3];
        self.pixels.read_exact(&mut bytes).ok()?;
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
fn fraction(text: &str) -> Option<(u32, u32)> {
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
