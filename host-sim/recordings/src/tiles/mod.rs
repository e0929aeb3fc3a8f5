//! The built-in recording that firmware for boards draws as well, to measure its cycles: see `core/examples/cycles`.

mod scene;

use super::{BoundingBox, GrayFrame, Sequence};
use scene::{FRAMES, HEIGHT, SIDE, WIDTH};

pub const NAME: &str = "tiles";

pub(super) fn sequence() -> Sequence {
    let frame = |index| {
        let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| scene::level(index, x, y))).collect();
        GrayFrame { width: WIDTH, height: HEIGHT, pixels }
    };
    let truth = |index| {
        let (x, y) = scene::place(index);
        let side = f64::from(SIDE);
        let target = BoundingBox { x: x.into(), y: y.into(), width: side, height: side };
        (!scene::is_hidden(index)).then_some(target)
    };
    Sequence::made(NAME, (0..FRAMES).map(frame), (0..FRAMES).map(truth).collect())
}
