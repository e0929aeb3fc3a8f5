//! One frame as the file of a picture.

use crate::sequence::GrayFrame;
use anyhow::Result;
use png::{ColorType, Encoder};

/// As PNG.
///
/// # Errors
/// The encoder's.
pub fn png(frame: &GrayFrame) -> Result<Vec<u8>> {
    encoded((frame.width, frame.height), ColorType::Grayscale, &frame.pixels)
}

/// Red, green and blue of each pixel as PNG.
///
/// # Errors
/// The encoder's, for example that there are too few pixels.
pub fn rgb_png(size: (u16, u16), rgb: &[u8]) -> Result<Vec<u8>> {
    encoded(size, ColorType::Rgb, rgb)
}

fn encoded((width, height): (u16, u16), color: ColorType, samples: &[u8]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width.into(), height.into());
    encoder.set_color(color);
    encoder.write_header()?.write_image_data(samples)?;
    Ok(bytes)
}

/// As binary PGM (P5), the form that every reader of PGM knows.
#[must_use]
pub fn pgm(GrayFrame { width, height, pixels }: &GrayFrame) -> Vec<u8> {
    [format!("P5\n{width} {height}\n255\n").as_bytes(), pixels].concat()
}

/// A PNG that was written, to be looked at by tests.
#[cfg(test)]
pub(crate) struct Decoded {
    pub size: (u32, u32),
    rgb: Vec<u8>,
}

#[cfg(test)]
impl Decoded {
    pub(crate) fn new(png: &[u8]) -> Self {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        let decoded = reader.next_frame(&mut samples).unwrap();
        let rgb = match decoded.color_type {
            ColorType::Rgb => samples,
            ColorType::Grayscale => samples.iter().flat_map(|&gray| [gray; 3]).collect(),
            other => panic!("{other:?}"),
        };
        Self { size: (decoded.width, decoded.height), rgb }
    }

    pub(crate) fn at(&self, x: u32, y: u32) -> [u8; 3] {
        self.rgb.as_chunks().0[(y * self.size.0 + x) as usize]
    }

    pub(crate) fn rgb(&self) -> &[u8] {
        &self.rgb
    }
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
