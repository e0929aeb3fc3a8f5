//! The similarity of equal pixels is 1.0. Tables store it as 65535.

/// The similarity of equal pixels: 1.0.
pub(crate) const ONE: u16 = u16::MAX;

/// The most pixels whose similarities a `u32` can sum: 65537.
pub(crate) const MAX_PIXELS: usize = u32::MAX as usize / ONE as usize;
