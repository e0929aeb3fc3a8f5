//! The ends of what there can be: the smallest and the longest frames and boxes, and steps as large as they get. Overflow
//! checks are on in tests, so that a sum or a product beyond its type would end them.

use super::grid::{Lattice, PIXEL};
use super::{Config, RADIUS, State, ThresholdRule, Tracker};
use crate::{Fraction, Frame, Image, Rect};
use heapless::Vec as Fixed;
use std::{boxed::Box, vec, vec::Vec};

/// Pixels without any pattern, others in each frame.
fn noise(pixels: usize, frame: u32) -> Vec<u8> {
    let byte = |at: u32| ((at ^ frame << 20).wrapping_mul(2_654_435_761) >> 13) as u8;
    (0..pixels as u32).map(byte).collect()
}

/// Locks on `target`, and looks for it in frames of all kinds; of each frame only what is asked for is there.
fn follow<const PIXELS: usize, const WINDOW: usize>(config: Config, width: u16, height: u16, target: Rect) {
    let pixels = usize::from(width) * usize::from(height);
    let bounds = Rect::new(0, 0, width, height);
    let mut tracker = Box::new(Tracker::<PIXELS, WINDOW>::new(config));
    let first = noise(pixels, 0);
    tracker.lock(&Frame::whole(Image::new(&first, width, height).unwrap()), target).unwrap();
    let others = [noise(pixels, 1), vec![0; pixels], vec![255; pixels], noise(pixels, 2), noise(pixels, 3), first];
    for frame in others {
        let window = tracker.window().unwrap();
        assert!(bounds.contains(window), "{window:?}");
        let part = Image::new(&frame, width, height).unwrap().crop(window).unwrap();
        let part = Frame::part(part, window.x as u16, window.y as u16, width, height).unwrap();
        let answer = tracker.update(&part).unwrap();
        let offsets = 0..=i32::from(2 * RADIUS);
        assert!(offsets.contains(&answer.peak.x) && offsets.contains(&answer.peak.y), "{answer:?}");
        assert!(!answer.bbox.is_empty() && answer.alpha <= 256, "{answer:?}");
        // The middle stays on the frame, so the box touches it, and the scale within 1/4 to 4.
        let Rect { x, y, width, height } = answer.bbox;
        let around = Rect::new(x - 1, y - 1, width.saturating_add(2), height.saturating_add(2));
        assert!(!around.intersection(bounds).is_empty(), "{answer:?}");
        assert!((1 << 14..=1 << 18).contains(&answer.scale), "{answer:?}");
    }
}

fn configs() -> [Config; 2] {
    let mut paper = Config::robust();
    paper.threshold = ThresholdRule::LargestChange(Fraction::new(u16::MAX, 1));
    [Config::robust(), paper]
}

/// The smallest and the longest frames and boxes, in the smallest tracker, in the usual one, and in one with room for the most
/// columns.
#[test]
fn the_smallest_and_the_longest_frames_and_boxes() {
    let cases = [
        (1, 1, Rect::new(0, 0, 1, 1)),
        (2, 3, Rect::new(1, 2, 1, 1)),
        (1, 2000, Rect::new(0, 0, 1, 2000)),
        (30, 2000, Rect::new(29, 0, 1, 2000)),
        (65535, 1, Rect::new(0, 0, 65535, 1)),
        (65535, 1, Rect::new(65534, 0, 1, 1)),
        (1, 65535, Rect::new(0, 0, 1, 65535)),
        (320, 240, Rect::new(0, 0, 320, 240)),
    ];
    for (width, height, target) in cases {
        for config in configs() {
            follow::<16, 4624>(config, width, height, target);
            follow::<1024, 12288>(config, width, height, target);
            follow::<1024, 26112>(config, width, height, target);
        }
    }
}

#[test]
fn a_box_as_large_as_a_large_frame() {
    follow::<16, 4624>(Config::robust(), 1920, 1080, Rect::new(0, 0, 1920, 1080));
    follow::<1024, 12288>(Config::robust(), 1920, 1080, Rect::new(0, 0, 1920, 1080));
}

/// A template of 1024 pixels has a step of at most 65535 / 32 pixels, 8192 at the largest scale: blocks of 4096x4096. Their
/// sums are at most 255 * 2^24, and the half unit to round by would still fit a `u32`; those of smaller templates would not.
#[test]
fn the_largest_blocks_of_means() {
    let side = 4096u16;
    let white = vec![255; usize::from(side) * usize::from(side)];
    let frame = Frame::whole(Image::new(&white, side, side).unwrap());
    for step in [8191, 65535] {
        let mut sample = Fixed::<u8, 4>::new();
        let lattice = Lattice { x: 2047 * PIXEL, y: 2047 * PIXEL, step: step * PIXEL, columns: 2, rows: 2 };
        assert!(lattice.sample(&frame, &mut sample));
        assert_eq!(sample, [255; 4], "a step of {step}");
    }
}

/// Where nothing can be told apart the target stays, and is not lost.
#[test]
fn a_plain_frame_holds_the_box() {
    let plain = vec![77; 100 * 80];
    let frame = Frame::whole(Image::new(&plain, 100, 80).unwrap());
    let mut tracker = Box::new(Tracker::<1024, 12288>::new(Config::robust()));
    let target = Rect::new(40, 30, 20, 20);
    tracker.lock(&frame, target).unwrap();
    for _ in 0..5 {
        let answer = tracker.update(&frame).unwrap();
        assert_eq!((answer.bbox, answer.state, answer.ratio), (target, State::Tracking, u16::MAX));
    }
}
