//! YUV4MPEG2 (`.y4m`) as a recording: the luma plane is the gray picture, byte for byte.
//!
//! What ffmpeg decodes comes through here as well, see [`super::video`].

use super::damage::Damaged;
use super::{GrayFrame, has_extension};
use ::y4m::{Decoder, Error, Limits};
use anyhow::{Context, Result, anyhow, bail, ensure};
use std::fs::File;
use std::io::{BufRead, BufReader, Chain, Cursor, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// More than a header can be.
const HEADER_BYTES: u64 = 1024;

/// The largest frame that memory is taken for, all planes: 16384x16384 gray.
const FRAME_BYTES: usize = 1 << 28;

pub(super) fn is_y4m(file: &Path) -> bool {
    has_extension(file, &["y4m"])
}

pub(super) fn open(file: &Path) -> Result<Frames<BufReader<File>>> {
    let name = file.display().to_string();
    let data = File::open(file).with_context(|| format!("cannot open {name}"))?;
    Frames::new(BufReader::new(data), name)
}

pub(super) struct Frames<R: Read> {
    decoder: Decoder<Counted<Chain<Cursor<Vec<u8>>, R>>>,
    /// Bytes that the decoder has read. It takes the end of the stream and a frame cut short for the same thing.
    count: Arc<AtomicU64>,
    size: (u16, u16),
    frame_bytes: u64,
    name: String,
    number: u64,
}

impl<R: BufRead> Frames<R> {
    /// Reads the header. `name` is what the stream is called in errors.
    pub(super) fn new(mut stream: R, name: String) -> Result<Self> {
        let mut line = Vec::new();
        stream
            .by_ref()
            .take(HEADER_BYTES)
            .read_until(b'\n', &mut line)
            .with_context(|| format!("cannot read {name}"))?;
        let header = Header::parse(&line).with_context(|| name.clone())?;
        let count = Arc::new(AtomicU64::new(0));
        let stream = Counted { inner: Cursor::new(line).chain(stream), count: Arc::clone(&count) };
        let decoder = Decoder::new_with_limits(stream, Limits { bytes: FRAME_BYTES }).map_err(|_| {
            anyhow!("{name}: its header is not understood: expected that of YUV4MPEG2, as ffmpeg writes it")
        })?;
        let Header { size, frame_bytes } = header;
        Ok(Self { decoder, count, size, frame_bytes, name, number: 0 })
    }
}

impl<R: Read> Frames<R> {
    fn read(&mut self) -> Result<Option<GrayFrame>> {
        let before = self.count.load(Ordering::Relaxed);
        match self.decoder.read_frame() {
            Ok(frame) => {
                let (width, height) = self.size;
                Ok(Some(GrayFrame { width, height, pixels: frame.get_y_plane().to_vec() }))
            }
            Err(Error::EOF) => {
                let found = self.count.load(Ordering::Relaxed) - before;
                let expected = "FRAME\n".len() as u64 + self.frame_bytes;
                if found > 0 {
                    let why = format!("it is cut short: expected {expected} bytes with its header, found {found}");
                    return Err(Damaged::new(why).into());
                }
                Ok(None)
            }
            Err(Error::IoError(error)) => Err(error.into()),
            Err(_) => bail!("it does not begin as a frame of YUV4MPEG2 does: expected a line FRAME before its pixels"),
        }
    }
}

impl<R: Read> Iterator for Frames<R> {
    type Item = Result<GrayFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        self.number += 1;
        let read = self.read();
        read.with_context(|| format!("{}, frame {}", self.name, self.number)).transpose()
    }
}

/// What is checked before the decoder sees it: it multiplies whatever size it is told.
#[derive(Debug, PartialEq, Eq)]
struct Header {
    size: (u16, u16),
    /// Bytes of all planes of a frame.
    frame_bytes: u64,
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
            frame_bytes <= FRAME_BYTES as u64,
            "a frame of {width}x{height} has {frame_bytes} bytes: expected at most {FRAME_BYTES}"
        );
        Ok(Self { size, frame_bytes })
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

/// A reader that says how far it has got.
struct Counted<R> {
    inner: R,
    count: Arc<AtomicU64>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.inner.read(buffer)?;
        self.count.fetch_add(read as u64, Ordering::Relaxed);
        Ok(read)
    }
}
