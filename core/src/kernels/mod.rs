//! Fast sums over pixels and cells: the inner loops of both trackers. All `unsafe` code of the crate is here.
//!
//! The plain loops in `plain/` are the specification: every other loop of the same name gives the same integers.
//! `check.rs` tests all of them.
//!
//! | folder or file | instruction set | used when | tested |
//! |---|---|---|---|
//! | `plain/` | any | no faster backend exists | always |
//! | `x86/avx2.rs` | AVX2 | found at run time (`std`) or compiled for | where the machine has it |
//! | `x86/ssse3.rs` | SSSE3 (Intel since 2006, AMD since 2011) | the same, without AVX2 | where the machine has it |
//! | `neon.rs` | NEON | compiled for | emulated by QEMU (`.ci/run neon`), or natively |
//! | `simd128.rs` | SIMD128, the vectors of WebAssembly | compiled for | in Node (`.ci/web`) |
//! | `arm/dsp/` | DSP extension of Armv7E-M and Armv8-M | compiled for, without Helium | `examples/kernels` on the emulated Cortex-M4 and M7 |
//! | `arm/helium/` | Helium, the vectors of Armv8.1-M | compiled for | `examples/kernels` on the emulated Cortex-M55 |
//! | `swar/` | any but DSP and Helium: words of four pixels in ordinary registers | no faster one exists (Armv6-M, RV32, plain WebAssembly, older x86-64) | always; `examples/kernels` on the emulated Cortex-M0+ and RV32 |
//!
//! Each loop has a file for its plain version, one for each instruction set that has its own version, and one that
//! chooses:
//!
//! | loop | chosen in | plain | x86 | NEON | SIMD128 | DSP, Helium | words |
//! |---|---|---|---|---|---|---|---|
//! | scores, distances (SAD), and upper bounds of scores for groups of offsets and for four offsets at a time | `scorer.rs` | `scores.rs` | `scores.rs` | `neon.rs` | `simd128.rs` | `scores.rs`, `bounds.rs` | `scores.rs` |
//! | responses of a filter, gradients of its error | `products.rs` | `products.rs` | AVX2: `avx2.rs` | (compiler) | `products.rs` | `products.rs` | `products.rs` |
//! | cells of gradient orientations (HOG) | `native.rs` | `gradients.rs` | (compiler) | (compiler) | (compiler) | `gradients.rs` | (plain) |
//! | layers of the refiner's network | `products.rs` | `dense.rs` | AVX2: `avx2.rs` | (compiler) | (compiler) | `dense.rs` | (plain) |
//! | bilinear sampling of a row, contrast of a patch, update of a template | `native.rs` | `levels.rs` | (compiler) | (compiler) | (compiler) | `levels.rs` | sampling: `levels.rs` |
//! | weights of a filter: coding, steps | `native.rs` | `weights.rs` | (compiler) | (compiler) | (compiler) | `weights.rs` | (plain) |
//!
//! "(compiler)" stands for the plain loop, which the compiler vectorizes where it can.
//!
//! A [`Backend`] chooses scores, products and layers, by the macro `by_backend!` (`backend.rs`). It has the one list of
//! instruction sets. Each of them is a module that says whether it is available, and takes from `plain` the loops that
//! it does not do faster. The other loops follow the set that the program is compiled for: `native`.
//!
//! `generic.rs` holds the score loops of x86-64, AArch64 and WebAssembly, written once over a vector trait. The file of
//! an instruction set defines its vector and the lookup in a table. The loops in `arm/` are assembly; `arm/scores.rs`
//! calls those of scores, for both instruction sets there. `scores.rs` says what a backend has, and decides how often a
//! bound is worth its time. `rows.rs` gives the kernels the rows of two pictures, `three_sums.rs` saves products,
//! `unrolling.rs` keeps loops small.
//!
//! Words in ordinary registers (`swar/`): on Armv6-M and RV32IMAC words cannot be loaded from any address, and a word
//! assembled from bytes costs more than it saves. So only ranges and bounds use words. They take 7 bits of a pixel.
//! Ranges lie at multiples of four in a buffer of the search, and words of a row are shifted out of aligned words.
//! Scores, distances and sums of products are loops over single numbers that share loads: Arm and RV32 score four
//! offsets at once, and up to nine sums take a factor together. On Armv6-M these sums are in the high registers, to
//! which it can only add. `examples/README.md` compares the instructions with those of the plain loops.
//!
//! Inlining: a function with an intrinsic is always inlined into a function with `#[target_feature]`, since only there
//! the intrinsic becomes an instruction. So is a function that would pass numbers through memory, where reading them
//! back stalls. Never inlined are functions that take less flash in one copy, and loops that need all registers. A
//! comment gives any other reason.
//!
//! # Where a weight for each pixel would go
//!
//! A kernel would multiply each similarity by a weight, a small integer, before adding it. `plain::scores::pixel` would
//! specify this; `generic::add_row`, `CutTable::of_pixels` and the loops of `arm/` would follow. The lookup and the
//! tables would stay. Bounds would take the sum of the weights instead of the number of pixels.

#![allow(unsafe_code)] // intrinsics and assembly; each block says why it is sound

#[cfg(any(smr_dsp, smr_helium))]
mod arm;
mod backend;
#[cfg(any(test, feature = "unstable"))]
pub mod check;
mod cut_table;
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
pub(crate) use cut_table::{MAX_PIXELS, ONE};
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
pub(crate) use scores::{ALL_FOUR, Blocks, RowsOfRanges};
pub(crate) use unrolling::rolled;

#[cfg(test)]
mod tests;
