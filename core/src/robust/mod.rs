//! Beyond the paper: a tracker that holds when light, size and view change, and says so when it does not.

mod agreement;
mod config;
mod features;
mod filter;
mod gauss;
mod grid;
mod light;
mod peak;
mod place;
mod samples;
mod sweep;
mod templates;
mod threshold;
mod tracker;
mod trust;
#[doc(hidden)]
pub mod tuning;

pub use config::Config;
pub use grid::Grid;
pub use tracker::{Answer, FineRect, LockError, State, Tracker, UpdateError};

/// How far the filter searches to each side, in cells of 4 pixels of the grid.
pub const REACH: u16 = 8;
/// Pixels of the largest template.
const MOST_PIXELS: usize = 1600;
/// Cells of the largest filter.
const MOST_CELLS: usize = 200;
use grid::MOST_SIDE;
