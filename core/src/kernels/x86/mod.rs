//! The instruction sets of x86-64.

pub(crate) mod avx2;
mod scores;
pub(crate) mod ssse3;
