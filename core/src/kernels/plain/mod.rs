//! Plain Rust loops. They specify every kernel, and run where no instruction set is faster.
#![allow(dead_code)] // a processor with a faster loop does not need the plain one

#[cfg(feature = "refiner")]
pub(crate) mod dense;
pub(crate) mod gradients;
pub(crate) mod levels;
pub(crate) mod products;
pub(crate) mod scores;
pub(crate) mod weights;
