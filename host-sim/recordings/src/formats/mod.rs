//! Formats that host-sim reads itself: images, Y4M and raw dumps, each frame of them as gray levels.

pub(crate) mod images;
mod jpeg;
pub(crate) mod names;
mod pnm;
pub(crate) mod raw;
pub(crate) mod to_gray;
pub(crate) mod y4m;
