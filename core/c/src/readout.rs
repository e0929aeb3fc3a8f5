//! Converts a camera's lines to gray as they arrive, and keeps the windows that a tracker reads.

use crate::frame::{smr_frame, smr_part, smr_rect};
use crate::pointer::{self, Out};
use crate::status::{
    SMR_ERROR_BUFFER_TOO_SMALL, SMR_ERROR_FORMAT_UNKNOWN, SMR_ERROR_LINE_MISSING, smr_status, status_of,
};
use core::sync::atomic::{Ordering, compiler_fence};
use core::{ptr, slice};
use smr_core::readout::{Format, Readout, ReadoutError, Shrink};
use smr_core::{Rect, Windows};

/// The format in which a camera sends its pixels: the address of one of the constants SMR_GRAY8 to SMR_GRAY10. A program
/// links only the formats that it names.
pub struct smr_format(Format);

/// One byte per pixel: gray.
#[unsafe(no_mangle)]
pub static SMR_GRAY8: smr_format = smr_format(Format::GRAY8);
/// Two bytes per pixel: Y U Y V. Gray is Y.
#[unsafe(no_mangle)]
pub static SMR_YUYV: smr_format = smr_format(Format::YUYV);
/// Two bytes per pixel: U Y V Y. Gray is Y.
#[unsafe(no_mangle)]
pub static SMR_UYVY: smr_format = smr_format(Format::UYVY);
/// Two bytes per pixel, the high byte first: five bits red, six green, five blue. Gray is (19595 R + 38470 G + 7471
/// B + 32768) >> 16, with R, G and B widened to eight bits by repeating their high bits.
#[unsafe(no_mangle)]
pub static SMR_RGB565_BE: smr_format = smr_format(Format::RGB565_BE);
/// RGB565 with the low byte first.
#[unsafe(no_mangle)]
pub static SMR_RGB565_LE: smr_format = smr_format(Format::RGB565_LE);
/// One byte per pixel, behind a mosaic of color filters. 2x2 pixels become one gray pixel: width and height halve.
#[unsafe(no_mangle)]
pub static SMR_BAYER8: smr_format = smr_format(Format::BAYER8);
/// Four gray pixels of ten bits in five bytes (MIPI RAW10). The low two bits are dropped.
#[unsafe(no_mangle)]
pub static SMR_GRAY10: smr_format = smr_format(Format::GRAY10);

/// The state of a frame that is being read out. #smr_readout_begin fills it; programs read only `line`.
///
/// Lines may arrive in an interrupt while the main loop polls #smr_readout_frame:
/// - #smr_readout_begin writes every field: call it in the interrupt, or while the interrupt is off.
/// - Only #smr_readout_line writes `next` and `line`. It writes no pixel of the windows after #smr_readout_frame has
///   succeeded, so the interrupt may stay on during #smr_lock and #smr_update. Begin the next frame after the
///   update, or in other memory.
/// - #smr_readout_frame only reads, and may be interrupted at any point.
///
/// The interrupt must run on the processor core of the main loop. You must prevent all other overlaps: two calls of
/// #smr_readout_line, or #smr_readout_lines and any other call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_readout {
    /// The pixel format.
    pub format: *const smr_format,
    /// Columns of the sensor.
    pub columns: u16,
    /// Lines of the sensor.
    pub lines: u16,
    /// Index of the next line. It increases after the pixels of a line are written.
    pub next: u16,
    /// Index of the line that caused the last error SMR_ERROR_LINE_...
    pub line: u16,
    /// The frame is shrunk by this: 1 to 4.
    pub shrink: u16,
    /// The windows to keep. If there is no second one, its width and height are 0.
    pub windows: [smr_rect; 2],
    /// The gray pixels of the first window, then those of the second.
    pub pixels: *mut u8,
    /// Size of the memory at `pixels`, in bytes.
    pub size: usize,
}

impl smr_readout {
    /// Copies `from` while an interrupt may change `next` and `line`: reads `next` once, sets the copy's `line` to 0.
    ///
    /// # Safety
    /// A `from` that passes [`pointer::check`] points to an `smr_readout`.
    unsafe fn read(from: *const Self) -> Result<Self, smr_status> {
        pointer::check(from)?;
        // SAFETY: `from` passed `check`, so it points to a readout. Only `next`, which is read as a volatile, and
        // `line`, which is not read, may change meanwhile.
        unsafe {
            let next = (&raw const (*from).next).read_volatile();
            // Pixels must be read later than `next`, because only lines with an index below `next` are complete.
            compiler_fence(Ordering::Acquire);
            Ok(Self { next, line: 0, ..*from })
        }
    }

    /// Stores `next` once the pixels are written. If `result` is an error of a line, stores the line's index in `line`.
    ///
    /// # Safety
    /// `to` points to an `smr_readout`, aligned, which only this call writes.
    unsafe fn store_progress(to: *mut Self, next: u16, result: Result<(), ReadoutError>) -> Result<(), smr_status> {
        use ReadoutError::{LineMissing, LineOutOfOrder, LineOutsideFrame, LineTooShort};
        compiler_fence(Ordering::Release);
        // SAFETY: `to` points to a readout, aligned, which only this call writes.
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
        let shrink = match self.shrink {
            1 => Shrink::By1,
            2 => Shrink::By2,
            3 => Shrink::By3,
            4 => Shrink::By4,
            _ => return Err(SMR_ERROR_FORMAT_UNKNOWN),
        };
        // SAFETY: by the header, `format` is NULL or the address of a constant of this file.
        unsafe { self.format.as_ref() }.map(|format| format.0.shrunk(shrink)).ok_or(SMR_ERROR_FORMAT_UNKNOWN)
    }

    /// Checks the fields and makes a `Readout` of them. Does not touch the pixels, which another call may be writing.
    fn core_readout(&self) -> Result<Readout, smr_status> {
        let ([first, second], format) = (self.windows.map(Rect::from), self.format()?);
        pointer::check_bytes(self.pixels, self.size, &[0..0, 0..0])?;
        let windows = Windows::new(first, Some(second).filter(|second| !second.is_empty()));
        let readout = Readout::new(format, (self.columns, self.lines), windows)?;
        if self.size < readout.pixels() {
            return Err(SMR_ERROR_BUFFER_TOO_SMALL);
        }
        Ok(readout.resumed(self.next))
    }

    /// The windows as parts of a frame, one after the other in `pixels`. `core_readout` has checked them.
    fn parts(&self) -> [smr_part; 2] {
        let [first, second] = self.windows.map(Rect::from);
        let first = smr_part::of(self.pixels, first);
        let rest = if second.is_empty() { ptr::null_mut() } else { self.pixels.wrapping_add(first.size) };
        [first, smr_part::of(rest, second)]
    }
}

/// Begins the read-out of a frame.
///
/// Windows are in pixels of the gray frame, which has the sensor's size, or half its width and height with #SMR_BAYER8.
/// Pass #smr_windows; before a lock pass #smr_lock_window and an empty one.
///
/// @param readout  Is filled; need not be initialised. Unchanged after an error.
/// @param format   The address of a constant, such as &SMR_YUYV: see #smr_format.
/// @param columns  Columns of the sensor.
/// @param lines    Lines of the sensor.
/// @param windows  Two windows inside the gray frame. Only the second may be empty.
/// @param pixels   Initialised memory for the gray pixels of the first window, then of the second, row by row without
///                 gaps. It must stay until the tracker was called with the frame.
/// @param size     Bytes at `pixels`; at least width * height of both windows.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE, #SMR_ERROR_FORMAT_UNKNOWN,
///                 #SMR_ERROR_OUTSIDE_FRAME or #SMR_ERROR_BUFFER_TOO_SMALL.
/// cbindgen:ptrs-as-arrays=[[windows; 2]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_begin(
    readout: *mut smr_readout,
    format: *const smr_format,
    columns: u16,
    lines: u16,
    windows: *const smr_rect,
    pixels: *mut u8,
    size: usize,
) -> smr_status {
    // SAFETY: by the header, each address is valid for its type, `windows` for two, `pixels` for `size` initialised bytes.
    unsafe { smr_readout_begin_shrunk(readout, format, columns, lines, 1, windows, pixels, size) }
}

/// #smr_readout_begin for a frame that is shrunk as its lines arrive, so that a large target needs a small buffer: each
/// of its pixels is the mean of `shrink` x `shrink` gray pixels. Windows, boxes and answers are in pixels of the small
/// frame, whose size is that of the gray frame divided by `shrink`.
///
/// The first of the lines of a block stores the means of `shrink` pixels, rounded. The k-th moves the stored pixel by the
/// k-th part of its difference to the mean of the new line, `(difference * ceil(65536 / k) + 32768) >> 16`. The result
/// is at most 1.0, 1.4 or 1.7 gray levels from the exact mean (`shrink` = 2, 3, 4), with #SMR_BAYER8 at most 2.2, 2.8 or
/// 3.2.
///
/// @param readout  As of #smr_readout_begin, and so for all that is not named here.
/// @param format   See above.
/// @param columns  See above.
/// @param lines    See above.
/// @param shrink   1 to 4; with 1 the call is #smr_readout_begin. #SMR_ERROR_FORMAT_UNKNOWN for another number.
/// @param windows  Two windows inside the small frame.
/// @param pixels   See above.
/// @param size     See above.
/// @return         As #smr_readout_begin.
/// cbindgen:ptrs-as-arrays=[[windows; 2]]
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // as smr_readout_begin, and one more
pub unsafe extern "C" fn smr_readout_begin_shrunk(
    readout: *mut smr_readout,
    format: *const smr_format,
    columns: u16,
    lines: u16,
    shrink: u16,
    windows: *const smr_rect,
    pixels: *mut u8,
    size: usize,
) -> smr_status {
    let begin = || {
        // SAFETY: by the header, `readout` points to memory for a readout, and `windows` to two rectangles.
        let (readout, windows) = unsafe { (Out::new(readout)?, pointer::read(windows.cast::<[smr_rect; 2]>())?) };
        let begun = smr_readout { format, columns, lines, next: 0, line: 0, shrink, windows, pixels, size };
        begun.core_readout()?;
        readout.write(begun);
        Ok(())
    };
    status_of(begin())
}

/// Converts a line of the sensor, for example in a DMA interrupt: see #smr_readout. Lines must come in order; lines
/// outside the windows may be skipped. Only pixels in the windows cost time.
///
/// @param readout  Filled by #smr_readout_begin. After an error only its `line` is changed.
/// @param y        Index of the line, from 0.
/// @param bytes    The bytes of the line.
/// @param size     The number of bytes; excess bytes are ignored.
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
    // SAFETY: by the header, `readout` is filled, its windows' memory belongs to this call, and `size` bytes can be
    // read at `bytes`.
    status_of(unsafe { convert(readout, bytes, size, |readout, bytes, pixels| readout.push_line(y, bytes, pixels)) })
}

/// Converts all lines of a frame in memory. Not for interrupts, because it returns only after the last line.
///
/// @param readout  Filled by #smr_readout_begin. After an error the lines before its `line` are converted.
/// @param bytes    The bytes of the frame.
/// @param size     The number of bytes.
/// @param stride   Bytes from the start of a line to the start of the next.
/// @return         As #smr_readout_line. A frame that ends early has lines that are too short.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_lines(
    readout: *mut smr_readout,
    bytes: *const u8,
    size: usize,
    stride: usize,
) -> smr_status {
    // SAFETY: by the header, `readout` is filled, its windows' memory belongs to this call, and `size` bytes can be
    // read at `bytes`.
    status_of(unsafe {
        convert(readout, bytes, size, |readout, bytes, pixels| readout.push_frame(bytes, stride, pixels))
    })
}

/// Calls `push` to convert the lines in `bytes`, then updates `next` and `line` of the readout `to`.
///
/// # Safety
/// A `to` that passes `pointer::check` points to an `smr_readout`. Its `size` bytes at `pixels`, if they pass too, are
/// initialised, and nobody else uses them during the call unless the readout is complete. If `bytes` is not NULL,
/// `size` bytes can be read there, and stay unchanged.
unsafe fn convert(
    to: *mut smr_readout,
    bytes: *const u8,
    size: usize,
    push: impl FnOnce(&mut Readout, &[u8], &mut [u8]) -> Result<(), ReadoutError>,
) -> Result<(), smr_status> {
    // SAFETY: `to` points to an `smr_readout`, if it passes `pointer::check`.
    let begun = unsafe { smr_readout::read(to)? };
    pointer::check_bytes(bytes, size, &[pointer::range(begun.pixels, begun.size), 0..0])?;
    let mut readout = begun.core_readout()?;
    // Once the windows are complete, the tracker may be reading them, so later lines get no memory to write to.
    let room = if readout.is_complete() { 0 } else { begun.size };
    // SAFETY: `size` bytes can be read at `bytes`, outside the windows' memory. That memory has `begun.size` bytes,
    // which nobody else uses unless `room` is 0.
    let result = unsafe {
        let (bytes, pixels) = (slice::from_raw_parts(bytes, size), slice::from_raw_parts_mut(begun.pixels, room));
        push(&mut readout, bytes, pixels)
    };
    // SAFETY: `read` has checked that `to` is neither NULL nor misaligned, and only this call writes the readout.
    unsafe { smr_readout::store_progress(to, readout.next_line(), result) }
}

/// Fills a frame for #smr_lock and #smr_update once all window lines have come. About interrupts see #smr_readout.
///
/// @param readout  Filled by #smr_readout_begin.
/// @param frame    Is filled; need not be initialised. Points to the windows' memory. Unchanged after an error.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_LINE_MISSING as long as a line of a
///                 window has not come, or an error of #smr_readout_begin if the readout was changed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_frame(readout: *const smr_readout, frame: *mut smr_frame) -> smr_status {
    let fill = || {
        // SAFETY: by the header, `readout` is filled, and `frame` points to memory for a frame.
        let (begun, frame) = unsafe { (smr_readout::read(readout)?, Out::new(frame)?) };
        if !begun.core_readout()?.is_complete() {
            return Err(SMR_ERROR_LINE_MISSING);
        }
        let (width, height) = begun.format()?.gray_size((begun.columns, begun.lines));
        frame.write(smr_frame { width, height, parts: begun.parts() });
        Ok(())
    };
    status_of(fill())
}
