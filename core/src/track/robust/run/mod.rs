//! Runs a frame through the stages in pieces: the pipelines of an update (`pipeline`) and of a lock (`lock`), their
//! inputs (`inputs`, `windows`), their scratch memory (`buffers`) and the upper bounds of their work (`cost`).

mod buffers;
mod inputs;
mod lock;
mod most_work;
pub(super) mod pipeline;
mod windows;

pub(super) use buffers::Buffers;
pub(super) use inputs::Inputs;
pub(super) use lock::LockPipeline;
pub(super) use pipeline::Pipeline;
pub(super) use windows::{expected_pixels, lock_pixels, swept_pixels};
