//! A built-in recording that tests the rules for targets near the picture's border: whether the template is updated
//! there, and how a target leaves the picture.
//!
//! The target has no noise except one pixel, which changes in every frame and so shows whether the template was
//! updated. The target stands at both sides of each edge of the update zone, leaves the picture and returns. Then a
//! twin appears, some of whose pixels differ. With many such pixels the target's score leads by more than 100, but not
//! by the ratio that a returning target needs. With few it is lost, and later found again.

use crate::annotations::boxes::BoundingBox;
use crate::raster::GrayFrame;
use crate::sequence::Sequence;

pub const NAME: &str = "border";

const WIDTH: u16 = 112;
const HEIGHT: u16 = 84;
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

fn script() -> impl ExactSizeIterator<Item = ((i32, i32), i32)> + Send {
    SCRIPT.as_chunks().0.iter().map(|&[x, y, others]| ((x, y), others))
}

pub fn frames() -> impl ExactSizeIterator<Item = GrayFrame> + Send + 'static {
    script().enumerate().map(|(index, (target, others))| {
        GrayFrame::drawn(WIDTH, HEIGHT, |x, y| {
            let of = |place: (i32, i32)| inside(x - place.0, y - place.1);
            match (of(target), of(TWIN).filter(|_| others < 100)) {
                (Some((0, 0)), _) => [60, 100, 140][index % 3],
                (Some(at), _) => hash(at, 1),
                (None, Some(at)) if i32::from(hash(at, 3)) * 100 < others * 256 => hash(at, 1) ^ 0x80,
                (None, Some(at)) => hash(at, 1),
                (None, None) => hash((x, y), 2),
            }
        })
    })
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

pub(crate) fn sequence() -> Sequence {
    let of = |(x, y): (i32, i32)| BoundingBox::from([x, y, TARGET.0, TARGET.1]);
    let truth = script().map(|(place, _)| (place != NOWHERE).then(|| of(place))).collect();
    Sequence::made(NAME, frames(), truth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::Paper;
    use smr_core::paper::Config;
    use smr_core::unstable::{Peaks, peaks};
    use smr_core::{Answer, State, Tracker};

    #[test]
    fn the_papers_rules_decide_in_the_frames_they_are_meant_for() {
        let mut tracker = Tracker::<Paper>::with(Config::paper()).unwrap();
        let mut frames = frames();
        let first = frames.next().unwrap();
        tracker.lock(&first.frame(), sequence().start().unwrap()).unwrap();
        let answers: Vec<(Answer, Peaks)> = frames
            .map(|frame| (tracker.update(&frame.frame()).unwrap(), peaks(tracker.workspace()).unwrap()))
            .collect();
        let answer = |frame: usize| answers[frame - 1].0;
        let runner_up = |frame: usize| answers[frame - 1].1.runner_up;
        let ratio = |frame: usize| f64::from(answer(frame).ratio) / f64::from(answer(frame).runner_up_ratio.unwrap());
        assert_eq!(answer(10).state, State::Leaving);
        assert!((11..=15).all(|frame| runner_up(frame).is_some()), "returning");
        assert!((13..=14).all(|frame| ratio(frame) < 1.2 && answer(frame).state == State::Tracking), "the lead");
        assert_eq!([15, 16, 17].map(|frame| answer(frame).state), [State::Lost; 3]);
        assert!((18..=20).all(|frame| answer(frame).state == State::Tracking), "found again");
        assert_eq!((runner_up(19), runner_up(20)), (None, None));
        assert_eq!([21, 23].map(|frame| answer(frame).state), [State::Leaving; 2]);
        assert_eq!(answer(24).state, State::Tracking);
        for (frame, (place, _)) in script().enumerate().skip(1) {
            if frame != 15 && place != NOWHERE {
                assert_eq!((answer(frame).bbox.x, answer(frame).bbox.y), place, "frame {frame}");
            }
        }
    }
}
