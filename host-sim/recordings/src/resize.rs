//! Scales the frames and boxes of a recording to another size.

use crate::bounding_box::BoundingBox;
use crate::frame::Frame;
use crate::raster::{MAX_PIXELS, Raster};
use crate::sequence::Sequence;
use anyhow::{Context, Result, bail, ensure};
use rgb::FromSlice as _;
use std::fmt;
use std::str::FromStr;

/// Target size of scaled frames: `320x240`, or a fraction of their own size, `1/2`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resize {
    To(u16, u16),
    By(u16, u16),
}

impl FromStr for Resize {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let pair = |separator| {
            let (first, second) = text.split_once(separator)?;
            let number = |text: &str| text.parse().ok().filter(|&number: &u16| number > 0);
            Some((number(first)?, number(second)?))
        };
        match (pair('x'), pair('/')) {
            (Some((width, height)), _) => Ok(Self::To(width, height)),
            (_, Some((numerator, denominator))) => Ok(Self::By(numerator, denominator)),
            _ => bail!("expected a size like 320x240 or a fraction like 1/2, of numbers from 1 to 65535"),
        }
    }
}

impl fmt::Display for Resize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::To(width, height) => write!(f, "{width}x{height}"),
            Self::By(numerator, denominator) => write!(f, "{numerator}/{denominator}"),
        }
    }
}

impl Resize {
    fn size(self, width: u16, height: u16) -> Result<(u16, u16)> {
        let (numerator, denominator) = match self {
            Self::To(width, height) => return Ok((width, height)),
            Self::By(numerator, denominator) => (u64::from(numerator), u64::from(denominator)),
        };
        let side = |side: u16| u16::try_from((2 * u64::from(side) * numerator + denominator) / (2 * denominator)).ok();
        let (new_width, new_height) = side(width).zip(side(height)).with_context(|| {
            format!("--resize {self} of {width}x{height}: expected at most 65535 pixels on each side")
        })?;
        Ok((new_width.max(1), new_height.max(1)))
    }
}

impl Sequence {
    /// Scales all frames (by a triangle filter) and their boxes. Errors: The new size is too large, or the first frame,
    /// which is read to learn its size, cannot be read.
    pub fn resized(self, resize: Resize) -> Result<Self> {
        let mut frames = self.frames;
        let first = frames.next().with_context(|| format!("{} holds no frame", self.name))??;
        let (old_width, old_height) = (first.gray.width, first.gray.height);
        let (width, height) = resize.size(old_width, old_height)?;
        let pixels = u64::from(width) * u64::from(height);
        ensure!(pixels <= MAX_PIXELS, "--resize to {width}x{height}: expected at most {MAX_PIXELS} pixels");
        let scale = (f64::from(width) / f64::from(old_width), f64::from(height) / f64::from(old_height));
        let frames = std::iter::once(Ok(first)).chain(frames).map(move |frame: Result<Frame>| {
            let frame = frame?;
            Ok(Frame { gray: resized(frame.gray, width, height), ..frame })
        });
        let scaled = |entry: Option<BoundingBox>| entry.map(|entry| entry.scaled(scale));
        let (init, truth) = (scaled(self.init), self.truth.map(|truth| truth.into_iter().map(scaled).collect()));
        Ok(Self { frames: Box::new(frames), init, truth, scale, ..self })
    }
}

pub trait Scalable: Copy {
    fn scale(from: (u16, u16), source: &[Self], to: (u16, u16), target: &mut [Self]);
}

impl Scalable for u8 {
    fn scale(from: (u16, u16), source: &[Self], to: (u16, u16), target: &mut [Self]) {
        scale(resize::Pixel::Gray8, from, source.as_gray(), to, target.as_gray_mut());
    }
}

impl Scalable for [u8; 3] {
    fn scale(from: (u16, u16), source: &[Self], to: (u16, u16), target: &mut [Self]) {
        let (source, target) = (source.as_flattened().as_rgb(), target.as_flattened_mut().as_rgb_mut());
        scale(resize::Pixel::RGB8, from, source, to, target);
    }
}

/// Scales a frame to `width` and `height`, neither of which may be 0.
pub fn resized<P: Scalable>(frame: Raster<P>, width: u16, height: u16) -> Raster<P> {
    if (frame.width, frame.height) == (width, height) {
        return frame;
    }
    let mut pixels = vec![frame.pixels[0]; usize::from(width) * usize::from(height)];
    P::scale((frame.width, frame.height), &frame.pixels, (width, height), &mut pixels);
    Raster { width, height, pixels }
}

fn scale<F: resize::PixelFormat>(
    format: F,
    from: (u16, u16),
    source: &[F::InputPixel],
    to: (u16, u16),
    target: &mut [F::OutputPixel],
) {
    resize::new(from.0.into(), from.1.into(), to.0.into(), to.1.into(), format, resize::Type::Triangle)
        .and_then(|mut resizer| resizer.resize(source, target))
        .expect("a frame is made with as many pixels as its size says");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in::synthetic;
    use crate::raster::GrayFrame;

    fn synthetic_as(text: &str) -> Sequence {
        synthetic::sequence().resized(text.parse().unwrap()).unwrap()
    }

    #[test]
    fn sizes_as_they_are_typed() {
        assert_eq!("320x240".parse::<Resize>().unwrap(), Resize::To(320, 240));
        assert_eq!("1/2".parse::<Resize>().unwrap().size(321, 1).unwrap(), (161, 1));
        assert_eq!(Resize::By(1, 1000).size(320, 240).unwrap(), (1, 1));
        assert!(Resize::By(1000, 1).size(320, 240).is_err());
        for refused in ["", "2", "0x3", "1/0", "320x", "1/2/3", "-1x4", "70000x4"] {
            let error = refused.parse::<Resize>().unwrap_err().to_string();
            assert!(error.starts_with("expected a size like 320x240"), "{refused}: {error}");
        }
    }

    #[test]
    fn boxes_are_scaled_along() {
        let (width, height) = (synthetic::WIDTH, synthetic::HEIGHT);
        let half = synthetic_as("1/2");
        assert_eq!((half.scale, synthetic::sequence().scale), ((0.5, 0.5), (1.0, 1.0)));
        let BoundingBox { x, y, width: wide, height: high } = synthetic::truth(7).unwrap();
        let expected = BoundingBox { x: x / 2.0, y: y / 2.0, width: wide / 2.0, height: high / 2.0 };
        assert_eq!(half.truth.unwrap()[7], Some(expected));
        let frames: Vec<_> = half.frames.map(|frame| frame.unwrap().gray).collect();
        assert_eq!((frames.len(), frames[3].width, frames[3].height), (synthetic::LENGTH, width / 2, height / 2));

        let wider = synthetic_as(&format!("{}x{height}", width * 2));
        let start = synthetic::truth(0).unwrap();
        assert_eq!(wider.init, Some(BoundingBox { x: start.x * 2.0, width: start.width * 2.0, ..start }));
    }

    #[test]
    fn means_stay_and_the_same_size_is_the_same() {
        let same = synthetic_as("1/1");
        assert!(same.frames.map(|frame| frame.unwrap().gray).eq(synthetic::frames()));
        let mean = |frame: &GrayFrame| {
            frame.pixels.iter().map(|&pixel| f64::from(pixel)).sum::<f64>() / frame.pixels.len() as f64
        };
        let whole = synthetic::frames().next().unwrap();
        let small = synthetic_as("1/3").frames.next().unwrap().unwrap().gray;
        assert!((mean(&whole) - mean(&small)).abs() < 1.0);
    }
}
