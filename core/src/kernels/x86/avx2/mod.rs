//! AVX2: 32 pixels in a vector.

#[cfg(feature = "refiner")]
pub(crate) mod dense;
pub(crate) mod products;
pub(crate) mod scores;

/// True if the machine has it, or without `std` if the program is compiled for it.
pub(crate) fn is_available() -> bool {
    #[cfg(feature = "std")]
    return std::is_x86_feature_detected!("avx2");
    #[cfg(not(feature = "std"))]
    return cfg!(target_feature = "avx2");
}
