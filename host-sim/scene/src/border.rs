//! A built-in recording that tests the rules for targets near the picture's border: whether the template is updated
//! there, and how a target leaves the picture.
//!
//! The target has no noise except one pixel, which changes in every frame and so shows whether the template was
//! updated. The target stands at both sides of each edge of the update zone, leaves the picture and returns. Then a
//! twin appears, some of whose pixels differ. With many such pixels the target's score leads by more than 100, but not
//! by the ratio that a returning target needs. With few it is lost, and later found again.

use crate::Sides;

pub const WIDTH: u16 = 112;
pub const HEIGHT: u16 = 84;
pub const LENGTH: usize = SCRIPT.len() / 3;
const TARGET: (i32, i32) = (24, 28);
const TWIN: (i32, i32) = (30, 20);

/// Three numbers for each frame: left and top edge of the target in pixels, and the percentage of pixels that differ
/// between the target and its twin, a second copy (100: the frame has no twin).
const SCRIPT: [i32; 75] = [
    40, 30, 100, 20, 30, 100, 19, 30, 100, 25, 20, 100, 25, 19, 100, 60, 54, 100, 60, 55, 100, 86, 40, 100, 87, 40,
    100, 84, 41, 100, 92, 40, 100, 80, 42, 100, 78, 40, 100, 76, 44, 16, 75, 45, 16, 74, 45, 8, 400, 400, 100, 400,
    400, 100, 60, 40, 100, 61, 40, 100, 61, 40, 8, 58, 59, 100, 56, 20, 100, 50, -5, 100, 50, 1, 100,
];
const NOWHERE: (i32, i32) = (400, 400);

/// Returns the gray level of the pixel (`x`, `y`) in frame `index`.
pub fn level(index: usize, x: i32, y: i32) -> u8 {
    let [left, top, others] = SCRIPT.as_chunks().0[index];
    let of = |place: (i32, i32)| inside(x - place.0, y - place.1);
    match (of((left, top)), of(TWIN).filter(|_| others < 100)) {
        (Some((0, 0)), _) => [60, 100, 140][index % 3],
        (Some(at), _) => hash(at, 1),
        (None, Some(at)) if i32::from(hash(at, 3)) * 100 < others * 256 => hash(at, 1) ^ 0x80,
        (None, Some(at)) => hash(at, 1),
        (None, None) => hash((x, y), 2),
    }
}

/// Returns the target's box in frame `index`; `None` if it is outside the frame.
pub fn truth(index: usize) -> Option<Sides> {
    let [left, top, _] = SCRIPT.as_chunks().0[index];
    ((left, top) != NOWHERE).then_some([left, top, TARGET.0, TARGET.1])
}

fn inside(x: i32, y: i32) -> Option<(i32, i32)> {
    ((0..TARGET.0).contains(&x) && (0..TARGET.1).contains(&y)).then_some((x, y))
}

fn hash((x, y): (i32, i32), seed: u32) -> u8 {
    let mut bits = seed.wrapping_mul(0x9E37_79B1) ^ x.cast_unsigned() ^ y.cast_unsigned() << 12;
    for _ in 0..2 {
        bits = (bits ^ bits >> 15).wrapping_mul(0x2C1B_3C6D);
    }
    bits.to_be_bytes()[0]
}
