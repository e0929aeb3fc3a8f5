//! Recordings as files: for other programs, for firmware, and to be looked at.
//!
//! - [`png()`], [`pgm`]: a frame as a picture.
//! - [`Writer`]: a recording as a folder of pictures, a Y4M file, a raw dump or a C array, or in the layout of a toolkit.
//! - [`Film`]: a recording with boxes drawn, as a video, an animation or a folder of pictures.

mod c_array;
mod draw;
mod encoded;
mod film;
mod matroska;
mod timeline;
mod toolkit;
mod writer;

pub use crate::encode::{pgm, png};
pub use draw::Overlay;
pub use film::{Film, Plan};
pub use timeline::Rate;
pub use writer::{Format, Writer, Written, is_whole};
