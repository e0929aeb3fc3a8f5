//! Writes recordings and trackers' answers as files: for other programs, for firmware, and to watch.
//!
//! - [`Writer`]: a recording as a folder of pictures, a Y4M file, a raw dump or a C array, or in the layout of a toolkit.
//! - [`boxes`]: the answers of trackers, as text.
//! - [`VideoWriter`]: a recording with boxes drawn, as a video or a folder of pictures.

pub mod boxes;
mod c_array;
mod enlarged;
mod ffmpeg;
mod letters;
mod matroska;
mod overlay;
mod pixels_per_metre;
mod read_back;
mod sound;
mod video;
mod writer;

pub use overlay::Overlay;
pub use pixels_per_metre::PixelsPerMetre;
pub use video::{ENDINGS as FILM_ENDINGS, Plan, VideoWriter};
pub use writer::{Format, Writer, Written, is_whole};
