//! A frame of the camera, with all of its pixels or parts of them in memory.

use super::windows::area;
use super::{Image, ImageError, Rect, Windows};

errors! {
    /// The reason why an image was refused as a part of a frame.
    FrameError {
        /// The image reaches beyond the right or lower edge of the frame.
        OutsideFrame => "the image reaches beyond the right or lower edge of the frame",
    }

    /// The reason why the pixels of windows were refused.
    WindowError {
        /// A window is empty, or there are fewer pixels than the windows have.
        Image(error: ImageError) => "{error}",
        /// A window reaches outside the frame.
        Frame(error: FrameError) => "{error}",
    }
}

/// A camera frame: its size, and one or two images, which hold all of its pixels or only parts of the frame.
///
/// [`Frame::whole`] is for whole frames, [`Frame::of_windows`] for the windows of the tracker in one buffer,
/// [`Frame::part`] and [`Frame::and_part`] for rows with gaps and for windows in separate buffers. Coordinates are always
/// those of the whole frame.
///
/// ```
/// use smr_core::{Frame, Image, Rect};
/// let (readout, second) = ([0u8; 96 * 96], [0u8; 64 * 32]);
/// // A 96x96 window at (100, 40) of a 320x240 sensor.
/// let frame = Frame::part(Image::new(&readout, 96, 96)?, 100, 40, 320, 240)?;
/// assert_eq!(frame.bounds(), Rect::new(0, 0, 320, 240));
/// assert!(frame.covers(Rect::new(100, 40, 96, 96)) && !frame.covers(Rect::new(0, 0, 64, 32)));
/// // A second window of the same sensor.
/// let frame = frame.and_part(Image::new(&second, 64, 32)?, 0, 0)?;
/// assert!(frame.covers(Rect::new(100, 40, 96, 96)) && frame.covers(Rect::new(0, 0, 64, 32)));
/// # Ok::<(), smr_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    first: Part<'a>,
    second: Option<Part<'a>>,
    width: u16,
    height: u16,
}

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

    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    fn patch(&self, rect: Rect) -> Option<Image<'a>> {
        // A difference that wraps is large and positive, beyond the image's right or lower edge: `crop` refuses it.
        let (x, y) = (rect.x.wrapping_sub(self.x.into()), rect.y.wrapping_sub(self.y.into()));
        self.image.crop(Rect { x, y, ..rect })
    }
}

impl<'a> Frame<'a> {
    /// A frame wholly in memory.
    #[must_use]
    pub const fn whole(image: Image<'a>) -> Self {
        Self { first: Part { image, x: 0, y: 0 }, second: None, width: image.width(), height: image.height() }
    }

    /// A `width` x `height` frame of which only `image` is in memory. The top left pixel of `image` is at (`x`, `y`).
    ///
    /// # Errors
    /// [`FrameError::OutsideFrame`] if `image` reaches outside the frame.
    pub const fn part(image: Image<'a>, x: u16, y: u16, width: u16, height: u16) -> Result<Self, FrameError> {
        match Part::within(image, x, y, width, height) {
            Ok(first) => Ok(Self { first, second: None, width, height }),
            Err(error) => Err(error),
        }
    }

    /// Adds `image` with its top left pixel at (`x`, `y`) as the second part. Replaces an earlier second part.
    ///
    /// # Errors
    /// [`FrameError::OutsideFrame`] if `image` reaches outside the frame.
    pub const fn and_part(self, image: Image<'a>, x: u16, y: u16) -> Result<Self, FrameError> {
        match Part::within(image, x, y, self.width, self.height) {
            Ok(second) => Ok(Self { second: Some(second), ..self }),
            Err(error) => Err(error),
        }
    }

    /// A `width` x `height` frame of which only the pixels in `windows` are in memory: [`Windows`], or one [`Rect`].
    /// `pixels` has the gray pixels of the first window, then those of the next, each row by row without gaps; bytes
    /// after them are ignored. Copies nothing.
    ///
    /// ```
    /// use smr_core::{Frame, Image, Rect, Robust, Tracker, Windows};
    /// # let sensor: Vec<u8> = (0..160 * 120).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    /// # let read_out = |windows: Windows| -> Vec<u8> {
    /// #     let row = |window: Rect, y| &sensor[(y * 160 + window.x) as usize..][..window.width.into()];
    /// #     windows.iter().flat_map(|window| (window.y..window.bottom()).flat_map(move |y| row(window, y))).copied().collect()
    /// # };
    /// let (size, target) = ((160, 120), Rect::new(60, 50, 24, 24));
    /// let mut tracker = Tracker::<Robust>::new();
    /// let window = tracker.lock_window(Rect::new(0, 0, 160, 120), target);
    /// let pixels = read_out(window.into()); // your sensor sends only these pixels
    /// tracker.lock(&Frame::of_windows(&pixels, window, size)?, target)?;
    /// // For each frame:
    /// if let Some(windows) = tracker.windows() {
    ///     let pixels = read_out(windows);
    ///     let answer = tracker.update(&Frame::of_windows(&pixels, windows, size)?)?;
    ///     assert_eq!(answer.bbox, target);
    /// }
    /// # Ok::<(), smr_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`WindowError`].
    pub fn of_windows(
        pixels: &'a [u8],
        windows: impl Into<Windows>,
        (width, height): (u16, u16),
    ) -> Result<Self, WindowError> {
        let (first, second) = windows.into().split();
        let (image, x, y) = placed(pixels, first)?;
        let frame = Self::part(image, x, y, width, height).map_err(WindowError::Frame)?;
        let Some(second) = second else { return Ok(frame) };
        let (image, x, y) = placed(pixels.get(area(first)..).unwrap_or_default(), second)?;
        frame.and_part(image, x, y).map_err(WindowError::Frame)
    }

    /// The rectangle of the frame, at (0, 0).
    #[must_use]
    pub const fn bounds(&self) -> Rect {
        Rect::new(0, 0, self.width, self.height)
    }

    /// True if one part in memory contains all of `rect` (frame coordinates). False if `rect` is empty.
    #[must_use]
    pub fn covers(&self, rect: Rect) -> bool {
        self.patch(rect).is_some()
    }

    /// The pixels in `rect` (frame coordinates); `None` if no part in memory contains all of them.
    #[must_use]
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    pub fn patch(&self, rect: Rect) -> Option<Image<'a>> {
        self.first.patch(rect).or_else(|| self.second.as_ref()?.patch(rect))
    }
}

/// The image of a window, and the place of its top left pixel.
fn placed(pixels: &[u8], window: Rect) -> Result<(Image<'_>, u16, u16), WindowError> {
    let (Ok(x), Ok(y)) = (u16::try_from(window.x), u16::try_from(window.y)) else {
        return Err(WindowError::Frame(FrameError::OutsideFrame));
    };
    let image = Image::new(pixels, window.width, window.height).map_err(WindowError::Image)?;
    Ok((image, x, y))
}

impl<'a> From<Image<'a>> for Frame<'a> {
    fn from(image: Image<'a>) -> Self {
        Self::whole(image)
    }
}
