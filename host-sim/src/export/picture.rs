//! One frame as the file of a picture.

use crate::sequence::GrayFrame;
use anyhow::Result;
use image::{ExtendedColorType, ImageFormat};
use std::io::Cursor;

/// As PNG.
///
/// # Errors
/// The encoder's.
pub fn png(frame: &GrayFrame) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let (width, height) = (frame.width.into(), frame.height.into());
    image::write_buffer_with_format(&mut bytes, &frame.pixels, width, height, ExtendedColorType::L8, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// As binary PGM (P5), the form that every reader of PGM knows.
#[must_use]
pub fn pgm(GrayFrame { width, height, pixels }: &GrayFrame) -> Vec<u8> {
    [format!("P5\n{width} {height}\n255\n").as_bytes(), pixels].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::decode_picture;

    #[test]
    fn pictures_read_back() {
        let frame = GrayFrame { width: 3, height: 2, pixels: vec![0, 10, 255, 13, 35, 128] };
        assert_eq!(decode_picture(&png(&frame).unwrap()).unwrap(), frame);
        assert_eq!(decode_picture(&pgm(&frame)).unwrap(), frame);
        assert!(pgm(&frame).starts_with(b"P5\n3 2\n255\n\0"));
    }
}
