//! Runs a frame through the stages in pieces, for an update (`pipeline`) and a lock (`lock`): their inputs (`inputs`,
//! `windows`), memory (`buffers`) and bounds of work (`cost`).

mod buffers;
mod cost;
mod inputs;
mod lock;
pub(super) mod pipeline;
mod windows;

pub(super) use buffers::Buffers;
pub(super) use inputs::Inputs;
pub(super) use lock::LockPipeline;
pub(super) use pipeline::Pipeline;
pub(super) use windows::{expected_pixels, lock_pixels, swept_pixels};
