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
            Self::Gray8 => copy(gray, from(x)),
            Self::Yuyv => every_second(gray, from(2 * x), |[y, _]| y),
            Self::Uyvy => every_second(gray, from(2 * x), |[_, y]| y),
            Self::Rgb565Be => fill(gray, from(2 * x).as_chunks().0.iter().map(|&pair| luma(u16::from_be_bytes(pair)))),
            Self::Rgb565Le => fill(gray, from(2 * x).as_chunks().0.iter().map(|&pair| luma(u16::from_le_bytes(pair)))),
            Self::Bayer8 if is_upper => blocks(gray, from(2 * x), |_, blocks| means(blocks, 0)),
            Self::Bayer8 => blocks(gray, from(2 * x), lower_means),
            Self::Gray10 => packed(gray, line, x),
        }
    }
}

fn copy(gray: &mut [u8], line: &[u8]) {
    if let Some(line) = line.get(..gray.len()) {
        gray.copy_from_slice(line);
    }
}

#[inline(always)] // one loop for each format
fn fill(gray: &mut [u8], levels: impl Iterator<Item = u8>) {
    gray.iter_mut().zip(levels).for_each(|(gray, level)| *gray = level);
}

/// Takes one byte of each two. Handles four pixels at once, because a loop costs more than one pixel does.
#[inline(always)] // one loop for each format
fn every_second(gray: &mut [u8], line: &[u8], of: impl Fn([u8; 2]) -> u8) {
    let ((fours, last), (eights, _)) = (gray.as_chunks_mut(), line.as_chunks());
    for (gray, &[a, b, c, d, e, f, g, h]) in fours.iter_mut().zip(eights) {
        *gray = [of([a, b]), of([c, d]), of([e, f]), of([g, h])];
    }
    let rest = line.get(8 * fours.len()..).unwrap_or_default();
    fill(last, rest.as_chunks().0.iter().map(|&pair| of(pair)));
}

/// Converts a line of 2x2 blocks, four at once: `of` computes four gray levels from the present ones and eight bytes.
#[inline(always)] // one loop for each line of a block
fn blocks(gray: &mut [u8], line: &[u8], of: impl Fn([u8; 4], [u8; 8]) -> [u8; 4]) {
    let ((fours, last), (eights, _)) = (gray.as_chunks_mut(), line.as_chunks());
    fours.iter_mut().zip(eights).for_each(|(gray, &blocks)| *gray = of(*gray, blocks));
    let rest = line.get(8 * fours.len()..).unwrap_or_default();
    for (gray, &[a, b]) in last.iter_mut().zip(rest.as_chunks().0) {
        [*gray, ..] = of([*gray, 0, 0, 0], [a, b, 0, 0, 0, 0, 0, 0]);
    }
}

/// The means of four pairs. `up` is 0 to round down, 0x0001_0001 to round up.
#[inline(always)] // see `blocks`
fn means([a, b, c, d, e, f, g, h]: [u8; 8], up: u32) -> [u8; 4] {
    // Bits 0 to 7 and 16 to 23 have the means of two pairs each.
    let two = |pairs: u32| ((pairs & 0x00FF_00FF) + (pairs >> 8 & 0x00FF_00FF) + up) >> 1 & 0x00FF_00FF;
    let (left, right) = (two(u32::from_le_bytes([a, b, c, d])), two(u32::from_le_bytes([e, f, g, h])));
    ((left | left >> 8) & 0xFFFF | (right | right >> 8) << 16).to_le_bytes()
}

/// The gray levels of four blocks: means of the upper line's means, rounded down, and the lower line's, rounded up.
#[inline(always)] // see `blocks`
fn lower_means(upper: [u8; 4], blocks: [u8; 8]) -> [u8; 4] {
    let (upper, lower) = (u32::from_le_bytes(upper), u32::from_le_bytes(means(blocks, 0x0001_0001)));
    // The mean of two bytes, rounded down: the bits that both have, and half of the others.
    ((upper & lower) + ((upper ^ lower) >> 1 & 0x7F7F_7F7F)).to_le_bytes()
}

/// Pixels in groups: four bytes of high bits, then one byte of low bits. `x` is the first pixel.
fn packed(gray: &mut [u8], line: &[u8], x: usize) {
    let begun = gray.len().min(x.next_multiple_of(4) - x);
    let (first, gray) = gray.split_at_mut_checked(begun).unwrap_or_default();
    fill(first, line.get(x / 4 * 5 + x % 4..).unwrap_or_default().iter().copied());
    let groups = line.get(x.div_ceil(4) * 5..).unwrap_or_default();
    let (fours, last) = gray.as_chunks_mut();
    for (gray, &[a, b, c, d, _]) in fours.iter_mut().zip(groups.as_chunks().0) {
        *gray = [a, b, c, d];
    }
    fill(last, groups.get(5 * fours.len()..).unwrap_or_default().iter().copied());
}

/// The gray level of an RGB565 pixel. The weights add up to 65536, so the sum fits 24 bits.
fn luma(rgb: u16) -> u8 {
    let (red, green, blue) = (u32::from(rgb >> 11), u32::from(rgb >> 5 & 63), u32::from(rgb & 31));
    let (red, green, blue) = (red << 3 | red >> 2, green << 2 | green >> 4, blue << 3 | blue >> 2);
    let sum = 19_595 * red + 38_470 * green + 7_471 * blue + 32_768;
    sum.to_le_bytes()[2]
}
