//! Turns an `ffmpeg` (5.1 or later) from the PATH into facts: images, and whether they are whole.
//!
//! ffmpeg fills damaged areas and often ends with success, and its messages differ between versions. So nothing here
//! reads the words of a message. The facts are its exit status (`-xerror -err_detect explode`), the level of each
//! message, images in NUT, lines of packets by `framecrc`, and the time of each image by the filter `metadata`.
//! Messages are only quoted.

mod decoder;
mod facts;
mod index;
mod last_whole_image;
mod live;
mod matroska;
mod nut;
mod packets;
mod process;
mod reading;
#[cfg(test)]
mod tests;
mod tones;

pub(super) use decoder::{Image, Use};
pub(super) use index::{Index, count};
pub(super) use live::without_secrets;
pub use live::{Arrivals, Live, is_live};
pub use process::{PATIENCE, input, silent};
pub(super) use reading::{good, open, sought};

use crate::formats::names::has_extension;
use std::path::Path;

/// Extensions that mark a video in a folder. A file that the user names goes to ffmpeg whatever its extension.
const EXTENSIONS: [&str; 22] = [
    "mpg", "mpeg", "mp4", "m4v", "mov", "avi", "mkv", "webm", "wmv", "flv", "ts", "mts", "m2ts", "ogv", "3gp", "m1v",
    "m2v", "h264", "h265", "hevc", "ivf", "mjpeg",
];

pub(super) fn is_video(file: &Path) -> bool {
    has_extension(file, &EXTENSIONS)
}
