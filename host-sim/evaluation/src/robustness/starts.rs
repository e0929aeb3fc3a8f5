//! Start boxes of runs: the given box and four close to it, or ground truth boxes along the recording.

use super::figures::RunFigures;
use crate::matrix::{Case, Intervention, Protocol, Recording};
use crate::{Run, Variant};
use anyhow::{Context, Error, Result, anyhow, ensure};
use smr_core::Rect;
use smr_recordings::BoundingBox;
use std::num::NonZeroUsize;
use std::str::FromStr;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Starts {
    /// Five starts in the first frame: the given box unchanged, moved 2 pixels right or 2 down, scaled by 0.95 or 1.05.
    Near,
    /// The ground truth box in every N-th visible frame, from the first one on, but not in the recording's last frame.
    Every(NonZeroUsize),
    /// The given box in the first frame alone.
    Given,
}

/// Parses `1`, `5` or `every:N` from the command line.
impl FromStr for Starts {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let every = || text.strip_prefix("every:")?.parse().ok().map(Self::Every);
        match text {
            "1" => Ok(Self::Given),
            "5" => Ok(Self::Near),
            _ => every().context("expected 1, 5 or every:N, with N 1 or more"),
        }
    }
}

impl Protocol for Starts {
    type Figures = RunFigures;
    const IS_COMMON: bool = false;

    fn cases(&self, _: usize, recording: &Recording) -> Result<Vec<Case>> {
        let name = &recording.name;
        let starts = match self {
            Self::Near => near(recording, usize::MAX),
            Self::Every(every) => along(recording, *every),
            Self::Given => near(recording, 1),
        };
        let starts = starts.with_context(|| name.clone())?;
        ensure!(!starts.is_empty(), "{name}: no frame to start from: the target is visible in none but the last");
        Ok(starts)
    }

    fn figures(&self, _: &Variant, recording: &Recording, case: &Case, run: &Run) -> Result<RunFigures> {
        RunFigures::new(run, &recording.truth[case.frame..])
    }
}

/// Returns the first `most` cases of `Starts::Near`. Boxes are scaled about their centre. Each value is rounded once,
/// at the end, so scaling may leave a small box as given. All boxes but the given one are cut to the frame.
fn near(recording: &Recording, most: usize) -> Result<Vec<Case>> {
    let given = recording.init;
    let changed = [
        ("given", given),
        ("x+2", BoundingBox { x: given.x + 2.0, ..given }),
        ("y+2", BoundingBox { y: given.y + 2.0, ..given }),
        ("0.95", scaled(given, 0.95)),
        ("1.05", scaled(given, 1.05)),
    ];
    let case = |(name, changed): (&str, BoundingBox)| {
        let target = if name == "given" { whole(&changed) } else { inside(&changed, recording.bounds()) };
        case(name.to_owned(), 0, target, recording)
    };
    changed.into_iter().take(most).map(case).collect()
}

/// Returns cases that start on the ground truth box, cut to the picture, of every N-th visible frame.
fn along(recording: &Recording, every: NonZeroUsize) -> Result<Vec<Case>> {
    let last = recording.truth.len().saturating_sub(1);
    let visible = (0..last).filter_map(|frame| Some((frame, recording.truth[frame]?)));
    let case = |(frame, truth): (usize, BoundingBox)| {
        case(format!("frame {}", frame + 1), frame, inside(&truth, recording.bounds()), recording)
    };
    visible.step_by(every.get()).map(case).collect()
}

fn case(name: String, frame: usize, target: Result<Rect>, recording: &Recording) -> Result<Case> {
    let target = target.with_context(|| format!("start {name}"))?;
    Ok(Case { name, frame, target, end: recording.frames.len(), intervention: Intervention::None })
}

fn scaled(given: BoundingBox, factor: f64) -> BoundingBox {
    let (width, height) = (given.width * factor, given.height * factor);
    let (x, y) = (given.x + (given.width - width) / 2.0, given.y + (given.height - height) / 2.0);
    BoundingBox { x, y, width, height }
}

pub(crate) fn whole(target: &BoundingBox) -> Result<Rect> {
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
        let starts = starts.cases(0, &recording(init, init)).unwrap();
        starts.into_iter().map(|start| start.target).collect()
    }

    #[test]
    fn five_boxes_near_the_given_one() {
        let near = |given: &str, expected: [[i32; 4]; 5]| {
            let boxes = targets(Starts::Near, given).into_iter();
            let boxes = boxes.map(|Rect { x, y, width, height }| [x, y, width.into(), height.into()]);
            assert_eq!(boxes.collect::<Vec<_>>(), expected);
        };
        // Unrounded, the boxes scaled by 0.95 and 1.05 are 10.5,5.6,19,22.8 and 9.5,4.4,21,25.2.
        near("10,5,20,24", [[10, 5, 20, 24], [12, 5, 20, 24], [10, 7, 20, 24], [11, 6, 19, 23], [10, 4, 21, 25]]);
        // Unrounded, the scaled boxes are 10.89,5.825,18.62,8.55 and 9.91,5.375,20.58,9.45.
        near("10.4,5.6,19.6,9", [[10, 6, 20, 9], [12, 6, 20, 9], [10, 8, 20, 9], [11, 6, 19, 9], [10, 5, 21, 9]]);
        // Unrounded, the scaled boxes are 40.5,1,19,38 (wholly inside) and 39.5,-1,21,42.
        near("40,0,20,40", [[40, 0, 20, 40], [42, 0, 18, 40], [40, 2, 20, 38], [41, 1, 19, 38], [40, 0, 20, 40]]);
        assert_eq!(targets(Starts::Given, "10,5,20,24"), [Rect::new(10, 5, 20, 24)]);
    }

    #[test]
    fn every_so_many_th_visible_frame_is_a_start() {
        let recording = recording("1,1,4,4", "-5,30,20.4,20");
        let starts = |every: &str| format!("every:{every}").parse::<Starts>().unwrap().cases(0, &recording).unwrap();
        let target = || Ok(Rect::new(0, 30, 15, 10));
        let at = |frame: usize| case(format!("frame {}", frame + 1), frame, target(), &recording).unwrap();
        assert_eq!(starts("1"), [at(0), at(2)], "the last frame is no start");
        assert_eq!(starts("2"), [at(0)]);
    }

    #[test]
    fn a_start_without_pixels_is_named() {
        let error = |starts: Starts, recording| format!("{:#}", starts.cases(0, &recording).unwrap_err());
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

    #[test]
    fn starts_are_read() {
        assert_eq!(["1", "5"].map(|text| text.parse::<Starts>().unwrap()), [Starts::Given, Starts::Near]);
        for refused in ["", "2", "every", "every:", "every:0", "every:x", "every:-1"] {
            assert!(refused.parse::<Starts>().is_err(), "{refused}");
        }
    }
}
