//! Rectangles, and the frames that a tracker looks at.

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
    /// Left edge, to the right of the frame's left edge; may be negative.
    pub x: i32,
    /// Top edge, below the frame's top edge; may be negative.
    pub y: i32,
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

/// A part of a frame that is in memory: 8-bit gray pixels, and where in the frame they are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_part {
    /// The top left pixel in memory.
    pub pixels: *const u8,
    /// Bytes that may be read from `pixels` on: at least (height - 1) * stride + width.
    pub size: usize,
    /// Bytes from a pixel to the one below it: at least `width`.
    pub stride: usize,
    /// Pixels of a row; at least 1.
    pub width: u16,
    /// Rows; at least 1.
    pub height: u16,
    /// Where the part begins: column of the frame.
    pub x: u16,
    /// Where the part begins: row of the frame.
    pub y: u16,
}

/// One frame of the camera: its size, and what of it is in memory. Pixels are only read, and only during the call.
///
/// A whole frame is one part of the frame's own size at x = y = 0. Firmware that reads out only what the tracker asks for gives
/// #smr_window as the first part and, where there is one, #smr_sweep_window as the second.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_frame {
    /// Width of the whole frame.
    pub width: u16,
    /// Height of the whole frame.
    pub height: u16,
    /// What is in memory. There is no second part where its `pixels` are NULL.
    pub parts: [smr_part; 2],
}

/// 8-bit gray pixels, row by row without a gap.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_image {
    /// width * height bytes.
    pub pixels: *const u8,
    /// Pixels of a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
}

impl smr_part {
    /// The pixels, which must not lie in the `taken` addresses: there they would change while they are read.
    ///
    /// # Safety
    /// If `pixels` is not NULL, `size` bytes from there can be read, and nobody writes them as long as the result lives.
    unsafe fn image<'a>(&self, taken: &[Range<usize>; 2]) -> Result<Image<'a>, smr_status> {
        pointer::check_bytes(self.pixels, self.size, taken)?;
        // SAFETY: not NULL, bytes are always aligned, no longer than isize::MAX; the rest as the caller says.
        let pixels = unsafe { core::slice::from_raw_parts(self.pixels, self.size) };
        Ok(Image::with_stride(pixels, self.width, self.height, self.stride)?)
    }
}

impl smr_frame {
    /// What it says, for a call on a tracker with memory at the `taken` addresses.
    ///
    /// # Safety
    /// As for [`smr_part::image`], of both parts.
    pub(crate) unsafe fn frame<'a>(&self, taken: &[Range<usize>; 2]) -> Result<Frame<'a>, smr_status> {
        let [first, second] = &self.parts;
        // SAFETY: as the caller says.
        let frame = Frame::part(unsafe { first.image(taken)? }, first.x, first.y, self.width, self.height)?;
        if second.pixels.is_null() {
            return Ok(frame);
        }
        // SAFETY: as the caller says.
        Ok(frame.and_part(unsafe { second.image(taken)? }, second.x, second.y)?)
    }
}

/// Two structs with the same fields, one made from the other.
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
