//! YUV4MPEG2 (`.y4m`) as a recording: the luma plane is the gray picture, byte for byte.
//!
//! What ffmpeg decodes comes through here as well, see [`super::video`].

use super::damage::Damaged;
use super::{GrayFrame, MOST_PIXELS, has_extension};
use anyhow::{Context, Result, bail, ensure};
use std::fs::{File, Metadata};
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

/// More than a line can have: the header of the stream, or that of a frame.
const LINE_BYTES: u64 = 1024;

pub(super) fn is_y4m(file: &Path) -> bool {
    has_extension(file, &["y4m"])
}

pub(super) fn open(file: &Path) -> Result<Frames<BufReader<File>>> {
    let name = file.display().to_string();
    let data = File::open(file).with_context(|| format!("cannot open {name}"))?;
    Frames::new(BufReader::new(data), name)
}

/// The times of the frames of a file, in seconds; `None` if its header says no rate.
pub(super) fn times(file: &Path) -> Option<impl Iterator<Item = f64> + use<>> {
    let mut frames = open(file).ok()?;
    let (number, seconds) = frames.header.rate?;
    let end = frames.stream.get_ref().metadata().ok().filter(Metadata::is_file)?.len();
    let count = std::iter::from_fn(move || frames.skip_frame().filter(|&at| at <= end));
    Some((0_u32..).zip(count).map(move |(frame, _)| f64::from(frame) * seconds / number))
}

/// The frames of a file from the one on that is shown at `time`.
pub(super) fn frames_at(file: &Path, time: f64) -> Option<impl Iterator<Item = GrayFrame> + Send + use<>> {
    let count = times(file)?.take_while(|&before| before < time - 1e-6).count();
    let mut frames = open(file).ok()?;
    for _ in 0..count {
        frames.skip_frame()?;
    }
    Some(frames.map_while(Result::ok))
}

pub(super) struct Frames<R> {
    stream: R,
    header: Header,
    name: String,
    number: u64,
}

impl<R: BufRead> Frames<R> {
    /// Reads the header. `name` is what the stream is called in errors.
    pub(super) fn new(mut stream: R, name: String) -> Result<Self> {
        let line = line(&mut stream).with_context(|| format!("cannot read {name}"))?;
        let header = Header::parse(&line).with_context(|| name.clone())?;
        Ok(Self { stream, header, name, number: 0 })
    }

    fn read(&mut self) -> Result<Option<GrayFrame>> {
        let Header { size: (width, height), frame_bytes, .. } = self.header;
        let line = line(&mut self.stream)?;
        if line.is_empty() {
            return Ok(None);
        }
        let luma = u64::from(width) * u64::from(height);
        let (mut pixels, mut chroma) = (Vec::new(), 0);
        if line.ends_with(b"\n") || line.len() as u64 == LINE_BYTES {
            let is_frame = line.starts_with(b"FRAME\n") || line.starts_with(b"FRAME ") && line.ends_with(b"\n");
            ensure!(
                is_frame,
                "it does not begin as a frame of YUV4MPEG2 does: expected a line FRAME before its pixels"
            );
            self.stream.by_ref().take(luma).read_to_end(&mut pixels)?;
            chroma = io::copy(&mut self.stream.by_ref().take(frame_bytes - luma), &mut io::sink())?;
        }
        let read = pixels.len() as u64 + chroma;
        if read < frame_bytes {
            let (expected, found) = ("FRAME\n".len() as u64 + frame_bytes, line.len() as u64 + read);
            let why = format!("it is cut short: expected {expected} bytes with its header, found {found}");
            return Err(Damaged::new(why).into());
        }
        Ok(Some(GrayFrame { width, height, pixels }))
    }
}

impl Frames<BufReader<File>> {
    /// Where the next frame begins; `None` if none begins here.
    fn skip_frame(&mut self) -> Option<u64> {
        line(&mut self.stream).ok()?.starts_with(b"FRAME").then_some(())?;
        self.stream.seek_relative(self.header.frame_bytes.try_into().ok()?).ok()?;
        self.stream.stream_position().ok()
    }
}

fn line(stream: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    stream.take(LINE_BYTES).read_until(b'\n', &mut line)?;
    Ok(line)
}

impl<R: BufRead> Iterator for Frames<R> {
    type Item = Result<GrayFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        self.number += 1;
        let read = self.read();
        read.with_context(|| format!("{}, frame {}", self.name, self.number)).transpose()
    }
}

#[derive(Debug, PartialEq)]
struct Header {
    size: (u16, u16),
    /// Bytes of all planes of a frame.
    frame_bytes: u64,
    /// So many frames in so many seconds.
    rate: Option<(f64, f64)>,
}

impl Header {
    fn parse(line: &[u8]) -> Result<Self> {
        ensure!(
            !(line.starts_with(b"YUV4MPEG2 ") && line.ends_with(b"\r\n")),
            "its header ends with CR LF: expected LF alone; it was changed as if it were text, and its pixels too"
        );
        let fields = line.strip_prefix(b"YUV4MPEG2 ").and_then(|rest| rest.strip_suffix(b"\n"));
        let fields =
            String::from_utf8_lossy(fields.context("expected a line that begins with YUV4MPEG2")?).into_owned();
        let field = |letter| fields.split(' ').rev().find_map(|field| field.strip_prefix(letter));
        let size = (side('W', field('W'))?, side('H', field('H'))?);
        let frame_bytes = frame_bytes(size, field('C').unwrap_or("420"))?;
        let (width, height) = size;
        ensure!(
            frame_bytes <= MOST_PIXELS,
            "a frame of {width}x{height} has {frame_bytes} bytes: expected at most {MOST_PIXELS}"
        );
        // They tell whether this is such a header.
        let is_ratio =
            |text: &str| text.split_once(':').is_some_and(|(a, b)| [a, b].iter().all(|n| n.parse::<u64>().is_ok()));
        let ratios = fields.split(' ').filter_map(|field| field.strip_prefix(['F', 'A']));
        ensure!(
            ratios.into_iter().all(is_ratio),
            "its header is not understood: expected that of YUV4MPEG2, as ffmpeg writes it"
        );
        let rate = field('F').and_then(|rate| rate.split_once(':'));
        let rate = rate.and_then(|(frames, seconds)| Some((frames.parse().ok()?, seconds.parse().ok()?)));
        Ok(Self {
            size,
            frame_bytes,
            rate: rate.filter(|&(frames, seconds): &(f64, f64)| frames > 0.0 && seconds > 0.0),
        })
    }
}

fn side(letter: char, value: Option<&str>) -> Result<u16> {
    let value = value.with_context(|| format!("its header names no size: expected {letter} and a number"))?;
    let side = value.parse().ok().filter(|&side| side > 0);
    side.with_context(|| format!("its header says {letter}{value}: expected a size of 1 to 65535"))
}

fn frame_bytes((width, height): (u16, u16), colour: &str) -> Result<u64> {
    let (width, height) = (u64::from(width), u64::from(height));
    let chroma = match colour {
        "mono" => 0,
        "420" | "420jpeg" | "420paldv" | "420mpeg2" => width.div_ceil(2) * height.div_ceil(2),
        "422" => width.div_ceil(2) * height,
        "444" => width * height,
        _ => bail!("{}", unsupported(colour)),
    };
    Ok(width * height + 2 * chroma)
}

fn unsupported(colour: &str) -> String {
    // mono12, 420p10: the depth stands at the end.
    let family = ["mono", "420p", "422p", "444p"].into_iter().find_map(|family| colour.strip_prefix(family));
    match family.and_then(|depth| depth.parse::<u8>().ok()) {
        Some(depth) => format!("its pixels have {depth} bits (C{colour}): expected 8"),
        None => format!("its colour space is C{colour}: expected mono, 420, 422 or 444 with 8 bits"),
    }
}
