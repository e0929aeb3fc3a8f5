//! Built-in recordings: the scenes of `smr_scene` as sequences with ground truth.

pub mod street;
pub mod synthetic;

use crate::bounding_box::BoundingBox;
use crate::raster::GrayFrame;
use crate::sequence::Sequence;
use smr_scene::slow::Slow;
use smr_scene::{border, noise, periodic, tiles};
use std::path::Path;

pub const BUILT_IN: [&str; 6] = [street::NAME, synthetic::NAME, PERIODIC, BORDER, "noise", "tiles"];

/// Names of the built-in recordings that test smr-core, without `noise`, which has no target and is only for timing.
pub const CHECKED: [&str; 3] = [synthetic::NAME, PERIODIC, BORDER];

const PERIODIC: &str = "periodic";
const BORDER: &str = "border";

pub(crate) fn built_in(path: &Path) -> Option<Sequence> {
    let made = [street::sequence, synthetic::sequence, periodic, border, noise, tiles];
    let exact = BUILT_IN.iter().zip(made).find(|(name, _)| path == Path::new(name)).map(|(_, made)| made());
    exact.or_else(|| synthetic::seeded(path.to_str()?))
}

fn periodic() -> Sequence {
    let level = |index| move |x, y| periodic::level(index, x, y);
    let frame = move |index| GrayFrame::drawn(periodic::WIDTH, periodic::HEIGHT, level(index));
    let made = Sequence::made(PERIODIC, (0..periodic::LENGTH).map(frame), vec![]);
    Sequence { init: Some(periodic::START.into()), truth: None, ..made }
}

fn border() -> Sequence {
    let level = |index| move |x, y| border::level(index, x, y);
    let frame = move |index| GrayFrame::drawn(border::WIDTH, border::HEIGHT, level(index));
    let truth = (0..border::LENGTH).map(|index| border::truth(index).map(Into::into)).collect();
    Sequence::made(BORDER, (0..border::LENGTH).map(frame), truth)
}

fn noise() -> Sequence {
    let frame = |index| GrayFrame { width: noise::WIDTH, height: noise::HEIGHT, pixels: noise::frame(index).collect() };
    let truth = vec![Some(noise::TARGET.into()); noise::LENGTH];
    Sequence::made("noise", (0..noise::LENGTH).map(frame), truth)
}

fn tiles() -> Sequence {
    let frame = |index| {
        let pixels = (0..tiles::HEIGHT).flat_map(|y| (0..tiles::WIDTH).map(move |x| tiles::level(index, x, y)));
        GrayFrame { width: tiles::WIDTH, height: tiles::HEIGHT, pixels: pixels.collect() }
    };
    let truth = |index| {
        let (x, y) = tiles::place(index);
        (!tiles::is_hidden(index)).then_some([x, y, tiles::SIDE, tiles::SIDE].map(i32::from).into())
    };
    Sequence::made("tiles", (0..tiles::FRAMES).map(frame), (0..tiles::FRAMES).map(truth).collect())
}

/// Number of recordings that [`slow`] draws.
pub const SLOW: usize = smr_scene::slow::COUNT;

/// Draws recording `number`, below [`SLOW`], of a slow target on a textured background, for tests of covers.
pub fn slow(number: usize) -> Sequence {
    use smr_scene::slow::{HEIGHT, LENGTH, WIDTH, truth};
    let slow = Box::new(Slow::new(number));
    let name = slow.name();
    let frames = (0..LENGTH).map(move |index| GrayFrame::drawn(WIDTH, HEIGHT, slow.frame(index)));
    let of = |[x, y, width, height]: [f64; 4]| BoundingBox { x, y, width, height };
    Sequence::made(name, frames, (0..LENGTH).map(|index| Some(of(truth(index)))).collect())
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
        let recording = border();
        let start = recording.start().unwrap();
        let mut frames = recording.frames.map(|frame| frame.unwrap().gray);
        tracker.lock(&frames.next().unwrap().frame(), start).unwrap();
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
        for (frame, place) in
            (0..border::LENGTH).map(border::truth).enumerate().skip(1).filter(|(frame, _)| *frame != 15)
        {
            if let Some([x, y, ..]) = place {
                assert_eq!((answer(frame).bbox.x, answer(frame).bbox.y), (x, y), "frame {frame}");
            }
        }
    }
}
