//! SSE2, which every x86-64 has: 16 pixels in a vector. The compiler vectorizes the plain loops of the other kernels.

pub(crate) mod scores;

#[cfg(feature = "refiner")]
pub(crate) use crate::kernels::plain::dense;
pub(crate) use crate::kernels::plain::products;

/// True: the compiler may use it on every x86-64.
pub(crate) const fn is_available() -> bool {
    cfg!(target_feature = "sse2")
}
