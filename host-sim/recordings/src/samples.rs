//! Decoded samples as a frame in gray or in color, and what may be wrong with a picture.

use super::damage::Damaged;
use super::{ColorFrame, GrayFrame, MOST_PIXELS, Raster};
use anyhow::{Error, Result, anyhow, ensure};

pub(super) const EXPECTED: &str = "expected a PNG, JPEG, PGM or PPM picture";

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

/// A decoded picture: samples of 8 bits, gray or RGB, each with or without alpha.
pub(super) struct Samples {
    width: u16,
    height: u16,
    /// Samples a pixel, 1 to 4.
    channels: usize,
    samples: Vec<u8>,
}

impl Samples {
    pub fn new(width: u32, height: u32, channels: usize, samples: Vec<u8>) -> Result<Self> {
        let side = |side: u32| {
            u16::try_from(side)
                .map_err(|_| anyhow!("it is {width}x{height}: expected at most 65535 pixels on each side"))
        };
        Ok(Self { width: side(width)?, height: side(height)?, channels, samples })
    }

    pub fn gray(self) -> GrayFrame {
        if self.channels == 1 {
            return GrayFrame { width: self.width, height: self.height, pixels: self.samples };
        }
        self.pixels(luma)
    }

    pub fn colors(self) -> ColorFrame {
        self.pixels(|rgb| rgb)
    }

    fn pixels<P>(self, of: impl Fn([u8; 3]) -> P) -> Raster<P> {
        let Self { width, height, channels, samples } = self;
        let pixels = match channels {
            3 => samples.as_chunks().0.iter().map(|&rgb| of(rgb)).collect(),
            4 => samples.as_chunks().0.iter().map(|&[r, g, b, _alpha]| of([r, g, b])).collect(),
            _ => samples.iter().step_by(channels).map(|&gray| of([gray; 3])).collect(),
        };
        Raster { width, height, pixels }
    }
}

/// The weights add up to 65536, so the third byte from the right is the quotient and never overflows.
pub fn luma([r, g, b]: [u8; 3]) -> u8 {
    let sum = 19595 * u32::from(r) + 38470 * u32::from(g) + 7471 * u32::from(b) + 32768;
    sum.to_be_bytes()[1]
}
