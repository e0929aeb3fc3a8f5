//! Pictures as bytes, and bytes as a part of a page.

use super::Color;
use crate::sequence::GrayFrame;
use anyhow::{Context, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{FilterType, resize};
use image::{ExtendedColorType, GrayImage};

/// A PNG of pixels that are indices into `palette`. Small, and the same bytes every time.
pub(super) fn png((width, height): (u32, u32), indices: &[u8], palette: &[Color]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette.concat());
    encoder.set_compression(png::Compression::High);
    // Neighbours in the palettes are neighbours to the eye, so what predicts gray levels predicts indices.
    encoder.set_filter(png::Filter::Adaptive);
    encoder.write_header()?.write_image_data(indices)?;
    Ok(bytes)
}

/// The frame as a JPEG: a page with many frames must stay small, and they are only looked at.
pub(super) fn jpeg(frame: &GrayFrame) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 88);
    encoder.encode(&frame.pixels, frame.width.into(), frame.height.into(), ExtendedColorType::L8)?;
    Ok(bytes)
}

/// The frame as a JPEG with no side longer than `side`.
pub(super) fn jpeg_within(frame: &GrayFrame, side: u32) -> Result<Vec<u8>> {
    let size = (frame.width.into(), frame.height.into());
    let (width, height) = within(size, side);
    let whole = GrayImage::from_raw(size.0, size.1, frame.pixels.clone()).context("a frame has all its pixels")?;
    if size == (width, height) {
        jpeg_of(&whole)
    } else {
        jpeg_of(&resize(&whole, width, height, FilterType::Triangle))
    }
}

/// A frame of a film, smaller in bytes than one that is looked at for itself.
pub(super) fn jpeg_of(image: &GrayImage) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, 75).encode_image(image)?;
    Ok(bytes)
}

/// The size with no side longer than `side`.
pub(super) fn within((width, height): (u32, u32), side: u32) -> (u32, u32) {
    let longest = width.max(height).max(1);
    let fit = |length: u32| if longest <= side { length } else { (length * side / longest).max(1) };
    (fit(width), fit(height))
}

/// A URI that holds the bytes themselves: a page with it needs no other file.
pub(super) fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", base64(bytes))
}

pub(super) fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_reads_back() {
        let palette = [[0, 0, 0], [255, 0, 0], [0, 0, 255]];
        let bytes = png((3, 2), &[0, 1, 2, 2, 1, 0], &palette).unwrap();
        let read = image::load_from_memory(&bytes).unwrap().into_rgb8();
        assert_eq!(
            (read.dimensions(), read.get_pixel(1, 0).0, read.get_pixel(0, 1).0),
            ((3, 2), palette[1], palette[2])
        );

        let frame = GrayFrame { width: 8, height: 8, pixels: vec![100; 64] };
        let read = image::load_from_memory(&jpeg(&frame).unwrap()).unwrap().into_luma8();
        assert!(read.pixels().all(|pixel| pixel.0[0].abs_diff(100) <= 2));
    }
}
