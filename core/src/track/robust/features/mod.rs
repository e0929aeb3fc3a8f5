//! The features of a search window: its place (`motion`), its samples (`grid`, `sampling`), and its cells (`cells`).

pub(super) mod cells;
mod grid;
mod motion;
mod sampling;

pub(super) use cells::Extractor;
pub(super) use grid::Extent;
pub use grid::Grid;
pub(super) use motion::{Motion, Place};
pub(super) use sampling::{Lattice, SAMPLED, Sampling, most_read, row_of};
