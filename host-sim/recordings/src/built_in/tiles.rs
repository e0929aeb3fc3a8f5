//! The built-in recording `tiles`, which firmware also draws to measure its cycles: see `tests/chip/cycles`.

use crate::annotations::boxes::BoundingBox;
use crate::raster::GrayFrame;
use crate::sequence::Sequence;
use smr_scene::tiles::{FRAMES, HEIGHT, SIDE, WIDTH, is_hidden, level, place};

pub const NAME: &str = "tiles";

pub(crate) fn sequence() -> Sequence {
    let frame = |index| {
        let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| level(index, x, y))).collect();
        GrayFrame { width: WIDTH, height: HEIGHT, pixels }
    };
    let truth = |index| {
        let (x, y) = place(index);
        (!is_hidden(index)).then_some(BoundingBox::from([x, y, SIDE, SIDE].map(i32::from)))
    };
    Sequence::made(NAME, (0..FRAMES).map(frame), (0..FRAMES).map(truth).collect())
}
