//! The worst case of a search that excludes offsets: pictures in which nothing resembles anything, so nothing is excluded.
//!
//! Every pixel of every frame is random by itself. The box stands in the middle throughout, with room around it for the
//! paper's window wherever an update has moved it within another.

use super::random::Random;
use super::{BoundingBox, GrayFrame, Sequence};

pub const NAME: &str = "noise";

/// A search is timed in 60 frames, and needs the two before each.
const LENGTH: usize = 62;
const WIDTH: u16 = 320;
const HEIGHT: u16 = 272;
const SIDE: u16 = 64;

fn frames() -> impl ExactSizeIterator<Item = GrayFrame> + Send + 'static {
    (0..LENGTH).map(|index| {
        let mut random = Random(0x4015_E000 + index as u64);
        let bytes = std::iter::repeat_with(|| random.next().to_le_bytes()).flatten();
        let pixels = bytes.take(usize::from(WIDTH) * usize::from(HEIGHT)).collect();
        GrayFrame { width: WIDTH, height: HEIGHT, pixels }
    })
}

pub(super) fn sequence() -> Sequence {
    let side = f64::from(SIDE);
    let target =
        BoundingBox { x: f64::from((WIDTH - SIDE) / 2), y: f64::from((HEIGHT - SIDE) / 2), width: side, height: side };
    Sequence::made(NAME, frames(), vec![Some(target); LENGTH])
}
