//! A folder of pictures as a recording: PNG, JPEG, PGM and PPM in natural order (`img2` before `img10`).
//!
//! Gray pictures pass unchanged. Of 16-bit pictures the high byte is taken, alpha is ignored, and colour becomes gray
//! by BT.601 in integers, the same on every machine: `(19595 R + 38470 G + 7471 B + 32768) >> 16`.

use super::damage::{Damaged, Instead};
use super::{GrayFrame, has_extension};
use crate::input;
use anyhow::{Context, Result, anyhow, bail, ensure};
use image::codecs::pnm::PnmDecoder;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader};
use std::io::{Cursor, ErrorKind};
use std::path::{Path, PathBuf};
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

const EXTENSIONS: [&str; 6] = ["png", "jpg", "jpeg", "pgm", "ppm", "pnm"];

const EXPECTED: &str = "expected a PNG, JPEG, PGM or PPM picture";

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

pub(super) fn frames(files: Vec<PathBuf>) -> impl Iterator<Item = Result<GrayFrame>> + Send + 'static {
    files.into_iter().enumerate().map(|(index, file)| {
        read(&file).with_context(|| format!("cannot read {} (frame {})", file.display(), index + 1))
    })
}

/// The largest picture that memory is taken for, in pixels: 16384x16384.
const MOST_PIXELS: u64 = 1 << 28;

/// One picture.
pub fn read_picture(file: &Path) -> Result<GrayFrame> {
    read(file).with_context(|| format!("cannot read {}", file.display()))
}

/// One picture as the bytes of its file.
pub fn decode_picture(bytes: &[u8]) -> Result<GrayFrame> {
    decode(Path::new(""), bytes)
}

fn read(file: &Path) -> Result<GrayFrame> {
    decode(file, &input::bytes(file, &input::PICTURE)?)
}

pub(super) fn decode(file: &Path, bytes: &[u8]) -> Result<GrayFrame> {
    let mut reader = ImageReader::new(Cursor::new(bytes));
    if let Ok(format) = ImageFormat::from_path(file) {
        reader.set_format(format);
    }
    let reader = reader.with_guessed_format()?;
    match reader.format() {
        Some(ImageFormat::Png) => {}
        Some(ImageFormat::Jpeg) => return jpeg(bytes),
        Some(ImageFormat::Pnm) => check_header(bytes)?,
        _ => return Err(damaged(EXPECTED.to_owned())),
    }
    gray(reader.decode().map_err(undecodable)?)
}

/// What the header of a PNM says is checked before memory is taken for it. Where a PGM says that its white is neither 255
/// nor 65535, its values would have to be scaled; unscaled they would give an almost black picture without a word.
fn check_header(bytes: &[u8]) -> Result<()> {
    let decoder = PnmDecoder::new(bytes).map_err(undecodable)?;
    let largest = decoder.header().maximal_sample();
    ensure!(matches!(largest, 255 | 65535), "its largest value is {largest}: expected 255 or 65535");
    check_size(decoder.header().width(), decoder.header().height())
}

fn check_size(width: u32, height: u32) -> Result<()> {
    let pixels = u64::from(width) * u64::from(height);
    ensure!(pixels > 0, "it is {width}x{height}: expected at least 1 pixel on each side");
    ensure!(pixels <= MOST_PIXELS, "it is {width}x{height}: expected at most {MOST_PIXELS} pixels");
    Ok(())
}

/// The decoder that `image` has, too, which in its usual state conceals whatever is missing.
fn jpeg(bytes: &[u8]) -> Result<GrayFrame> {
    let broken = match jpeg_as(bytes, true) {
        Ok(frame) if has_end(bytes) => return Ok(frame),
        Ok(_) => "its end is missing".to_owned(),
        Err(error) => error.to_string(),
    };
    let why = format!("{EXPECTED}: {broken}");
    match jpeg_as(bytes, false) {
        Ok(frame) => Err(Damaged { why, instead: Instead::Decoded(frame) }.into()),
        Err(_) => Err(damaged(why)),
    }
}

/// `strict`: what is damaged is an error; else it is gray or some other guess.
fn jpeg_as(bytes: &[u8], strict: bool) -> Result<GrayFrame> {
    let side = usize::from(u16::MAX);
    let options = DecoderOptions::default().set_strict_mode(strict).set_max_width(side).set_max_height(side);
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let broken = |_| anyhow!("it is damaged");
    decoder.decode_headers().map_err(broken)?;
    let too_long = |_| anyhow!("expected at most 65535 pixels on each side");
    let (width, height) = decoder.dimensions().context("its size is missing")?;
    let (width, height) = (u16::try_from(width).map_err(too_long)?, u16::try_from(height).map_err(too_long)?);
    check_size(width.into(), height.into())?;
    let colors = match decoder.input_colorspace() {
        Some(ColorSpace::Luma) => ColorSpace::Luma,
        _ => ColorSpace::RGB,
    };
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(colors));
    let decoded = decoder.decode().map_err(broken)?;
    let pixels = match colors {
        ColorSpace::Luma => decoded,
        _ => decoded.as_chunks().0.iter().map(|&rgb| luma(rgb)).collect(),
    };
    let expected = usize::from(width) * usize::from(height);
    ensure!(pixels.len() == expected, "{} pixels were decoded: expected {expected}", pixels.len());
    Ok(GrayFrame { width, height, pixels })
}

/// True if the marker of the end follows the last beginning of pixels, in which it cannot occur.
fn has_end(bytes: &[u8]) -> bool {
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|bytes| bytes == marker);
    last([0xFF, 0xD9]) > last([0xFF, 0xDA])
}

/// What a decoder says is for who wrote it.
fn undecodable(error: ImageError) -> anyhow::Error {
    match error {
        ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
            damaged(format!("{EXPECTED}: it is cut short"))
        }
        ImageError::Decoding(_) | ImageError::IoError(_) => damaged(format!("{EXPECTED}: it is damaged")),
        ImageError::Limits(_) => anyhow!("it is too large: expected at most {MOST_PIXELS} pixels"),
        _ => anyhow!("{EXPECTED}, of a form that cameras and programs write"),
    }
}

/// Of a picture of which nothing can be decoded.
fn damaged(why: String) -> anyhow::Error {
    Damaged { why, instead: Instead::Former }.into()
}

fn gray(picture: DynamicImage) -> Result<GrayFrame> {
    let (width, height) = (picture.width(), picture.height());
    let (Ok(width), Ok(height)) = (u16::try_from(width), u16::try_from(height)) else {
        bail!("it is {width}x{height}: expected at most 65535 pixels on each side");
    };
    // A header may say 0 on one side alone, which decoders take.
    check_size(width.into(), height.into())?;
    let pixels = match picture {
        DynamicImage::ImageLuma8(picture) => picture.into_raw(),
        DynamicImage::ImageLumaA8(picture) => picture.pixels().map(|pixel| pixel.0[0]).collect(),
        DynamicImage::ImageRgb8(picture) => picture.pixels().map(|pixel| luma(pixel.0)).collect(),
        DynamicImage::ImageRgba8(picture) => picture.pixels().map(|pixel| luma(rgb(pixel.0))).collect(),
        DynamicImage::ImageLuma16(picture) => picture.pixels().map(|pixel| high(pixel.0[0])).collect(),
        DynamicImage::ImageLumaA16(picture) => picture.pixels().map(|pixel| high(pixel.0[0])).collect(),
        DynamicImage::ImageRgb16(picture) => picture.pixels().map(|pixel| luma(pixel.0.map(high))).collect(),
        DynamicImage::ImageRgba16(picture) => picture.pixels().map(|pixel| luma(rgb(pixel.0).map(high))).collect(),
        other => bail!("its pixels are {:?}: expected 8 or 16 bits each", other.color()),
    };
    Ok(GrayFrame { width, height, pixels })
}

fn rgb<T: Copy>([r, g, b, _alpha]: [T; 4]) -> [T; 3] {
    [r, g, b]
}

fn high(value: u16) -> u8 {
    value.to_be_bytes()[0]
}

/// The weights add up to 65536, so the third byte from the right is the quotient and never overflows.
pub(crate) fn luma([r, g, b]: [u8; 3]) -> u8 {
    let sum = 19595 * u32::from(r) + 38470 * u32::from(g) + 7471 * u32::from(b) + 32768;
    sum.to_be_bytes()[1]
}
