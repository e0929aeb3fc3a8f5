//! The run of a frame through the stages, in pieces (`pipeline`, `lock`): inputs (`inputs`, `windows`), memory (`buffers`), most work (`cost`).

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
