//! A recording with all its frames in memory, so that many runs read it and it is decoded once.

use crate::{CORRECT, Method, Trajectory, Variant, lock, truth_of};
use anyhow::{Context, Result, ensure};
use smr_core::{Rect, State};
use smr_recordings::{BoundingBox, GrayFrame, Sequence};

/// The most bytes of frames that one recording may have: 1 GiB, some 14000 frames of 320x240 pixels.
pub(crate) const MOST_BYTES: u64 = 1 << 30;

/// A recording, read.
pub(crate) struct Recording {
    pub name: String,
    /// As many as there are entries of the truth; at least one.
    pub frames: Vec<GrayFrame>,
    pub init: BoundingBox,
    pub truth: Vec<Option<BoundingBox>>,
}

impl Recording {
    /// Errors: No ground truth, one that shows the target nowhere, or one of another length; no box to start from; a frame that
    /// cannot be read; more than `most_bytes` of frames.
    pub fn read(sequence: Sequence, most_bytes: u64) -> Result<Self> {
        let start = sequence.start();
        let Sequence { name, frames, init, truth, .. } = sequence;
        let truth = truth_of(&name, truth)?;
        start?;
        let init = init.with_context(|| format!("{name}: no box to start from"))?;
        ensure!(truth.iter().any(Option::is_some), "{name}: the target is visible in no frame of the ground truth");
        let boxes = truth.len();
        let mut kept = Vec::with_capacity(boxes);
        let mut count = 0;
        for frame in frames {
            let frame = frame?;
            if count == 0 {
                let bytes = boxes as u64 * frame.pixels.len() as u64;
                ensure!(
                    bytes <= most_bytes,
                    "{name}: its frames ({boxes} of {}x{}) need {} MiB of memory: at most {} MiB are used for a recording",
                    frame.width,
                    frame.height,
                    bytes.div_ceil(MIB),
                    most_bytes / MIB
                );
            }
            count += 1;
            // What is beyond the truth is only counted: it is an error, and may be long.
            if count <= boxes {
                kept.push(frame);
            }
        }
        ensure!(count == boxes, "{name}: there are {count} frames, but the ground truth has {boxes} boxes");
        Ok(Self { name, frames: kept, init, truth })
    }

    /// A tracker that is locked on `target` in frame `start`, counted from 0.
    /// Errors: It cannot be built, or refuses the target.
    pub fn watch(&self, variant: &Variant, start: usize, target: Rect) -> Result<Watch<'_>> {
        let mut method = variant.build()?;
        lock(method.as_mut(), &self.frames[start].frame(), target)?;
        Ok(Watch { method, truth: &self.truth })
    }

    /// The size of a frame.
    pub fn bounds(&self) -> Rect {
        self.frames.first().map_or(Rect::default(), |frame| frame.frame().bounds())
    }

    /// Bytes of all frames.
    pub fn bytes(&self) -> u64 {
        self.frames.iter().map(|frame| frame.pixels.len() as u64).sum()
    }
}

const MIB: u64 = 1 << 20;

/// A tracker that is watched for what it says, and whether that is right.
pub(crate) struct Watch<'a> {
    method: Box<dyn Method>,
    truth: &'a Trajectory,
}

impl Watch<'_> {
    /// What it says of `frame`, and whether its box is right if the target is where it is in frame `number` of the recording.
    pub fn update(&mut self, number: usize, frame: &GrayFrame) -> Result<(State, bool)> {
        let report = self.method.update(&frame.frame()).with_context(|| format!("frame {}", number + 1))?;
        let iou = report.target.zip(self.truth[number]).map_or(0.0, |(answer, truth)| truth.iou(&answer));
        Ok((report.state, iou > CORRECT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence() -> Sequence {
        let frame = GrayFrame { width: 1024, height: 512, pixels: vec![0; 1 << 19] };
        let at: BoundingBox = "3,4,5,6".parse().unwrap();
        Sequence {
            name: "mine".to_owned(),
            frames: Box::new(vec![frame; 3].into_iter().map(Ok)),
            length: Some(3),
            first: 1,
            init: Some(at),
            truth: Some(vec![Some(at), None, Some(at)]),
            colors: smr_recordings::Colors::None,
        }
    }

    #[test]
    fn a_recording_is_kept_whole() {
        let recording = Recording::read(sequence(), MOST_BYTES).unwrap();
        assert_eq!((recording.frames.len(), recording.bytes()), (3, 3 << 19));
        assert_eq!(recording.bounds(), Rect::new(0, 0, 1024, 512));
    }

    #[test]
    fn what_cannot_be_measured_is_named() {
        let error = |sequence| format!("{:#}", Recording::read(sequence, 1 << 20).err().unwrap());
        assert_eq!(
            error(sequence()),
            "mine: its frames (3 of 1024x512) need 2 MiB of memory: at most 1 MiB are used for a recording"
        );
        assert!(error(Sequence { truth: None, ..sequence() }).starts_with("mine: no ground truth"));
        assert!(error(Sequence { init: None, ..sequence() }).starts_with("mine: no box to start from"));
        let two = sequence().truth.map(|truth| truth[..2].to_vec());
        let lengths = "mine: there are 3 frames, but the ground truth has 2 boxes";
        assert_eq!(error(Sequence { truth: two, ..sequence() }), lengths);
        let unseen = Some(vec![None; 3]);
        assert!(error(Sequence { truth: unseen, ..sequence() }).contains("visible in no frame"));
    }
}
