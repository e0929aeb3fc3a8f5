//! Recordings of images (PNG, JPEG, PGM, PPM, PAM): one image in each file of a folder, or several in one file.
//!
//! A 16-bit value becomes its high byte, unless [`Levels`] map it. Alpha is ignored. Colour becomes gray by BT.601 in
//! integers: `(19595 R + 38470 G + 7471 B + 32768) >> 16`. Exif orientation turns images upright.

use super::{jpeg, pnm};
use crate::checked_frames::damaged;
use crate::formats::names::has_extension;
use crate::formats::to_gray::{CONVERT, EXPECTED, Levels, Samples, check_size, orientation, several, unread};
use crate::frame::Frame;
use crate::raster::{ColorFrame, GrayFrame, MAX_PIXELS};
use anyhow::{Context, Error, Result, anyhow, ensure};
use png::{DecodingError, Transformations};
use smr_files::input::{self, Kind};
use std::fs::File;
use std::io::{Cursor, ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// 512 MiB are enough for 16384x16384 pixels, except uncompressed pixels of two bytes or more.
const KIND: Kind = Kind { expected: "a PNG, JPEG, PGM, PPM or PAM picture", most: 512 };

const EXTENSIONS: [&str; 9] = ["png", "jpg", "jpeg", "jpe", "jfif", "pgm", "ppm", "pnm", "pam"];

/// Extensions of unsupported image formats. A single GIF is read as a video.
const FOREIGN: [&str; 28] = [
    "bmp", "dib", "tif", "tiff", "webp", "gif", "heic", "heif", "avif", "jp2", "j2k", "jxl", "jls", "mpo", "pbm",
    "pfm", "tga", "exr", "hdr", "psd", "dng", "cr2", "cr3", "nef", "arw", "orf", "rw2", "raf",
];

pub(crate) fn is_image(file: &Path) -> bool {
    has_extension(file, &EXTENSIONS)
}

pub(crate) fn is_foreign(file: &Path) -> bool {
    has_extension(file, &FOREIGN)
}

/// Returns the format of an image by its extension. The images of a recording have one format.
pub(crate) fn kind(file: &Path) -> Option<String> {
    let extension = file.extension()?.to_string_lossy().to_ascii_lowercase();
    let is_jpeg = has_extension(file, &["jpg", "jpeg", "jpe", "jfif"]);
    let is_known = is_jpeg || is_image(file) || is_foreign(file);
    is_known.then(|| if is_jpeg { "jpg".to_owned() } else { extension })
}

/// Returns an error if the extension is that of an unsupported image format.
pub(crate) fn check_kind(file: &Path) -> Result<()> {
    ensure!(!is_foreign(file), "{}: this kind of picture is not supported: {CONVERT}", file.display());
    Ok(())
}

/// An image file, or a range of bytes in a file of several images.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageFile {
    file: PathBuf,
    part: Option<Range<u64>>,
    pub(crate) levels: Option<Levels>,
}

impl From<PathBuf> for ImageFile {
    fn from(file: PathBuf) -> Self {
        Self { file, part: None, levels: None }
    }
}

impl ImageFile {
    /// Returns all images in a file. An unreadable file counts as one image; reading its pixels reports the error.
    pub(crate) fn all_in(file: &Path) -> Vec<Self> {
        let whole = Self::from(file.to_owned());
        let Some(bytes) = whole.is_file().then(|| whole.bytes().ok()).flatten() else { return vec![whole] };
        let (mut all, mut start) = (Vec::new(), 0);
        while let Some(length) = next(&bytes[start..]) {
            all.push(start as u64..(start + length) as u64);
            start += length;
        }
        if all.is_empty() {
            return vec![whole];
        }
        all.push(start as u64..bytes.len() as u64);
        all.into_iter().map(|part| Self { part: Some(part), ..whole.clone() }).collect()
    }

    /// False for a pipe, which can be read only once.
    pub(crate) fn is_file(&self) -> bool {
        self.file.is_file()
    }

    /// Returns the name of the file; `None` if the file has several images.
    pub fn name(&self) -> Option<String> {
        let name = self.file.file_name().filter(|_| self.part.is_none())?;
        Some(name.to_string_lossy().into_owned())
    }

    fn bytes(&self) -> Result<Vec<u8>> {
        let Some(part) = &self.part else { return input::bytes(&self.file, &KIND) };
        let mut file = File::open(&self.file)?;
        file.seek(SeekFrom::Start(part.start))?;
        let mut bytes = Vec::new();
        file.take(part.end - part.start).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    pub(crate) fn samples(&self) -> Result<Samples> {
        samples(&self.bytes()?)
    }

    pub(crate) fn colors(&self) -> Result<ColorFrame> {
        self.samples()?.colors(self.levels)
    }
}

/// Returns the frames from number `first` on; `images` are all images of the recording.
pub(crate) fn frames(images: &[ImageFile], first: usize) -> impl Iterator<Item = Result<Frame>> + Send + use<> {
    let rest = images.get(first - 1..).unwrap_or_default().to_owned();
    (first..).zip(rest).map(|(number, image)| {
        let gray = image.samples().and_then(|samples| samples.gray(image.levels));
        let gray = gray.with_context(|| format!("cannot read {} (frame {number})", image.file.display()));
        Ok(Frame::new(number, None, gray?))
    })
}

pub fn decode_image(bytes: &[u8]) -> Result<GrayFrame> {
    samples(bytes)?.gray(None)
}

pub fn decode_colors(bytes: &[u8]) -> Result<ColorFrame> {
    samples(bytes)?.colors(None)
}

/// Range of 8-bit gray levels (highest minus lowest) below which the user gets a note. 14-bit values stored unscaled in
/// 16 bits reach only level 63.
const MIN_LEVELS: usize = 64;

/// Count of pixels of which one may be dead; so 1 / `PIXELS_PER_DEAD` of the values is ignored at each histogram end.
const PIXELS_PER_DEAD: u64 = 10_000;

/// Returns a note if 16-bit images use few levels, judged by the first, middle and last of `images`.
pub(crate) fn levels_note(images: &[ImageFile]) -> Option<String> {
    let mut counts = vec![0_u64; 1 << 16];
    let mut all = 0;
    for at in [0, images.len() / 2, images.len().saturating_sub(1)] {
        let samples = images.get(at).filter(|image| image.is_file())?.samples().ok()?;
        for value in samples.values()? {
            counts[usize::from(value)] += 1;
            all += 1;
        }
    }
    let mut below = 0;
    let mut used = (0..=u16::MAX).zip(counts).filter_map(|(value, count)| {
        below += count;
        (below > all / PIXELS_PER_DEAD && below - count < all - all / PIXELS_PER_DEAD).then_some(value)
    });
    let first = used.next()?;
    let last = used.last().unwrap_or(first);
    let levels = images.first()?.levels;
    let [low, high] = [first, last].map(|value| levels.map_or(value.to_be_bytes()[0], |levels| levels.of(value)));
    if usize::from(high - low) >= MIN_LEVELS {
        return None;
    }
    let margin = ((last - first) / 4).max(8);
    let wanted = Levels { black: first.saturating_sub(margin), white: last.saturating_add(margin) };
    Some(format!(
        "its 16-bit values are only {first} to {last}, so trackers see the gray levels {low} to {high}: --levels {wanted} gives more contrast"
    ))
}

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

fn samples(bytes: &[u8]) -> Result<Samples> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png(bytes),
        [0xFF, 0xD8, ..] => jpeg::decode(bytes),
        [] => Err(damaged(format!("it is empty: {EXPECTED}"), None)),
        [b'P', b'1' | b'4', space, ..] if space.is_ascii_whitespace() => Err(unread("a bitmap of one bit (PBM)")),
        [b'P', b'2' | b'3' | b'5' | b'6' | b'7', ..] => pnm::decode(bytes),
        _ => match foreign(bytes) {
            Some(kind) => Err(unread(kind)),
            None => Err(damaged(format!("{EXPECTED}: it begins like none of these formats"), None)),
        },
    }
}

/// Returns the byte offset of the second image in a file; `None` without one, or if the first is damaged.
fn next(bytes: &[u8]) -> Option<usize> {
    match bytes {
        [0x89, ..] => Chunks::of(bytes).next(bytes),
        [0xFF, ..] => jpeg::next(bytes),
        [b'P', ..] => pnm::next(bytes),
        _ => None,
    }
}

/// Returns the name of an unsupported image format, recognised by its first bytes.
fn foreign(bytes: &[u8]) -> Option<&'static str> {
    let is =
        |at: usize, magic: &[&[u8]]| bytes.get(at..).is_some_and(|rest| magic.iter().any(|one| rest.starts_with(one)));
    FOREIGN_MAGIC.iter().find(|(at, magic, _)| is(*at, magic)).map(|(_, _, kind)| *kind)
}

/// Unsupported image formats: byte offset of the magic bytes in the file, alternative magic bytes, and format name.
const FOREIGN_MAGIC: [(usize, &[&[u8]], &str); 10] = [
    (0, &[b"BM"], "a BMP picture"),
    (0, &[b"II*\0", b"MM\0*"], "a TIFF picture"),
    (0, &[b"GIF8"], "a GIF picture"),
    (8, &[b"WEBP"], "a WebP picture"),
    (4, &[b"ftypheic", b"ftypheix", b"ftyphevc", b"ftypmif1", b"ftypmsf1"], "a HEIC picture"),
    (4, &[b"ftypavif", b"ftypavis"], "an AVIF picture"),
    (0, &[b"\0\0\0\x0CJXL ", b"\xFF\x0A"], "a JPEG XL picture"),
    (0, &[b"\0\0\0\x0CjP  ", b"\xFF\x4F\xFF\x51"], "a JPEG 2000 picture"),
    (0, &[b"\x76\x2F\x31\x01"], "an OpenEXR picture"),
    (0, &[b"Pf", b"PF"], "a picture of floating-point numbers (PFM)"),
];

struct Chunks {
    orientation: u8,
    /// Number of images in an animated PNG; 1 if it is not animated.
    count: u32,
    is_of_apple: bool,
    /// Byte offset behind the last chunk, IEND; `None` if it is missing.
    end: Option<usize>,
}

impl Chunks {
    fn of(bytes: &[u8]) -> Self {
        let mut chunks = Self { orientation: 1, count: 1, is_of_apple: false, end: None };
        chunks.end = chunks.walk(bytes);
        chunks
    }

    fn walk(&mut self, bytes: &[u8]) -> Option<usize> {
        let mut at = PNG.len();
        loop {
            let (length, rest) = bytes.get(at..)?.split_first_chunk()?;
            let length = u32::from_be_bytes(*length) as usize;
            let (kind, rest) = rest.split_first_chunk::<4>()?;
            let data = rest.get(..length)?;
            at += length + 12;
            match kind {
                b"eXIf" => self.orientation = orientation(data),
                b"acTL" => self.count = data.first_chunk().map_or(1, |&count| u32::from_be_bytes(count)),
                b"CgBI" => self.is_of_apple = true,
                b"IEND" => return Some(at.min(bytes.len())),
                _ => {}
            }
        }
    }

    fn next(&self, bytes: &[u8]) -> Option<usize> {
        self.end.filter(|&end| bytes[end..].starts_with(PNG))
    }
}

fn png(bytes: &[u8]) -> Result<Samples> {
    let chunks = Chunks::of(bytes);
    let count = chunks.count;
    let mend = "make a film of it with ffmpeg -f apng -i";
    ensure!(count <= 1, "it is an animated PNG of {count} pictures: expected one; {mend}");
    ensure!(!chunks.is_of_apple, unread("a PNG in Apple's own form"));
    ensure!(chunks.next(bytes).is_none(), several());
    // Limits the memory of chunks without pixels. `check_size` limits the number of pixels.
    let limits = png::Limits { bytes: 1 << 28 };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    // `EXPAND` decodes to gray or RGB, with or without alpha, of 8 or 16 bits.
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(undecodable)?;
    let (width, height) = reader.info().size();
    check_size(width, height)?;
    let mut samples = vec![0; reader.output_buffer_size().context("it is too large")?];
    let decoded = reader.next_frame(&mut samples).map_err(undecodable)?;
    samples.truncate(decoded.buffer_size());
    let samples = Samples::new(width, height, decoded.color_type.samples(), samples)?;
    Ok(Samples { is_wide: decoded.bit_depth == png::BitDepth::Sixteen, orientation: chunks.orientation, ..samples })
}

fn undecodable(error: DecodingError) -> Error {
    match error {
        DecodingError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
            damaged(format!("{EXPECTED}: it is cut short"), None)
        }
        DecodingError::LimitsExceeded => anyhow!("it is too large: expected at most {MAX_PIXELS} pixels"),
        _ => damaged(format!("{EXPECTED}: it is damaged"), None),
    }
}

#[cfg(test)]
mod tests;
