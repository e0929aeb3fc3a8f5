//! One frame as the file of a picture.

use anyhow::Result;
use jpeg_encoder::{ColorType as JpegColor, Encoder as JpegEncoder};
use png::{ColorType, Encoder};
use smr_recordings::GrayFrame;

/// As PNG.
///
/// # Errors
/// The encoder's.
pub fn png(frame: &GrayFrame) -> Result<Vec<u8>> {
    encoded((frame.width.into(), frame.height.into()), ColorType::Grayscale, &frame.pixels)
}

/// Red, green and blue of each pixel as PNG.
///
/// # Errors
/// The encoder's, for example that there are too few pixels.
pub(super) fn rgb_png(size: (u32, u32), rgb: &[u8]) -> Result<Vec<u8>> {
    encoded(size, ColorType::Rgb, rgb)
}

fn encoded((width, height): (u32, u32), color: ColorType, samples: &[u8]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.write_header()?.write_image_data(samples)?;
    Ok(bytes)
}

/// As JPEG; 100 is the best quality.
///
/// # Errors
/// The encoder's.
pub(super) fn jpeg(frame: &GrayFrame, quality: u8) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    JpegEncoder::new(&mut bytes, quality).encode(&frame.pixels, frame.width, frame.height, JpegColor::Luma)?;
    Ok(bytes)
}

/// As binary PGM (P5), the form that every reader of PGM knows.
#[must_use]
pub fn pgm(GrayFrame { width, height, pixels }: &GrayFrame) -> Vec<u8> {
    [format!("P5\n{width} {height}\n255\n").as_bytes(), pixels].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::decode_picture;

    #[test]
    fn pictures_read_back() {
        let frame = GrayFrame { width: 3, height: 2, pixels: vec![0, 10, 255, 13, 35, 128] };
        assert_eq!(decode_picture(&png(&frame).unwrap()).unwrap(), frame);
        assert_eq!(decode_picture(&pgm(&frame)).unwrap(), frame);
        assert!(pgm(&frame).starts_with(b"P5\n3 2\n255\n\0"));
    }
}
