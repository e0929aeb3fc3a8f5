//! The built-in recording `synthetic`, which `smr_scene::synthetic` draws, to test trackers.

use crate::bounding_box::BoundingBox;
use crate::raster::GrayFrame;
use crate::sequence::Sequence;
use smr_scene::synthetic::Textures;
pub use smr_scene::synthetic::{HEIGHT, LENGTH, WIDTH};
use std::sync::LazyLock;

pub const NAME: &str = "synthetic";

static TEXTURES: LazyLock<Textures> = LazyLock::new(|| Textures::new(0));

pub fn frames() -> impl Iterator<Item = GrayFrame> + Send + 'static {
    (0..LENGTH).map(frame)
}

/// Draws frame `index`, from 0. After the last frame nothing moves; only the noise goes on.
pub fn frame(index: usize) -> GrayFrame {
    drawn(&TEXTURES, index, 0x5EED_0000 + index as u64)
}

fn drawn(textures: &Textures, index: usize, noise: u64) -> GrayFrame {
    GrayFrame { width: WIDTH, height: HEIGHT, pixels: textures.frame(index, noise).collect() }
}

/// Draws the recording's frames with textures of `seed`, alternately forward and backward without end, with new noise.
fn endless(seed: u32) -> impl Iterator<Item = GrayFrame> + Send + 'static {
    let seed = u64::from(seed);
    let textures = Box::new(Textures::new(seed));
    let turns = (0..LENGTH).chain((0..LENGTH).rev()).cycle();
    turns.zip(seed << 32..).map(move |(index, noise)| drawn(&textures, index, noise))
}

/// Returns the endless recording `synthetic:SEED`; `None` if `name` is another one.
pub(crate) fn seeded(name: &str) -> Option<Sequence> {
    let seed = name.strip_prefix(NAME)?.strip_prefix(':')?.parse().ok()?;
    Some(Sequence { init: truth(0), ..Sequence::endless(name.to_owned(), endless(seed)) })
}

pub fn truth(index: usize) -> Option<BoundingBox> {
    smr_scene::synthetic::truth(index).map(BoundingBox::from)
}

pub(crate) fn sequence() -> Sequence {
    Sequence::made(NAME, (0..LENGTH).map(frame), (0..LENGTH).map(truth).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::Paper;
    use smr_core::paper::Config;
    use smr_core::{State, Tracker};

    #[test]
    fn the_script_is_kept() {
        let fnv = crate::fixtures::fnv(frames().flat_map(|frame| frame.pixels));
        assert_eq!(fnv, 0xB71D_F7BB_FDEB_9A1D, "{fnv:#X}");
        let of_box = |BoundingBox { x, y, width, height }: BoundingBox| [x, y, width, height].map(f64::to_be_bytes);
        let truth_of = |index| truth(index).map_or([[0; 8]; 4], of_box).concat();
        let fnv = crate::fixtures::fnv((0..LENGTH).flat_map(truth_of));
        assert_eq!(fnv, 0x2E56_2931_BD32_D5EC, "{fnv:#X}");
        let hidden: Vec<usize> = (0..LENGTH).filter(|&index| truth(index).is_none()).collect();
        assert_eq!(hidden, (173..=199).collect::<Vec<_>>());
        assert_eq!(truth(LENGTH - 1), truth(usize::MAX), "it stands still at the end");
    }

    #[test]
    fn the_tracker_follows_loses_and_finds_again() {
        let mut tracker = Tracker::<Paper>::with(Config::paper()).unwrap();
        let start = truth(0).and_then(|start| start.to_rect()).unwrap();
        tracker.lock(&frame(0).frame(), start).unwrap();
        let answers: Vec<_> = frames().map(|frame| tracker.update(&frame.frame()).unwrap()).collect();
        for (index, answer) in answers.iter().enumerate() {
            let overlap = truth(index).map(|truth| truth.iou(&answer.bbox.into()));
            assert!(overlap.is_none_or(|overlap| overlap > 0.5), "frame {index}: {answer:?}");
        }
        for state in [State::Tracking, State::Leaving, State::Lost] {
            assert!(answers.iter().any(|answer| answer.state == state), "{state:?}");
        }
    }
}
