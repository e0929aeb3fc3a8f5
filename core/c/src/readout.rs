//! A camera's lines as they come, in any pixel format, into the windows that a tracker needs.

use crate::frame::{smr_frame, smr_part, smr_rect};
use crate::pointer::{self, Out};
use crate::status::{SMR_ERROR_FORMAT_UNKNOWN, smr_status, status_of};
use core::ptr;
use core::sync::atomic::{Ordering, compiler_fence};
use smr_core::readout::{Format, Lines, Readout, ReadoutError};

/// How a camera sends its pixels.
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
    /// The same with the low byte first.
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
/// - #smr_readout_begin and #smr_readout_add_window write all of it: call them where no line can come, in the interrupt
///   itself or while it is switched off.
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
    /// The line after the last one that came. Written after its pixels.
    pub next: u16,
    /// The line that the last error SMR_ERROR_LINE_... is about.
    pub line: u16,
    /// The windows. If there is no second one, its `pixels` are NULL.
    pub windows: [smr_rect; 2],
    /// Where their gray pixels go.
    pub pixels: [*mut u8; 2],
    /// Bytes there.
    pub sizes: [usize; 2],
}

impl smr_readout {
    /// What is at `from`. An interrupt may change `next` and `line`: the one is read at once, the other not at all.
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
            let (format, columns, lines) = ((*from).format, (*from).columns, (*from).lines);
            let (windows, pixels, sizes) = ((*from).windows, (*from).pixels, (*from).sizes);
            Ok(Self { format, columns, lines, next, line: 0, windows, pixels, sizes })
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

    /// The lines, without the pixels, which another call may be writing.
    fn lines(&self) -> Result<Lines, smr_status> {
        let ([first, second], [near, far], [room, more]) = (self.pixels, self.windows, self.sizes);
        let format = self.format()?;
        pointer::check_bytes(first, room, &[0..0, 0..0])?;
        let lines = Lines::new(format, (self.columns, self.lines), near.into(), room)?;
        if second.is_null() {
            return Ok(lines.resume(self.next));
        }
        pointer::check_bytes(second, more, &[0..0, 0..0])?;
        Ok(lines.and_window(far.into(), more)?.resume(self.next))
    }

    /// The readout of `smr-core`, which has these `lines`.
    ///
    /// # Safety
    /// `pixels` that are not NULL point to as many bytes as `sizes` says, and nobody else uses them while the result
    /// lives.
    unsafe fn open<'a>(&self, lines: Lines) -> Readout<'a> {
        let ([first, second], [room, more]) = (self.pixels, self.sizes);
        // SAFETY: `lines` has checked the pointers; the rest as the caller ensures.
        unsafe {
            let second = if second.is_null() { &mut [] } else { core::slice::from_raw_parts_mut(second, more) };
            Readout::of(lines, core::slice::from_raw_parts_mut(first, room), second)
        }
    }
}

/// Begins a frame. The gray pixels of the window go to `pixels`, row by row without gaps.
///
/// Windows are in pixels of the gray frame, which has the sensor's size, or half of it with #SMR_BAYER8. Give
/// #smr_window, or #smr_lock_window before a lock.
///
/// @param readout  Is filled; need not be initialised. Unchanged after an error.
/// @param format   A number of #smr_format.
/// @param columns  Columns of the sensor.
/// @param lines    Lines of the sensor.
/// @param window   The window, not empty and inside the gray frame.
/// @param pixels   Initialised memory for width * height bytes, until the tracker was called with the frame.
/// @param size     Bytes there.
/// @return         #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE, #SMR_ERROR_FORMAT_UNKNOWN,
///                 #SMR_ERROR_OUTSIDE_FRAME or #SMR_ERROR_BUFFER_TOO_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_begin(
    readout: *mut smr_readout,
    format: i32,
    columns: u16,
    lines: u16,
    window: *const smr_rect,
    pixels: *mut u8,
    size: usize,
) -> smr_status {
    let begin = || {
        // SAFETY: as the header demands of the caller.
        let (readout, window) = unsafe { (Out::new(readout)?, pointer::read(window)?) };
        let (pixels, sizes) = ([pixels, ptr::null_mut()], [size, 0]);
        let begun = smr_readout { format, columns, lines, next: 0, line: 0, windows: [window; 2], pixels, sizes };
        begun.lines()?;
        readout.write(begun);
        Ok(())
    };
    status_of(begin())
}

/// Adds a second window: #smr_sweep_window. Before the first line.
///
/// @param readout  Filled by #smr_readout_begin. Unchanged after an error.
/// @param window   The window, not empty and inside the gray frame.
/// @param pixels   As for #smr_readout_begin; other memory than that of the first window.
/// @param size     Bytes there.
/// @return         As #smr_readout_begin; #SMR_ERROR_OVERLAPS_TRACKER if it is memory of the first window;
///                 #SMR_ERROR_LINE_OUT_OF_ORDER after the first line.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_readout_add_window(
    readout: *mut smr_readout,
    window: *const smr_rect,
    pixels: *mut u8,
    size: usize,
) -> smr_status {
    let add = || {
        // SAFETY: as the header demands of the caller.
        let (mut changed, window) = unsafe { (pointer::read(readout)?, pointer::read(window)?) };
        if changed.next > 0 {
            return Err(smr_status::SMR_ERROR_LINE_OUT_OF_ORDER);
        }
        pointer::check(pixels)?;
        let ([near, _], [first, _], [room, _]) = (changed.windows, changed.pixels, changed.sizes);
        (changed.windows, changed.pixels, changed.sizes) = ([near, window], [first, pixels], [room, size]);
        if pointer::overlap(&pointer::range(first, room), &pointer::range(pixels, size)) {
            return Err(smr_status::SMR_ERROR_OVERLAPS_TRACKER);
        }
        changed.lines()?;
        // SAFETY: `read` has checked the pointer.
        unsafe { readout.write(changed) };
        Ok(())
    };
    status_of(add())
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
    status_of(unsafe {
        pushed(readout, bytes, size, |begun, bytes| {
            let lines = begun.lines()?;
            Ok(match lines.check(y, bytes.len()) {
                // Whoever has the frame may be reading its pixels, but then none of its lines is left to come.
                Ok(true) => begun
                    .open(lines)
                    .push_line(y, bytes)
                    .map_or_else(|error| (begun.next, Err(error)), |()| (y + 1, Ok(()))),
                Ok(false) => (y + 1, Ok(())),
                Err(error) => (begun.next, Err(error)),
            })
        })
    })
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
        pushed(readout, bytes, size, |begun, bytes| {
            let mut readout = begun.open(begun.lines()?);
            let result = readout.push_frame(bytes, stride);
            Ok((readout.next_line(), result))
        })
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
    push: impl FnOnce(&smr_readout, &[u8]) -> Result<(u16, Result<(), ReadoutError>), smr_status>,
) -> Result<(), smr_status> {
    // SAFETY: as the caller ensures.
    let begun = unsafe { smr_readout::read(to)? };
    let ([first, second], [room, more]) = (begun.pixels, begun.sizes);
    let taken = [(first, room), (second, more)]
        .map(|(pixels, size)| pointer::range(pixels, if pixels.is_null() { 0 } else { size }));
    pointer::check_bytes(bytes, size, &taken)?;
    // SAFETY: as the caller ensures; the line is outside the windows' memory.
    let (next, result) = push(&begun, unsafe { core::slice::from_raw_parts(bytes, size) })?;
    // SAFETY: `to` was read.
    unsafe { smr_readout::note(to, next, result) }
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
        let lines = begun.lines()?;
        lines.check_frame()?;
        let (width, height) = lines.gray_size();
        frame.write(smr_frame { width, height, parts: begun.parts() });
        Ok(())
    };
    status_of(fill())
}

impl smr_readout {
    /// The windows, which were checked.
    fn parts(&self) -> [smr_part; 2] {
        let [near, far] = self.windows;
        let ([first, second], [room, more]) = (self.pixels, self.sizes);
        [(near, first, room), (far, second, more)].map(|(window, pixels, size)| {
            let smr_rect { x, y, width, height } = window;
            let place = |at: i32| u16::try_from(at).unwrap_or(0);
            smr_part { pixels, size, stride: width.into(), width, height, x: place(x), y: place(y) }
        })
    }
}
