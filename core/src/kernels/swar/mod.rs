//! Words of four pixels in ordinary 32-bit registers, for processors without a faster instruction set.

#[cfg(all(smr_swar, target_arch = "arm"))]
pub(crate) mod gradients;
#[cfg(smr_swar)]
pub(crate) mod levels;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) mod products;
pub(crate) mod scores;

#[cfg(feature = "refiner")]
pub(crate) use crate::kernels::plain::dense;
#[cfg(all(smr_swar, not(target_arch = "arm")))]
pub(crate) use crate::kernels::plain::gradients;
// The plain loops, because a WebAssembly module must be small, and nearly all browsers have SIMD128.
#[cfg(target_arch = "wasm32")]
pub(crate) use crate::kernels::plain::products;
#[cfg(smr_swar)]
pub(crate) use crate::kernels::plain::weights;
