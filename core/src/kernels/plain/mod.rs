//! The plain loops: they specify every kernel, and compute where no instruction set does it faster.
#![allow(dead_code)] // a processor with a faster loop does not need the plain one

#[cfg(feature = "refiner")]
pub(crate) mod dense;
pub(crate) mod gradients;
pub(crate) mod levels;
pub(crate) mod products;
pub(crate) mod scores;
pub(crate) mod weights;
