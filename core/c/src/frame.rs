//! Rectangles, and frames that may be only partly in memory.

use crate::pointer;
use crate::status::smr_status;
use core::ops::Range;
use smr_core::{FineRect, Frame, Image, Rect};

/// A rectangle in whole pixels of the frame. It may reach outside the frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_rect {
    /// Left edge, in pixels to the right of the frame's left edge; may be negative.
    pub x: i32,
    /// Top edge, in pixels below the frame's top edge; may be negative.
    pub y: i32,
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
}

/// A rectangle in units of 1/256 pixel of the frame. It may reach outside the frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_fine_rect {
    /// Left edge, in 1/256 pixel to the right of the frame's left edge; may be negative.
    pub x: i32,
    /// Top edge, in 1/256 pixel below the frame's top edge; may be negative.
    pub y: i32,
    /// Width in 1/256 pixel.
    pub width: u32,
    /// Height in 1/256 pixel.
    pub height: u32,
}

/// A rectangular part of a frame in memory: 8-bit gray pixels and their position in the frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_part {
    /// Address of the top left pixel.
    pub pixels: *const u8,
    /// Readable bytes from `pixels` on: at least (height - 1) * stride + width.
    pub size: usize,
    /// Bytes from a pixel to the pixel below it: at least `width`.
    pub stride: usize,
    /// Width in pixels; at least 1.
    pub width: u16,
    /// Height in pixels; at least 1.
    pub height: u16,
    /// Column of the frame at which the part begins.
    pub x: u16,
    /// Row of the frame at which the part begins.
    pub y: u16,
}

/// A camera frame: its size, and its parts in memory. A call only reads the pixels, and does not keep their address.
///
/// For a whole frame, pass one part of the frame's size at x = y = 0. If you read out only what the tracker needs, pass
/// #smr_windows as the parts, the second only if it is not empty.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_frame {
    /// Width of the whole frame in pixels.
    pub width: u16,
    /// Height of the whole frame in pixels.
    pub height: u16,
    /// The parts in memory. If there is no second part, its `pixels` are NULL.
    pub parts: [smr_part; 2],
}

/// An image of 8-bit gray pixels, row by row without gaps.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_image {
    /// Address of width * height bytes.
    pub pixels: *const u8,
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
}

impl smr_part {
    /// The part of a frame in the given window. `pixels` points to the window's pixels, row by row without gaps.
    pub(crate) fn of(pixels: *const u8, Rect { x, y, width, height }: Rect) -> Self {
        let [x, y] = [x, y].map(|place| u16::try_from(place).unwrap_or(0));
        let stride = usize::from(width);
        Self { pixels, size: stride * usize::from(height), stride, width, height, x, y }
    }

    /// The pixels as an image. They must lie outside `taken`, the tracker's memory, which changes while they are read.
    ///
    /// # Safety
    /// If `pixels` is not NULL, `size` bytes from there can be read, and nobody writes them while the result lives.
    #[inline(never)] // one copy in flash
    unsafe fn image<'a>(&self, taken: &[Range<usize>; 2]) -> Result<Image<'a>, smr_status> {
        pointer::check_bytes(self.pixels, self.size, taken)?;
        // SAFETY: not NULL, and `size` bytes, at most isize::MAX, can be read and stay unchanged while the result
        // lives.
        let pixels = unsafe { core::slice::from_raw_parts(self.pixels, self.size) };
        Ok(Image::with_stride(pixels, self.width, self.height, self.stride)?)
    }
}

impl smr_frame {
    /// # Safety
    /// For each part whose `pixels` are not NULL, `size` bytes from there can be read, and nobody writes them while the
    /// result lives.
    pub(crate) unsafe fn frame<'a>(&self, taken: &[Range<usize>; 2]) -> Result<Frame<'a>, smr_status> {
        let [first, second] = &self.parts;
        // SAFETY: `size` bytes of the first part can be read, and nobody writes them while the result lives.
        let frame = Frame::part(unsafe { first.image(taken)? }, first.x, first.y, self.width, self.height)?;
        if second.pixels.is_null() {
            return Ok(frame);
        }
        // SAFETY: `size` bytes of the second part can be read, and nobody writes them while the result lives.
        Ok(frame.and_part(unsafe { second.image(taken)? }, second.x, second.y)?)
    }
}

/// Implements `From` in both directions between two structs with the same fields.
macro_rules! same {
    ($($core:path, $c:ident { $($field:ident),+ })+) => {
        $(
            impl From<$core> for $c {
                fn from(from: $core) -> Self {
                    Self { $($field: from.$field.into()),+ }
                }
            }

            impl From<$c> for $core {
                fn from(from: $c) -> Self {
                    Self { $($field: from.$field.into()),+ }
                }
            }
        )+
    };
}
pub(crate) use same;

same! {
    Rect, smr_rect { x, y, width, height }
    FineRect, smr_fine_rect { x, y, width, height }
}
