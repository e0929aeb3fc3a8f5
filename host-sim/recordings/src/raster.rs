//! Frames in gray and in color: pixels row by row.

/// A frame; its pixels are stored row by row, without gaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster<P> {
    pub width: u16,
    pub height: u16,
    pub pixels: Vec<P>,
}

pub type GrayFrame = Raster<u8>;

pub type ColorFrame = Raster<[u8; 3]>;

/// Largest number of pixels in a frame, 16384x16384. A larger frame is refused before memory is allocated for it.
pub(crate) const MAX_PIXELS: u64 = 1 << 28;

impl GrayFrame {
    /// Draws a frame row by row; `level` returns the gray level of the pixel (x, y).
    pub fn drawn(width: u16, height: u16, mut level: impl FnMut(i32, i32) -> u8) -> Self {
        let places = (0..i32::from(height)).flat_map(|y| (0..i32::from(width)).map(move |x| (x, y)));
        Self { width, height, pixels: places.map(|(x, y)| level(x, y)).collect() }
    }

    pub fn frame(&self) -> smr_core::Frame<'_> {
        smr_core::Frame::whole(self.image())
    }

    pub fn image(&self) -> smr_core::Image<'_> {
        let image = smr_core::Image::new(&self.pixels, self.width, self.height);
        image.expect("a GrayFrame is made with as many pixels as its size says, and at least one")
    }

    /// Returns the gray level of a pixel; 0 outside the frame, as in the zero padding of the trackers.
    pub fn level(&self, x: i32, y: i32) -> u8 {
        let (Ok(x), Ok(y)) = (u16::try_from(x), u16::try_from(y)) else { return 0 };
        let inside = x < self.width && y < self.height;
        if inside { self.pixels[usize::from(y) * usize::from(self.width) + usize::from(x)] } else { 0 }
    }
}

impl From<smr_core::Image<'_>> for GrayFrame {
    fn from(image: smr_core::Image<'_>) -> Self {
        Self { width: image.width(), height: image.height(), pixels: image.rows().flatten().copied().collect() }
    }
}

impl From<&GrayFrame> for ColorFrame {
    fn from(GrayFrame { width, height, pixels }: &GrayFrame) -> Self {
        Self { width: *width, height: *height, pixels: pixels.iter().map(|&gray| [gray; 3]).collect() }
    }
}
