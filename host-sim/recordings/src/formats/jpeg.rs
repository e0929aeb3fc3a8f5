//! Decodes JPEG images with zune-jpeg, up to the end marker; a video clip or a preview may follow the marker.

use crate::checked_frames::damaged;
use crate::formats::to_gray::{EXIF, EXPECTED, Samples, check_size, orientation, several, unread};
use anyhow::{Context, Result, anyhow, ensure};
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

pub(crate) const MAGIC: &[u8] = &[0xFF, 0xD8, 0xFF];

/// Segment that makes the decoder use the Huffman tables of ITU-T T.81, annex K.3, for an image without tables.
/// Webcams send no tables, because readers of their streams know them.
const STANDARD_TABLES: &[u8] = b"\xFF\xE0\0\x07AVI1\0";

pub(crate) fn decode(bytes: &[u8]) -> Result<Samples> {
    let layout = Layout::of(bytes);
    if let Some(kind) = layout.unread() {
        return Err(unread(kind));
    }
    let why = if layout.frame.is_some() { "its end is missing" } else { "it is damaged" };
    let end = layout.end.ok_or_else(|| damaged(format!("{EXPECTED}: {why}"), None))?;
    ensure!(layout.next(bytes).is_none(), several());
    let samples = pixels(&[&bytes[..2], STANDARD_TABLES, &bytes[2..end]].concat());
    let samples = samples.map_err(|error| damaged(format!("{EXPECTED}: {error}"), None))?;
    Ok(Samples { orientation: layout.orientation, ..samples })
}

/// Returns the byte offset of the second image in a file, as in a stream of JPEGs.
pub(crate) fn next(bytes: &[u8]) -> Option<usize> {
    Layout::of(bytes).next(bytes)
}

struct Layout {
    orientation: u8,
    frame: Option<Frame>,
    scanned: u8,
    /// True if the file also holds other views or sizes of the same image (MPF).
    has_views: bool,
    /// Byte offset behind the end marker; `None` if the marker is missing.
    end: Option<usize>,
}

#[derive(PartialEq)]
struct Frame {
    marker: u8,
    sizes: [u8; 6],
    /// True if a component (usually luma) has a vertical sampling factor above 1, so that others may have fewer rows.
    has_fewer_rows: bool,
}

impl Layout {
    fn of(bytes: &[u8]) -> Self {
        let mut layout = Self { orientation: 1, frame: None, scanned: 0, has_views: false, end: None };
        layout.end = layout.walk(bytes);
        layout
    }

    /// Scans from marker to marker. In pixel data, 0xFF is followed by 0 or by a restart code.
    fn walk(&mut self, bytes: &[u8]) -> Option<usize> {
        let mut at = 2;
        loop {
            at += bytes.get(at..)?.iter().position(|&byte| byte == 0xFF)?;
            at += bytes[at..].iter().position(|&byte| byte != 0xFF)?;
            let marker = bytes[at];
            at += 1;
            match marker {
                0 | 1 | 0xD0..=0xD7 => continue,
                // A start marker: another image begins although this one has not ended.
                0xD8 => return None,
                0xD9 => return Some(at),
                _ => {}
            }
            let length = u16::from_be_bytes(*bytes.get(at..)?.first_chunk()?);
            let end = at + usize::from(length);
            let segment = bytes.get(at + 2..end)?;
            match marker {
                // DHT, JPG and DAC have codes between those of frame headers.
                0xC4 | 0xC8 | 0xCC => {}
                0xC0..=0xCF | 0xF7 if self.frame.is_none() => {
                    let has_fewer_rows = segment.iter().skip(7).step_by(3).any(|sampling| sampling & 0xF > 1);
                    self.frame = segment.first_chunk().map(|&sizes| Frame { marker, sizes, has_fewer_rows });
                }
                0xDA if self.scanned == 0 => self.scanned = *segment.first()?,
                0xE1 if self.orientation == 1 => {
                    self.orientation = segment.strip_prefix(EXIF).map_or(1, orientation);
                }
                0xE2 => self.has_views |= segment.starts_with(b"MPF\0"),
                _ => {}
            }
            at = end;
        }
    }

    /// Returns the byte offset of a second image directly behind the first. An image with another frame header is
    /// taken for a preview and does not count, nor does any image in a file of several views (MPF).
    fn next(&self, bytes: &[u8]) -> Option<usize> {
        let rest = &bytes[self.end.filter(|_| !self.has_views)?..];
        let is_next = rest.starts_with(MAGIC) && Self::of(rest).frame == self.frame;
        is_next.then_some(bytes.len() - rest.len())
    }

    /// Returns the name of an unsupported kind of JPEG; `None` if the kind is supported.
    fn unread(&self) -> Option<&'static str> {
        let Frame { marker, sizes: [precision, height @ .., _, _, components], has_fewer_rows } =
            self.frame.as_ref()?;
        Some(match marker {
            0xC3 => "a lossless JPEG",
            0xC5..=0xC7 => "a hierarchical JPEG",
            0xC9..=0xCF => "an arithmetic-coded JPEG",
            0xF7 => "a JPEG-LS picture",
            _ if *precision != 8 => "a JPEG of more than 8 bits",
            _ if *height == [0, 0] => "a JPEG whose height follows its pixels",
            // The decoder silently misplaces colors if components of different row counts come in separate scans.
            0xC0 | 0xC1 if *has_fewer_rows && self.scanned < *components => "a JPEG with separate scans for its colors",
            _ => return None,
        })
    }
}

/// Decodes in strict mode, because the decoder otherwise fills in missing data silently.
fn pixels(bytes: &[u8]) -> Result<Samples> {
    let side = usize::from(u16::MAX);
    let options = DecoderOptions::default().set_strict_mode(true).set_max_width(side).set_max_height(side);
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let broken = |_| anyhow!("it is damaged");
    decoder.decode_headers().map_err(broken)?;
    let too_long = |_| anyhow!("expected at most 65535 pixels on each side");
    let (width, height) = decoder.dimensions().context("its size is missing")?;
    let (width, height) = (u32::try_from(width).map_err(too_long)?, u32::try_from(height).map_err(too_long)?);
    check_size(width, height)?;
    let (colors, channels) = match decoder.input_colorspace() {
        Some(ColorSpace::Luma) => (ColorSpace::Luma, 1),
        _ => (ColorSpace::RGB, 3),
    };
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(colors));
    let samples = decoder.decode().map_err(broken)?;
    let (found, expected) = (samples.len() / channels, width as usize * height as usize);
    ensure!(found == expected, "{found} pixels were decoded: expected {expected}");
    Samples::new(width, height, channels, samples)
}
