//! Where runs start: on the given box and on four close to it, or on the ground truth's boxes along the way.

use crate::run::Recording;
use anyhow::{Context, Result, anyhow, ensure};
use smr_core::Rect;
use smr_recordings::BoundingBox;
use std::num::NonZeroUsize;

#[derive(Clone, Copy, Debug)]
pub enum Starts {
    /// The given box, the same 2 pixels to the right, 2 pixels down, and scaled by 0.95 and 1.05; in the first frame.
    Near,
    /// The first frame in which the target is visible, and of those that follow every so many-th; the box is the ground
    /// truth's. The recording's last frame is none: nothing follows it.
    Every(NonZeroUsize),
    /// The given box in the first frame alone.
    Given,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Start {
    /// As it stands in JSON and in errors.
    pub name: String,
    /// The frame that is locked on, counted from 0.
    pub frame: usize,
    pub target: Rect,
}

impl Starts {
    /// The starts in a recording, at least one.
    pub(super) fn of(self, recording: &Recording) -> Result<Vec<Start>> {
        let name = &recording.name;
        let starts = match self {
            Self::Near => near(recording, usize::MAX),
            Self::Every(every) => along(recording, every),
            Self::Given => near(recording, 1),
        };
        let starts = starts.with_context(|| name.clone())?;
        ensure!(!starts.is_empty(), "{name}: no frame to start from: the target is visible in none but the last");
        Ok(starts)
    }
}

/// The box to start from as it is given; 2 pixels to the right; 2 pixels down; 0.95 and 1.05 times as wide and as high
/// about its centre; no more than `most` of them.
///
/// The four numbers of a box are rounded to the nearest integer once, after the change: a small box may be the same when
/// scaled. What then lies outside the frame is cut off; the given box is left as it is.
fn near(recording: &Recording, most: usize) -> Result<Vec<Start>> {
    let given = recording.init;
    let changed = [
        ("given", given),
        ("x+2", BoundingBox { x: given.x + 2.0, ..given }),
        ("y+2", BoundingBox { y: given.y + 2.0, ..given }),
        ("0.95", scaled(given, 0.95)),
        ("1.05", scaled(given, 1.05)),
    ];
    let start = |(name, changed): (&str, BoundingBox)| {
        let target = match name {
            "given" => whole(&changed),
            _ => inside(&changed, recording.bounds()),
        };
        let target = target.with_context(|| format!("start {name}"))?;
        Ok(Start { name: name.to_owned(), frame: 0, target })
    };
    changed.into_iter().take(most).map(start).collect()
}

/// Ground truth may reach out of the picture: what lies outside is cut off.
fn along(recording: &Recording, every: NonZeroUsize) -> Result<Vec<Start>> {
    let last = recording.truth.len().saturating_sub(1);
    let visible = (0..last).filter_map(|frame| Some((frame, recording.truth[frame]?)));
    let start = |(frame, truth): (usize, BoundingBox)| {
        let name = format!("frame {}", frame + 1);
        let target = inside(&truth, recording.bounds()).with_context(|| format!("start {name}"))?;
        Ok(Start { name, frame, target })
    };
    visible.step_by(every.get()).map(start).collect()
}

fn scaled(given: BoundingBox, factor: f64) -> BoundingBox {
    let (width, height) = (given.width * factor, given.height * factor);
    let (x, y) = (given.x + (given.width - width) / 2.0, given.y + (given.height - height) / 2.0);
    BoundingBox { x, y, width, height }
}

fn whole(target: &BoundingBox) -> Result<Rect> {
    target.pixels().map_err(|what| anyhow!("the box {what}"))
}

fn inside(target: &BoundingBox, bounds: Rect) -> Result<Rect> {
    let cut = whole(target)?.intersection(bounds);
    ensure!(!cut.is_empty(), "the box has no pixels inside the frame: {target} (x,y,width,height)");
    Ok(cut)
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::GrayFrame;

    /// Four frames of 60x40 pixels; the target is not visible in the second.
    fn recording(init: &str, truth: &str) -> Recording {
        let truth: BoundingBox = truth.parse().unwrap();
        Recording {
            name: "mine".to_owned(),
            frames: vec![GrayFrame { width: 60, height: 40, pixels: vec![0; 2400] }; 4],
            init: init.parse().unwrap(),
            truth: vec![Some(truth), None, Some(truth), Some(truth)],
        }
    }

    fn targets(starts: Starts, init: &str) -> Vec<Rect> {
        let starts = starts.of(&recording(init, init)).unwrap();
        starts.into_iter().map(|start| start.target).collect()
    }

    /// Near the given one: rounded once, and what lies outside the frame is cut off.
    #[test]
    fn five_boxes_near_the_given_one() {
        let near = |given: &str, expected: [[i32; 4]; 5]| {
            let boxes = targets(Starts::Near, given).into_iter();
            let boxes = boxes.map(|Rect { x, y, width, height }| [x, y, width.into(), height.into()]);
            assert_eq!(boxes.collect::<Vec<_>>(), expected);
        };
        // 10.5, 5.6, 19, 22.8; and 9.5, 4.4, 21, 25.2.
        near("10,5,20,24", [[10, 5, 20, 24], [12, 5, 20, 24], [10, 7, 20, 24], [11, 6, 19, 23], [10, 4, 21, 25]]);
        // 10.4 + 2 is 12; rounded first, 10.4 would be 10, and 19.6 * 0.95 = 18.62 would be 20 * 0.95 = 19. 9.91, 5.375, 20.58, 9.45.
        near("10.4,5.6,19.6,9", [[10, 6, 20, 9], [12, 6, 20, 9], [10, 8, 20, 9], [11, 6, 19, 9], [10, 5, 21, 9]]);
        // 40.5, 1, 19, 38: cut to nothing less; and 39.5, -1, 21, 42.
        near("40,0,20,40", [[40, 0, 20, 40], [42, 0, 18, 40], [40, 2, 20, 38], [41, 1, 19, 38], [40, 0, 20, 40]]);
        assert_eq!(targets(Starts::Given, "10,5,20,24"), [Rect::new(10, 5, 20, 24)]);
    }

    #[test]
    fn every_so_many_th_visible_frame_is_a_start() {
        let recording = recording("1,1,4,4", "-5,30,20.4,20");
        let starts = |every| Starts::Every(NonZeroUsize::new(every).unwrap()).of(&recording).unwrap();
        let at = |frame: usize| Start { name: format!("frame {}", frame + 1), frame, target: Rect::new(0, 30, 15, 10) };
        assert_eq!(starts(1), [at(0), at(2)], "the last frame is no start");
        assert_eq!(starts(2), [at(0)]);
    }

    #[test]
    fn a_start_without_pixels_is_named() {
        let error = |starts: Starts, recording| format!("{:#}", starts.of(&recording).unwrap_err());
        let beside = error(Starts::Near, recording("58.4,3,2,5", "1,1,4,4"));
        assert_eq!(beside, "mine: start x+2: the box has no pixels inside the frame: 60.4,3,2,5 (x,y,width,height)");
        let tiny = error(Starts::Near, recording("5,3,0.3,5", "1,1,4,4"));
        assert_eq!(tiny, "mine: start given: the box has no pixels: 5,3,0.3,5 (x,y,width,height)");
        let every = Starts::Every(NonZeroUsize::MIN);
        assert!(
            error(every, recording("1,1,4,4", "70,3,5,5")).starts_with("mine: start frame 1: the box has no pixels")
        );
        let mut unseen = recording("1,1,4,4", "1,1,4,4");
        unseen.truth[..3].fill(None);
        assert!(error(every, unseen).starts_with("mine: no frame to start from"));
    }
}
