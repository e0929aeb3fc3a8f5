//! The instruction set of WebAssembly.

pub(crate) mod simd128;
