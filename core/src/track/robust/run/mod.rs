//! The run of a frame through the stages, in pieces (`pipeline`, `lock`): inputs (`model`, `windows`), memory (`buffers`), most work (`cost`).

mod buffers;
mod cost;
mod lock;
mod model;
pub(super) mod pipeline;
mod windows;

pub(super) use buffers::Buffers;
pub(super) use lock::LockPipeline;
pub(super) use model::Model;
pub(super) use pipeline::Pipeline;
pub(super) use windows::{expected_pixels, lock_pixels, swept_pixels};
