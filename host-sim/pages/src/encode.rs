//! Encodes frames as PNG, JPEG and PGM, and bytes and numbers for HTML pages.

use crate::colors::Color;
use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use jpeg_encoder::{ColorType, Encoder};
use serde_json::Value;
use smr_recordings::{ColorFrame, GrayFrame, Raster, Scalable, resized};
use std::ops::Range;

/// Encodes an indexed PNG in which `color` maps each gray level to a color. The file is small and deterministic.
pub(crate) fn palette_png(levels: &GrayFrame, color: impl Fn(u8) -> Color) -> Result<Vec<u8>> {
    let pixels: Vec<Color> = levels.pixels.iter().map(|&level| color(level)).collect();
    let mut palette = pixels.clone();
    palette.sort_unstable();
    palette.dedup();
    let index = |pixel: &Color| palette.partition_point(|color| color < pixel).to_le_bytes()[0];
    let indices: Vec<u8> = pixels.iter().map(index).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, levels.width.into(), levels.height.into());
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette.concat());
    encoder.set_compression(png::Compression::High);
    // In a sorted palette of grays, similar levels have close indices, so PNG's prediction filters help.
    let grays = palette.iter().filter(|[red, green, blue]| red == green && green == blue).count();
    encoder.set_filter(if 2 * grays > palette.len() { png::Filter::Adaptive } else { png::Filter::NoFilter });
    encoder.write_header()?.write_image_data(&indices)?;
    Ok(bytes)
}

pub fn png(frame: &GrayFrame) -> Result<Vec<u8>> {
    plain_png((frame.width.into(), frame.height.into()), png::ColorType::Grayscale, &frame.pixels)
}

pub(crate) fn rgb_png(size: (u32, u32), rgb: &[u8]) -> Result<Vec<u8>> {
    plain_png(size, png::ColorType::Rgb, rgb)
}

/// Largest width and height, in pixels, of a part that is cropped from a frame.
const MAX_SIDE: i32 = 640;

/// Encodes a rectangle (left, top, width, height) of the frame as PNG. It is clipped to the frame and to `MAX_SIDE`;
/// `None` if no pixel is left.
pub(crate) fn part_png(frame: &ColorFrame, [x, y, width, height]: [i32; 4]) -> Result<Option<Vec<u8>>> {
    let span = |from: i32, length: i32, end: u16| -> Result<Range<usize>> {
        let first = from.clamp(0, end.into());
        let last = from.saturating_add(length).clamp(first, i32::from(end).min(first + MAX_SIDE));
        Ok(first.try_into()?..last.try_into()?)
    };
    let (columns, rows) = (span(x, width, frame.width)?, span(y, height, frame.height)?);
    let size = (columns.len().try_into()?, rows.len().try_into()?);
    let rows = frame.pixels.chunks(frame.width.into()).take(rows.end).skip(rows.start);
    let rgb: Vec<u8> = rows.flat_map(|row| row[columns.clone()].as_flattened()).copied().collect();
    (!rgb.is_empty()).then(|| rgb_png(size, &rgb)).transpose()
}

fn plain_png((width, height): (u32, u32), color: png::ColorType, samples: &[u8]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.write_header()?.write_image_data(samples)?;
    Ok(bytes)
}

/// Encodes the frame as binary PGM (P5), which every PGM reader supports.
pub fn pgm(GrayFrame { width, height, pixels }: &GrayFrame) -> Vec<u8> {
    [format!("P5\n{width} {height}\n255\n").as_bytes(), pixels].concat()
}

/// JPEG quality in percent: `GOOD` for a single picture, `ENOUGH` for a page with many, which must stay small.
pub(crate) const GOOD: u8 = 88;
pub(crate) const ENOUGH: u8 = 75;

pub(crate) fn color_jpeg(frame: &ColorFrame, quality: u8) -> Result<Vec<u8>> {
    let ColorFrame { width, height, ref pixels } = *frame;
    // A grayscale JPEG takes fewer bytes.
    if pixels.iter().all(|&[red, green, blue]| red == green && green == blue) {
        let pixels = pixels.iter().map(|&[gray, ..]| gray).collect();
        return jpeg(&GrayFrame { width, height, pixels }, quality);
    }
    let mut bytes = Vec::new();
    Encoder::new(&mut bytes, quality).encode(pixels.as_flattened(), width, height, ColorType::Rgb)?;
    Ok(bytes)
}

pub(crate) fn jpeg(frame: &GrayFrame, quality: u8) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    Encoder::new(&mut bytes, quality).encode(&frame.pixels, frame.width, frame.height, ColorType::Luma)?;
    Ok(bytes)
}

/// Scales the frame down so that no side is longer than `side` pixels; a smaller frame is unchanged.
pub(crate) fn within<P: Scalable>(frame: &Raster<P>, side: u16) -> Raster<P> {
    let longest = u32::from(frame.width.max(frame.height)).max(1);
    let fit = |length: u16| {
        let fitted = u32::from(length) * u32::from(side) / longest;
        if longest <= side.into() { length } else { u16::try_from(fitted).unwrap_or(side).max(1) }
    };
    resized(frame.clone(), fit(frame.width), fit(frame.height))
}

/// Returns a `data:` URI that contains the bytes, so that a page needs no other file.
pub(crate) fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", base64(bytes))
}

pub(crate) fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Rounds a number of a page to `digits` decimals. An integral value is written without a fraction, which is shorter.
pub(crate) fn rounded(value: f64, digits: i32) -> Value {
    let unit = 10_f64.powi(digits);
    let value = (value * unit).round() / unit;
    #[allow(clippy::cast_possible_truncation)] // compared with what it came from
    let whole = value as i64;
    if whole as f64 == value { whole.into() } else { value.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::{decode_colors, decode_image};

    #[test]
    fn an_image_reads_back() {
        let color = |level: u8| [[0, 0, 0], [255, 0, 0], [0, 0, 255]][usize::from(level)];
        let levels = [0, 1, 2, 2, 1, 0];
        let frame = GrayFrame { width: 3, height: 2, pixels: levels.to_vec() };
        let read = decode_colors(&palette_png(&frame, color).unwrap()).unwrap();
        assert_eq!((read.width, read.height, read.pixels), (3, 2, levels.map(color).to_vec()));

        let frame = GrayFrame { width: 3, height: 2, pixels: vec![0, 10, 255, 13, 35, 128] };
        assert_eq!(decode_image(&png(&frame).unwrap()).unwrap(), frame);
        assert_eq!(decode_image(&pgm(&frame)).unwrap(), frame);
        assert!(pgm(&frame).starts_with(b"P5\n3 2\n255\n\0"));

        let frame = ColorFrame { width: 4, height: 2, pixels: (0..8).map(|at| [at, 2 * at, 3 * at]).collect() };
        let part = |part| part_png(&frame, part).unwrap().map(|bytes| decode_colors(&bytes).unwrap());
        let read = part([-1, 1, 3, 9]).unwrap();
        assert_eq!((read.width, read.height, read.pixels), (2, 1, vec![[4, 8, 12], [5, 10, 15]]));
        assert!(part([4, 0, 9, 9]).is_none() && part([0, 0, i32::MIN, 1]).is_none());
        let wide = ColorFrame { width: 1000, height: 1, pixels: vec![[1, 2, 3]; 1000] };
        let read = part_png(&wide, [7, 0, i32::MAX, 1]).unwrap().unwrap();
        assert_eq!(decode_colors(&read).unwrap().width, 640);

        let frame = GrayFrame { width: 8, height: 8, pixels: vec![100; 64] };
        let read = decode_image(&jpeg(&frame, GOOD).unwrap()).unwrap();
        assert!(read.pixels.iter().all(|pixel| pixel.abs_diff(100) <= 2));
    }
}
