//! Detection of the instruction sets that this machine supports.

use super::backend::Backend;

impl Backend {
    const ALL: [Self; 8] =
        [Self::Avx2, Self::Ssse3, Self::Neon, Self::Simd128, Self::Helium, Self::Dsp, Self::Swar, Self::Scalar];

    /// The backends that this machine supports, the fastest first. [`Backend::Scalar`] is always the last.
    ///
    /// With the feature `std`, instruction sets are detected at run time. Without it, only those that the program is
    /// compiled for are available.
    pub fn available() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|backend| backend.is_available())
    }

    /// The fastest backend that this machine supports.
    #[must_use]
    #[cfg_attr(smr_small, inline)] // a constant
    pub fn best() -> Self {
        Self::available().next().unwrap_or(Self::Scalar)
    }

    /// True if this machine supports the backend.
    #[must_use]
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar => true,
            Self::Ssse3 => has_ssse3(),
            Self::Avx2 => has_avx2(),
            Self::Neon => cfg!(all(target_arch = "aarch64", target_feature = "neon")),
            Self::Simd128 => cfg!(all(target_arch = "wasm32", target_feature = "simd128")),
            Self::Dsp => cfg!(smr_dsp),
            Self::Helium => cfg!(smr_helium),
            Self::Swar => cfg!(not(any(smr_dsp, smr_helium))),
        }
    }

    /// This backend if the machine supports it, else [`Backend::Scalar`].
    pub(crate) fn or_scalar(self) -> Self {
        if self.is_available() { self } else { Self::Scalar }
    }
}

/// Detects SSSE3 at run time; without `std` and outside of tests, at compile time.
fn has_ssse3() -> bool {
    #[cfg(all(target_arch = "x86_64", any(test, feature = "std")))]
    return std::is_x86_feature_detected!("ssse3");
    #[cfg(not(all(target_arch = "x86_64", any(test, feature = "std"))))]
    return cfg!(all(target_arch = "x86_64", target_feature = "ssse3"));
}

/// Detects AVX2 at run time; without `std` and outside of tests, at compile time.
fn has_avx2() -> bool {
    #[cfg(all(target_arch = "x86_64", any(test, feature = "std")))]
    return std::is_x86_feature_detected!("avx2");
    #[cfg(not(all(target_arch = "x86_64", any(test, feature = "std"))))]
    return cfg!(all(target_arch = "x86_64", target_feature = "avx2"));
}
