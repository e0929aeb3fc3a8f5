//! Runs a frame through the stages in pieces: the pipelines of an update (`pipeline`) and of a lock (`lock`), their
//! inputs (`inputs`, `windows`), their scratch memory (`buffers`), the sizes of memory (`size`) and the upper bounds of
//! their work (`most_work`).

mod buffers;
mod inputs;
mod lock;
mod most_work;
pub(super) mod pipeline;
mod size;
mod windows;

pub(super) use buffers::Buffers;
pub(super) use inputs::Inputs;
pub(super) use lock::LockPipeline;
pub(super) use pipeline::Pipeline;
pub use size::{Size, Small, Standard};
pub(super) use windows::{expected_pixels, lock_pixels, swept_pixels};
