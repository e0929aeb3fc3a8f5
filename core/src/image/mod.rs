//! What the tracker looks at: a borrowed 8-bit [`Image`], the [`Frame`] it shows (wholly or in parts), and rectangles.
//!
//! Sizes are checked once, when a view is made; everything after that reads without being able to fail.

mod frame;
mod rect;
#[cfg(test)]
mod tests;
mod view;

pub use frame::{Frame, FrameError};
pub use rect::{FineRect, Rect};
pub use view::{Image, ImageError};
