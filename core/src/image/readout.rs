//! Reads a camera's lines, as they come and in the camera's pixel format, into the gray windows that a tracker needs.
//!
//! A camera sends a line at a time, often in color. There is no need for a gray copy of the whole frame:
//! [`Tracker::window`] says which pixels the next update reads, and [`Readout`] keeps only those.
//!
//! ```
//! use smr_core::readout::{Format, Readout};
//! use smr_core::{Rect, Robust, Tracker, robust};
//!
//! # fn camera_line(_y: u16) -> [u8; 640] { [90; 640] }
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! let mut tracker = Tracker::<Robust>::new();
//! let mut pixels = [0; 320 * 240];
//!
//! // A camera of 320x240 that sends YUYV. The lock reads the pixels around the box.
//! let (sensor, target) = (Rect::new(0, 0, 320, 240), Rect::new(100, 80, 40, 48));
//! let mut readout = Readout::new(Format::Yuyv, (320, 240), tracker.lock_window(sensor, target), &mut pixels)?;
//! for y in 0..240 {
//!     readout.push_line(y, &camera_line(y))?; // in the interrupt of the DMA
//! }
//! tracker.lock(&readout.frame()?, target)?;
//!
//! // The next frame: only what the update reads is converted and kept.
//! let window = tracker.window().expect("there is a target");
//! let mut readout = Readout::new(Format::Yuyv, (320, 240), window, &mut pixels)?;
//! for y in 0..240 {
//!     readout.push_line(y, &camera_line(y))?;
//! }
//! let answer = tracker.update(&readout.frame()?)?;
//! # let _ = answer;
//! # Ok(())
//! # }
//! ```
//!
//! While a target is lost, the robust tracker reads a second window: [`Readout::and_window`] with
//! [`Tracker::sweep_window`].
//!
//! # Cost
//!
//! Instructions a gray pixel on a Cortex-M4, with all calls for a row of 64 pixels (`examples/kernels` in QEMU):
//!
//! | gray 8 | YUYV, UYVY | RGB565, low byte first | high byte first | Bayer (two lines) | packed 10 bits |
//! |---|---|---|---|---|---|
//! | 4.5 | 5.9 | 19.2 | 20.7 | 31.6 | 13.2 |
//!
//! [`Tracker::window`]: crate::Tracker::window
//! [`Tracker::sweep_window`]: crate::Tracker::sweep_window

use super::{Frame, Image, Rect};
use core::fmt;

/// How a camera sends its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Format {
    /// One byte a pixel, gray.
    Gray8,
    /// Two bytes a pixel: Y U Y V. Gray is Y.
    Yuyv,
    /// Two bytes a pixel: U Y V Y. Gray is Y.
    Uyvy,
    /// Two bytes a pixel, the high byte first: five bits red, six green, five blue. Gray is `(19595 R + 38470 G + 7471
    /// B + 32768) >> 16`, with R, G and B widened to eight bits by repeating their high bits.
    Rgb565Be,
    /// The same with the low byte first.
    Rgb565Le,
    /// One byte a pixel behind a mosaic of color filters, in any order of the filters. Each 2x2 pixels become one gray
    /// pixel, so the gray frame has half the width and half the height: `((a + b) / 2 + (c + d + 1) / 2) / 2` of a and
    /// b in the upper line, c and d below.
    Bayer8,
    /// Four gray pixels of ten bits in five bytes (MIPI RAW10): the high eight bits of each, then the low two bits of
    /// all four, which are left out.
    Gray10,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 7] =
        [Self::Gray8, Self::Yuyv, Self::Uyvy, Self::Rgb565Be, Self::Rgb565Le, Self::Bayer8, Self::Gray10];

    /// Width and height of the gray frame of a sensor with this many columns and lines.
    #[must_use]
    pub const fn gray_size(self, (columns, lines): (u16, u16)) -> (u16, u16) {
        match self {
            Self::Bayer8 => (columns / 2, lines / 2),
            _ => (columns, lines),
        }
    }

    /// Bytes of a line with this many columns.
    #[must_use]
    pub const fn line_bytes(self, columns: u16) -> usize {
        let columns = columns as usize;
        match self {
            Self::Gray8 | Self::Bayer8 => columns,
            Self::Yuyv | Self::Uyvy | Self::Rgb565Be | Self::Rgb565Le => 2 * columns,
            Self::Gray10 => columns.div_ceil(4) * 5,
        }
    }

    /// Lines of the sensor that make one gray row.
    const fn lines_a_row(self) -> u16 {
        if matches!(self, Self::Bayer8) { 2 } else { 1 }
    }

    /// The first of the sensor's lines in a window, and the one after the last. The window is inside the frame, so both
    /// fit.
    fn lines_of(self, window: Rect) -> (u16, u16) {
        let top = u16::try_from(window.y).unwrap_or(u16::MAX);
        let lines = self.lines_a_row();
        (top.saturating_mul(lines), top.saturating_add(window.height).saturating_mul(lines))
    }

    /// Converts the pixels of line `y` that are in a window.
    fn push(self, y: u16, bytes: &[u8], window: Rect, pixels: &mut [u8]) {
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

    /// Converts gray pixels from column `x` on. `line` is long enough. `is_upper`: it is the first of the lines that
    /// make a gray row.
    fn convert(self, line: &[u8], x: usize, is_upper: bool, gray: &mut [u8]) {
        let from = |start: usize| line.get(start..).unwrap_or(&[]);
        match self {
            Self::Gray8 => gray.iter_mut().zip(from(x)).for_each(|(gray, &byte)| *gray = byte),
            Self::Yuyv => gray.iter_mut().zip(from(2 * x).iter().step_by(2)).for_each(|(gray, &y)| *gray = y),
            Self::Uyvy => gray.iter_mut().zip(from(2 * x + 1).iter().step_by(2)).for_each(|(gray, &y)| *gray = y),
            Self::Rgb565Be => {
                let pairs = from(2 * x).as_chunks().0;
                gray.iter_mut().zip(pairs).for_each(|(gray, &pair)| *gray = luma(u16::from_be_bytes(pair)));
            }
            Self::Rgb565Le => {
                let pairs = from(2 * x).as_chunks().0;
                gray.iter_mut().zip(pairs).for_each(|(gray, &pair)| *gray = luma(u16::from_le_bytes(pair)));
            }
            Self::Bayer8 => {
                let pairs = from(2 * x).as_chunks::<2>().0;
                for (gray, &[left, right]) in gray.iter_mut().zip(pairs) {
                    let sum = u16::from(left) + u16::from(right);
                    let mean = if is_upper { sum / 2 } else { (u16::from(*gray) + sum.div_ceil(2)) / 2 };
                    *gray = mean.to_le_bytes()[0];
                }
            }
            Self::Gray10 => {
                // First the pixels left in the group of four that holds column `x`, then whole groups.
                let (within, groups) = (x % 4, from(x / 4 * 5).as_chunks::<5>().0);
                let lead = if within == 0 { 0 } else { gray.len().min(4 - within) };
                let (start, rest) = gray.split_at_mut_checked(lead).unwrap_or_default();
                let (first, others) = groups.split_at_checked(usize::from(within > 0)).unwrap_or_default();
                let first = first.iter().flat_map(|[high @ .., _low]| high);
                start.iter_mut().zip(first.skip(within)).for_each(|(gray, &byte)| *gray = byte);
                for (gray, [high @ .., _low]) in rest.chunks_mut(4).zip(others) {
                    gray.iter_mut().zip(high).for_each(|(gray, &byte)| *gray = byte);
                }
            }
        }
    }
}

/// The gray level of five bits red, six green and five blue. The weights add up to 65536, so the sum fits 24 bits.
fn luma(rgb: u16) -> u8 {
    let (red, green, blue) = (u32::from(rgb >> 11), u32::from(rgb >> 5 & 63), u32::from(rgb & 31));
    let (red, green, blue) = (red << 3 | red >> 2, green << 2 | green >> 4, blue << 3 | blue >> 2);
    let sum = 19_595 * red + 38_470 * green + 7_471 * blue + 32_768;
    sum.to_le_bytes()[2]
}

/// The reason why a line or a frame was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReadoutError {
    /// The window has no pixels, or is partly outside the gray frame.
    WindowOutsideFrame,
    /// The buffer has fewer bytes than the window has pixels.
    BufferTooSmall,
    /// The line came before, or a later one did.
    LineOutOfOrder(u16),
    /// The line has fewer bytes than the format needs.
    LineTooShort(u16),
    /// The sensor has no such line.
    LineOutsideFrame(u16),
    /// The line is in a window but did not come: a later line came, or the frame ended.
    LineMissing(u16),
}

impl fmt::Display for ReadoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WindowOutsideFrame => f.write_str("the window has no pixels, or is not wholly inside the frame"),
            Self::BufferTooSmall => f.write_str("the buffer has fewer bytes than the window has pixels"),
            Self::LineOutOfOrder(line) => write!(f, "line {line} came twice, or after a later line"),
            Self::LineTooShort(line) => write!(f, "line {line} has fewer bytes than its format needs"),
            Self::LineOutsideFrame(line) => write!(f, "line {line} is below the last line of the frame"),
            Self::LineMissing(line) => write!(f, "line {line} is in the window and did not come"),
        }
    }
}

impl core::error::Error for ReadoutError {}

/// The lines that are in the windows, and those that have come: a readout without its pixels.
///
/// The C interface uses it. There lines come in interrupts of the code that asks for the frame, and only the code that
/// writes pixels may hold a reference to them.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Lines {
    format: Format,
    columns: u16,
    lines: u16,
    first: Rect,
    second: Option<Rect>,
    /// The next line. All lines before it have come, or are in no window.
    next: u16,
}

impl Lines {
    /// The lines of [`Readout::new`], for a buffer of `size` bytes.
    ///
    /// # Errors
    /// As [`Readout::new`].
    pub fn new(format: Format, (columns, lines): (u16, u16), window: Rect, size: usize) -> Result<Self, ReadoutError> {
        let begun = Self { format, columns, lines, first: window, second: None, next: 0 };
        begun.check_window(window, size)?;
        Ok(begun)
    }

    /// Adds the window of [`Readout::and_window`], for a buffer of `size` bytes.
    ///
    /// # Errors
    /// As [`Readout::and_window`].
    pub fn and_window(self, window: Rect, size: usize) -> Result<Self, ReadoutError> {
        if self.next > 0 {
            return Err(ReadoutError::LineOutOfOrder(0));
        }
        self.check_window(window, size)?;
        Ok(Self { second: Some(window), ..self })
    }

    /// Continues at `line`: see [`Readout::resume`].
    #[must_use]
    pub const fn resume(self, line: u16) -> Self {
        Self { next: line, ..self }
    }

    /// Width and height of the gray frame.
    #[must_use]
    pub const fn gray_size(&self) -> (u16, u16) {
        self.format.gray_size((self.columns, self.lines))
    }

    fn check_window(&self, window: Rect, size: usize) -> Result<(), ReadoutError> {
        let (width, height) = self.gray_size();
        if window.is_empty() || !Rect::new(0, 0, width, height).contains(window) {
            return Err(ReadoutError::WindowOutsideFrame);
        }
        if size < area(window) { Err(ReadoutError::BufferTooSmall) } else { Ok(()) }
    }

    /// Checks whether line `y`, which has `bytes` bytes, can come next. True if it is in a window.
    ///
    /// # Errors
    /// As [`Readout::push_line`].
    pub fn check(&self, y: u16, bytes: usize) -> Result<bool, ReadoutError> {
        if y >= self.lines {
            return Err(ReadoutError::LineOutsideFrame(y));
        }
        if y < self.next {
            return Err(ReadoutError::LineOutOfOrder(y));
        }
        if bytes < self.format.line_bytes(self.columns) {
            return Err(ReadoutError::LineTooShort(y));
        }
        match self.next_needed() {
            Some(needed) if needed < y => Err(ReadoutError::LineMissing(needed)),
            needed => Ok(needed == Some(y)),
        }
    }

    /// Checks whether all lines of the windows have come.
    ///
    /// # Errors
    /// As [`Readout::frame`].
    pub fn check_frame(&self) -> Result<(), ReadoutError> {
        self.next_needed().map_or(Ok(()), |line| Err(ReadoutError::LineMissing(line)))
    }

    /// The first line of the windows that has not come.
    fn next_needed(&self) -> Option<u16> {
        let of = |window: Rect| {
            let (start, end) = self.format.lines_of(window);
            (self.next < end).then_some(self.next.max(start))
        };
        let (first, second) = (of(self.first), self.second.and_then(of));
        first.into_iter().chain(second).min()
    }
}

/// Pixels of a window.
fn area(window: Rect) -> usize {
    usize::from(window.width) * usize::from(window.height)
}

/// A frame that a camera is sending: the gray pixels of one or two windows, filled as lines come.
///
/// Windows are in pixels of the gray frame ([`Format::gray_size`]), lines are those of the sensor. Lines outside the
/// windows may be left out. See the [module](self) for an example.
///
/// Cost: only pixels in the windows are converted. A line that is in no window costs a few comparisons.
#[derive(Debug)]
pub struct Readout<'a> {
    lines: Lines,
    /// The pixels of the first window.
    first: &'a mut [u8],
    /// The pixels of the second window; empty without one.
    second: &'a mut [u8],
}

impl<'a> Readout<'a> {
    /// Begins a frame of a sensor with this many columns and lines. The window's pixels go to `pixels`, row after row.
    ///
    /// # Errors
    /// [`ReadoutError::WindowOutsideFrame`], [`ReadoutError::BufferTooSmall`].
    pub fn new(
        format: Format,
        (columns, lines): (u16, u16),
        window: Rect,
        pixels: &'a mut [u8],
    ) -> Result<Self, ReadoutError> {
        Ok(Self { lines: Lines::new(format, (columns, lines), window, pixels.len())?, first: pixels, second: &mut [] })
    }

    /// A readout of `lines`, which were checked with the sizes of both buffers. Without a second window `second` is
    /// empty.
    #[doc(hidden)]
    #[must_use]
    pub const fn of(lines: Lines, first: &'a mut [u8], second: &'a mut [u8]) -> Self {
        Self { lines, first, second }
    }

    /// Adds a second window, for [`Tracker::sweep_window`](crate::Tracker::sweep_window). Call it before the first
    /// line.
    ///
    /// # Errors
    /// As [`Readout::new`]; [`ReadoutError::LineOutOfOrder`] after the first line.
    pub fn and_window(self, window: Rect, pixels: &'a mut [u8]) -> Result<Self, ReadoutError> {
        Ok(Self { lines: self.lines.and_window(window, pixels.len())?, second: pixels, ..self })
    }

    /// Continues a readout that was begun before with the same arguments: its next line is `line` or a later one. It is
    /// for programs that keep the buffers in a `static` and make the readout anew in each interrupt.
    ///
    /// ```
    /// use smr_core::Rect;
    /// use smr_core::readout::{Format, Readout};
    ///
    /// let (mut pixels, window) = ([0; 16], Rect::new(0, 0, 4, 4));
    /// let mut next = 0;
    /// for y in 0..4 {
    ///     let mut readout = Readout::new(Format::Gray8, (4, 4), window, &mut pixels)?.resume(next);
    ///     readout.push_line(y, &[200; 4])?;
    ///     next = readout.next_line();
    /// }
    /// assert!(Readout::new(Format::Gray8, (4, 4), window, &mut pixels)?.resume(next).frame().is_ok());
    /// # Ok::<(), smr_core::readout::ReadoutError>(())
    /// ```
    #[must_use]
    pub const fn resume(self, line: u16) -> Self {
        Self { lines: self.lines.resume(line), ..self }
    }

    /// The line after the last one that came: see [`Readout::resume`].
    #[must_use]
    pub const fn next_line(&self) -> u16 {
        self.lines.next
    }

    /// Takes line `y` of the sensor. Bytes beyond the line's length are ignored.
    ///
    /// # Errors
    /// [`ReadoutError::LineOutsideFrame`], [`ReadoutError::LineOutOfOrder`], [`ReadoutError::LineTooShort`], and
    /// [`ReadoutError::LineMissing`] with the first line of a window that was skipped. The frame is then as it was
    /// before the call.
    pub fn push_line(&mut self, y: u16, bytes: &[u8]) -> Result<(), ReadoutError> {
        if self.lines.check(y, bytes.len())? {
            let Lines { format, first, second, .. } = self.lines;
            format.push(y, bytes, first, self.first);
            second.into_iter().for_each(|second| format.push(y, bytes, second, self.second));
        }
        self.lines.next = y + 1;
        Ok(())
    }

    /// Takes all lines of a frame that is in memory. Each line begins `stride` bytes after the one before.
    ///
    /// # Errors
    /// As [`Readout::push_line`]: a frame that ends early has lines that are too short.
    pub fn push_frame(&mut self, bytes: &[u8], stride: usize) -> Result<(), ReadoutError> {
        for y in self.lines.next..self.lines.lines {
            let line = usize::from(y).checked_mul(stride).and_then(|start| bytes.get(start..)).unwrap_or(&[]);
            self.push_line(y, line)?;
        }
        Ok(())
    }

    /// The frame with its windows, for a lock or an update. Lines below the windows need not have come.
    ///
    /// # Errors
    /// [`ReadoutError::LineMissing`] with the first line of a window that has not come.
    pub fn frame(&self) -> Result<Frame<'_>, ReadoutError> {
        self.lines.check_frame()?;
        let outside = |_| ReadoutError::WindowOutsideFrame;
        let (width, height) = self.lines.gray_size();
        let (image, x, y) = part(self.lines.first, self.first)?;
        let frame = Frame::part(image, x, y, width, height).map_err(outside)?;
        let Some(second) = self.lines.second else { return Ok(frame) };
        let (image, x, y) = part(second, self.second)?;
        frame.and_part(image, x, y).map_err(outside)
    }
}

/// The pixels of a window, and the place of its top left pixel.
fn part(window: Rect, pixels: &[u8]) -> Result<(Image<'_>, u16, u16), ReadoutError> {
    let Rect { x, y, width, height } = window;
    let image = pixels.get(..area(window)).and_then(|pixels| Image::new(pixels, width, height).ok());
    let place = u16::try_from(x).ok().zip(u16::try_from(y).ok());
    image.zip(place).map(|(image, (x, y))| (image, x, y)).ok_or(ReadoutError::WindowOutsideFrame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// Any bytes as a sensor's lines, each with 3 bytes of padding.
    fn sensor(format: Format, columns: u16, lines: u16, seed: u32) -> (Vec<u8>, usize) {
        let stride = format.line_bytes(columns) + 3;
        let byte = |at: usize| ((at as u32).wrapping_mul(2_654_435_761).wrapping_add(seed * 40_503) >> 23) as u8;
        ((0..stride * usize::from(lines)).map(byte).collect(), stride)
    }

    /// The gray level at (x, y), computed as the documentation says.
    fn gray(format: Format, bytes: &[u8], stride: usize, x: usize, y: usize) -> u8 {
        let at = |x: usize, y: usize| u32::from(bytes[y * stride + x]);
        let luma = |rgb: u32| {
            let widened = |value: u32, bits: u32| value << (8 - bits) | value >> (2 * bits - 8);
            let (red, green, blue) = (widened(rgb >> 11 & 31, 5), widened(rgb >> 5 & 63, 6), widened(rgb & 31, 5));
            (19_595 * red + 38_470 * green + 7_471 * blue + 32_768) >> 16
        };
        let level = match format {
            Format::Gray8 => at(x, y),
            Format::Yuyv => at(2 * x, y),
            Format::Uyvy => at(2 * x + 1, y),
            Format::Rgb565Be => luma(at(2 * x, y) << 8 | at(2 * x + 1, y)),
            Format::Rgb565Le => luma(at(2 * x + 1, y) << 8 | at(2 * x, y)),
            Format::Bayer8 => {
                let (upper, lower) =
                    (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1));
                (upper / 2 + lower.div_ceil(2)) / 2
            }
            Format::Gray10 => at(x / 4 * 5 + x % 4, y),
        };
        u8::try_from(level).unwrap()
    }

    proptest! {
        #[test]
        fn each_pixel_is_what_its_format_says(
            format in proptest::sample::select(&Format::ALL[..]),
            (columns, lines) in (2..40_u16, 2..30_u16),
            (left, top, right, bottom) in (0..40_u16, 0..30_u16, 1..41_u16, 1..31_u16),
            seed in 0..100_u32,
        ) {
            let (bytes, stride) = sensor(format, columns, lines, seed);
            let (width, height) = format.gray_size((columns, lines));
            let (left, top) = (left % width, top % height);
            let window = Rect::new(left.into(), top.into(), right.min(width - left), bottom.min(height - top));
            let mut pixels = std::vec![0; usize::from(window.width) * usize::from(window.height)];
            let mut readout = Readout::new(format, (columns, lines), window, &mut pixels).unwrap();
            readout.push_frame(&bytes, stride).unwrap();
            let frame = readout.frame().unwrap();
            prop_assert_eq!(frame.bounds(), Rect::new(0, 0, width, height));
            let rows = frame.patch(window).unwrap();
            for (y, row) in (usize::from(top)..).zip(rows.rows()) {
                for (x, &level) in (usize::from(left)..).zip(row) {
                    prop_assert_eq!(level, gray(format, &bytes, stride, x, y), "{:?} at {},{}", format, x, y);
                }
            }
        }
    }

    fn readout(pixels: &mut [u8]) -> Readout<'_> {
        Readout::new(Format::Gray8, (8, 6), Rect::new(2, 1, 4, 3), pixels).unwrap()
    }

    #[test]
    fn lines_must_come_once_and_in_order() {
        let (mut pixels, line) = ([0; 12], [7; 8]);
        let mut readout = readout(&mut pixels);
        assert_eq!(readout.frame().err(), Some(ReadoutError::LineMissing(1)));
        // Line 0 is in no window.
        assert_eq!(readout.push_line(2, &line), Err(ReadoutError::LineMissing(1)));
        assert_eq!(readout.push_line(1, &line), Ok(()));
        assert_eq!(readout.push_line(1, &line), Err(ReadoutError::LineOutOfOrder(1)));
        assert_eq!(readout.push_line(0, &line), Err(ReadoutError::LineOutOfOrder(0)));
        assert_eq!(readout.push_line(2, &line[..7]), Err(ReadoutError::LineTooShort(2)));
        assert_eq!(readout.push_line(3, &line), Err(ReadoutError::LineMissing(2)));
        assert_eq!(readout.push_line(2, &line), Ok(()));
        assert_eq!(readout.frame().err(), Some(ReadoutError::LineMissing(3)));
        assert_eq!(readout.push_line(3, &line), Ok(()));
        assert!(readout.frame().is_ok());
        // Below the window lines may be left out.
        assert_eq!(readout.push_line(5, &line), Ok(()));
        assert_eq!(readout.push_line(6, &line), Err(ReadoutError::LineOutsideFrame(6)));
        assert!(readout.and_window(Rect::new(0, 0, 1, 1), &mut [0]).is_err());
    }

    #[test]
    fn windows_and_buffers_are_checked() {
        let size = (8, 6);
        let error = |format, window, bytes: usize| Readout::new(format, size, window, &mut std::vec![0; bytes]).err();
        assert_eq!(error(Format::Gray8, Rect::new(0, 0, 8, 6), 48), None);
        assert_eq!(error(Format::Gray8, Rect::new(0, 0, 8, 6), 47), Some(ReadoutError::BufferTooSmall));
        for window in [Rect::new(0, 0, 0, 3), Rect::new(-1, 0, 3, 3), Rect::new(5, 0, 4, 3), Rect::new(0, 4, 3, 3)] {
            assert_eq!(error(Format::Gray8, window, 48), Some(ReadoutError::WindowOutsideFrame), "{window:?}");
        }
        assert_eq!(error(Format::Bayer8, Rect::new(0, 0, 4, 3), 12), None);
        assert_eq!(error(Format::Bayer8, Rect::new(0, 0, 5, 3), 48), Some(ReadoutError::WindowOutsideFrame));
    }

    #[test]
    fn two_windows_are_filled_at_once() {
        let (bytes, stride) = sensor(Format::Uyvy, 20, 16, 5);
        let (near, far) = (Rect::new(3, 2, 6, 5), Rect::new(10, 9, 10, 7));
        let (mut first, mut second) = ([0; 30], [0; 70]);
        let readout = Readout::new(Format::Uyvy, (20, 16), near, &mut first).unwrap();
        let mut readout = readout.and_window(far, &mut second).unwrap();
        for y in 0..16 {
            let line = &bytes[usize::from(y) * stride..];
            if y == 7 {
                // Between the windows.
                continue;
            }
            readout.push_line(y, line).unwrap();
        }
        let frame = readout.frame().unwrap();
        assert!(frame.covers(near) && frame.covers(far) && !frame.covers(Rect::new(0, 0, 1, 1)));
        assert_eq!(frame.patch(far).unwrap().row(6)[9], gray(Format::Uyvy, &bytes, stride, 19, 15));
    }

    #[test]
    fn a_frame_that_ends_early_names_the_line() {
        let mut pixels = [0; 12];
        let mut readout = readout(&mut pixels);
        assert_eq!(readout.push_frame(&[1; 2 * 8 + 7], 8), Err(ReadoutError::LineTooShort(2)));
        assert_eq!(readout.frame().err(), Some(ReadoutError::LineMissing(2)));
    }

    #[test]
    fn the_largest_sensor_has_no_overflow() {
        let side = u16::MAX;
        let last = Rect::new(i32::from(side) - 1, i32::from(side) - 1, 1, 1);
        let (mut pixels, line) = ([0], std::vec![255; 2 * usize::from(side)]);
        let mut readout = Readout::new(Format::Rgb565Le, (side, side), last, &mut pixels).unwrap();
        readout.push_line(side - 1, &line).unwrap();
        assert_eq!(readout.frame().unwrap().patch(last).unwrap().row(0), [255]);
        assert_eq!(Format::Gray10.line_bytes(side), 81_920);
    }
}
