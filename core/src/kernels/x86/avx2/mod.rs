//! AVX2: 32 pixels in a vector.

#[cfg(feature = "refiner")]
pub(crate) mod dense;
pub(crate) mod products;
pub(crate) mod scores;

/// True if the machine has it; without `std` and outside of tests, if the program is compiled for it.
pub(crate) fn is_available() -> bool {
    #[cfg(any(test, feature = "std"))]
    return std::is_x86_feature_detected!("avx2");
    #[cfg(not(any(test, feature = "std")))]
    return cfg!(target_feature = "avx2");
}
