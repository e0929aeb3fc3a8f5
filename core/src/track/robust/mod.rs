//! Beyond the paper: a tracker that holds when light, size and view change, and says so when it does not.
//!
//! A filter says where the target is: it learns in every frame what the target is, and what it is not. SMR says whether it is still the
//! target: an early template, which hardly learns, is compared part by part. All numbers are integers, and every frame costs about the same.
//!
//! | part | file | what it does |
//! |---|---|---|
//! | grid | `grid.rs` | target and surroundings are resampled, so that the target has about 1600 pixels |
//! | features | `features.rs` | each cell of 4x4 pixels becomes ten bytes: gradients by direction, and gray |
//! | filter | `filter.rs`, `responses.rs`, `label.rs` | weights for the cells, a step of learning in each frame |
//! | velocity, near | `track.rs`, `responses.rs` | a moving target is expected to go on, and far places must answer more clearly |
//! | size | `update.rs` | the filter looks at two more scales |
//! | place and size, exactly | `exact.rs` | where the early template agrees well, it says where by its pixels, and how large |
//! | verification | `early.rs`, `light.rs`, `agreement.rs`, `trust.rs` | the early template tells whether it is still the target |
//! | caution | `trust.rs` | what does not agree is not learned |
//! | sweep | `sweep.rs` | a lost target is looked for all over the frame, one window in each frame |
//!
//! Positions are in units of 1/4096 pixel, scales in units of 1/65536; a frame's position is that of its pixels' middles.

mod agreement;
mod config;
mod cost;
mod early;
mod exact;
mod features;
mod filter;
mod grid;
mod label;
mod light;
mod responses;
mod saved;
mod sweep;
mod target;
#[cfg(test)]
mod tests;
mod track;
mod trust;
mod update;
mod workspace;

pub use config::Config;
#[cfg(feature = "ablation")]
pub use config::Part;
pub use features::{CELL, CHANNELS};
pub use grid::Grid;
pub(super) use saved::numbers;
pub use target::Robust;
pub use workspace::Workspace;

/// The most that the filter searches to each side, in cells: see `Config::reach`.
pub const REACH: u16 = 8;
/// Pixels of the largest template.
const MOST_PIXELS: usize = 1600;
/// Cells of the largest filter.
const MOST_CELLS: usize = 200;
