//! Words of four pixels in ordinary 32-bit registers, for processors without a faster instruction set.

#[cfg(smr_swar)]
pub(crate) mod bilinear;
pub(crate) mod products;
pub(crate) mod scores;

#[cfg(feature = "refiner")]
pub(crate) use crate::kernels::plain::dense;
#[cfg(smr_swar)]
pub(crate) use crate::kernels::plain::{gradients, levels, weights};

/// True: every processor has such registers.
pub(crate) const fn is_available() -> bool {
    true
}
