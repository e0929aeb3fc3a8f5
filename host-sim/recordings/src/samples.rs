//! Decoded samples as a frame in gray or in color, and what may be wrong with a picture.

use super::damage::Damaged;
use super::levels::Levels;
use super::{ColorFrame, GrayFrame, MOST_PIXELS, Raster};
use anyhow::{Error, Result, anyhow, ensure};

pub(super) const EXPECTED: &str = "expected a PNG, JPEG, PGM, PPM or PAM picture";

pub(super) fn check_size(width: u32, height: u32) -> Result<()> {
    let pixels = u64::from(width) * u64::from(height);
    ensure!(pixels > 0, "it is {width}x{height}: expected at least 1 pixel on each side");
    ensure!(pixels <= MOST_PIXELS, "it is {width}x{height}: expected at most {MOST_PIXELS} pixels");
    Ok(())
}

/// The error for a picture of which nothing can be decoded.
pub(super) fn damaged(why: String) -> Error {
    Damaged::new(why).into()
}

/// The error for a picture that may well be whole, but of a kind that is not read.
pub(super) fn unread(kind: &str) -> Error {
    anyhow!("it is {kind}, which is not read: {CONVERT}")
}

pub(super) const CONVERT: &str = "convert it to PNG first";

/// The error for a file with several pictures in place of one.
pub(super) fn several() -> Error {
    anyhow!("it holds several pictures: expected one in a file; a file with several is a recording of its own")
}

/// A decoded picture: gray or RGB, each with or without alpha.
pub(super) struct Samples {
    width: u16,
    height: u16,
    /// Samples a pixel, 1 to 4.
    channels: usize,
    /// Samples of 8 bits, or of 16 with the high byte first.
    samples: Vec<u8>,
    is_wide: bool,
    /// As Exif counts, 1 to 8.
    orientation: u8,
}

impl Samples {
    /// Upright samples of 8 bits.
    pub fn new(width: u32, height: u32, channels: usize, samples: Vec<u8>) -> Result<Self> {
        let side = |side: u32| {
            u16::try_from(side)
                .map_err(|_| anyhow!("it is {width}x{height}: expected at most 65535 pixels on each side"))
        };
        let (width, height) = (side(width)?, side(height)?);
        Ok(Self { width, height, channels, samples, is_wide: false, orientation: 1 })
    }

    /// Sets whether samples have two bytes.
    pub fn wide(self, is_wide: bool) -> Self {
        Self { is_wide, ..self }
    }

    pub fn oriented(self, orientation: u8) -> Self {
        Self { orientation, ..self }
    }

    /// 16-bit values without those of alpha; `None` for 8-bit samples.
    pub fn values(&self) -> Option<impl Iterator<Item = u16>> {
        let colors = if self.channels < 3 { 1 } else { 3 };
        let values = self.samples.chunks_exact(2 * self.channels).flat_map(move |pixel| &pixel.as_chunks().0[..colors]);
        self.is_wide.then(|| values.map(|&bytes| u16::from_be_bytes(bytes)))
    }

    /// Returns samples of 8 bits: the high byte, or the value stretched by `levels`.
    /// Errors: Levels are given for samples of 8 bits.
    fn narrow(self, levels: Option<Levels>) -> Result<Self> {
        ensure!(self.is_wide || levels.is_none(), "--levels is for 16-bit pictures: this one has 8 bits");
        if !self.is_wide {
            return Ok(self);
        }
        let pairs = self.samples.as_chunks().0.iter();
        let samples = pairs.map(|&pair| levels.map_or(pair[0], |levels| levels.of(u16::from_be_bytes(pair)))).collect();
        Ok(Self { samples, is_wide: false, ..self })
    }

    pub fn gray(self, levels: Option<Levels>) -> Result<GrayFrame> {
        let narrow = self.narrow(levels)?;
        if narrow.channels == 1 {
            let Self { width, height, samples: pixels, orientation, .. } = narrow;
            return Ok(Raster { width, height, pixels }.turned(orientation));
        }
        Ok(narrow.pixels(luma))
    }

    pub fn colors(self, levels: Option<Levels>) -> Result<ColorFrame> {
        Ok(self.narrow(levels)?.pixels(|rgb| rgb))
    }

    fn pixels<P: Copy>(self, of: impl Fn([u8; 3]) -> P) -> Raster<P> {
        let Self { width, height, channels, samples, orientation, .. } = self;
        let pixels = match channels {
            3 => samples.as_chunks().0.iter().map(|&rgb| of(rgb)).collect(),
            4 => samples.as_chunks().0.iter().map(|&[r, g, b, _alpha]| of([r, g, b])).collect(),
            _ => samples.iter().step_by(channels).map(|&gray| of([gray; 3])).collect(),
        };
        Raster { width, height, pixels }.turned(orientation)
    }
}

impl<P: Copy> Raster<P> {
    /// Returns the picture upright, by the orientation that Exif states: 2 to 4 are mirrored or turned by 180 degrees, 5 to 8 also
    /// have rows for columns.
    fn turned(self, orientation: u8) -> Self {
        if orientation == 1 {
            return self;
        }
        let (columns, rows) = (usize::from(self.width), usize::from(self.height));
        let has_rows_for_columns = orientation >= 5;
        let (width, height) = if has_rows_for_columns { (self.height, self.width) } else { (self.width, self.height) };
        let pixel = |x: usize, y: usize| {
            let (column, row) = if has_rows_for_columns { (y, x) } else { (x, y) };
            let column = if matches!(orientation, 2 | 3 | 7 | 8) { columns - 1 - column } else { column };
            let row = if matches!(orientation, 3 | 4 | 6 | 7) { rows - 1 - row } else { row };
            self.pixels[row * columns + column]
        };
        let places = (0..usize::from(height)).flat_map(|y| (0..usize::from(width)).map(move |x| (x, y)));
        Self { width, height, pixels: places.map(|(x, y)| pixel(x, y)).collect() }
    }
}

/// The weights add up to 65536, so the third byte from the right is the quotient and never overflows.
pub fn luma([r, g, b]: [u8; 3]) -> u8 {
    let sum = 19595 * u32::from(r) + 38470 * u32::from(g) + 7471 * u32::from(b) + 32768;
    sum.to_be_bytes()[1]
}
