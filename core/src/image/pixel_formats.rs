//! The pixel formats of cameras, and their conversion to gray.

use super::Rect;
use core::fmt;
use core::num::NonZeroU16;

/// The bytes of a pixel, or of a group of four.
#[derive(Clone, Copy)]
enum Bytes {
    APixel(u8),
    FourPixels(u8),
}

/// The columns and lines of which a pixel of a shrunk frame is the mean: see [`Format::shrunk`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Shrink {
    /// The frame keeps its size.
    By1 = 1,
    /// Means of 2x2 pixels.
    By2,
    /// Means of 3x3 pixels.
    By3,
    /// Means of 4x4 pixels.
    By4,
}

/// A camera's pixel format: one of the constants, and by how much its frames are to be shrunk. A program links only the
/// formats that it names.
#[derive(Clone, Copy)]
pub struct Format {
    name: &'static str,
    bytes: Bytes,
    /// Columns and lines of a gray pixel: 2 if true, else 1.
    is_mosaic: bool,
    shrink: Shrink,
    /// Converts a line into gray pixels, from a gray column on. The flag is false only for the lower line of a block.
    convert: fn(&[u8], usize, bool, &mut [u8]),
}

impl Format {
    /// One gray byte per pixel.
    pub const GRAY8: Self = Self::new("GRAY8", Bytes::APixel(1), |line, x, _, gray| copy(gray, from(line, x)));
    /// Two bytes a pixel: Y U Y V. Gray is Y.
    pub const YUYV: Self =
        Self::new("YUYV", Bytes::APixel(2), |line, x, _, gray| every_second(gray, from(line, 2 * x), |[y, _]| y));
    /// Two bytes a pixel: U Y V Y. Gray is Y.
    pub const UYVY: Self =
        Self::new("UYVY", Bytes::APixel(2), |line, x, _, gray| every_second(gray, from(line, 2 * x), |[_, y]| y));
    /// Two bytes a pixel, the high byte first: five bits red, six green, five blue. Gray is `(19595 R + 38470 G + 7471
    /// B + 32768) >> 16`, with R, G and B widened to eight bits by repeating their high bits.
    pub const RGB565_BE: Self = Self::new("RGB565_BE", Bytes::APixel(2), |line, x, _, gray| {
        fill(gray, from(line, 2 * x).as_chunks().0.iter().map(|&pair| luma(u16::from_be_bytes(pair))));
    });
    /// Two bytes a pixel as in [`Format::RGB565_BE`], but the low byte first.
    pub const RGB565_LE: Self = Self::new("RGB565_LE", Bytes::APixel(2), |line, x, _, gray| {
        fill(gray, from(line, 2 * x).as_chunks().0.iter().map(|&pair| luma(u16::from_le_bytes(pair))));
    });
    /// Bayer mosaic of color filters in any order, one byte per pixel. Halves width and height: each 2x2 block becomes
    /// one gray pixel, `((a + b) / 2 + (c + d + 1) / 2) / 2` with a and b in the upper line, c and d in the lower.
    pub const BAYER8: Self = Self {
        is_mosaic: true,
        ..Self::new("BAYER8", Bytes::APixel(1), |line, x, is_upper, gray| {
            let line = from(line, 2 * x);
            if is_upper { blocks(gray, line, |_, blocks| means(blocks, 0)) } else { blocks(gray, line, lower_means) }
        })
    };
    /// Four gray pixels of ten bits in five bytes (MIPI RAW10): four bytes of high bits, one of low bits (ignored).
    pub const GRAY10: Self = Self::new("GRAY10", Bytes::FourPixels(5), |line, x, _, gray| packed(gray, line, x));

    /// All formats.
    pub const ALL: [Self; 7] =
        [Self::GRAY8, Self::YUYV, Self::UYVY, Self::RGB565_BE, Self::RGB565_LE, Self::BAYER8, Self::GRAY10];

    const fn new(name: &'static str, bytes: Bytes, convert: fn(&[u8], usize, bool, &mut [u8])) -> Self {
        Self { name, bytes, is_mosaic: false, shrink: Shrink::By1, convert }
    }

    /// This format with frames that are shrunk as their lines arrive, so that a large target needs a small buffer: a
    /// pixel is the mean of n x n gray pixels (n is 1 to 4). Windows, box and answers are then in pixels of the small
    /// frame, and rests of the sensor's size are dropped.
    ///
    /// The first of the n lines of a block stores the means of n pixels, rounded. The k-th moves the stored pixel by
    /// the k-th part of its difference to the mean of the new line, `(difference * ceil(65536 / k) + 32768) >> 16`. The
    /// result is at most 1.0, 1.4 or 1.7 gray levels from the exact mean (n = 2, 3, 4). Of a mosaic, the 2n lines of a
    /// block are averaged so, each from the means of its pairs: at most 2.2, 2.8 or 3.2 gray levels.
    #[must_use]
    pub const fn shrunk(self, shrink: Shrink) -> Self {
        Self { shrink, ..self }
    }

    /// (width, height) of the gray frame from a sensor of (`columns`, `lines`) pixels.
    #[must_use]
    pub const fn gray_size(self, (columns, lines): (u16, u16)) -> (u16, u16) {
        let side = self.lines_a_row().get();
        (columns / side, lines / side)
    }

    /// The sensor's lines, and columns, of a gray pixel: 1 to 8.
    const fn lines_a_row(self) -> NonZeroU16 {
        let side = match self.shrink {
            Shrink::By1 => NonZeroU16::MIN,
            Shrink::By2 => NonZeroU16::MIN.saturating_add(1),
            Shrink::By3 => NonZeroU16::MIN.saturating_add(2),
            Shrink::By4 => NonZeroU16::MIN.saturating_add(3),
        };
        if self.is_mosaic { side.saturating_add(side.get()) } else { side }
    }

    /// The length in bytes of a line of `columns` pixels.
    #[must_use]
    pub const fn line_bytes(self, columns: u16) -> usize {
        match self.bytes {
            Bytes::APixel(bytes) => columns as usize * bytes as usize,
            Bytes::FourPixels(bytes) => (columns as usize).div_ceil(4) * bytes as usize,
        }
    }

    /// The first sensor line of `window`, and the line after its last. Both fit in a `u16`, because the window is
    /// inside the frame.
    pub(super) fn lines_of(self, window: Rect) -> (u16, u16) {
        let top = u16::try_from(window.y).unwrap_or(u16::MAX);
        let lines = self.lines_a_row().get();
        (top.saturating_mul(lines), top.saturating_add(window.height).saturating_mul(lines))
    }

    pub(super) fn push(self, y: u16, bytes: &[u8], window: Rect, pixels: &mut [u8]) {
        let (start, end) = self.lines_of(window);
        if !(start..end).contains(&y) {
            return;
        }
        let (line, lines) = (y - start, self.lines_a_row());
        let (width, x) = (usize::from(window.width), usize::try_from(window.x).unwrap_or(0));
        let start = usize::from(line / lines) * width;
        let row = pixels.get_mut(start..start + width).unwrap_or_default();
        match self.shrink {
            Shrink::By1 => (self.convert)(bytes, x, line % lines == 0, row),
            _ => self.add_line(bytes, x, line % lines, row),
        }
    }

    /// Adds a line of the sensor, the `number`-th of its blocks from 0, to the means in `row`, whose first pixel is in
    /// column `x`.
    fn add_line(self, bytes: &[u8], x: usize, number: u16, row: &mut [u8]) {
        const AT_ONCE: usize = 16;
        let side = usize::from(self.shrink as u8).max(1);
        let share = |of: usize| SHARES.get(of).copied().unwrap_or_default();
        let (of_pixels, of_lines) = (share(side - 1), share(number.into()));
        let mut gray = [0; 4 * AT_ONCE];
        for (part, means) in row.chunks_mut(AT_ONCE).enumerate() {
            let gray = gray.get_mut(..side * means.len()).unwrap_or_default();
            (self.convert)(bytes, side * (x + AT_ONCE * part), true, gray);
            for (mean, block) in means.iter_mut().zip(gray.chunks_exact(side)) {
                let sum: i32 = block.iter().copied().map(i32::from).sum();
                let step = rounded(sum * of_pixels) - i32::from(*mean);
                [*mean, ..] = (i32::from(*mean) + rounded(step * of_lines)).to_le_bytes();
            }
        }
    }
}

/// 65536 / 1 to 65536 / 8, rounded up.
const SHARES: [i32; 8] = [65_536, 32_768, 21_846, 16_384, 13_108, 10_923, 9_363, 8_192];

const fn rounded(number: i32) -> i32 {
    (number + 32_768) >> 16
}

impl PartialEq for Format {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.shrink == other.shrink
    }
}

impl Eq for Format {}

impl fmt::Debug for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.shrink {
            Shrink::By1 => formatter.write_str(self.name),
            shrink => write!(formatter, "{} shrunk {shrink:?}", self.name),
        }
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Format {
    fn format(&self, formatter: defmt::Formatter<'_>) {
        defmt::write!(formatter, "{=str} shrunk {}", self.name, self.shrink);
    }
}

fn from(line: &[u8], start: usize) -> &[u8] {
    line.get(start..).unwrap_or_default()
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
