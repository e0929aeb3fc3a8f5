//! The inner loops (kernels) of both trackers. All `unsafe` code of the crate is here.
//!
//! The plain loops in `plain/` are the specification. Every other version returns the same integers; only an upper
//! bound of a score may be looser. `check` compares them.
//!
//! | folder or file | instruction set | used when | tested |
//! |---|---|---|---|
//! | `plain/` | any | no faster backend exists | always |
//! | `x86/avx2.rs` | AVX2 | found at run time (`std`) or compiled for | where the machine has it |
//! | `x86/ssse3.rs` | SSSE3 (Intel since 2006, AMD since 2011) | the same, without AVX2 | where the machine has it |
//! | `neon.rs` | NEON | compiled for | emulated by QEMU (`.ci/run neon`), or natively |
//! | `simd128.rs` | SIMD128, the vectors of WebAssembly | compiled for | in Node (`.ci/web`) |
//! | `arm/dsp/` | DSP extension of Armv7E-M and Armv8-M | compiled for, without Helium | `tests/chip/kernels` on the emulated Cortex-M4 and M7 |
//! | `arm/helium/` | Helium, the vectors of Armv8.1-M | compiled for | `tests/chip/kernels` on the emulated Cortex-M55 |
//! | `swar/` | any but DSP and Helium: words of four pixels in ordinary registers | no faster one exists (Armv6-M, RV32, plain WebAssembly, older x86-64) | always; `tests/chip/kernels` on the emulated Cortex-M0+ and RV32 |
//!
//! Each kernel has a plain version, a version for some instruction sets, and a file that selects one:
//!
//! | kernel | selected in | plain | x86 | NEON | SIMD128 | DSP, Helium | words |
//! |---|---|---|---|---|---|---|---|
//! | scores, distances (SAD), and upper bounds of scores for 4x4 groups of offsets and for four neighbouring offsets | `scorer.rs` | `scores.rs` | `scores.rs` | `neon.rs` | `simd128.rs` | `scores.rs`, `bounds.rs` | `scores.rs` |
//! | responses of a filter, gradients of its error | `products.rs` | `products.rs` | AVX2: `avx2.rs` | (compiler) | `products.rs` | `products.rs` | `products.rs` |
//! | cells of gradient orientations (HOG) | `native.rs` | `gradients.rs` | (compiler) | (compiler) | (compiler) | `gradients.rs` | (plain) |
//! | layers of the refiner's network | `products.rs` | `dense.rs` | AVX2: `avx2.rs` | (compiler) | (compiler) | `dense.rs` | (plain) |
//! | bilinear sampling of a row, contrast of a patch, update of a template | `native.rs` | `levels.rs` | (compiler) | (compiler) | (compiler) | `levels.rs` | sampling: `levels.rs` |
//! | weights of a filter: quantisation, gradient steps | `native.rs` | `weights.rs` | (compiler) | (compiler) | (compiler) | `weights.rs` | (plain) |
//!
//! "(compiler)" stands for the plain loop, which the compiler vectorizes where it can.
//!
//! The macro `by_backend!` (`backend.rs`) selects the kernels of scores, products and layers for a [`Backend`]. It has
//! the only list of their modules, of which each re-exports the plain loops that it does not accelerate. `detect.rs`
//! detects which the processor supports. The other kernels are selected at compile time: `native.rs`.
//!
//! `generic` has the score loops of x86-64, AArch64 and WebAssembly, written once over a vector trait; the file of
//! an instruction set defines its vector and its table lookup. The loops in `arm/` are assembly. `scores.rs` defines
//! the trait of score kernels, `rows.rs` row addresses. `three_sums.rs` saves multiplications, `unrolling.rs` flash.
//!
//! `swar/` computes on words in ordinary registers. Armv6-M and RV32IMAC load words from aligned addresses only, and
//! assembling a word from bytes costs more than it saves. So only ranges and bounds use words, of 7 bits of each pixel.
//! All other kernels process single numbers but share loads: four offsets are scored at once, and up to nine sums share
//! a factor. `tests/chip/README.md` compares instruction counts with the plain loops.
//!
//! Inlining: a function with an intrinsic is always inlined into a function with `#[target_feature]`, because only
//! there it compiles to an instruction. So is a function that would pass numbers through memory, because reading them
//! back stalls. Never inlined are functions that take less flash in one copy, and loops that need all registers.
//!
//! # Where a weight for each pixel would go
//!
//! A kernel would multiply each similarity by a weight, a small integer, before adding it: in `plain::scores::pixel`
//! (the specification), `generic::add_row`, `CutTable::of_pixels` and the loops of `arm/`. Lookups and tables would
//! stay. Bounds would take the sum of the weights instead of the number of pixels.

#![allow(unsafe_code)] // intrinsics and assembly; each block says why it is sound

#[cfg(any(smr_dsp, smr_helium))]
mod arm;
mod backend;
#[cfg(any(test, feature = "unstable"))]
pub mod check;
mod cut_table;
mod detect;
#[cfg(any(
    target_arch = "x86_64",
    all(target_arch = "aarch64", target_feature = "neon"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
mod generic;
mod layout;
mod native;
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod neon;
mod plain;
mod products;
mod rows;
mod scorer;
mod scores;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;
#[cfg(not(any(smr_dsp, smr_helium)))]
mod swar;
#[cfg(not(smr_helium))]
#[cfg(not(target_arch = "wasm32"))]
mod three_sums;
mod unrolling;
#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(all(smr_helium, feature = "refiner"))]
pub(crate) use arm::helium::dense::copy;
pub use backend::Backend;
pub use cut_table::CutTable;
pub use layout::{CELL, CHANNELS};
pub(crate) use layout::{Layout, PACKED, Packed, SIDE};
pub(crate) use native::{GradientStep, Interpolation, ScaledSums, deviation, features, gradients, norms, replace};
pub(crate) use plain::levels::{BIAS, MixedRow};
#[cfg(feature = "refiner")]
pub(crate) use plain::{dense::Layer, gradients::root};
pub(crate) use products::Products;
#[cfg(feature = "refiner")]
pub(crate) use products::{Dense, SPARE};
pub use scorer::Scorer;
pub(crate) use scores::{ALL_FOUR, Blocks, MAX_PIXELS, ONE, RowsOfRanges};
pub(crate) use unrolling::rolled;

#[cfg(test)]
mod tests;
