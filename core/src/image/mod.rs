//! The input of a tracker: a borrowed [`Image`], a [`Frame`] of one or two images, rectangles, a camera's [`readout`].
//!
//! Constructors check all sizes, so later reads cannot fail.

mod frame;
mod pixel_formats;
pub mod readout;
mod rect;
#[cfg(test)]
mod tests;
mod view;
mod windows;

pub use frame::{Frame, FrameError, WindowError};
pub use rect::{FineRect, Rect};
pub use view::{Image, ImageError};
pub use windows::Windows;
