//! Frames of random pixels: the worst case of a search that rejects offsets early, because the search can reject none.
//!
//! The box stays in the middle, so that a second update's search window lies in the frame wherever the first moves it.

use crate::annotations::boxes::BoundingBox;
use crate::raster::GrayFrame;
use crate::sequence::Sequence;
use smr_scene::random::Random;

pub const NAME: &str = "noise";

/// Number of frames, enough to lock on each of the first 60 and time the second update after each lock.
const LENGTH: usize = 62;
const WIDTH: u16 = 320;
const HEIGHT: u16 = 272;
const SIDE: u16 = 64;

pub(crate) fn sequence() -> Sequence {
    let frame = |index| {
        let mut random = Random(0x4015_E000 + index as u64);
        let bytes = std::iter::repeat_with(|| random.next().to_le_bytes()).flatten();
        let pixels = bytes.take(usize::from(WIDTH) * usize::from(HEIGHT)).collect();
        GrayFrame { width: WIDTH, height: HEIGHT, pixels }
    };
    let target = BoundingBox::from([(WIDTH - SIDE) / 2, (HEIGHT - SIDE) / 2, SIDE, SIDE].map(i32::from));
    Sequence::made(NAME, (0..LENGTH).map(frame), vec![Some(target); LENGTH])
}
