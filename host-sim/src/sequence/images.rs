//! A folder of pictures as a recording: PNG, JPEG, PGM and PPM in natural order (`img2` before `img10`).
//!
//! Gray pictures pass unchanged. Of 16-bit pictures the high byte is taken, alpha is ignored, and colour becomes gray
//! by BT.601 in integers, the same on every machine: `(19595 R + 38470 G + 7471 B + 32768) >> 16`.

use super::{GrayFrame, has_extension};
use anyhow::{Context, Result, anyhow, bail, ensure};
use image::codecs::pnm::PnmDecoder;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

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

fn read(file: &Path) -> Result<GrayFrame> {
    let reader = ImageReader::open(file)?.with_guessed_format()?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg) => {}
        Some(ImageFormat::Pnm) => check_largest_value(file)?,
        _ => bail!(EXPECTED),
    }
    gray(reader.decode().map_err(undecodable)?)
}

/// Where a PGM says that its white is neither 255 nor 65535, its values would have to be scaled; unscaled they would
/// give an almost black picture without a word.
fn check_largest_value(file: &Path) -> Result<()> {
    let largest = PnmDecoder::new(BufReader::new(File::open(file)?)).map_err(undecodable)?.header().maximal_sample();
    ensure!(matches!(largest, 255 | 65535), "its largest value is {largest}: expected 255 or 65535");
    Ok(())
}

/// The errors of `image` already contain their causes: as a chain they would be printed twice.
fn undecodable(error: ImageError) -> anyhow::Error {
    anyhow!("{EXPECTED}: {error}")
}

fn gray(picture: DynamicImage) -> Result<GrayFrame> {
    let (width, height) = (picture.width(), picture.height());
    let (Ok(width), Ok(height)) = (u16::try_from(width), u16::try_from(height)) else {
        bail!("it is {width}x{height}: expected at most 65535 pixels on each side");
    };
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
fn luma([r, g, b]: [u8; 3]) -> u8 {
    let sum = 19595 * u32::from(r) + 38470 * u32::from(g) + 7471 * u32::from(b) + 32768;
    sum.to_be_bytes()[1]
}
