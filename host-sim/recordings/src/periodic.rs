//! The other built-in recording: patterns without noise, where many offsets score exactly the same.
//!
//! A natural recording hardly ever has a tie, so it cannot show whether ties are decided as stated. Here a checkerboard
//! moves by half of its period, where the offsets to the left and to the right, above and below are equally close. Some
//! frames show nothing at all; in others a cone stands alone, whose score falls with every pixel, so that the runner-up
//! tells where exactly the neighbourhood of the peak ends.

use super::{BoundingBox, GrayFrame, Sequence, Source};

/// What it is called, on the command line and in tables.
pub const NAME: &str = "periodic";

const WIDTH: u16 = 64;
const HEIGHT: u16 = 48;
const CELL: u16 = 4;

/// What a frame shows.
#[derive(Clone, Copy)]
enum Pattern {
    /// A checkerboard, moved this far to the right and down.
    Board(u16, u16),
    /// Flat gray.
    Flat,
    /// A cone with its top this far to the right and down, in the dark.
    Cone(u16, u16),
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

/// All frames in order.
pub fn frames() -> impl Iterator<Item = GrayFrame> + Send + 'static {
    SCRIPT.into_iter().map(|pattern| {
        let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| pattern.level(x, y))).collect();
        GrayFrame { width: WIDTH, height: HEIGHT, pixels }
    })
}

impl Pattern {
    fn level(self, x: u16, y: u16) -> u8 {
        match self {
            Board(right, down) if ((x + right) / CELL + (y + down) / CELL).is_multiple_of(2) => 8,
            Board(..) => 190,
            Flat => 128,
            Cone(right, down) => {
                let distance = x.abs_diff(right) + y.abs_diff(down);
                u8::try_from(200_u16.saturating_sub(4 * distance)).unwrap_or(u8::MAX)
            }
        }
    }
}

pub(super) fn sequence() -> Sequence {
    let source = Source::made(frames(), SCRIPT.len(), NAME);
    let init = BoundingBox { x: 26.0, y: 18.0, width: 12.0, height: 12.0 };
    Sequence {
        name: NAME.to_owned(),
        frames: source.frames,
        length: source.length,
        first: 1,
        init: Some(init),
        truth: None,
        colors: super::Colors::None,
        damage: source.damage,
    }
}
