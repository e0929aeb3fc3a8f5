//! Beyond the paper: a tracker for targets that change in light, size and view. It reports when it is uncertain.
//!
//! A correlation filter finds the target. It learns the target and its surroundings in every frame with enough evidence. SMR verifies
//! the target: an early template, which learns very slowly, is compared part by part. All numbers are integers. Every frame costs about
//! the same.
//!
//! ```text
//!   frame
//!     |
//!  motion        where the target is expected
//!     |
//!  sampling      the search window on the target's grid (grid)
//!     |
//!  gradients     cells of gradient orientations and gray
//!     |
//!  response      the filter at all offsets, its peak
//!     |
//!  verification  the agreement with the early template (template), displaced (displacement) and relit (lighting)
//!     |
//!  refinement    place and size to a fraction of a pixel
//!     |
//!  scale         the response at other scales
//!     |
//!  confidence    the state: tracking, uncertain, lost
//!     |       \
//!     |        redetection   if the target is lost: a second window, searched and verified like the first
//!     |
//!  learning      ridge regression on a Gaussian label (gaussian), if there is enough evidence
//!     |
//!   answer
//! ```
//!
//! `pipeline.rs` runs these stages and cuts them into steps, `state.rs` holds what the tracker remembers, `cost.rs` counts the work,
//! `constants.rs` holds the constants of the method that are not in [`Config`].

mod buffers;
mod confidence;
mod config;
mod constants;
mod cost;
mod displacement;
mod gaussian;
mod gradients;
mod grid;
mod learning;
mod lighting;
mod motion;
mod pipeline;
mod redetection;
mod refinement;
mod response;
mod sampling;
mod scale;
mod state;
mod target;
mod template;
#[cfg(test)]
mod tests;
mod verification;
mod workspace;

pub use config::Config;
#[cfg(feature = "unstable")]
pub use config::Part;
#[cfg(feature = "unstable")]
pub(crate) use constants::SPAN;
pub use constants::{CELL, CHANNELS, REACH};
pub use grid::Grid;
pub(super) use state::numbers;
pub use target::Robust;
pub use workspace::Workspace;
