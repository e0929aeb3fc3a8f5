//! The search: scores the offsets of a window and returns the **peak** and the **runner-up** (steps 1 and 4).
//!
//! Ties: of equal scores the offset closest to the centre of the window wins (least dx^2 + dy^2), then the smaller y,
//! then the smaller x. A target without texture therefore stays where it was.
//!
//! | file | what it does |
//! |---|---|
//! | `window.rs` | which offsets there are, what a search returns, and the tie rule |
//! | `runner_up.rs` | the runner-up, from the maximum of each row and column of scores |
//! | `floor.rs` | the peak so far, and the floor: the least score that can change the result |
//! | `exclusion.rs` | excludes groups of 4x4 offsets by the ranges of their pixels |
//! | `progress.rs` | the progress of a search and its budget; scores an offset |
//! | `tiles.rs` | excludes or scores the groups of a window |
//! | `scan.rs` | the stages of a search and its steps; the descent from the last position to a small SAD; the scouts |
//! | `most_work.rs` | the most comparisons of a search |

mod exclusion;
mod floor;
mod most_work;
mod progress;
mod runner_up;
mod scan;
mod tiles;
mod window;

pub(crate) use most_work::Extent;
pub(crate) use progress::{Scene, Search};
pub(crate) use window::Wanted;
pub use window::{Peak, Peaks, Radius, Window};

#[cfg(test)]
mod tests;
