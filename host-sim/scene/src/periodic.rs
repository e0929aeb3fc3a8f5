//! A built-in recording of patterns without noise, where many offsets have equal scores, to test how ties are broken.
//!
//! A checkerboard moves by half of its period, where opposite offsets are equally close. Some frames are uniform.
//! Others show a cone: its score falls with every pixel, so the runner-up shows where the peak's neighbourhood ends.

use crate::Sides;

pub const WIDTH: u16 = 64;
pub const HEIGHT: u16 = 48;
pub const LENGTH: usize = SCRIPT.len() / 3;
/// Box on which trackers lock. No frame has ground truth.
pub const START: Sides = [26, 18, 12, 12];

const CELL: i32 = 4;

const FLAT: i32 = 0;
const BOARD: i32 = 1;
const CONE: i32 = 2;

/// Three numbers per frame: the pattern; then, in pixels, a board's shift left and up, or x and y of a cone's peak.
const SCRIPT: [i32; 57] = [
    BOARD, 0, 0, BOARD, 4, 0, BOARD, 4, 4, BOARD, 6, 4, BOARD, 6, 6, BOARD, 2, 6, FLAT, 0, 0, FLAT, 0, 0, BOARD, 2, 2,
    BOARD, 6, 2, BOARD, 5, 1, BOARD, 5, 5, FLAT, 0, 0, BOARD, 1, 5, CONE, 32, 24, CONE, 32, 24, CONE, 35, 22, CONE, 30,
    26, CONE, 2, 26,
];

/// Returns the gray level of the pixel (`x`, `y`) in frame `index`.
pub fn level(index: usize, x: i32, y: i32) -> u8 {
    let [pattern, right, down]: [i32; 3] = SCRIPT.as_chunks().0[index];
    let distance = x.abs_diff(right) + y.abs_diff(down);
    match pattern {
        BOARD if ((x + right) / CELL + (y + down) / CELL) % 2 == 0 => 8,
        BOARD => 190,
        CONE => u8::try_from(200_u32.saturating_sub(4 * distance)).unwrap_or(u8::MAX),
        _ => 128,
    }
}
