//! What is timed: one search of one template in one frame of a recording.

use anyhow::{Context, Result};
use smr_core::paper::{Config, Radius};
use smr_core::similarity::Backend;
use smr_core::{Image, Rect, Robust, Target, Tracker, robust};
use smr_evaluation::Paper;
use smr_evaluation::truth_of;
use smr_recordings::{GrayFrame, Sequence};
use std::collections::VecDeque;
use std::rc::Rc;

/// The size of a template.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// That of the box that the recording starts with.
    Own,
    /// Width and height.
    Of(u16, u16),
}

/// Three frames in a row, and where the target is in the first. The tracker locks on in the first frame and is updated with
/// the second, so that it has a typical template and alpha. The search in the third frame is timed.
pub struct Triple {
    frames: [Rc<GrayFrame>; 3],
    /// The target's box in the first, by the ground truth.
    target: Rect,
    own: (u16, u16),
    /// The third's, counted from 1.
    pub number: usize,
}

/// How many triples [`triples`] gives.
/// Errors: There is no ground truth.
pub fn count(sequence: &Sequence, every: usize) -> Result<usize> {
    let truth = truth_of(&sequence.name, sequence.truth.as_deref())?;
    Ok(truth.iter().take(truth.len().saturating_sub(2)).step_by(every).flatten().count())
}

/// Every `every`th frame in which the target is visible, with the two after it.
/// Errors: A frame that cannot be read, no ground truth, no box to start from.
pub fn triples(sequence: Sequence, every: usize, mut found: impl FnMut(&Triple) -> Result<()>) -> Result<()> {
    let start = sequence.start()?;
    let truth = truth_of(&sequence.name, sequence.truth)?;
    let mut last = VecDeque::new();
    for (index, frame) in sequence.frames.enumerate() {
        last.push_back(Rc::new(frame?));
        let [first, second, third] = last.make_contiguous() else { continue };
        let frames = [first.clone(), second.clone(), third.clone()];
        last.pop_front();
        let target = truth.get(index - 2).copied().flatten().and_then(|target| target.to_rect());
        if let Some(target) = target.filter(|_| (index - 2).is_multiple_of(every)) {
            found(&Triple { frames, target, own: (start.width, start.height), number: index + 1 })?;
        }
    }
    Ok(())
}

/// A search in the third frame, ready to be run in several ways.
pub struct Case {
    pub frames: [Rc<GrayFrame>; 3],
    /// What is locked on.
    pub target: Rect,
    radius: Radius,
    /// The pixels that the search reads, and what it looks for in them.
    pub crop: GrayFrame,
    pub template: GrayFrame,
}

impl Case {
    /// A template of `size`, as close to the middle of the target as leaves the window of `radius` inside the frame.
    /// `None` if there is no room: the window does not fit, or the target has moved to the edge.
    pub fn new(triple: &Triple, size: Size, radius: Radius) -> Result<Option<Self>> {
        let Some(target) = place(triple, size, radius) else { return Ok(None) };
        let frames = triple.frames.clone();
        let mut tracker = tracker(Backend::best(), true, radius)?;
        prepare(&mut tracker, &frames, target)?;
        let window = tracker.window().context("the tracker is locked")?;
        let whole = (target.width.checked_add(2 * radius.x), target.height.checked_add(2 * radius.y));
        if (Some(window.width), Some(window.height)) != whole {
            return Ok(None);
        }
        let crop = frames[2].frame().patch(window).context("the window lies in the frame")?;
        let (crop, template) = (copy(crop), copy(tracker.target().template().context("the tracker is locked")?));
        Ok(Some(Self { frames, target, radius, crop, template }))
    }

    /// Comparisons of two pixels in an exhaustive search: offsets times pixels of the template.
    pub fn comparisons(&self) -> u64 {
        u64::from(offsets(self.radius)) * u64::from(self.template.width) * u64::from(self.template.height)
    }

    /// A tracker of the paper's with this window, without a target.
    pub fn tracker(&self, backend: Backend, pruning: bool) -> Result<Box<Tracker<Paper>>> {
        tracker(backend, pruning, self.radius)
    }

    /// The frame that is searched.
    pub fn frame(&self) -> smr_core::Frame<'_> {
        self.frames[2].frame()
    }

    /// Brings a tracker, whatever it did before, to the state before the search.
    pub fn prepare<T: Target>(&self, tracker: &mut Tracker<T>) -> Result<()> {
        prepare(tracker, &self.frames, self.target)
    }
}

/// The offsets of a window.
pub fn offsets(radius: Radius) -> u32 {
    (2 * u32::from(radius.x) + 1) * (2 * u32::from(radius.y) + 1)
}

/// A robust tracker without a target. Its window is its own.
pub fn robust(backend: Backend) -> Result<Box<Tracker<Robust>>> {
    let mut config = robust::Config::refined();
    config.backend = Some(backend);
    Ok(Box::new(Tracker::new(config)?))
}

fn tracker(backend: Backend, pruning: bool, radius: Radius) -> Result<Box<Tracker<Paper>>> {
    let mut config = Config::paper();
    config.window = radius;
    config.window_limit = radius;
    config.backend = Some(backend);
    config.pruning = pruning;
    Ok(Box::new(Tracker::new(config)?))
}

fn prepare<T: Target>(tracker: &mut Tracker<T>, frames: &[Rc<GrayFrame>; 3], target: Rect) -> Result<()> {
    tracker.lock(&frames[0].frame(), target)?;
    tracker.update(&frames[1].frame())?;
    Ok(())
}

fn copy(image: Image<'_>) -> GrayFrame {
    GrayFrame { width: image.width(), height: image.height(), pixels: image.rows().flatten().copied().collect() }
}

fn place(triple: &Triple, size: Size, radius: Radius) -> Option<Rect> {
    let (width, height) = match size {
        Size::Own => triple.own,
        Size::Of(width, height) => (width, height),
    };
    let (target, frame) = (triple.target, &triple.frames[0]);
    let x = along(target.x, target.width, width, radius.x, frame.width)?;
    let y = along(target.y, target.height, height, radius.y, frame.height)?;
    Some(Rect::new(x, y, width, height))
}

/// How many pixels the target may move in the second frame before the window is cut, where there is room for it.
const SPARE: i32 = 8;

/// Where a template of `size` begins on an axis.
fn along(target: i32, target_size: u16, size: u16, radius: u16, frame: u16) -> Option<i32> {
    let (first, last) = (i32::from(radius), i32::from(frame) - i32::from(size) - i32::from(radius));
    if first > last {
        return None;
    }
    let spare = SPARE.min((last - first) / 2);
    let middle = target + (i32::from(target_size) - i32::from(size)) / 2;
    Some(middle.clamp(first + spare, last - spare))
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::{OpenOptions, open, synthetic};

    #[test]
    fn the_template_is_centred_where_there_is_room() {
        assert_eq!(along(100, 20, 64, 16, 320), Some(78));
        assert_eq!(along(0, 20, 64, 16, 320), Some(24), "pushed in, with room to move");
        assert_eq!(along(310, 20, 64, 16, 320), Some(320 - 64 - 24));
        assert_eq!(along(50, 20, 64, 16, 97), Some(17), "room for little but the window");
        assert_eq!(along(50, 20, 64, 16, 95), None);
    }

    #[test]
    fn cases_hold_what_the_search_reads() {
        let mut numbers = Vec::new();
        let sequence = open(synthetic::NAME.as_ref(), &OpenOptions::default()).unwrap();
        let expected = count(&sequence, 60).unwrap();
        triples(sequence, 60, |triple| {
            numbers.push(triple.number);
            let case = Case::new(triple, Size::Of(32, 16), Radius { x: 8, y: 4 })?.context("there is room")?;
            assert_eq!((case.crop.width, case.crop.height), (48, 24));
            assert_eq!((case.template.width, case.template.height), (32, 16));
            assert_eq!((offsets(case.radius), case.comparisons()), (17 * 9, 17 * 9 * 32 * 16));
            let mut tracker = case.tracker(Backend::Scalar, false)?;
            case.prepare(&mut tracker)?;
            let template: Vec<u8> = tracker.target().template().unwrap().rows().flatten().copied().collect();
            assert_eq!(template, case.template.pixels);
            assert!(Case::new(triple, Size::Of(64, 64), Radius { x: 60, y: 50 })?.is_none());
            assert!(Case::new(triple, Size::Own, Radius { x: 4, y: 4 })?.is_some());
            Ok(())
        })
        .unwrap();
        assert_eq!(numbers, [3, 63, 123], "in frame 181 the target is outside the picture");
        assert_eq!(numbers.len(), expected);
    }

    fn noise() -> Sequence {
        open("noise".as_ref(), &OpenOptions::default()).unwrap()
    }

    /// What the recording `noise` is there for, in both windows that smr-bench has by itself.
    #[test]
    fn in_noise_there_is_room_in_every_frame_and_nothing_is_excluded() {
        assert_eq!(count(&noise(), 1).unwrap(), 60);
        triples(noise(), 20, |triple| {
            for radius in [Radius { x: 16, y: 16 }, Radius { x: 60, y: 50 }] {
                let case = Case::new(triple, Size::Of(64, 64), radius)?.expect("there is room");
                let mut tracker = case.tracker(Backend::best(), true)?;
                case.prepare(&mut tracker)?;
                let frame = case.frame();
                let mut update = tracker.begin(&frame)?;
                while !update.step(u32::MAX) {}
                assert!(u64::from(update.work()) >= case.comparisons(), "{} of {}", update.work(), case.comparisons());
            }
            Ok(())
        })
        .unwrap();
    }
}
