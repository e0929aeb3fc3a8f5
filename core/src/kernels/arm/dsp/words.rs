//! Words of four pixels, in which the DSP extension computes.

/// Pixels in a word.
pub(super) const LANES: usize = 4;

/// A word of four equal bytes.
pub(super) fn in_lanes(byte: u8) -> u32 {
    u32::from_ne_bytes([byte; LANES])
}
