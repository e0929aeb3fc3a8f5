//! The DSP extension of Armv7E-M (Cortex-M4, M7) and Armv8-M (M33, M35P): four pixels in a word, by assembly.

mod bounds;
#[cfg(feature = "refiner")]
pub(crate) mod dense;
pub(crate) mod gradients;
pub(crate) mod levels;
pub(crate) mod products;
pub(crate) mod scores;
pub(crate) mod weights;
mod words;
