//! A built-in recording of patterns without noise, where many offsets score exactly the same.
//!
//! A natural recording hardly ever has a tie, so it cannot show whether ties are decided as stated. Here a checkerboard
//! moves by half of its period, where the offsets to the left and to the right, above and below are equally close. Some
//! frames show nothing at all; in others a cone stands alone, whose score falls with every pixel, so that the runner-up
//! tells where exactly the neighbourhood of the peak ends.

use super::{GrayFrame, Sequence};

pub const NAME: &str = "periodic";

const WIDTH: u16 = 64;
const HEIGHT: u16 = 48;
const CELL: i32 = 4;

#[derive(Clone, Copy)]
enum Pattern {
    /// A checkerboard, moved this far to the right and down.
    Board(i32, i32),
    Flat,
    /// A cone with its top this far to the right and down, in the dark.
    Cone(i32, i32),
}

use Pattern::{Board, Cone, Flat};

const SCRIPT: [Pattern; 19] = [
    Board(0, 0),
    Board(4, 0),
    Board(4, 4),
    Board(6, 4),
    Board(6, 6),
    Board(2, 6),
    Flat,
    Flat,
    Board(2, 2),
    Board(6, 2),
    Board(5, 1),
    Board(5, 5),
    Flat,
    Board(1, 5),
    Cone(32, 24),
    Cone(32, 24),
    Cone(35, 22),
    Cone(30, 26),
    Cone(2, 26),
];

pub fn frames() -> impl ExactSizeIterator<Item = GrayFrame> + Send + 'static {
    SCRIPT.into_iter().map(|pattern| GrayFrame::drawn(WIDTH, HEIGHT, |x, y| pattern.level(x, y)))
}

impl Pattern {
    fn level(self, x: i32, y: i32) -> u8 {
        match self {
            Board(right, down) if ((x + right) / CELL + (y + down) / CELL) % 2 == 0 => 8,
            Board(..) => 190,
            Flat => 128,
            Cone(right, down) => {
                let distance = x.abs_diff(right) + y.abs_diff(down);
                u8::try_from(200_u32.saturating_sub(4 * distance)).unwrap_or(u8::MAX)
            }
        }
    }
}

pub(super) fn sequence() -> Sequence {
    Sequence { init: Some([26, 18, 12, 12].into()), truth: None, ..Sequence::made(NAME, frames(), vec![]) }
}
