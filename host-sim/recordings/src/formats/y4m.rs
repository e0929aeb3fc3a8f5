//! YUV4MPEG2 (`.y4m`) as a recording or a live source: the luma plane is the gray image, byte for byte.

use crate::checked_frames::damaged;
use crate::formats::names::has_extension;
use crate::frame::Frame;
use crate::planes::{Chroma, Planes};
use crate::raster::MAX_PIXELS;
use anyhow::{Context, Result, bail, ensure};
use std::fs::{File, Metadata};
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

/// Largest number of bytes in a header line, of the stream or of a frame.
const MAX_LINE_BYTES: u64 = 1024;

pub(crate) fn is_y4m(file: &Path) -> bool {
    has_extension(file, &["y4m"])
}

pub(crate) fn open(file: &Path) -> Result<Frames<BufReader<File>>> {
    let name = file.display().to_string();
    let data = File::open(file).with_context(|| format!("cannot open {name}"))?;
    Frames::new(BufReader::new(data), name)
}

/// Returns the times of a file's frames in seconds; `None` if its header states no rate.
pub(crate) fn times(file: &Path) -> Option<impl Iterator<Item = f64> + use<>> {
    let mut frames = open(file).ok()?;
    let (number, seconds) = frames.header.rate?;
    let end = frames.stream.get_ref().metadata().ok().filter(Metadata::is_file)?.len();
    let count = std::iter::from_fn(move || frames.skip_frame().filter(|&at| at <= end));
    Some((0_u32..).zip(count).map(move |(frame, _)| f64::from(frame) * seconds / number))
}

pub(crate) struct Frames<R> {
    stream: R,
    header: Header,
    name: String,
    number: usize,
}

impl<R: BufRead> Frames<R> {
    /// Reads the stream's header. Errors call the stream `name`.
    pub(crate) fn new(mut stream: R, name: String) -> Result<Self> {
        let line = line(&mut stream).with_context(|| format!("cannot read {name}"))?;
        let header = Header::parse(&line).with_context(|| name.clone())?;
        Ok(Self { stream, header, name, number: 0 })
    }

    pub(crate) fn next_planes(&mut self) -> Result<Option<Planes>> {
        self.number += 1;
        let read = self.read();
        let bytes = read.with_context(|| format!("{}, frame {}", self.name, self.number))?;
        Ok(bytes.map(|bytes| Planes { size: self.header.size, chroma: self.header.chroma, bytes }))
    }

    fn read(&mut self) -> Result<Option<Vec<u8>>> {
        let frame_bytes = self.header.frame_bytes;
        let line = line(&mut self.stream)?;
        if line.is_empty() {
            return Ok(None);
        }
        let mut pixels = Vec::new();
        if line.ends_with(b"\n") || line.len() as u64 == MAX_LINE_BYTES {
            let is_frame = line.starts_with(b"FRAME\n") || line.starts_with(b"FRAME ") && line.ends_with(b"\n");
            let expected = "expected a line FRAME before its pixels";
            ensure!(is_frame, "it does not begin as a frame of YUV4MPEG2 does: {expected}");
            self.stream.by_ref().take(frame_bytes).read_to_end(&mut pixels)?;
        }
        let read = pixels.len() as u64;
        if read < frame_bytes {
            let (expected, found) = ("FRAME\n".len() as u64 + frame_bytes, line.len() as u64 + read);
            let why = format!("it is cut short: expected {expected} bytes with its header, found {found}");
            return Err(damaged(why, None));
        }
        Ok(Some(pixels))
    }
}

impl Frames<BufReader<File>> {
    pub(crate) fn from(mut self, first: usize) -> impl Iterator<Item = Result<Frame>> {
        while self.number + 1 < first && self.skip_frame().is_some() {
            self.number += 1;
        }
        self
    }

    /// Skips a frame and returns the byte offset behind it; `None` if no frame begins here.
    fn skip_frame(&mut self) -> Option<u64> {
        line(&mut self.stream).ok()?.starts_with(b"FRAME").then_some(())?;
        self.stream.seek_relative(self.header.frame_bytes.try_into().ok()?).ok()?;
        self.stream.stream_position().ok()
    }
}

fn line(stream: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    stream.take(MAX_LINE_BYTES).read_until(b'\n', &mut line)?;
    Ok(line)
}

impl<R: BufRead> Iterator for Frames<R> {
    type Item = Result<Frame>;

    fn next(&mut self) -> Option<Self::Item> {
        let planes = self.next_planes().transpose()?;
        let time = |(frames, seconds)| (self.number - 1) as f64 * seconds / frames;
        Some(planes.map(|planes| Frame::new(self.number, self.header.rate.map(time), planes.gray())))
    }
}

#[derive(Debug, PartialEq)]
struct Header {
    size: (u16, u16),
    frame_bytes: u64,
    chroma: Chroma,
    /// Frame rate as a fraction: a number of frames, and the seconds that they last.
    rate: Option<(f64, f64)>,
}

impl Header {
    fn parse(line: &[u8]) -> Result<Self> {
        let changed = "it was changed as if it were text, and its pixels too";
        let is_changed = line.starts_with(b"YUV4MPEG2 ") && line.ends_with(b"\r\n");
        ensure!(!is_changed, "its header ends with CR LF: expected LF alone; {changed}");
        let fields = line.strip_prefix(b"YUV4MPEG2 ").and_then(|rest| rest.strip_suffix(b"\n"));
        let fields =
            String::from_utf8_lossy(fields.context("expected a line that begins with YUV4MPEG2")?).into_owned();
        let field = |letter| fields.split(' ').rev().find_map(|field| field.strip_prefix(letter));
        let size = (side('W', field('W'))?, side('H', field('H'))?);
        let (across, down) = chroma(field('C').unwrap_or("420"))?;
        let chroma = Chroma { across, down, is_full: across == 0 || fields.contains("XCOLORRANGE=FULL") };
        let (width, height) = size;
        let plane =
            |across: usize, down: usize| usize::from(width).div_ceil(across) * usize::from(height).div_ceil(down);
        let frame_bytes = plane(1, 1) as u64 + if across == 0 { 0 } else { 2 * plane(across, down) as u64 };
        let has = format!("a frame of {width}x{height} has {frame_bytes} bytes");
        ensure!(frame_bytes <= MAX_PIXELS, "{has}: expected at most {MAX_PIXELS}");
        // Requires the frame rate (F) and the pixel aspect (A) to be ratios, which tells a header from other text.
        let is_ratio =
            |text: &str| text.split_once(':').is_some_and(|(a, b)| [a, b].iter().all(|n| n.parse::<u64>().is_ok()));
        let mut ratios = fields.split(' ').filter_map(|field| field.strip_prefix(['F', 'A']));
        let expected = "expected that of YUV4MPEG2, as ffmpeg writes it";
        ensure!(ratios.all(is_ratio), "its header is not understood: {expected}");
        let rate = field('F').and_then(|rate| rate.split_once(':'));
        let rate = rate.and_then(|(frames, seconds)| Some((frames.parse().ok()?, seconds.parse().ok()?)));
        let rate = rate.filter(|&(frames, seconds): &(f64, f64)| frames > 0.0 && seconds > 0.0);
        Ok(Self { size, frame_bytes, chroma, rate })
    }
}

fn side(letter: char, value: Option<&str>) -> Result<u16> {
    let value = value.with_context(|| format!("its header names no size: expected {letter} and a number"))?;
    let side = value.parse().ok().filter(|&side| side > 0);
    side.with_context(|| format!("its header says {letter}{value}: expected a size of 1 to 65535"))
}

/// Returns the chroma subsampling across and down; 0 for gray.
fn chroma(colour: &str) -> Result<(usize, usize)> {
    Ok(match colour {
        "mono" => (0, 0),
        "420" | "420jpeg" | "420paldv" | "420mpeg2" => (2, 2),
        "422" => (2, 1),
        "444" => (1, 1),
        _ => {
            // The bit depth is a suffix, as in mono12 or 420p10.
            let family = ["mono", "420p", "422p", "444p"].into_iter().find_map(|family| colour.strip_prefix(family));
            if let Some(depth) = family.and_then(|depth| depth.parse::<u8>().ok()) {
                bail!("its pixels have {depth} bits (C{colour}): expected 8");
            }
            bail!("its colour space is C{colour}: expected mono, 420, 422 or 444 with 8 bits");
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::reads;

    #[test]
    fn luma_is_the_image_and_damage_is_named() {
        let frames =
            b"FRAME\n\x01\x02\x03\x04\x05\x06\x80\x80\x80\x80FRAME Ip\n\x07\x08\x09\x0A\x0B\x0C\x80\x80\x80\x80";
        for colour in [" C420jpeg", " C420", ""] {
            let header = format!("YUV4MPEG2 W3 H2 F25:1{colour}\n");
            reads("a.y4m", None, &[header.as_bytes(), frames].concat(), &[1, 7], "");
        }
        let line_ends =
            "...: its header ends with CR LF: expected LF alone; it was changed as if it were text, and its pixels too";
        for (text, error) in [
            ("W3 H2 Cmono\n", "@/a.y4m holds no frame: expected at least one"),
            ("W3 H2 Cmono\nRUBBISH\n", "@/a.y4m, frame 1: it does not begin as a frame of YUV4MPEG2 does..."),
            ("W3 H2\r\n", line_ends),
            ("W3 H2 F25:1 C420p10\n", "@/a.y4m: its pixels have 10 bits (C420p10): expected 8"),
            ("W3 H2 F25:1 Cmono16\n", "@/a.y4m: its pixels have 16 bits (Cmono16): expected 8"),
            ("W3 H2 C411\n", "@/a.y4m: its colour space is C411: expected mono, 420, 422 or 444 with 8 bits"),
            ("W70000 H2\n", "@/a.y4m: its header says W70000: expected a size of 1 to 65535"),
            ("W3 H0\n", "@/a.y4m: its header says H0: expected a size of 1 to 65535"),
            ("W3\n", "@/a.y4m: its header names no size: expected H and a number"),
            ("W65535 H65535 Cmono\n", "...a frame of 65535x65535 has 4294836225 bytes: expected at most 268435456"),
            ("W3 H2 Fx\n", "@/a.y4m: its header is not understood: expected that of YUV4MPEG2, as ffmpeg writes it"),
        ] {
            reads("a.y4m", None, format!("YUV4MPEG2 {text}").as_bytes(), &[], error);
        }
        reads("a.y4m", None, b"RIFF\n", &[], "@/a.y4m: expected a line that begins with YUV4MPEG2");
        let whole = b"YUV4MPEG2 W3 H2 F25:1 Cmono\nFRAME\n123456FRAME\n123456";
        for (cut, found) in [(1, 11), (6, 6), (9, 3)] {
            let error = format!("@/a.y4m, frame 2: it is cut short: expected 12 bytes with its header, found {found}");
            reads("a.y4m", None, &whole[..whole.len() - cut], b"1", &error);
        }
    }

    /// In limited range (BT.601), pure red has Y 81, Cb 90 and Cr 240.
    #[test]
    fn planes_have_colors_in_both_ranges() {
        let color = |header: &str, planes: &[u8]| {
            let stream = [b"YUV4MPEG2 W2 H2 ".as_slice(), header.as_bytes(), b"\nFRAME\n", planes].concat();
            let mut frames = Frames::new(stream.as_slice(), "a.y4m".to_owned()).unwrap();
            frames.next_planes().unwrap().unwrap().color().pixels
        };
        let near = |found: [u8; 3], expected: [u8; 3]| found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 2);
        let limited = color("C420", &[81, 81, 16, 235, 90, 240]);
        assert!(near(limited[0], [255, 0, 0]) && near(limited[1], [255, 0, 0]), "{limited:?}");
        let full = color("C444 XCOLORRANGE=FULL", &[76, 0, 255, 29, 85, 128, 128, 255, 255, 128, 128, 107]);
        assert!(near(full[0], [254, 0, 0]) && near(full[1], [0; 3]) && near(full[2], [255; 3]), "{full:?}");
        assert!(near(full[3], [0, 0, 254]), "{full:?}");
        assert_eq!(color("Cmono", &[0, 7, 200, 255]), [[0; 3], [7; 3], [200; 3], [255; 3]]);
    }
}
