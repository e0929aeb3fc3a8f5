//! Kernels for the instruction sets of x86-64: SSSE3 and AVX2.

pub(crate) mod avx2;
mod scores;
pub(crate) mod ssse3;
