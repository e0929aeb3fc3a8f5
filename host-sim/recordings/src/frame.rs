//! A frame of a recording: gray levels, number, time, and colors if they are wanted.

use crate::planes::Planes;
use crate::raster::{ColorFrame, GrayFrame};
use anyhow::Result;

#[derive(Clone, Debug)]
pub struct Frame {
    /// Number in the recording, from 1; a live source also counts the frames that it dropped.
    pub number: usize,
    pub seconds: Option<f64>,
    pub gray: GrayFrame,
    /// The frame in color, if `Sequence::in_color` asks for it.
    pub color: Option<ColorFrame>,
    /// Presentation time and pixel aspect, for a video written from the color frames.
    pub moment: Option<Moment>,
    /// Luma and chroma planes of the frame, kept only for a live source, because it cannot be read a second time.
    pub planes: Option<Planes>,
}

impl Frame {
    pub fn new(number: usize, seconds: Option<f64>, gray: GrayFrame) -> Self {
        Self { number, seconds, gray, color: None, moment: None, planes: None }
    }
}

pub type Frames = Box<dyn Iterator<Item = Result<Frame>> + Send>;

/// Presentation time of a frame, and the aspect ratio of its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// Time in units of `base`.
    pub time: i64,
    /// Unit of `time` in seconds, as a fraction.
    pub base: (u32, u32),
    /// Width and height of a pixel, as a ratio.
    pub aspect: (u32, u32),
}

impl Moment {
    pub fn seconds(&self) -> f64 {
        self.time as f64 * f64::from(self.base.0) / f64::from(self.base.1)
    }
}
