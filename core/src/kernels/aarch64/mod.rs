//! The instruction set of AArch64.

pub(crate) mod neon;
