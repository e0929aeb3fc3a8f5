//! Converts a camera's lines, as they arrive, from its pixel format into the gray windows that a tracker reads.
//!
//! A camera sends one line at a time, often in color. No gray copy of the whole frame is needed: [`Tracker::windows`]
//! returns the pixels that the next update reads, and a [`Readout`] keeps only those. The caller owns the pixel buffer,
//! so an interrupt and the main loop can share readout and buffer in a `static`:
//!
//! ```
//! use smr_core::readout::{Format, Readout, ReadoutError};
//! use smr_core::{Rect, Robust, Tracker};
//! use std::sync::Mutex; // in firmware, for example that of `critical-section`
//!
//! const SIZE: (u16, u16) = (320, 240);
//! /// The frame that the camera is sending, and the buffer for its gray pixels.
//! static COMING: Mutex<Option<Readout>> = Mutex::new(None);
//! static PIXELS: Mutex<[u8; 100_000]> = Mutex::new([0; 100_000]); // a static of its own: all zeroes, so no flash
//!
//! /// The interrupt of the DMA: the camera has sent line `y`, here as YUYV.
//! fn line_came(y: u16, line: &[u8]) -> Result<(), ReadoutError> {
//!     let Some(readout) = &mut *COMING.lock().unwrap() else { return Ok(()) };
//!     readout.push_line(y, line, &mut *PIXELS.lock().unwrap())
//! }
//!
//! # fn wait_for_lines() { for y in 0..240 { line_came(y, &[90; 640]).unwrap() } }
//! # fn main() -> Result<(), smr_core::Error> {
//! let mut tracker = Tracker::<Robust>::new();
//! let target = Rect::new(100, 80, 40, 48);
//! for number in 0..3 {
//!     // Converts and keeps only the pixels that the call reads.
//!     let to_lock = tracker.lock_window(Rect::new(0, 0, SIZE.0, SIZE.1), target);
//!     let windows = tracker.windows().unwrap_or(to_lock.into());
//!     *COMING.lock().unwrap() = Some(Readout::new(Format::YUYV, SIZE, windows)?);
//!     wait_for_lines(); // until Readout::is_complete
//!     let pixels = PIXELS.lock().unwrap(); // in firmware: taken from the interrupt, as `examples/async` does
//!     let frame = COMING.lock().unwrap().take().expect("begun above").frame(&*pixels)?;
//!     if number == 0 {
//!         tracker.lock(&frame, target)?;
//!     } else {
//!         let answer = tracker.update(&frame)?;
//! #       let _ = answer;
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # Cost
//!
//! Instructions per gray pixel, with all calls for the lines of a window of 140x140 pixels (`tests/chip/readout.rs` in
//! QEMU). A line outside the window takes about 100 on the M4.
//!
//! | | gray 8 | YUYV, UYVY | RGB565, low byte first | high byte first | Bayer (two lines) | packed 10 bits |
//! |---|---|---|---|---|---|---|
//! | M4 | <!--=budgets/mps2-an386 readout-gray8 C.1-->5.9<!----> | <!--=budgets/mps2-an386 readout-yuyv C.1-->5.8<!----> | <!--=budgets/mps2-an386 readout-rgb565le C.1-->19.8<!----> | <!--=budgets/mps2-an386 readout-rgb565be C.1-->21.3<!----> | <!--=budgets/mps2-an386 readout-bayer8 C.1-->16.5<!----> | <!--=budgets/mps2-an386 readout-gray10 C.1-->5.5<!----> |
//! | M0+ | <!--=budgets/thumbv6m-none-eabi readout-gray8 C.1-->10.1<!----> | <!--=budgets/thumbv6m-none-eabi readout-yuyv C.1-->8.2<!----> | <!--=budgets/thumbv6m-none-eabi readout-rgb565le C.1-->39.1<!----> | <!--=budgets/thumbv6m-none-eabi readout-rgb565be C.1-->39.3<!----> | <!--=budgets/thumbv6m-none-eabi readout-bayer8 C.1-->44.8<!----> | <!--=budgets/thumbv6m-none-eabi readout-gray10 C.1-->9.6<!----> |
//!
//! [`Tracker::windows`]: crate::Tracker::windows

pub use super::pixel_formats::{Format, Shrink};
use super::windows::area;
use super::{Frame, Rect, Windows};

errors! {
    /// The reason why a line or a frame was refused.
    ReadoutError {
        /// A window has no pixels, or is partly outside the gray frame.
        WindowOutsideFrame => "a window has no pixels, or is not wholly inside the frame",
        /// The buffer has fewer bytes than the windows have pixels.
        BufferTooSmall => "the buffer has fewer bytes than the windows have pixels",
        /// The line arrived twice, or after a later line.
        LineOutOfOrder(line: u16) => "line {line} came twice, or after a later line",
        /// The line has fewer bytes than the format needs.
        LineTooShort(line: u16) => "line {line} has fewer bytes than its format needs",
        /// The line is below the last line of the sensor.
        LineOutsideFrame(line: u16) => "line {line} is below the last line of the frame",
        /// A line of a window is missing: a later line arrived first, or the frame ended.
        LineMissing(line: u16) => "line {line} is in the window and did not come",
    }
}

/// A frame that a camera is sending: its windows, and the lines that have arrived.
///
/// Windows are in pixels of the gray frame ([`Format::gray_size`]), lines are those of the sensor. Lines outside the
/// windows may be skipped. The caller's buffer receives the gray pixels of the first window, row by row, then those of
/// the second. See the [module](self) for an example.
///
/// Cost: converts only pixels in the windows. A line in no window costs a few comparisons.
#[derive(Clone, Copy, Debug)]
pub struct Readout {
    format: Format,
    columns: u16,
    lines: u16,
    windows: Windows,
    /// The line expected next: all earlier lines have arrived or lie in no window.
    next: u16,
}

impl Readout {
    /// Begins a frame of a sensor of (`columns`, `lines`) pixels, of which only the pixels in `windows` are converted
    /// and kept: those of [`Tracker::windows`](crate::Tracker::windows), or one [`Rect`].
    ///
    /// # Errors
    /// [`ReadoutError::WindowOutsideFrame`].
    pub fn new(
        format: Format,
        (columns, lines): (u16, u16),
        windows: impl Into<Windows>,
    ) -> Result<Self, ReadoutError> {
        let readout = Self { format, columns, lines, windows: windows.into(), next: 0 };
        let (width, height) = readout.gray_size();
        let (first, second) = readout.windows.split();
        let is_inside = |window| Rect::new(0, 0, width, height).contains(window);
        if is_inside(first) && second.is_none_or(is_inside) {
            Ok(readout)
        } else {
            Err(ReadoutError::WindowOutsideFrame)
        }
    }

    const fn gray_size(&self) -> (u16, u16) {
        self.format.gray_size((self.columns, self.lines))
    }

    /// This readout with the lines before `line` behind it: continues one whose [`next_line`](Self::next_line) was
    /// `line`, with the same windows and buffer. For programs that store the state of a readout themselves, as the
    /// interface for C does.
    #[must_use]
    pub const fn resumed(self, line: u16) -> Self {
        Self { next: line, ..self }
    }

    /// The line expected next: all earlier ones have arrived, or lie in no window.
    #[must_use]
    pub const fn next_line(&self) -> u16 {
        self.next
    }

    /// Size of the buffer for the windows in bytes: one for each gray pixel.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.windows.pixels()
    }

    /// Converts line `y` of the sensor into the buffer `pixels`, which is used only if the line is in a window. Ignores
    /// bytes after the line's end.
    ///
    /// # Errors
    /// [`ReadoutError::LineOutsideFrame`], [`ReadoutError::LineOutOfOrder`], [`ReadoutError::LineTooShort`],
    /// [`ReadoutError::LineMissing`] with the first line of a window that was skipped,
    /// [`ReadoutError::BufferTooSmall`]. The readout is then unchanged.
    pub fn push_line(&mut self, y: u16, bytes: &[u8], pixels: &mut [u8]) -> Result<(), ReadoutError> {
        if y >= self.lines {
            return Err(ReadoutError::LineOutsideFrame(y));
        }
        if y < self.next {
            return Err(ReadoutError::LineOutOfOrder(y));
        }
        if bytes.len() < self.format.line_bytes(self.columns) {
            return Err(ReadoutError::LineTooShort(y));
        }
        match self.next_needed() {
            Some(needed) if needed < y => return Err(ReadoutError::LineMissing(needed)),
            Some(needed) if needed == y => {
                let pixels = pixels.get_mut(..self.pixels()).ok_or(ReadoutError::BufferTooSmall)?;
                let (window, second) = self.windows.split();
                let (pixels, rest) = pixels.split_at_mut_checked(area(window)).unwrap_or_default();
                self.format.push(y, bytes, window, pixels);
                second.into_iter().for_each(|window| self.format.push(y, bytes, window, rest));
            }
            _ => {}
        }
        self.next = y + 1;
        Ok(())
    }

    /// Converts all remaining lines of a frame in memory, whose lines begin `stride` bytes apart.
    ///
    /// # Errors
    /// As [`Readout::push_line`]: a frame that ends early has lines that are too short.
    pub fn push_frame(&mut self, bytes: &[u8], stride: usize, pixels: &mut [u8]) -> Result<(), ReadoutError> {
        for y in self.next..self.lines {
            let line = usize::from(y).checked_mul(stride).and_then(|start| bytes.get(start..)).unwrap_or(&[]);
            self.push_line(y, line, pixels)?;
        }
        Ok(())
    }

    /// True if all lines of the windows have arrived. Later lines do not change the buffer.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.next_needed().is_none()
    }

    /// The frame for `lock` or `update`, with its windows in memory. Lines below them need not have arrived.
    ///
    /// # Errors
    /// [`ReadoutError::LineMissing`] with the first missing line of a window, [`ReadoutError::BufferTooSmall`].
    pub fn frame<'a>(&self, pixels: &'a [u8]) -> Result<Frame<'a>, ReadoutError> {
        self.next_needed().map_or(Ok(()), |line| Err(ReadoutError::LineMissing(line)))?;
        // The only possible error, because the windows are inside the frame.
        Frame::of_windows(pixels, self.windows, self.gray_size()).map_err(|_| ReadoutError::BufferTooSmall)
    }

    /// The first line of the windows that has not arrived.
    fn next_needed(&self) -> Option<u16> {
        let of = |window: Rect| {
            let (start, end) = self.format.lines_of(window);
            (self.next < end).then_some(self.next.max(start))
        };
        let (first, second) = self.windows.split();
        of(first).into_iter().chain(second.and_then(of)).min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// The expected gray level at (x, y), by the formulas in the documentation of [`Format`].
    fn gray(format: Format, bytes: &[u8], stride: usize, x: usize, y: usize) -> u8 {
        let at = |x: usize, y: usize| u32::from(bytes[y * stride + x]);
        let luma = |rgb: u32| {
            let widened = |value: u32, bits: u32| value << (8 - bits) | value >> (2 * bits - 8);
            let (red, green, blue) = (widened(rgb >> 11 & 31, 5), widened(rgb >> 5 & 63, 6), widened(rgb & 31, 5));
            (19_595 * red + 38_470 * green + 7_471 * blue + 32_768) >> 16
        };
        let level = match std::format!("{format:?}").as_str() {
            "GRAY8" => at(x, y),
            "YUYV" => at(2 * x, y),
            "UYVY" => at(2 * x + 1, y),
            "RGB565_BE" => luma(at(2 * x, y) << 8 | at(2 * x + 1, y)),
            "RGB565_LE" => luma(at(2 * x + 1, y) << 8 | at(2 * x, y)),
            "BAYER8" => {
                let (upper, lower) =
                    (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1));
                (upper / 2 + lower.div_ceil(2)) / 2
            }
            "GRAY10" => at(x / 4 * 5 + x % 4, y),
            other => panic!("no formula for {other}"),
        };
        u8::try_from(level).unwrap()
    }

    proptest! {
        #[test]
        fn each_pixel_is_what_its_format_says(
            format in proptest::sample::select(&Format::ALL[..]),
            sensor in (2..40_u16, 2..30_u16),
            windows in any::<[(u16, u16, u16, u16); 2]>(),
            (all_lines, bytes) in (any::<bool>(), prop::collection::vec(any::<u8>(), 30 * 83)),
        ) {
            let (stride, size) = (format.line_bytes(sensor.0) + 3, format.gray_size(sensor));
            let windows = windows.map(|(left, top, width, height)| {
                let (left, top) = (left % size.0, top % size.1);
                Rect::new(left.into(), top.into(), 1 + width % (size.0 - left), 1 + height % (size.1 - top))
            });
            let mut readout = Readout::new(format, sensor, Windows::new(windows[0], Some(windows[1]))).unwrap();
            let mut pixels = std::vec![0; readout.pixels()];
            if all_lines {
                readout.push_frame(&bytes, stride, &mut pixels).unwrap();
            }
            // Lines in no window may be skipped.
            while let Some(y) = readout.next_needed() {
                readout.push_line(y, &bytes[usize::from(y) * stride..], &mut pixels).unwrap();
            }
            let frame = readout.frame(&pixels).unwrap();
            prop_assert_eq!(frame.bounds(), Rect::new(0, 0, size.0, size.1));
            for window in windows {
                for (y, row) in (window.y as usize..).zip(frame.patch(window).unwrap().rows()) {
                    for (x, &level) in (window.x as usize..).zip(row) {
                        prop_assert_eq!(level, gray(format, &bytes, stride, x, y), "{:?} at {},{}", format, x, y);
                    }
                }
            }
        }
    }

    /// Bytes of all levels, or only 0 and 255, in random order.
    fn levels() -> impl Strategy<Value = Vec<u8>> {
        let extreme = any::<bool>().prop_map(|is_white| if is_white { 255 } else { 0 });
        let of = |level: BoxedStrategy<u8>| prop::collection::vec(level, 30 * 80);
        prop_oneof![of(any::<u8>().boxed()), of(extreme.boxed())]
    }

    proptest! {
        #[test]
        fn a_shrunk_frame_has_the_means_of_blocks(
            format in proptest::sample::select(&[Format::GRAY8, Format::YUYV, Format::BAYER8][..]),
            (n, shrink) in proptest::sample::select(&[(2, Shrink::By2), (3, Shrink::By3), (4, Shrink::By4)][..]),
            bytes in levels(),
        ) {
            let (sensor, small) = ((40, 30), format.shrunk(shrink).gray_size((40, 30)));
            let (is_mosaic, side) = (format == Format::BAYER8, usize::from(40 / small.0));
            let bytes_a_pixel = if format == Format::YUYV { 2 } else { 1 };
            let window = Rect::new(1, 1, small.0 - 1, small.1 - 1);
            let mut readout = Readout::new(format.shrunk(shrink), sensor, window).unwrap();
            let mut pixels = std::vec![77; readout.pixels()];
            readout.push_frame(&bytes, 80, &mut pixels).unwrap();
            let frame = readout.frame(&pixels).unwrap();
            prop_assert_eq!(frame.bounds(), Rect::new(0, 0, small.0, small.1));
            let most = [[1.0, 1.4, 1.7], [2.2, 2.8, 3.2]][usize::from(is_mosaic)][n - 2];
            for (y, row) in (1..).zip(frame.patch(window).unwrap().rows()) {
                for (x, &level) in (1..).zip(row) {
                    let columns = |x: usize| (x * side..(x + 1) * side).map(|x| x * bytes_a_pixel);
                    let block = (y * side..(y + 1) * side).flat_map(|y| columns(x).map(move |x| 80 * y + x));
                    let sum: f64 = block.map(|at| f64::from(bytes[at])).sum();
                    let mean = sum / (side * side) as f64;
                    prop_assert!((f64::from(level) - mean).abs() <= most, "{:?}: {} for {}", readout, level, mean);
                }
            }
        }
    }

    fn readout() -> Readout {
        Readout::new(Format::GRAY8, (8, 6), Rect::new(2, 1, 4, 3)).unwrap()
    }

    #[test]
    fn lines_must_come_once_and_in_order() {
        use ReadoutError::{BufferTooSmall, LineMissing, LineOutOfOrder, LineOutsideFrame, LineTooShort};
        let (mut readout, mut pixels, line) = (readout(), [0; 12], [7; 8]);
        assert_eq!(readout.frame(&pixels).err(), Some(LineMissing(1)));
        // The window has lines 1 to 3. Lines outside it may be skipped. Lines below it need no buffer (`room` 0).
        for (y, bytes, room, result, missing) in [
            (2, 8, 12, Err(LineMissing(1)), Some(1)),
            (1, 8, 11, Err(BufferTooSmall), Some(1)),
            (1, 8, 12, Ok(()), Some(2)),
            (1, 8, 12, Err(LineOutOfOrder(1)), Some(2)),
            (0, 8, 12, Err(LineOutOfOrder(0)), Some(2)),
            (2, 7, 12, Err(LineTooShort(2)), Some(2)),
            (3, 8, 12, Err(LineMissing(2)), Some(2)),
            (2, 8, 12, Ok(()), Some(3)),
            (3, 8, 12, Ok(()), None),
            (5, 8, 0, Ok(()), None),
            (6, 8, 12, Err(LineOutsideFrame(6)), None),
        ] {
            assert_eq!(readout.push_line(y, &line[..bytes], &mut pixels[..room]), result, "line {y}");
            assert_eq!(readout.is_complete(), missing.is_none(), "line {y}");
            assert_eq!(readout.frame(&pixels).err(), missing.map(LineMissing), "line {y}");
        }
        let mut short = self::readout();
        assert_eq!(short.push_frame(&[1; 2 * 8 + 7], 8, &mut pixels), Err(LineTooShort(2)));
        assert_eq!(short.frame(&pixels).err(), Some(LineMissing(2)), "a frame that ends early");
    }

    #[test]
    fn a_readout_goes_on_where_another_one_was() {
        let line: Vec<u8> = (0..8).collect();
        let (mut whole, mut pixels, mut stored) = (readout(), [0; 12], 0);
        let mut resumed_pixels = pixels;
        for y in 0..5 {
            whole.push_line(y, &line, &mut pixels).unwrap();
            let mut resumed = readout().resumed(stored);
            resumed.push_line(y, &line, &mut resumed_pixels).unwrap();
            stored = resumed.next_line();
            assert_eq!((stored, resumed.is_complete()), (y + 1, whole.is_complete()));
            assert_eq!(resumed.push_line(y, &line, &mut resumed_pixels), Err(ReadoutError::LineOutOfOrder(y)));
        }
        assert_eq!(pixels, resumed_pixels);
    }

    #[test]
    fn windows_and_buffers_are_checked() {
        let outside = Err(ReadoutError::WindowOutsideFrame);
        for (format, x, y, width, height, needs) in [
            (Format::GRAY8, 0, 0, 8, 6, Ok(48)),
            (Format::BAYER8, 0, 0, 4, 3, Ok(12)),
            (Format::BAYER8, 0, 0, 5, 3, outside),
            (Format::GRAY8, 0, 0, 0, 3, outside),
            (Format::GRAY8, -1, 0, 3, 3, outside),
            (Format::GRAY8, 5, 0, 4, 3, outside),
            (Format::GRAY8, 0, 4, 3, 3, outside),
        ] {
            let window = Rect::new(x, y, width, height);
            assert_eq!(Readout::new(format, (8, 6), window).map(|readout| readout.pixels()), needs, "{window:?}");
            let both = Windows::new(Rect::new(0, 0, 1, 1), Some(window));
            let of_both = Readout::new(format, (8, 6), both).map(|readout| readout.pixels());
            assert_eq!(of_both, needs.map(|pixels| pixels + 1), "{window:?}");
        }
        let windows = Windows::new(Rect::new(2, 1, 4, 3), Some(Rect::new(0, 3, 2, 1)));
        let mut both = Readout::new(Format::GRAY8, (8, 6), windows).unwrap();
        assert_eq!(both.pixels(), 14);
        assert_eq!(both.push_line(1, &[7; 8], &mut [0; 13]), Err(ReadoutError::BufferTooSmall));
        assert_eq!(both.push_frame(&[7; 48], 8, &mut [0; 14]), Ok(()));
        assert_eq!(both.frame(&[0; 13]).err(), Some(ReadoutError::BufferTooSmall));
        assert_eq!(both.frame(&[0; 14]).err(), None);
    }

    #[test]
    fn the_largest_sensor_has_no_overflow() {
        let side = u16::MAX;
        let last = Rect::new(i32::from(side) - 1, i32::from(side) - 1, 1, 1);
        let (mut pixels, line) = ([0], std::vec![255; 2 * usize::from(side)]);
        let mut readout = Readout::new(Format::RGB565_LE, (side, side), last).unwrap();
        readout.push_line(side - 1, &line, &mut pixels).unwrap();
        assert_eq!(readout.frame(&pixels).unwrap().patch(last).unwrap().row(0), [255]);
        assert_eq!(Format::GRAY10.line_bytes(side), 81_920);
    }
}
