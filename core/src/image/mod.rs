//! The input: a borrowed 8-bit [`Image`], the [`Frame`] of which one or two images are in memory, rectangles, and
//! [`readout`] of a camera's lines.
//!
//! Sizes are checked when an image or frame is made. Reads after that cannot fail.

mod frame;
pub mod readout;
mod rect;
#[cfg(test)]
mod tests;
mod view;

pub use frame::{Frame, FrameError};
pub use rect::{FineRect, Rect};
pub use view::{Image, ImageError};
