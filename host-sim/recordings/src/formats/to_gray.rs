//! Converts decoded samples to an upright frame in gray or color, and creates errors about images.

use crate::raster::{ColorFrame, GrayFrame, MAX_PIXELS, Raster};
use anyhow::{Context, Error, Result, anyhow, ensure};
use std::fmt;
use std::str::FromStr;

pub(crate) const EXPECTED: &str = "expected a PNG, JPEG, PGM, PPM or PAM picture";

pub(crate) fn check_size(width: u32, height: u32) -> Result<()> {
    let pixels = u64::from(width) * u64::from(height);
    ensure!(pixels > 0, "it is {width}x{height}: expected at least 1 pixel on each side");
    ensure!(pixels <= MAX_PIXELS, "it is {width}x{height}: expected at most {MAX_PIXELS} pixels");
    Ok(())
}

/// Returns the error for an image of an unsupported kind. It does not call the image damaged.
pub(crate) fn unread(kind: &str) -> Error {
    anyhow!("it is {kind}, which is not supported: {CONVERT}")
}

pub(crate) const CONVERT: &str = "convert it to PNG first";

pub(crate) fn several() -> Error {
    anyhow!(
        "it holds several pictures: expected one picture in each file of a folder, or this file alone as the recording"
    )
}

/// A range of 16-bit values, stretched to 0..255; values outside become black or white. Text form: `7600..8366`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    pub(crate) black: u16,
    pub(crate) white: u16,
}

impl Levels {
    pub(crate) fn of(self, value: u16) -> u8 {
        let (above, span) = (u32::from(value.saturating_sub(self.black)), u32::from(self.white - self.black));
        u8::try_from((255 * above + span / 2) / span).unwrap_or(255)
    }
}

impl FromStr for Levels {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let ends = text.split_once("..").and_then(|(black, white)| Some((black.parse().ok()?, white.parse().ok()?)));
        let expected = "expected two values from 0 to 65535, black..white, like 7600..8366";
        let (black, white) = ends.context(expected)?;
        ensure!(black < white, "{expected}: the smaller one first");
        Ok(Self { black, white })
    }
}

impl fmt::Display for Levels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.black, self.white)
    }
}

/// A decoded image: gray or RGB, each with or without alpha.
pub(crate) struct Samples {
    pub width: u16,
    pub height: u16,
    /// Samples per pixel, 1 to 4.
    pub channels: usize,
    /// 8-bit samples, or 16-bit ones with the high byte first.
    pub samples: Vec<u8>,
    pub is_wide: bool,
    /// Exif orientation, 1 (upright) to 8.
    pub orientation: u8,
}

impl Samples {
    /// Creates upright 8-bit samples; an error if a side is longer than 65535 pixels.
    pub fn new(width: u32, height: u32, channels: usize, samples: Vec<u8>) -> Result<Self> {
        let side = |side: u32| {
            u16::try_from(side)
                .map_err(|_| anyhow!("it is {width}x{height}: expected at most 65535 pixels on each side"))
        };
        let (width, height) = (side(width)?, side(height)?);
        Ok(Self { width, height, channels, samples, is_wide: false, orientation: 1 })
    }

    /// Returns the 16-bit values except alpha; `None` for 8-bit samples.
    pub fn values(&self) -> Option<impl Iterator<Item = u16>> {
        let colors = if self.channels < 3 { 1 } else { 3 };
        let values = self.samples.chunks_exact(2 * self.channels).flat_map(move |pixel| &pixel.as_chunks().0[..colors]);
        self.is_wide.then(|| values.map(|&bytes| u16::from_be_bytes(bytes)))
    }

    /// Converts to 8 bits: the high byte, or the value stretched by `levels`, which are an error for 8-bit samples.
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
        Ok(self.narrow(levels)?.pixels(luma))
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
    /// Turns an image upright by its Exif orientation. Orientations from 5 on also swap rows and columns.
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

/// Returns the gray level by BT.601. The weights add up to 65536, so the level is bits 16 to 23 of the sum.
pub fn luma([r, g, b]: [u8; 3]) -> u8 {
    let sum = 19595 * u32::from(r) + 38470 * u32::from(g) + 7471 * u32::from(b) + 32768;
    sum.to_be_bytes()[1]
}

/// Returns the orientation in Exif data, tag 0x112 of the first TIFF directory: 1 (upright) to 8; 1 without the tag.
pub(crate) fn orientation(exif: &[u8]) -> u8 {
    let stated = stated(exif).and_then(|stated| u8::try_from(stated).ok());
    stated.filter(|stated| (1..=8).contains(stated)).unwrap_or(1)
}

fn stated(exif: &[u8]) -> Option<u32> {
    // Some writers of PNG put the header of the JPEG segment before the Exif data.
    let exif = exif.strip_prefix(EXIF).unwrap_or(exif);
    let is_little_endian = match exif.get(..2)? {
        b"II" => true,
        b"MM" => false,
        _ => return None,
    };
    let number = |at: usize, length: usize| {
        let join = |number: u32, &byte: &u8| number << 8 | u32::from(byte);
        let field = exif.get(at..)?.get(..length)?.iter();
        Some(if is_little_endian { field.rev().fold(0, join) } else { field.fold(0, join) })
    };
    let directory = usize::try_from(number(4, 4)?).ok()?;
    let entries = (0..number(directory, 2)? as usize).map(|entry| directory.saturating_add(2 + 12 * entry));
    let entry = entries.into_iter().find(|&entry| number(entry, 2) == Some(0x112))?;
    // A SHORT fills two of the four value bytes of a TIFF entry, a LONG all four.
    number(entry + 8, if number(entry + 2, 2)? == 4 { 4 } else { 2 })
}

/// Header of the Exif segment in JPEG.
pub(crate) const EXIF: &[u8] = b"Exif\0\0";

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    #[test]
    fn values_are_stretched_and_clamped() {
        let levels: Levels = "7600..8365".parse().unwrap();
        let values = [0, 7600, 7601, 7602, 7982, 8365, 8366, 65535].map(|value| levels.of(value));
        assert_eq!((values, levels.to_string().as_str()), ([0, 0, 0, 1, 127, 255, 255, 255], "7600..8365"));
        assert_eq!("0..65535".parse::<Levels>().unwrap().of(257 * 99), 99);
        for text in ["", "5", "5..", "..5", "5..5", "6..5", "0..65536", "-1..5", "a..b", "1...5"] {
            let error = text.parse::<Levels>().unwrap_err().to_string();
            assert!(error.starts_with("expected two values"), "{text}");
            assert_eq!(error.ends_with("the smaller one first"), ["5..5", "6..5"].contains(&text), "{text}");
        }
    }

    /// Exif data with another tag before the orientation.
    pub fn exif(is_little_endian: bool, orientation: u16) -> Vec<u8> {
        let short = |number: u16| if is_little_endian { number.to_le_bytes() } else { number.to_be_bytes() };
        let long = |number: u32| if is_little_endian { number.to_le_bytes() } else { number.to_be_bytes() };
        let entry = |tag, value| [&short(tag)[..], &short(3), &long(1), &short(value), &[0; 2]].concat();
        let head = [if is_little_endian { b"II" } else { b"MM" }, &short(42)[..], &long(8), &short(2)].concat();
        [head, entry(0x100, 7), entry(0x112, orientation), vec![0; 4]].concat()
    }

    #[test]
    fn both_orders_of_bytes_and_data_that_end_anywhere() {
        for is_little_endian in [true, false] {
            for (stated, expected) in [(1, 1), (6, 6), (8, 8), (0, 1), (9, 1), (262, 1)] {
                let whole = exif(is_little_endian, stated);
                assert_eq!(orientation(&whole), expected);
                assert_eq!(orientation(&[EXIF, &whole].concat()), expected);
                (0..whole.len()).for_each(|length| assert!((1..=8).contains(&orientation(&whole[..length]))));
            }
        }
        assert_eq!(orientation(b"MM\0*\xFF\xFF\xFF\xFF"), 1);
    }
}
