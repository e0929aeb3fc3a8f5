//! Compares the loops of a backend with formulas or the plain loops, for many sizes, alignments and thresholds, for
//! extreme values, and for slices that are too short. A difference panics.
//!
//! Unit tests do this for each backend of the host, with data that ends at a page that may not be read;
//! `tests/chip/kernels` does it on emulated chips, at the edges of their memory.

#![allow(clippy::indexing_slicing, clippy::unwrap_used)] // a panic is a result
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of noise

mod areas;
mod native;
mod products;
mod scores;

#[cfg(feature = "unstable")]
use super::backend::Backend;
pub use areas::{Areas, ROOM};
pub(super) use native::native;
#[cfg(feature = "refiner")]
pub(super) use products::dense;
pub(super) use products::products;
#[cfg(test)]
pub(super) use scores::cut;
pub(super) use scores::{candidates, groups, ranges, scores};

/// Compares all kernels of `backend`, and those selected at compile time, with formulas or the plain loops.
///
/// # Panics
/// If a result differs.
#[cfg(feature = "unstable")]
pub fn all(backend: Backend, areas: &mut Areas<'_>) {
    scores(backend, areas);
    candidates(backend, areas);
    ranges(backend, areas);
    groups(backend, areas);
    products(backend, areas);
    #[cfg(feature = "refiner")]
    dense(backend, areas);
    native(areas);
}
