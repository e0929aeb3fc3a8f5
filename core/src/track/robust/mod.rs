//! Beyond the paper: a tracker that holds when light, size and view change, and says so when it does not.
//!
//! A correlation filter finds the target: it learns in every frame what the target looks like, and what its surroundings look like. SMR
//! verifies it: an early template, which hardly learns, is compared part by part. All numbers are integers. Every frame costs about the
//! same.
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
//!  verification  the view of the peak; the early template (template) is displaced (displacement) and relit (lighting), and agrees or not
//!     |
//!  refinement    place and size to a fraction of a pixel
//!     |
//!  scale         the response at other scales
//!     |
//!  confidence    the state: tracking, uncertain, lost
//!     |       \
//!     |        redetection   if it is lost: a second window, searched and verified like the first
//!     |
//!  learning      ridge regression on a Gaussian label (gaussian), if there is enough evidence
//!     |
//!   answer
//! ```
//!
//! `pipeline.rs` runs these stages and cuts them into steps, `state.rs` holds what is remembered, `cost.rs` counts the work,
//! `constants.rs` holds the numbers of the method that are not in [`Config`].

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
