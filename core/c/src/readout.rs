//! A camera's lines as they come, in any pixel format, into the windows that a tracker needs.

use crate::frame::{smr_frame, smr_part, smr_rect};
use crate::pointer::{self, Out};
use crate::status::{
    SMR_ERROR_BUFFER_TOO_SMALL, SMR_ERROR_FORMAT_UNKNOWN, SMR_ERROR_LINE_MISSING, smr_status, status_of,
};
use core::sync::atomic::{Ordering, compiler_fence};
use core::{ptr, slice};
use smr_core::Rect;
use smr_core::readout::{Format, Readout, ReadoutError};

/// The format in which a camera sends its pixels.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum smr_format {
    /// One byte a pixel, gray.
    SMR_GRAY8 = 0,
    /// Two bytes a pixel: Y U Y V. Gray is Y.
    SMR_YUYV = 1,
    /// Two bytes a pixel: U Y V Y. Gray is Y.
    SMR_UYVY = 2,
    /// Two bytes a pixel, the high byte first: five bits red, six green, five blue. Gray is (19595 R + 38470 G + 7471 B
    /// + 32768) >> 16, with R, G and B widened to eight bits by repeating their high bits.
    SMR_RGB565_BE = 3,
    /// RGB565 with the low byte first.
    SMR_RGB565_LE = 4,
    /// One byte a pixel behind a mosaic of color filters. Each 2x2 pixels become one gray pixel: the gray frame has
    /// half the width and half the height.
    SMR_BAYER8 = 5,
    /// Four gray pixels of ten bits in five bytes (MIPI RAW10). The low two bits are left out.
    SMR_GRAY10 = 6,
}

// In the order of their numbers.
const _: () = {
    use Format::{Bayer8, Gray8, Gray10, Rgb565Be, Rgb565Le, Uyvy, Yuyv};
    assert!(matches!(Format::ALL, [Gray8, Yuyv, Uyvy, Rgb565Be, Rgb565Le, Bayer8, Gray10]));
};

/// A frame of a camera under way. #smr_readout_begin fills it; only `line` is to be read.
///
/// Lines may come in an interrupt while the main loop asks for the frame. Then:
/// - #smr_readout_begin writes all of it: call it where no line can come, in the interrupt itself or while it is
///   switched off.
/// - #smr_readout_line writes `next` and `line`, and nobody else does. It writes pixels only of lines in the windows,
///   which come before #smr_readout_frame succeeds; so the interrupt need not be switched off during #smr_lock or
///   #smr_update. For the next frame give other memory, or begin it after the update.
/// - #smr_readout_frame only reads, and may be interrupted at any point.
///
/// The interrupt must run on the same processor core as the loop. All else that calls do at the same time is for you to
/// prevent: two calls of #smr_readout_line, or #smr_readout_lines and any other.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_readout {
    /// A number of #smr_format.
    pub format: i32,
    /// Columns of the sensor.
    pub columns: u16,
    /// Lines of the sensor.
    pub lines: u16,
    /// The number of the next line. It grows after the pixels of a line are written.
    pub next: u16,
    /// The line that the last error SMR_ERROR_LINE_... is about.
    pub line: u16,
    /// The windows. If there is no second one, its width and height are 0.
    pub windows: [smr_rect; 2],
    /// The gray pixels of the first window, then those of the second.
    pub pixels: *mut u8,
    /// Bytes there.
    pub size: usize,
}

impl smr_readout {
    /// Reads the value at `from`. An interrupt may change `next` and `line`: the one is read at once, the other not at all.
    ///
    /// # Safety
    /// A `from` that passes [`pointer::check`] points to an `smr_readout`.
    unsafe fn read(from: *const Self) -> Result<Self, smr_status> {
        pointer::check(from)?;
        // SAFETY: neither NULL nor misaligned; the rest as the caller ensures.
        unsafe {
            let next = (&raw const (*from).next).read_volatile();
            // Nothing that the lines before `next` brought is read before it.
            compiler_fence(Ordering::Acquire);
            Ok(Self { next, line: 0, ..*from })
        }
    }

    /// Notes in `to`, after the pixels were written, the next line, and the line that an error is about.
    ///
    /// # Safety
    /// `to` was read.
    unsafe fn note(to: *mut Self, next: u16, result: Result<(), ReadoutError>) -> Result<(), smr_status> {
        use ReadoutError::{LineMissing, LineOutOfOrder, LineOutsideFrame, LineTooShort};
        compiler_fence(Ordering::Release);
        // SAFETY: `read` has checked the pointer.
        unsafe {
            (&raw mut (*to).next).write_volatile(next);
            if let Err(LineMissing(line) | LineOutOfOrder(line) | LineOutsideFrame(line) | LineTooShort(line)) = result
            {
                (&raw mut (*to).line).write_volatile(line);
            }
        }
        Ok(result?)
    }

    fn format(&self) -> Result<Format, smr_status> {
        let known = usize::try_from(self.format).ok().and_then(|number| Format::ALL.get(number));
        known.copied().ok_or(SMR_ERROR_FORMAT_UNKNOWN)
    }

    /// The readout of `smr-core`. Another call may be writing the pixels.
    fn open(&self) -> Result<Readout, smr_status> {
        let ([first, second], format) = (self.windows.map(Rect::from), self.format()?);
        pointer::check_bytes(self.pixels, self.size, &[0..0, 0..0])?;
        let mut readout = Readout::new(format, (self.columns, self.lines), first)?;
        if !second.is_empty() {
            readout = readout.and_window(second)?;
        }
        if self.size < readout.pixels() {
            return Err(SMR_ERROR_BUFFER_TOO_SMALL);
        }
        readout.next = self.next;
        Ok(readout)
    }

    /// The two parts of a frame that the read-out fills; they passed the checks of its start.
    fn parts(&self) -> [smr_part; 2] {
        let [first, second] = self.windows.map(Rect::from);
        let first = smr_part::of(self.pixels, first);
        let rest = if second.is_empty() { ptr::null_mut() } else { self.pixels.wrapping_add(first.size) };
        [first, smr_part::of(rest, second)]
    }
}

/// Begins a frame.
///
/// Windows are in pixels of the gray frame, which has the sensor's size, or half of it with #SMR_BAYER8. Give
/// #smr_windows; before a lock #smr_lock_window and an empty one.
///
/// @param readout  Is filled; need not be initialised. Unchanged after an error.
/// @param format   A number of #smr_format.
/// @param columns  Columns of the sensor.
/// @param lines    Lines of the sensor.
/// @param windows  Two windows inside the gray frame. Only the second may be empty.
/// @param pixels   Initialised memory, until the tracker was called with the frame. The gray pixels of the first window go there, then
///                 those of the second, row by row without gaps.
/// @param size     Bytes there; at least width * height of both windows.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE, #SMR_ERROR_FORMAT_UNKNOWN,
///                 #SMR_ERROR_OUTSIDE_FRAME or #SMR_ERROR_BUFFER_TOO_SMALL.
/// cbindgen:ptrs-as-arrays=[[windows; 2]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_begin(
    readout: *mut smr_readout,
    format: i32,
    columns: u16,
    lines: u16,
    windows: *const smr_rect,
    pixels: *mut u8,
    size: usize,
) -> smr_status {
    let begin = || {
        // SAFETY: as the header demands of the caller.
        let (readout, windows) = unsafe { (Out::new(readout)?, pointer::read(windows.cast::<[smr_rect; 2]>())?) };
        let begun = smr_readout { format, columns, lines, next: 0, line: 0, windows, pixels, size };
        begun.open()?;
        readout.write(begun);
        Ok(())
    };
    status_of(begin())
}

/// Takes a line of the sensor, for example in the interrupt of a DMA: see #smr_readout. Lines come in order; those in
/// no window may be left out.
///
/// Cost: only pixels in the windows are converted.
///
/// @param readout  Filled by #smr_readout_begin. After an error only its `line` is changed.
/// @param y        The number of the line; the first is 0.
/// @param bytes    The line.
/// @param size     Bytes there; more than the line has are ignored.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE, #SMR_ERROR_LINE_OUT_OF_ORDER,
///                 #SMR_ERROR_LINE_TOO_SHORT, #SMR_ERROR_LINE_OUTSIDE_FRAME, #SMR_ERROR_LINE_MISSING,
///                 #SMR_ERROR_OVERLAPS_TRACKER if the line lies in the memory of a window, or an error of #smr_readout_begin
///                 if the readout was changed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_line(
    readout: *mut smr_readout,
    y: u16,
    bytes: *const u8,
    size: usize,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe { pushed(readout, bytes, size, |readout, bytes, pixels| readout.push_line(y, bytes, pixels)) })
}

/// Takes all lines of a frame that is in memory. Not for interrupts: it takes as long as all its lines.
///
/// @param readout  Filled by #smr_readout_begin. After an error the lines before its `line` have come.
/// @param bytes    The first line.
/// @param size     Bytes there.
/// @param stride   Bytes from a line to the next one.
/// @return         As #smr_readout_line. A frame that ends early has lines that are too short.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_lines(
    readout: *mut smr_readout,
    bytes: *const u8,
    size: usize,
    stride: usize,
) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        pushed(readout, bytes, size, |readout, bytes, pixels| readout.push_frame(bytes, stride, pixels))
    })
}

/// Gives the `size` bytes to `push`, and notes its next line and its result.
///
/// # Safety
/// As the header demands of the caller of #smr_readout_line.
unsafe fn pushed(
    to: *mut smr_readout,
    bytes: *const u8,
    size: usize,
    push: impl FnOnce(&mut Readout, &[u8], &mut [u8]) -> Result<(), ReadoutError>,
) -> Result<(), smr_status> {
    // SAFETY: as the caller ensures.
    let begun = unsafe { smr_readout::read(to)? };
    pointer::check_bytes(bytes, size, &[pointer::range(begun.pixels, begun.size), 0..0])?;
    let mut readout = begun.open()?;
    // Whoever has the frame may be reading its pixels, but then no line of the windows is left to come.
    let room = if readout.is_complete() { 0 } else { begun.size };
    // SAFETY: as the caller ensures; the line is outside the windows' memory.
    let result = unsafe {
        let (bytes, pixels) = (slice::from_raw_parts(bytes, size), slice::from_raw_parts_mut(begun.pixels, room));
        push(&mut readout, bytes, pixels)
    };
    // SAFETY: `to` was read.
    unsafe { smr_readout::note(to, readout.next, result) }
}

/// The frame with its windows, for #smr_lock and #smr_update. Lines below the windows need not have come.
///
/// It changes nothing but `frame`, so an interrupt may bring lines at any time: see #smr_readout.
///
/// @param readout  Filled by #smr_readout_begin.
/// @param frame    Is filled; need not be initialised. It points to the memory of the windows. Unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_LINE_MISSING as long as a line of a window has not come, or
///                 an error of #smr_readout_begin if the readout was changed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_frame(readout: *const smr_readout, frame: *mut smr_frame) -> smr_status {
    let fill = || {
        // SAFETY: as the header demands of the caller.
        let (begun, frame) = unsafe { (smr_readout::read(readout)?, Out::new(frame)?) };
        if !begun.open()?.is_complete() {
            return Err(SMR_ERROR_LINE_MISSING);
        }
        let (width, height) = begun.format()?.gray_size((begun.columns, begun.lines));
        frame.write(smr_frame { width, height, parts: begun.parts() });
        Ok(())
    };
    status_of(fill())
}
