//! A frame of the camera, and what of it is in memory.

use super::{Image, Rect};
use core::fmt;

/// Why an image is not a part of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError {
    /// The image reaches beyond the right or the lower edge of the frame.
    OutsideFrame,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the image reaches beyond the edge of the frame it is said to be a part of")
    }
}

impl core::error::Error for FrameError {}

/// One frame of the camera: its size, and what of it is in memory: all of it, a part, or two parts.
///
/// A whole frame is [`Frame::whole`]. Firmware that reads out only what the tracker asks for gives [`Frame::part`] and, where two
/// windows are asked for, [`Frame::and_part`]. Boxes are in coordinates of the whole frame all the same.
///
/// ```
/// use smr_core::{Frame, Image, Rect};
/// let (readout, second) = ([0u8; 96 * 96], [0u8; 64 * 32]);
/// // A 96x96 window of a 320x240 sensor, its corner at (100, 40).
/// let frame = Frame::part(Image::new(&readout, 96, 96)?, 100, 40, 320, 240)?;
/// assert_eq!(frame.bounds(), Rect::new(0, 0, 320, 240));
/// assert!(frame.covers(Rect::new(100, 40, 96, 96)) && !frame.covers(Rect::new(0, 0, 64, 32)));
/// // Another window of the same sensor.
/// let frame = frame.and_part(Image::new(&second, 64, 32)?, 0, 0)?;
/// assert!(frame.covers(Rect::new(100, 40, 96, 96)) && frame.covers(Rect::new(0, 0, 64, 32)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    first: Part<'a>,
    second: Option<Part<'a>>,
    width: u16,
    height: u16,
}

/// What is in memory, and where its top left pixel is in the frame.
#[derive(Clone, Copy, Debug)]
struct Part<'a> {
    image: Image<'a>,
    x: u16,
    y: u16,
}

impl<'a> Part<'a> {
    const fn within(image: Image<'a>, x: u16, y: u16, width: u16, height: u16) -> Result<Self, FrameError> {
        let fits_x = x as u32 + image.width() as u32 <= width as u32;
        let fits_y = y as u32 + image.height() as u32 <= height as u32;
        if fits_x && fits_y { Ok(Self { image, x, y }) } else { Err(FrameError::OutsideFrame) }
    }

    fn patch(&self, rect: Rect) -> Option<Image<'a>> {
        let x = rect.x.checked_sub(i32::from(self.x))?;
        let y = rect.y.checked_sub(i32::from(self.y))?;
        self.image.crop(Rect { x, y, ..rect })
    }
}

impl<'a> Frame<'a> {
    /// A frame that is in memory as a whole.
    #[must_use]
    pub const fn whole(image: Image<'a>) -> Self {
        Self { first: Part { image, x: 0, y: 0 }, second: None, width: image.width(), height: image.height() }
    }

    /// The part of a `width` x `height` frame whose top left pixel is pixel (`x`, `y`) of the frame.
    ///
    /// # Errors
    /// [`FrameError::OutsideFrame`] if `image` does not lie within the frame.
    pub const fn part(image: Image<'a>, x: u16, y: u16, width: u16, height: u16) -> Result<Self, FrameError> {
        match Part::within(image, x, y, width, height) {
            Ok(first) => Ok(Self { first, second: None, width, height }),
            Err(error) => Err(error),
        }
    }

    /// The same frame with one part more in memory, in the place of a second one if there is one.
    ///
    /// # Errors
    /// [`FrameError::OutsideFrame`] if `image` does not lie within the frame.
    pub const fn and_part(self, image: Image<'a>, x: u16, y: u16) -> Result<Self, FrameError> {
        match Part::within(image, x, y, self.width, self.height) {
            Ok(second) => Ok(Self { second: Some(second), ..self }),
            Err(error) => Err(error),
        }
    }

    /// The frame's own rectangle, at (0, 0).
    #[must_use]
    pub const fn bounds(&self) -> Rect {
        Rect::new(0, 0, self.width, self.height)
    }

    /// True if all of `rect` (frame coordinates) lies in one part that is in memory. An empty one does not.
    #[must_use]
    pub fn covers(&self, rect: Rect) -> bool {
        self.patch(rect).is_some()
    }

    /// The pixels in `rect` (frame coordinates), or `None` if no part in memory has all of them.
    #[must_use]
    pub fn patch(&self, rect: Rect) -> Option<Image<'a>> {
        self.first.patch(rect).or_else(|| self.second?.patch(rect))
    }
}

impl<'a> From<Image<'a>> for Frame<'a> {
    fn from(image: Image<'a>) -> Self {
        Self::whole(image)
    }
}
