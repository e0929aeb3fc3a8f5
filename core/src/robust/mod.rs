//! Beyond the paper: a tracker that holds when light, size and view change, and says so when it does not.
//!
//! It shares image, similarity and search with the paper's [`Tracker`](crate::Tracker). What it adds are parts, each in its
//! file, each with a switch in its [`Config`]:
//!
//! | part | file | what it does |
//! |---|---|---|
//! | grid | `grid.rs` | target and surroundings are resampled to about 1024 pixels, whatever the target's size |
//! | threshold | `threshold.rs` | alpha follows the template's contrast, not its last change |
//! | slow template | `templates.rs` | a running mean beside the last patch: it does not drift as fast |
//! | anchor | `light.rs` | an early template, in today's light, has a say: it drifts least |
//! | sub-pixel | `peak.rs` | a parabola through the peak: errors of half a pixel do not add up |
//! | cells | `cells.rs` | 8x8 cells of the template, matched by themselves, tell the change of size |
//! | verification | `agreement.rs`, `trust.rs` | an early template, slower than all, tells part by part whether it is still the target |
//! | sweep | `sweep.rs`, `correlation.rs` | a lost or doubtful target is looked for all over the frame, one window in each frame |
//!
//! Positions are in units of 1/4096 pixel, scales in units of 1/65536; a frame's position is that of its pixels' middles.

mod agreement;
mod cells;
mod config;
mod correlation;
mod grid;
mod light;
mod peak;
mod sweep;
mod templates;
mod threshold;
mod tracker;
mod trust;

pub use config::{Config, ThresholdRule};
pub use grid::Grid;
pub use tracker::{Answer, FineRect, LockError, State, Tracker, UpdateError};

/// How far the search reaches to each side, in pixels of the grid.
pub const RADIUS: u16 = 32;
/// Offsets on each axis.
const SPAN: usize = 2 * RADIUS as usize + 1;
/// The search keeps three groups of 4x4 offsets for each of so many: all of a window are 17 x 17 of them.
const GROUPS: usize = 97;

/// A similarity search over a window of this tracker: `WINDOW` bytes of ranges.
type Search<const WINDOW: usize> = crate::search::Search<WINDOW, GROUPS>;

#[cfg(test)]
mod tests;
