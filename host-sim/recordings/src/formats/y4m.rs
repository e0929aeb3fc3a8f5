//! YUV4MPEG2 (`.y4m`) as a recording or a live source: the luma plane is the gray picture, byte for byte.

use crate::damage::damaged;
use crate::{ColorFrame, Frame, GrayFrame, MAX_PIXELS, has_extension};
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

/// A frame in the layout of the stream: the luma plane, then two chroma planes, if any.
#[derive(Clone, Debug)]
pub struct Planes {
    size: (u16, u16),
    chroma: Chroma,
    bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Chroma {
    /// Horizontal chroma subsampling: pixels for each chroma sample; 0 without chroma.
    across: usize,
    down: usize,
    /// True for full range (0 to 255) and gray frames, false for limited range (luma 16 to 235, chroma 16 to 240).
    is_full: bool,
}

impl Planes {
    pub fn gray(&self) -> GrayFrame {
        let (width, height) = self.size;
        let luma = usize::from(width) * usize::from(height);
        GrayFrame { width, height, pixels: self.bytes[..luma].to_vec() }
    }

    /// Converts the frame to RGB by the matrix of BT.601, because the stream names no matrix.
    pub fn color(&self) -> ColorFrame {
        let (width, height) = (usize::from(self.size.0), usize::from(self.size.1));
        let Chroma { across, down, is_full } = self.chroma;
        let (luma, chroma) = self.bytes.split_at(width * height);
        let (blue, red) = chroma.split_at(chroma.len() / 2);
        let (black, of_luma, of_chroma) = if is_full { (0.0, 1.0, 1.0) } else { (16.0, 255.0 / 219.0, 255.0 / 224.0) };
        let pixel = |at: usize| {
            let gray = (f32::from(luma[at]) - black) * of_luma;
            let difference = |plane: &[u8]| {
                let at = at / width / down.max(1) * width.div_ceil(across.max(1)) + at % width / across.max(1);
                plane.get(at).map_or(0.0, |&level| (f32::from(level) - 128.0) * of_chroma)
            };
            let (blue, red) = (difference(blue), difference(red));
            let rgb = [gray + 1.402 * red, gray - 0.344_136 * blue - 0.714_136 * red, gray + 1.772 * blue];
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
            rgb.map(|level| level.round() as u8)
        };
        ColorFrame { width: self.size.0, height: self.size.1, pixels: (0..luma.len()).map(pixel).collect() }
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
