//! A folder of pictures as a recording: PNG, JPEG, PGM and PPM in natural order (`img2` before `img10`).
//!
//! Gray pictures pass unchanged. Of 16-bit pictures the high byte is taken, alpha is ignored, and colour becomes gray
//! by BT.601 in integers, the same on every machine: `(19595 R + 38470 G + 7471 B + 32768) >> 16`.

use super::samples::{EXPECTED, Samples, check_size, damaged};
use super::{ColorFrame, GrayFrame, MOST_PIXELS, has_extension, pnm};
use crate::input;
use anyhow::{Context, Error, Result, anyhow, ensure};
use png::{DecodingError, Transformations};
use std::io::{Cursor, ErrorKind};
use std::path::{Path, PathBuf};
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

const EXTENSIONS: [&str; 6] = ["png", "jpg", "jpeg", "pgm", "ppm", "pnm"];

pub(super) fn is_picture(file: &Path) -> bool {
    has_extension(file, &EXTENSIONS)
}

/// The pictures among `files`, in natural order.
pub(super) fn pictures(files: &[PathBuf]) -> Vec<PathBuf> {
    let mut pictures: Vec<_> = files.iter().filter(|file| is_picture(file)).cloned().collect();
    // Names that differ only in white space are equal by nature; the order must not depend on the file system.
    pictures.sort_by(|a, b| natord::compare(&a.to_string_lossy(), &b.to_string_lossy()).then_with(|| a.cmp(b)));
    pictures
}

/// The pictures as frames, the first of them with the number `first`.
pub(super) fn frames(files: Vec<PathBuf>, first: usize) -> impl Iterator<Item = Result<GrayFrame>> + Send + 'static {
    (first..)
        .zip(files)
        .map(|(number, file)| read(&file).with_context(|| format!("cannot read {} (frame {number})", file.display())))
}

/// One picture.
pub fn read_picture(file: &Path) -> Result<GrayFrame> {
    read(file).with_context(|| format!("cannot read {}", file.display()))
}

/// One picture as the bytes of its file.
pub fn decode_picture(bytes: &[u8]) -> Result<GrayFrame> {
    samples(bytes).map(Samples::gray)
}

/// The same in its own colors.
pub fn decode_colors(bytes: &[u8]) -> Result<ColorFrame> {
    samples(bytes).map(Samples::colors)
}

fn read(file: &Path) -> Result<GrayFrame> {
    decode_picture(&input::bytes(file, &input::PICTURE)?)
}

/// One picture in its own colors.
pub(super) fn read_colors(file: &Path) -> Result<ColorFrame> {
    decode_colors(&input::bytes(file, &input::PICTURE)?)
}

fn samples(bytes: &[u8]) -> Result<Samples> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png(bytes),
        [0xFF, 0xD8, ..] => jpeg(bytes),
        [b'P', b'2' | b'3' | b'5' | b'6' | b'7', ..] => pnm::decode(bytes),
        _ => Err(damaged(format!("{EXPECTED}: it begins like none of them"))),
    }
}

fn png(bytes: &[u8]) -> Result<Samples> {
    // For what the file holds besides pixels. The number of pixels is checked below.
    let limits = png::Limits { bytes: 1 << 28 };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    // To gray or RGB, with or without alpha, of 8 bits each.
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(undecodable)?;
    let (width, height) = reader.info().size();
    check_size(width, height)?;
    let mut samples = vec![0; reader.output_buffer_size().context("it is too large")?];
    let decoded = reader.next_frame(&mut samples).map_err(undecodable)?;
    samples.truncate(decoded.buffer_size());
    Samples::new(width, height, decoded.color_type.samples(), samples)
}

/// The decoder fills in missing data without a word unless it is told to be strict.
fn jpeg(bytes: &[u8]) -> Result<Samples> {
    let samples = whole_jpeg(bytes).map_err(|error| damaged(format!("{EXPECTED}: {error}")))?;
    ensure!(has_end(bytes), damaged(format!("{EXPECTED}: its end is missing")));
    Ok(samples)
}

fn whole_jpeg(bytes: &[u8]) -> Result<Samples> {
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

/// True if the marker of the end follows the last beginning of pixels, in which it cannot occur.
fn has_end(bytes: &[u8]) -> bool {
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|bytes| bytes == marker);
    last([0xFF, 0xD9]) > last([0xFF, 0xDA])
}

/// What a decoder says is for who wrote it.
fn undecodable(error: DecodingError) -> Error {
    match error {
        DecodingError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
            damaged(format!("{EXPECTED}: it is cut short"))
        }
        DecodingError::LimitsExceeded => anyhow!("it is too large: expected at most {MOST_PIXELS} pixels"),
        _ => damaged(format!("{EXPECTED}: it is damaged")),
    }
}
