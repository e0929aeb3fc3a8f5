//! The instruction sets that kernels are written for, and those that this machine has.

#[cfg(target_arch = "x86_64")]
use super::x86::{avx2::scores as avx2, sse2};

/// An instruction set that computes scores and sums of products. All give the same integers.
///
/// # Where pixels may be
///
/// [`Backend::Dsp`] and [`Backend::Helium`] load words from any address. Arm's microcontrollers allow that in Normal
/// memory only. These accesses fault:
///
/// - in Device or Strongly-ordered memory. External RAM at 0xA000_0000 to 0xDFFF_FFFF is Device memory in the default
///   memory map, until firmware sets up the MPU to make it Normal;
/// - in all memory while `UNALIGN_TRP` is set.
///
/// In such memory use [`Backend::Scalar`], which loads bytes only: set `Config::backend` of either tracker.
/// [`Backend::Swar`] can read all memory.
///
/// ```
/// use smr_core::similarity::Backend;
/// assert!(Backend::available().any(|backend| backend == Backend::Scalar));
/// assert!(Backend::available().any(|backend| backend == Backend::best()));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Backend {
    /// The plain loop, the specification.
    Scalar,
    /// Any x86-64: distances, ranges and bounds 16 pixels at a time. The plain loop computes scores, and only if a
    /// bound says that the score can reach the floor.
    Sse2,
    /// x86-64 with AVX2: 32 pixels at a time.
    Avx2,
    /// AArch64 with NEON: 16 pixels at a time.
    Neon,
    /// SIMD128, the vectors of WebAssembly: 16 pixels at a time.
    Simd128,
    /// The DSP extension of Armv7E-M and Armv8-M (Cortex-M4, M7, M33): 4 pixels at a time.
    Dsp,
    /// Helium, the vectors of Armv8.1-M (Cortex-M52, M55, M85): 16 pixels at a time.
    Helium,
    /// Any processor, except those with DSP or Helium: words of four pixels in ordinary 32-bit registers, for ranges
    /// and bounds, and unrolled loops over bytes. The best one for 32-bit processors without DSP or SIMD (Cortex-M0+,
    /// RV32IMAC). A [`CutTable`](super::CutTable), of which each workspace has one, takes 510 bytes more there. Words
    /// are loaded from multiples of four only.
    Swar,
}

impl Backend {
    const ALL: [Self; 8] =
        [Self::Avx2, Self::Sse2, Self::Neon, Self::Simd128, Self::Helium, Self::Dsp, Self::Swar, Self::Scalar];

    /// The backends that this machine can run, the fastest first. [`Backend::Scalar`] is always the last.
    ///
    /// With the feature `std` the machine is asked at run time. Without it, only the instruction sets that the program
    /// is compiled for are available.
    pub fn available() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|backend| backend.is_available())
    }

    /// The fastest backend that this machine can run.
    #[must_use]
    #[cfg_attr(smr_small, inline)] // a constant
    pub fn best() -> Self {
        Self::available().next().unwrap_or(Self::Scalar)
    }

    /// True if this machine can run the backend.
    #[must_use]
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => sse2::is_available(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx2::is_available(),
            Self::Neon => cfg!(all(target_arch = "aarch64", target_feature = "neon")),
            Self::Simd128 => cfg!(all(target_arch = "wasm32", target_feature = "simd128")),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Sse2 | Self::Avx2 => false,
            Self::Dsp => cfg!(smr_dsp),
            Self::Helium => cfg!(smr_helium),
            Self::Swar => cfg!(not(any(smr_dsp, smr_helium))),
        }
    }
}
