//! A view of borrowed gray pixels.

use super::Rect;
use core::fmt;

errors! {
    /// The reason why an [`Image`] was refused.
    ImageError {
        /// Width or height is 0.
        Empty => "the image has no pixels: width and height must be at least 1",
        /// The stride is smaller than the width.
        StrideTooSmall => "the stride is smaller than the width",
        /// The slice ends before the last pixel of the last row.
        SliceTooShort => "the slice is shorter than (height - 1) * stride + width bytes",
    }
}

/// A borrowed view of 8-bit gray pixels: width and height 1 to 65535, rows `stride` bytes apart.
///
/// ```
/// use smr_core::{Image, ImageError};
/// let sensor = [0u8; 8 * 4];
/// let image = Image::with_stride(&sensor, 6, 4, 8)?; // the last two bytes of each row are padding
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
    /// `height` rows of `width` pixels without gaps.
    ///
    /// # Errors
    /// [`ImageError::Empty`], [`ImageError::SliceTooShort`].
    pub const fn new(pixels: &'a [u8], width: u16, height: u16) -> Result<Self, ImageError> {
        Self::with_stride(pixels, width, height, width as usize)
    }

    /// `height` rows of `width` pixels, `stride` bytes apart. The slice need not contain the gap after the last row.
    ///
    /// # Errors
    /// All of [`ImageError`]; [`ImageError::SliceTooShort`] also if the size overflows a `usize`.
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
            // If the image has a single row, its stride is never used. The width replaces it, so that later arithmetic
            // cannot overflow.
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

    /// The `width` pixels of row `y`; empty if `y` >= height.
    #[must_use]
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    pub fn row(&self, y: u16) -> &'a [u8] {
        if y >= self.height {
            return &[];
        }
        self.rest(usize::from(y) * self.stride, usize::from(self.width))
    }

    /// All rows from the top, `width` pixels each.
    pub fn rows(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let width = usize::from(self.width);
        // `max` changes nothing, but lets the compiler drop the panic of `chunks` for a stride of 0.
        self.pixels
            .chunks(self.stride.max(1))
            .take(usize::from(self.height))
            .map(move |row| row.get(..width).unwrap_or_default())
    }

    /// The slice and the stride. Row y starts at byte y * stride; all rows lie within the slice.
    #[cfg_attr(not(any(target_arch = "x86_64", target_arch = "aarch64")), allow(dead_code))] // for addresses
    pub(crate) const fn parts(&self) -> (&'a [u8], usize) {
        (self.pixels, self.stride)
    }

    /// A view of the pixels inside `rect`, which is given in coordinates of this image. `None` if `rect` is empty or
    /// reaches outside the image.
    #[must_use]
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    pub fn crop(&self, rect: Rect) -> Option<Self> {
        let (x, y) = (place(rect.x, rect.width, self.width)?, place(rect.y, rect.height, self.height)?);
        let start = y * self.stride + x;
        Some(Self { pixels: self.pixels.get(start..)?, width: rect.width, height: rect.height, stride: self.stride })
    }

    /// Rows `first`, `first + step`, and so on; `None` if the image ends before `first`.
    #[cfg_attr(not(smr_small), inline)]
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

    /// The first `rows` rows; `None` if there are fewer, or if `rows` is 0.
    #[inline]
    pub(crate) fn first(&self, rows: usize) -> Option<Self> {
        let height = u16::try_from(rows).ok().filter(|rows| (1..=self.height).contains(rows))?;
        Some(Self { height, ..*self })
    }

    /// An image of `height` equal rows, each the first `width` pixels of `row`; `None` if `row` has fewer than `width`
    /// pixels. The stride is 0, which [`Image::rows`] does not support.
    #[cfg(not(smr_swar))]
    pub(crate) fn repeated(row: &'a [u8], width: u16, height: u16) -> Option<Self> {
        (row.len() >= width.into()).then_some(Self { pixels: row, width, height, stride: 0 })
    }

    /// An image of `pixels` with the size and stride of `self`; `None` if `pixels` is shorter than the slice of `self`.
    pub(crate) fn like<'b>(&self, pixels: &'b [u8]) -> Option<Image<'b>> {
        let Self { width, height, stride, .. } = *self;
        (pixels.len() >= self.pixels.len()).then_some(Image { pixels, width, height, stride })
    }

    fn rest(&self, start: usize, len: usize) -> &'a [u8] {
        self.pixels.get(start..).and_then(|rest| rest.get(..len)).unwrap_or_default()
    }
}

/// `at`, if `at..at + size` is not empty and lies within `0..all`.
fn place(at: i32, size: u16, all: u16) -> Option<usize> {
    let last = all.checked_sub(size)?;
    usize::try_from(at).ok().filter(|&at| at <= last.into() && size > 0)
}

impl fmt::Debug for Image<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Image({}x{}, stride {})", self.width, self.height, self.stride)
    }
}
