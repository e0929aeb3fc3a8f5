//! NEON, which every AArch64 with floating point has: 16 pixels in a vector. The compiler vectorizes the plain loops of
//! the other kernels.

pub(crate) mod scores;

#[cfg(feature = "refiner")]
pub(crate) use crate::kernels::plain::dense;
pub(crate) use crate::kernels::plain::products;

/// True: it is compiled only for processors that have it.
pub(crate) const fn is_available() -> bool {
    true
}
