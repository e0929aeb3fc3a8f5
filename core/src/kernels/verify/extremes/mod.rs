//! Calls kernels at extreme values and in all shapes, on a microcontroller too.

pub(crate) mod filter;
#[cfg(feature = "refiner")]
mod layers;
pub(in crate::kernels) mod noise;
