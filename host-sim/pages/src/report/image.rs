//! Pixels of a picture: a frame, a patch, or differences, of which those that count are green.

use super::canvas::{Canvas, coarse, coarse_frame};
use crate::colors::Color;
use crate::encode;
use anyhow::Result;
use serde::ser::Error as _;
use serde::{Serialize, Serializer};
use smr_recordings::{GrayFrame, resized};

pub enum Pixels {
    /// A frame, which may be made smaller or larger.
    Frame(GrayFrame),
    /// Gray levels, shown pixel by pixel.
    Patch { size: (u16, u16), levels: Vec<u8> },
    /// Differences, brighter than they are, because most are small. Those that count are green.
    Differences { size: (u16, u16), levels: Vec<u8>, alpha: u16 },
}

/// As a URI, and whether it may be smoothed.
impl Serialize for Pixels {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.embedded().map_err(S::Error::custom)?.serialize(serializer)
    }
}

impl Pixels {
    pub(super) const fn size(&self) -> (u16, u16) {
        match self {
            Self::Frame(frame) => (frame.width, frame.height),
            Self::Patch { size, .. } | Self::Differences { size, .. } => *size,
        }
    }

    fn embedded(&self) -> Result<(String, bool)> {
        if let Self::Frame(frame) = self {
            return Ok((encode::data_uri("image/jpeg", &encode::jpeg(frame, encode::GOOD)?), true));
        }
        Ok((encode::data_uri("image/png", &self.png()?), false))
    }

    pub(super) fn png(&self) -> Result<Vec<u8>> {
        self.image().png()
    }

    fn image(&self) -> Canvas {
        let (width, height) = self.size();
        Canvas::from_fn(width.into(), height.into(), |x, y| self.color((y * u32::from(width) + x) as usize))
    }

    fn color(&self, at: usize) -> Color {
        match self {
            Self::Frame(GrayFrame { pixels: levels, .. }) | Self::Patch { levels, .. } => coarse(levels[at]),
            Self::Differences { levels, alpha, .. } => match levels[at] {
                level if u16::from(level) < *alpha => counting_color(level),
                level => coarse(gray(level)),
            },
        }
    }

    /// In another size. A frame is smoothed, unless its new size is a multiple of its own.
    pub(super) fn sized(&self, width: u16, height: u16) -> Canvas {
        let whole = |side: u16, own: u16| side.is_multiple_of(own.max(1));
        let sharp = whole(width, self.size().0) && whole(height, self.size().1);
        match self {
            Self::Frame(frame) if !sharp => coarse_frame(&resized(frame.clone(), width, height)),
            _ => self.image().nearest(width.into(), height.into()),
        }
    }
}

/// The difference with the brightest shade. Larger ones look the same.
pub(super) const BRIGHTEST: u8 = 127;

/// The shade of a difference. It rises steeply at first, because most differences are small.
pub(super) fn gray(level: u8) -> u8 {
    let shade = (255 * 255 * u32::from(level) / u32::from(BRIGHTEST)).isqrt();
    u8::try_from(shade).unwrap_or(u8::MAX)
}

fn counting_color(level: u8) -> Color {
    let shade = gray(level) / 3;
    [shade, 105 + shade, 65 + shade]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_grows_with_the_difference() {
        assert!((1..=BRIGHTEST).all(|level| gray(level) >= gray(level - 1)));
        assert_eq!((gray(0), gray(BRIGHTEST)), (0, 255));
    }
}
