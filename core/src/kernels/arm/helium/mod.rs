//! Helium, the vectors of Armv8.1-M (Cortex-M52, M55, M85): 16 pixels in a vector, by assembly.

pub(crate) mod bilinear;
mod candidates;
#[cfg(feature = "refiner")]
pub(crate) mod dense;
pub(crate) mod gradients;
mod groups;
pub(crate) mod levels;
pub(crate) mod products;
pub(crate) mod scores;
mod vectors;
pub(crate) mod weights;

/// True: it is compiled only for processors that have it.
pub(crate) const fn is_available() -> bool {
    true
}
