//! Luma and chroma planes of a frame, and its gray levels and colors.

use crate::raster::{ColorFrame, GrayFrame};

/// A frame in the layout of the stream: the luma plane, then two chroma planes, if any.
#[derive(Clone, Debug)]
pub struct Planes {
    pub(crate) size: (u16, u16),
    pub(crate) chroma: Chroma,
    pub(crate) bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Chroma {
    /// Horizontal chroma subsampling: pixels for each chroma sample; 0 without chroma.
    pub across: usize,
    pub down: usize,
    /// True for full range (0 to 255) and gray frames, false for limited range (luma 16 to 235, chroma 16 to 240).
    pub is_full: bool,
}

impl Planes {
    pub fn gray(&self) -> GrayFrame {
        let (width, height) = self.size;
        let luma = usize::from(width) * usize::from(height);
        GrayFrame { width, height, pixels: self.bytes[..luma].to_vec() }
    }

    /// Converts the frame to RGB by the matrix of BT.601, because the stream names no matrix.
    pub fn color(&self) -> ColorFrame {
        let (width, height) = (usize::from(self.size.0), usize::from(self.size.1));
        let Chroma { across, down, is_full } = self.chroma;
        let (luma, chroma) = self.bytes.split_at(width * height);
        let (blue, red) = chroma.split_at(chroma.len() / 2);
        let (black, of_luma, of_chroma) = if is_full { (0.0, 1.0, 1.0) } else { (16.0, 255.0 / 219.0, 255.0 / 224.0) };
        let pixel = |at: usize| {
            let gray = (f32::from(luma[at]) - black) * of_luma;
            let difference = |plane: &[u8]| {
                let at = at / width / down.max(1) * width.div_ceil(across.max(1)) + at % width / across.max(1);
                plane.get(at).map_or(0.0, |&level| (f32::from(level) - 128.0) * of_chroma)
            };
            let (blue, red) = (difference(blue), difference(red));
            let rgb = [gray + 1.402 * red, gray - 0.344_136 * blue - 0.714_136 * red, gray + 1.772 * blue];
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
            rgb.map(|level| level.round() as u8)
        };
        ColorFrame { width: self.size.0, height: self.size.1, pixels: (0..luma.len()).map(pixel).collect() }
    }
}
