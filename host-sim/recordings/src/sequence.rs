//! A recording as it is read: its frames in order, and the boxes known about them.

use crate::bounding_box::BoundingBox;
use crate::checked_frames;
use crate::frame::{Frame, Frames};
use crate::raster::GrayFrame;
use crate::source::Source;
use anyhow::{Context, Result, anyhow};

/// A recording: its frames in order, and its start box and ground truth, if known.
pub struct Sequence {
    /// Name of the folder, or of the file without its extension.
    pub name: String,
    /// Frames in order, all of the size of the first. A frame of another size is an error; no frame follows an error.
    pub frames: Frames,
    /// Count of frames, if known before they are read.
    pub length: Option<usize>,
    /// Number of the first frame: 1, or more after [`Sequence::part`].
    pub first: usize,
    /// Box on which trackers lock in the first frame.
    pub init: Option<BoundingBox>,
    /// Ground truth, one entry per frame; `None` where the target is not visible.
    pub truth: Option<Vec<Option<BoundingBox>>>,
    pub source: Source,
    pub notes: Vec<String>,
    /// Factors of width and height by which the frames were resized; 1 if they were not.
    pub scale: (f64, f64),
}

impl Sequence {
    /// Creates a sequence of generated frames. Trackers start from the first frame's box in `truth`.
    pub fn made(
        name: &str,
        frames: impl ExactSizeIterator<Item = GrayFrame> + Send + 'static,
        truth: Vec<Option<BoundingBox>>,
    ) -> Self {
        let (length, init) = (Some(frames.len()), truth.first().copied().flatten());
        Self { length, init, truth: Some(truth), ..Self::endless(name.to_owned(), frames) }
    }

    pub(crate) fn endless(name: String, frames: impl Iterator<Item = GrayFrame> + Send + 'static) -> Self {
        let frames = (1..).zip(frames).map(|(number, gray)| Ok(Frame::new(number, None, gray)));
        Self::streamed(name, frames, Source::Once)
    }

    pub(crate) fn streamed(
        name: String,
        frames: impl Iterator<Item = Result<Frame>> + Send + 'static,
        source: Source,
    ) -> Self {
        // A pipe may not keep to the frame rate in its Y4M header, so times computed from that rate are dropped.
        let has_times = !matches!(source, Source::Once);
        let timed = move |frame: Frame| Frame { seconds: frame.seconds.filter(|_| has_times), ..frame };
        let frames = checked_frames::frames(frames.map(move |frame| frame.map(timed)), name.clone());
        let scale = (1.0, 1.0);
        Self { name, frames, length: None, first: 1, init: None, truth: None, source, notes: Vec::new(), scale }
    }

    /// Drops all frames but the first and each `step`-th after it, with their ground truth. A step of 0 is one of 1.
    #[must_use]
    pub fn every(self, step: u16) -> Self {
        let step = usize::from(step.max(1));
        let is_kept = move |place: usize| place.is_multiple_of(step);
        // An error ends a recording, so it is kept.
        let frames = self.frames.enumerate().filter(move |(place, frame)| is_kept(*place) || frame.is_err());
        let truth = self.truth.map(|truth| truth.into_iter().step_by(step).collect());
        let length = self.length.map(|length| length.div_ceil(step));
        Self { frames: Box::new(frames.map(|(_, frame)| frame)), truth, length, ..self }
    }

    /// Returns the start box in whole pixels. Errors: There is no box, it has no pixels, or a `Rect` cannot hold it.
    pub fn start(&self) -> Result<smr_core::Rect> {
        let (name, first) = (&self.name, self.first);
        let init = self.init.with_context(|| match first {
            1 => format!("{name}: no initial box: give --init X,Y,W,H (drag it in `host-sim view`), or init.txt beside the recording"),
            _ => format!("{name}: no initial box for frame {first}: give --init X,Y,W,H (init.txt has that of frame 1)"),
        })?;
        init.pixels().map_err(|what| anyhow!("{name}: the initial box {what}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slower_camera_has_every_third_frame() {
        let frames = (0..8).map(|level| GrayFrame::drawn(2, 1, |_, _| level));
        let truth = (0..8).map(|place| Some([place, 0, 1, 1].into())).collect();
        let slow = Sequence::made("a", frames, truth).every(3);
        assert_eq!((slow.length, slow.truth.map(|truth| truth.len())), (Some(3), Some(3)));
        let levels: Vec<u8> = slow.frames.map(|frame| frame.unwrap().gray.pixels[0]).collect();
        assert_eq!(levels, [0, 3, 6]);
    }

    #[test]
    fn an_error_between_the_frames_is_kept() {
        let frames = (1..4).map(|number| match number {
            2 => Err(anyhow!("cut off")),
            _ => Ok(Frame::new(number, None, GrayFrame::drawn(2, 1, |_, _| 0))),
        });
        let kept: Vec<bool> =
            Sequence::streamed("a".into(), frames, Source::Once).every(2).frames.map(|frame| frame.is_ok()).collect();
        assert_eq!(kept, [true, false]);
    }
}
