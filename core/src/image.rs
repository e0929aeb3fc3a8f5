//! What the tracker looks at: a borrowed 8-bit [`Image`], the [`Frame`] it shows (wholly or in part), and [`Rect`].
//!
//! Sizes are checked once, when a view is made; everything after that reads without being able to fail.

use core::fmt;

/// A rectangle in whole pixels of the frame: left, top, width, height. It may reach outside the frame.
///
/// ```
/// use smr_core::Rect;
/// let target = Rect::new(-3, 5, 10, 8);
/// assert_eq!((target.right(), target.bottom()), (7, 13));
/// assert_eq!(target.intersection(Rect::new(0, 0, 64, 48)), Rect::new(0, 5, 7, 8));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rect {
    /// Left edge, in pixels to the right of the frame's left edge.
    pub x: i32,
    /// Top edge, in pixels below the frame's top edge.
    pub y: i32,
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
}

impl Rect {
    /// The rectangle with its top left corner at (`x`, `y`).
    #[must_use]
    pub const fn new(x: i32, y: i32, width: u16, height: u16) -> Self {
        Self { x, y, width, height }
    }

    /// The first column to the right of the rectangle. Saturates at `i32::MAX`.
    #[must_use]
    pub const fn right(self) -> i32 {
        self.x.saturating_add(self.width as i32)
    }

    /// The first row below the rectangle. Saturates at `i32::MAX`.
    #[must_use]
    pub const fn bottom(self) -> i32 {
        self.y.saturating_add(self.height as i32)
    }

    /// Pixels in the rectangle.
    #[must_use]
    pub const fn area(self) -> u32 {
        self.width as u32 * self.height as u32
    }

    /// True if it holds no pixel.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// True if every pixel of `inner` is also one of `self`. An empty `inner` is contained nowhere.
    #[must_use]
    pub const fn contains(self, inner: Self) -> bool {
        !inner.is_empty()
            && inner.x >= self.x
            && inner.y >= self.y
            && inner.right() <= self.right()
            && inner.bottom() <= self.bottom()
    }

    /// The pixels common to both; the empty rectangle at the origin if there are none.
    #[must_use]
    pub fn intersection(self, other: Self) -> Self {
        let (left, right) = (self.x.max(other.x), self.right().min(other.right()));
        let (top, bottom) = (self.y.max(other.y), self.bottom().min(other.bottom()));
        match (extent(left, right), extent(top, bottom)) {
            (Some(width), Some(height)) => Self::new(left, top, width, height),
            _ => Self::default(),
        }
    }
}

/// The size of `from..to` where it is one: more than zero, and a `u16`.
fn extent(from: i32, to: i32) -> Option<u16> {
    u16::try_from(to.checked_sub(from)?).ok().filter(|&size| size > 0)
}

/// Why bytes are not an [`Image`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ImageError {
    /// Width or height is zero.
    Empty,
    /// The stride is smaller than the width.
    StrideTooSmall,
    /// The slice ends before the last pixel of the last row.
    SliceTooShort,
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "the image has no pixels: width and height must be at least 1",
            Self::StrideTooSmall => "the stride is smaller than the width",
            Self::SliceTooShort => "the slice is shorter than (height - 1) * stride + width bytes",
        })
    }
}

impl core::error::Error for ImageError {}

/// A borrowed view of 8-bit gray pixels: 1..=65535 wide and high, rows `stride` bytes apart.
///
/// ```
/// use smr_core::{Image, ImageError};
/// let sensor = [0u8; 8 * 4];
/// let image = Image::with_stride(&sensor, 6, 4, 8)?; // two bytes of every row are not part of the picture
/// assert_eq!(image.row(3).len(), 6);
/// assert_eq!(Image::new(&sensor, 8, 5).err(), Some(ImageError::SliceTooShort));
/// # Ok::<(), ImageError>(())
/// ```
#[derive(Clone, Copy)]
pub struct Image<'a> {
    pixels: &'a [u8],
    width: u16,
    height: u16,
    stride: usize,
}

impl<'a> Image<'a> {
    /// `height` rows of `width` pixels, one after the other without a gap.
    ///
    /// # Errors
    /// [`ImageError::Empty`], [`ImageError::SliceTooShort`].
    pub const fn new(pixels: &'a [u8], width: u16, height: u16) -> Result<Self, ImageError> {
        Self::with_stride(pixels, width, height, width as usize)
    }

    /// `height` rows of `width` pixels, each `stride` bytes after the one before. The last row may end with its last
    /// pixel.
    ///
    /// # Errors
    /// All of [`ImageError`]. A size that a `usize` cannot hold is a slice too short.
    pub const fn with_stride(pixels: &'a [u8], width: u16, height: u16, stride: usize) -> Result<Self, ImageError> {
        if width == 0 || height == 0 {
            return Err(ImageError::Empty);
        }
        if stride < width as usize {
            return Err(ImageError::StrideTooSmall);
        }
        let Some(last_row) = (height as usize - 1).checked_mul(stride) else {
            return Err(ImageError::SliceTooShort);
        };
        match last_row.checked_add(width as usize) {
            // Of a single row the stride says nothing: without it, later arithmetic cannot overflow.
            Some(needed) if needed <= pixels.len() && height == 1 => {
                Ok(Self { pixels, width, height, stride: width as usize })
            }
            Some(needed) if needed <= pixels.len() => Ok(Self { pixels, width, height, stride }),
            _ => Err(ImageError::SliceTooShort),
        }
    }

    /// Width in pixels.
    #[must_use]
    pub const fn width(&self) -> u16 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub const fn height(&self) -> u16 {
        self.height
    }

    /// Row `y`, `width` pixels; empty if there is no such row.
    #[must_use]
    pub fn row(&self, y: u16) -> &'a [u8] {
        if y >= self.height {
            return &[];
        }
        self.rest(usize::from(y) * self.stride, usize::from(self.width))
    }

    /// All rows from the top, `width` pixels each.
    pub fn rows(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let width = usize::from(self.width);
        // The stride is never 0; saying so here removes the check (and its panic) from `chunks`.
        self.pixels
            .chunks(self.stride.max(1))
            .take(usize::from(self.height))
            .map(move |row| row.get(..width).unwrap_or_default())
    }

    /// The slice and the stride: row y of `width` pixels starts at byte y * stride, and all rows lie within the slice.
    #[cfg_attr(not(any(target_arch = "x86_64", target_arch = "aarch64")), allow(dead_code))] // for backends that go by addresses
    pub(crate) const fn parts(&self) -> (&'a [u8], usize) {
        (self.pixels, self.stride)
    }

    /// The part of the picture that `rect` covers, in the image's own coordinates; `None` if it reaches outside.
    #[must_use]
    pub fn crop(&self, rect: Rect) -> Option<Self> {
        if !Rect::new(0, 0, self.width, self.height).contains(rect) {
            return None;
        }
        let start = usize::try_from(rect.y).ok()? * self.stride + usize::try_from(rect.x).ok()?;
        Some(Self { pixels: self.pixels.get(start..)?, width: rect.width, height: rect.height, stride: self.stride })
    }

    /// Every `step`-th row from row `first` on; `None` if there is none.
    pub(crate) fn every(&self, first: usize, step: usize) -> Option<Self> {
        let rows = usize::from(self.height).checked_sub(first)?.div_ceil(step.max(1));
        let height = u16::try_from(rows).ok().filter(|&rows| rows > 0)?;
        Some(Self {
            pixels: self.pixels.get(first * self.stride..)?,
            height,
            stride: self.stride.saturating_mul(step),
            ..*self
        })
    }

    /// A picture of this shape in other bytes; `None` if they are fewer.
    pub(crate) fn like<'b>(&self, pixels: &'b [u8]) -> Option<Image<'b>> {
        let Self { width, height, stride, .. } = *self;
        (pixels.len() >= self.pixels.len()).then_some(Image { pixels, width, height, stride })
    }

    fn rest(&self, start: usize, len: usize) -> &'a [u8] {
        self.pixels.get(start..).and_then(|rest| rest.get(..len)).unwrap_or_default()
    }
}

impl fmt::Debug for Image<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Image({}x{}, stride {})", self.width, self.height, self.stride)
    }
}

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

/// One frame of the camera: its size, and the part of it that is in memory.
///
/// A whole frame is [`Frame::whole`]. Firmware that reads out only what the tracker asks for gives [`Frame::part`]: the
/// tracker speaks in coordinates of the frame all the same.
///
/// ```
/// use smr_core::{Frame, Image, Rect};
/// let readout = [0u8; 96 * 96];
/// // A 96x96 window of a 320x240 sensor, its corner at (100, 40).
/// let frame = Frame::part(Image::new(&readout, 96, 96)?, 100, 40, 320, 240)?;
/// assert_eq!(frame.bounds(), Rect::new(0, 0, 320, 240));
/// assert_eq!(frame.covered(), Rect::new(100, 40, 96, 96));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    image: Image<'a>,
    x: u16,
    y: u16,
    width: u16,
    height: u16,
}

impl<'a> Frame<'a> {
    /// A frame that is in memory as a whole.
    #[must_use]
    pub const fn whole(image: Image<'a>) -> Self {
        Self { image, x: 0, y: 0, width: image.width, height: image.height }
    }

    /// The part of a `width` x `height` frame whose top left pixel is pixel (`x`, `y`) of the frame.
    ///
    /// # Errors
    /// [`FrameError::OutsideFrame`] if `image` does not lie within the frame.
    pub const fn part(image: Image<'a>, x: u16, y: u16, width: u16, height: u16) -> Result<Self, FrameError> {
        let fits_x = x as u32 + image.width as u32 <= width as u32;
        let fits_y = y as u32 + image.height as u32 <= height as u32;
        if fits_x && fits_y { Ok(Self { image, x, y, width, height }) } else { Err(FrameError::OutsideFrame) }
    }

    /// The frame's own rectangle, at (0, 0).
    #[must_use]
    pub const fn bounds(&self) -> Rect {
        Rect::new(0, 0, self.width, self.height)
    }

    /// The part of the frame that is in memory.
    #[must_use]
    pub const fn covered(&self) -> Rect {
        Rect::new(self.x as i32, self.y as i32, self.image.width, self.image.height)
    }

    /// The pixels in `rect` (frame coordinates), or `None` where one of them is not in memory.
    #[must_use]
    pub fn patch(&self, rect: Rect) -> Option<Image<'a>> {
        let x = rect.x.checked_sub(i32::from(self.x))?;
        let y = rect.y.checked_sub(i32::from(self.y))?;
        self.image.crop(Rect { x, y, ..rect })
    }
}

impl<'a> From<Image<'a>> for Frame<'a> {
    fn from(image: Image<'a>) -> Self {
        Self::whole(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::{vec, vec::Vec};

    #[test]
    fn what_is_not_an_image_is_refused() {
        let pixels = [0; 12];
        assert_eq!(Image::new(&pixels, 0, 4).unwrap_err(), ImageError::Empty);
        assert_eq!(Image::new(&pixels, 4, 0).unwrap_err(), ImageError::Empty);
        assert_eq!(Image::new(&[], 1, 1).unwrap_err(), ImageError::SliceTooShort);
        assert_eq!(Image::with_stride(&pixels, 4, 3, 3).unwrap_err(), ImageError::StrideTooSmall);
        assert_eq!(Image::with_stride(&pixels, 4, 3, 5).unwrap_err(), ImageError::SliceTooShort);
        assert_eq!(Image::with_stride(&pixels, 1, 65535, usize::MAX).unwrap_err(), ImageError::SliceTooShort);
        assert!(Image::with_stride(&pixels, 2, 3, 5).is_ok(), "the last row may end with its last pixel");
        let row = Image::with_stride(&pixels, 4, 1, usize::MAX).unwrap();
        assert_eq!(
            row.every(0, 2).and_then(|row| row.crop(Rect::new(1, 0, 2, 1))).map(|row| row.row(0).len()),
            Some(2)
        );
        assert!(Image::with_stride(&pixels, 4, 1, usize::MAX).is_ok(), "one row needs no stride");
    }

    #[test]
    fn the_largest_sizes_work() {
        let pixels = vec![3; 65535];
        for (width, height) in [(65535, 1), (1, 65535)] {
            let image = Image::new(&pixels, width, height).unwrap();
            assert_eq!(image.rows().map(<[u8]>::len).sum::<usize>(), 65535);
            let corner = Rect::new(i32::from(width) - 1, i32::from(height) - 1, 1, 1);
            assert_eq!(image.crop(corner).unwrap().row(0), [3]);
            assert!(Frame::part(image, 0, 0, 65535, 65535).is_ok());
            assert!(Frame::part(image, 65535, 65535, 65535, 65535).is_err());
        }
    }

    fn any_rect() -> impl Strategy<Value = Rect> {
        (-12i32..12, -12i32..12, 0u16..12, 0u16..12).prop_map(|(x, y, width, height)| Rect { x, y, width, height })
    }

    fn pixels_of(rect: Rect) -> Vec<(i32, i32)> {
        (rect.y..rect.bottom()).flat_map(|y| (rect.x..rect.right()).map(move |x| (x, y))).collect()
    }

    proptest! {
        #[test]
        fn rectangles_are_sets_of_pixels(a in any_rect(), b in any_rect()) {
            let common: Vec<_> = pixels_of(a).into_iter().filter(|at| pixels_of(b).contains(at)).collect();
            prop_assert_eq!(pixels_of(a.intersection(b)), common.clone());
            prop_assert_eq!(a.contains(b), !b.is_empty() && common.len() == pixels_of(b).len());
            prop_assert_eq!(pixels_of(a).len(), a.area() as usize);
        }

        #[test]
        fn no_rectangle_overflows(
            a in any::<(i32, i32, u16, u16)>(),
            b in any::<(i32, i32, u16, u16)>(),
            pixels in prop::collection::vec(any::<u8>(), 100),
        ) {
            let (a, b) = (Rect::new(a.0, a.1, a.2, a.3), Rect::new(b.0, b.1, b.2, b.3));
            let common = a.intersection(b);
            prop_assert!(common.is_empty() || (a.contains(common) && b.contains(common)));
            let frame = Frame::part(Image::new(&pixels, 10, 10).unwrap(), 65525, 65525, 65535, 65535).unwrap();
            prop_assert_eq!(frame.patch(a).is_some(), frame.covered().contains(a));
        }

        #[test]
        fn rows_and_crops_are_the_pixels_at_their_place(
            (width, height, gap) in (1u16..9, 1u16..9, 0usize..4),
            rect in any_rect(),
            pixels in prop::collection::vec(any::<u8>(), 0..100),
        ) {
            let stride = usize::from(width) + gap;
            let needed = (usize::from(height) - 1) * stride + usize::from(width);
            let image = Image::with_stride(&pixels, width, height, stride);
            prop_assert_eq!(image.is_ok(), pixels.len() >= needed);
            let Ok(image) = image else { return Ok(()) };
            let expected: Vec<Vec<u8>> = (0..usize::from(height))
                .map(|y| pixels[y * stride..][..usize::from(width)].to_vec())
                .collect();
            prop_assert_eq!(image.rows().map(<[u8]>::to_vec).collect::<Vec<_>>(), expected.clone());
            prop_assert_eq!((0..height).map(|y| image.row(y).to_vec()).collect::<Vec<_>>(), expected.clone());
            prop_assert!(image.row(height).is_empty());

            let crop = image.crop(rect);
            prop_assert_eq!(crop.is_some(), Rect::new(0, 0, width, height).contains(rect));
            if let Some(crop) = crop {
                let (x, y) = (rect.x as usize, rect.y as usize);
                for (row, full) in crop.rows().zip(&expected[y..]) {
                    prop_assert_eq!(row, &full[x..x + usize::from(rect.width)]);
                }
                prop_assert_eq!(crop.rows().count(), usize::from(rect.height));
            }
        }
    }
}
