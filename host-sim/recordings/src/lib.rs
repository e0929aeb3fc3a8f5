//! Opens recordings by one call, [`open`]: folders of images, Y4M, video, raw dumps, cameras and built-in scenes.
//!
//! A [`Sequence`] streams frames with the boxes known about them. [`fault`] and [`cover`] change frames on their way to
//! a tracker.

pub mod annotations;
mod bounding_box;
mod built_in;
mod checked_frames;
mod color;
mod disturb;
mod ffmpeg;
mod find;
#[cfg(test)]
mod fixtures;
mod folder;
mod formats;
mod frame;
mod frame_number;
mod frame_range;
#[cfg(test)]
#[path = "../../../tests/missing.rs"]
mod missing;
mod open;
mod planes;
mod raster;
mod resize;
mod seekable;
mod sequence;
mod source;

pub use annotations::boxes;
pub use annotations::start::{Start, Target, check_gone, checked_name};
pub use bounding_box::{BoundingBox, Trajectory};
pub use built_in::{BUILT_IN, CHECKED, SLOW, slow, street, synthetic};
pub use checked_frames::Damaged;
pub use disturb::{away, cover, fault};
pub use ffmpeg::{Arrivals, Live, PATIENCE as FFMPEG_PATIENCE, input as ffmpeg_input, is_live, silent};
pub use find::recordings;
pub use folder::{INNER, RESULTS, is_of_boxes, is_of_frames, lone_video};
pub use formats::images::{ImageFile, decode_colors, decode_image};
pub use formats::to_gray::{Levels, luma};
pub use frame::{Frame, Frames, Moment};
pub use frame_number::FrameNumber;
pub use frame_range::{FrameRange, misfit};
pub use open::{OpenOptions, name_of, open, start_beside};
pub use planes::Planes;
pub use raster::{ColorFrame, GrayFrame, Raster};
pub use resize::{Resize, Scalable, resized};
pub use seekable::{Seekable, is_seekable};
pub use sequence::Sequence;
pub use source::Source;
