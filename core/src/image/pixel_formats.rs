//! The pixel formats of cameras, and their conversion to gray.

use super::Rect;

/// A camera's pixel format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Format {
    /// One gray byte per pixel.
    Gray8,
    /// Two bytes a pixel: Y U Y V. Gray is Y.
    Yuyv,
    /// Two bytes a pixel: U Y V Y. Gray is Y.
    Uyvy,
    /// Two bytes a pixel, the high byte first: five bits red, six green, five blue. Gray is `(19595 R + 38470 G + 7471
    /// B + 32768) >> 16`, with R, G and B widened to eight bits by repeating their high bits.
    Rgb565Be,
    /// Two bytes a pixel as in [`Format::Rgb565Be`], but the low byte first.
    Rgb565Le,
    /// Bayer mosaic of color filters in any order, one byte per pixel. Halves width and height: each 2x2 block becomes
    /// one gray pixel, `((a + b) / 2 + (c + d + 1) / 2) / 2` with a and b in the upper line, c and d in the lower.
    Bayer8,
    /// Four gray pixels of ten bits in five bytes (MIPI RAW10): four bytes of high bits, one of low bits (ignored).
    Gray10,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 7] =
        [Self::Gray8, Self::Yuyv, Self::Uyvy, Self::Rgb565Be, Self::Rgb565Le, Self::Bayer8, Self::Gray10];

    /// (width, height) of the gray frame from a sensor of (`columns`, `lines`) pixels.
    #[must_use]
    pub const fn gray_size(self, (columns, lines): (u16, u16)) -> (u16, u16) {
        match self {
            Self::Bayer8 => (columns / 2, lines / 2),
            _ => (columns, lines),
        }
    }

    /// The length in bytes of a line of `columns` pixels.
    #[must_use]
    pub const fn line_bytes(self, columns: u16) -> usize {
        let columns = columns as usize;
        match self {
            Self::Gray8 | Self::Bayer8 => columns,
            Self::Yuyv | Self::Uyvy | Self::Rgb565Be | Self::Rgb565Le => 2 * columns,
            Self::Gray10 => columns.div_ceil(4) * 5,
        }
    }

    const fn lines_a_row(self) -> u16 {
        if matches!(self, Self::Bayer8) { 2 } else { 1 }
    }

    /// The first sensor line of `window`, and the line after its last. Both fit in a `u16`, because the window is
    /// inside the frame.
    pub(super) fn lines_of(self, window: Rect) -> (u16, u16) {
        let top = u16::try_from(window.y).unwrap_or(u16::MAX);
        let lines = self.lines_a_row();
        (top.saturating_mul(lines), top.saturating_add(window.height).saturating_mul(lines))
    }

    pub(super) fn push(self, y: u16, bytes: &[u8], window: Rect, pixels: &mut [u8]) {
        let (start, end) = self.lines_of(window);
        if !(start..end).contains(&y) {
            return;
        }
        let (line, lines) = (y - start, self.lines_a_row());
        let width = usize::from(window.width);
        let start = usize::from(line / lines) * width;
        let row = pixels.get_mut(start..start + width).unwrap_or_default();
        self.convert(bytes, usize::try_from(window.x).unwrap_or(0), line.is_multiple_of(lines), row);
    }

    /// Converts `line` into `gray`, from gray column `x` on. `is_upper` is false only for a Bayer block's lower line.
    fn convert(self, line: &[u8], x: usize, is_upper: bool, gray: &mut [u8]) {
        let from = |start: usize| line.get(start..).unwrap_or(&[]);
        match self {
            Self::Gray8 => fill(gray, from(x).iter().copied()),
            Self::Yuyv => fill(gray, from(2 * x).iter().step_by(2).copied()),
            Self::Uyvy => fill(gray, from(2 * x + 1).iter().step_by(2).copied()),
            Self::Rgb565Be => fill(gray, from(2 * x).as_chunks().0.iter().map(|&pair| luma(u16::from_be_bytes(pair)))),
            Self::Rgb565Le => fill(gray, from(2 * x).as_chunks().0.iter().map(|&pair| luma(u16::from_le_bytes(pair)))),
            Self::Bayer8 => {
                for (gray, &[left, right]) in gray.iter_mut().zip(from(2 * x).as_chunks().0) {
                    let sum = u16::from(left) + u16::from(right);
                    let mean = if is_upper { sum / 2 } else { (u16::from(*gray) + sum.div_ceil(2)) / 2 };
                    *gray = mean.to_le_bytes()[0];
                }
            }
            // Each group of four pixels has four bytes of high bits, then one byte of low bits.
            Self::Gray10 => fill(gray, (x..).map(|x| line.get(x / 4 * 5 + x % 4).copied().unwrap_or(0))),
        }
    }
}

#[inline(always)] // one loop for each format
fn fill(gray: &mut [u8], levels: impl Iterator<Item = u8>) {
    gray.iter_mut().zip(levels).for_each(|(gray, level)| *gray = level);
}

/// The gray level of an RGB565 pixel. The weights add up to 65536, so the sum fits 24 bits.
fn luma(rgb: u16) -> u8 {
    let (red, green, blue) = (u32::from(rgb >> 11), u32::from(rgb >> 5 & 63), u32::from(rgb & 31));
    let (red, green, blue) = (red << 3 | red >> 2, green << 2 | green >> 4, blue << 3 | blue >> 2);
    let sum = 19_595 * red + 38_470 * green + 7_471 * blue + 32_768;
    sum.to_le_bytes()[2]
}
