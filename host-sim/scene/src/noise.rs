//! Frames of random pixels: the worst case of a search that rejects offsets early, because the search can reject none.
//!
//! The box stays in the middle, so that a second update's search window lies in the frame wherever the first moves it.

use crate::Sides;
use crate::random::Random;

/// Number of frames, enough to lock on each of the first 60 and time the second update after each lock.
pub const LENGTH: usize = 62;
pub const WIDTH: u16 = 320;
pub const HEIGHT: u16 = 272;
pub const TARGET: Sides = [(WIDTH as i32 - SIDE) / 2, (HEIGHT as i32 - SIDE) / 2, SIDE, SIDE];

const SIDE: i32 = 64;

/// Draws frame `index`, row by row.
pub fn frame(index: usize) -> impl Iterator<Item = u8> {
    let mut random = Random(0x4015_E000 + index as u64);
    let bytes = core::iter::repeat_with(move || random.next().to_le_bytes()).flatten();
    bytes.take(usize::from(WIDTH) * usize::from(HEIGHT))
}
