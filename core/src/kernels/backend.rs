//! Instruction sets of the kernels ([`Backend`]), and the selection of a kernel by them.

/// Evaluates `$call` with `$set` as the module of the backend's instruction set. The modules are listed only here; each
/// has `products` and `dense`. For `Scalar`, or a backend that is not compiled in, `$set` is `plain`.
macro_rules! by_backend {
    ($backend:expr, $set:ident => $call:expr) => {
        by_backend!(@ $backend, Backend, $set => $call; _ => {
            use $crate::kernels::plain as $set;
            $call
        })
    };
    // Matches an enum with a variant for each compiled backend, and binds `$kernels` to the content of the variant.
    ($ready:expr, $type:ident($kernels:ident) => $call:expr) => {
        by_backend!(@ $ready, $type($kernels), set => $call; $type::Scalar($kernels) => $call)
    };
    (@ $value:expr, $type:ident$(($kernels:ident))?, $set:ident => $call:expr; $last:pat => $other:expr) => {{
        #[allow(unused_imports)] // kernels that a variant holds need no module
        match $value {
            #[cfg(target_arch = "x86_64")]
            $type::Ssse3$(($kernels))? => {
                use $crate::kernels::x86::ssse3 as $set;
                $call
            }
            #[cfg(target_arch = "x86_64")]
            $type::Avx2$(($kernels))? => {
                use $crate::kernels::x86::avx2 as $set;
                $call
            }
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            $type::Neon$(($kernels))? => {
                use $crate::kernels::neon as $set;
                $call
            }
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            $type::Simd128$(($kernels))? => {
                use $crate::kernels::simd128 as $set;
                $call
            }
            #[cfg(smr_dsp)]
            $type::Dsp$(($kernels))? => {
                use $crate::kernels::arm::dsp as $set;
                $call
            }
            #[cfg(smr_helium)]
            $type::Helium$(($kernels))? => {
                use $crate::kernels::arm::helium as $set;
                $call
            }
            #[cfg(not(any(smr_dsp, smr_helium)))]
            $type::Swar$(($kernels))? => {
                use $crate::kernels::swar as $set;
                $call
            }
            $last => $other,
        }
    }};
}

pub(crate) use by_backend;

/// The module of the instruction set that the program is compiled for. `native.rs` uses its loops.
#[cfg(smr_dsp)]
pub(super) use super::arm::dsp as native;
#[cfg(smr_helium)]
pub(super) use super::arm::helium as native;
#[cfg(not(any(smr_dsp, smr_helium, smr_swar)))]
pub(super) use super::plain as native;
#[cfg(smr_swar)]
pub(super) use super::swar as native;

/// Instruction set of the kernels, which compute scores and sums of products. All sets return the same integers.
///
/// # Where pixels may be
///
/// [`Backend::Dsp`] and [`Backend::Helium`] load words from any address, which Arm's microcontrollers allow in Normal
/// memory only. These loads fault:
///
/// - in Device or Strongly-ordered memory. External RAM at 0xA000_0000 to 0xDFFF_FFFF is Device memory until firmware
///   sets up the MPU to make it Normal;
/// - in all memory while `UNALIGN_TRP` is set.
///
/// For pixels in such memory select [`Backend::Scalar`], which loads single bytes, in `Config::backend` of either
/// tracker. [`Backend::Swar`] can read all memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Backend {
    /// Plain Rust loops: the specification of all results.
    Scalar,
    /// x86-64 with SSSE3 (Intel since 2006, AMD since 2011): 16 pixels at a time.
    Ssse3,
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
    /// Any processor without DSP and Helium: unrolled byte loops, and words of four pixels in ordinary 32-bit registers
    /// for score bounds. The fastest backend on processors without DSP or SIMD (Cortex-M0+, RISC-V, Xtensa); there the
    /// `CutTable` in each workspace is 510 bytes larger than elsewhere. Loads words only from addresses divisible by 4.
    Swar,
}
