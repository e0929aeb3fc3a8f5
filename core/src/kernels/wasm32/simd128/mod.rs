//! SIMD128, the vectors of WebAssembly: 16 pixels in a vector. The compiler vectorizes the plain loop of layers.

pub(crate) mod products;
pub(crate) mod scores;

#[cfg(feature = "refiner")]
pub(crate) use crate::kernels::plain::dense;

/// True: it is compiled only for processors that have it.
pub(crate) const fn is_available() -> bool {
    true
}
