//! The input: a borrowed [`Image`], a [`Frame`] of one or two images, rectangles, and the [`readout`] of a camera.
//!
//! Constructors check all sizes, so later reads cannot fail.

mod frame;
pub mod readout;
mod rect;
#[cfg(test)]
mod tests;
mod view;

pub use frame::{Frame, FrameError};
pub use rect::{FineRect, Rect};
pub use view::{Image, ImageError};
