//! A recording with all its frames in memory, so that many runs read it and it is decoded once.

use super::{Follower, Run};
use crate::{Variant, truth_of};
use anyhow::{Context, Result, anyhow, ensure};
use smr_core::Rect;
use smr_recordings::cover::Cover;
use smr_recordings::fault::Fault;
use smr_recordings::{BoundingBox, GrayFrame, Sequence, cleanup, misfit};
use std::borrow::Cow;

/// The most bytes of frames that one recording may have: 1 GiB, some 14000 frames of 320x240 pixels.
pub(crate) const MOST_BYTES: u64 = 1 << 30;

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
            let frame = frame?.gray;
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
        misfit(count, boxes).map_or(Ok(()), |misfit| Err(anyhow!("{name}: {misfit}")))?;
        Ok(Self { name, frames: kept, init, truth })
    }

    /// Follows the target in a box of frame `start.0` from there on, as far as the frame before `end`. `progress` is called after each frame.
    /// Errors: A tracker that cannot be built, or the tracker's.
    pub fn run(
        &self,
        variant: &Variant,
        (start, target): (usize, Rect),
        end: usize,
        intervention: Intervention<'_>,
        progress: impl Fn(),
    ) -> Result<Run> {
        let mut follower = Follower::new(variant.build()?, vec![(start + 1, target)]);
        let mut run = Run::default();
        for place in start..end {
            ensure!(!cleanup::is_stopped(), "it was stopped");
            for frame in intervention.shown(&self.frames, place) {
                run.add(&mut follower, place, &frame)?;
                progress();
            }
        }
        Ok(run)
    }

    pub fn bounds(&self) -> Rect {
        self.frames.first().map_or(Rect::default(), |frame| frame.frame().bounds())
    }

    pub fn bytes(&self) -> u64 {
        self.frames.iter().map(|frame| frame.pixels.len() as u64).sum()
    }
}

const MIB: u64 = 1 << 20;

/// What comes between a recording and a tracker. Places are of frames, counted from 0.
#[derive(Clone, Copy)]
pub(crate) enum Intervention<'a> {
    None,
    /// From the first to before the last of these frames the camera has a fault.
    Fault(usize, usize, &'a Fault),
    /// Before this frame come so many that show nothing but the cover, or the frame of another scene.
    Cover(usize, usize, Cover, &'a GrayFrame),
}

impl<'a> Intervention<'a> {
    /// The frames that come for the one at `place`.
    fn shown(self, frames: &'a [GrayFrame], place: usize) -> Box<dyn Iterator<Item = Cow<'a, GrayFrame>> + 'a> {
        let own = std::iter::once(Cow::Borrowed(&frames[place]));
        match self {
            Self::Fault(at, end, fault) if (at..end).contains(&place) => {
                let before = (&frames[at.saturating_sub(1)], &frames[place.saturating_sub(1)]);
                Box::new(fault.of(place - at, &frames[place], before, at as u64).map(Cow::Owned).into_iter())
            }
            Self::Cover(at, count, cover, other) if at == place => {
                Box::new((0..count).map(move |index| Cow::Owned(cover.frame(index, other))).chain(own))
            }
            _ => Box::new(own),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence() -> Sequence {
        let frame = GrayFrame { width: 1024, height: 512, pixels: vec![0; 1 << 19] };
        let at: BoundingBox = "3,4,5,6".parse().unwrap();
        Sequence::made("mine", vec![frame; 3].into_iter(), vec![Some(at), None, Some(at)])
    }

    #[test]
    fn a_recording_is_kept_whole() {
        let recording = Recording::read(sequence(), MOST_BYTES).unwrap();
        assert_eq!((recording.frames.len(), recording.bytes()), (3, 3 << 19));
        assert_eq!(recording.bounds(), Rect::new(0, 0, 1024, 512));
    }

    #[test]
    fn an_intervention_shows_other_frames() {
        let frames: Vec<GrayFrame> =
            (0..6).map(|pixel| GrayFrame { width: 1, height: 1, pixels: vec![pixel] }).collect();
        let shown = |intervention: Intervention<'_>| {
            let of = |place| intervention.shown(&frames, place).map(move |frame| (place, frame.pixels[0]));
            (1..6).flat_map(of).collect::<Vec<_>>()
        };
        let white = GrayFrame { pixels: vec![255], ..frames[0].clone() };
        let (gap, repeated): (Fault, Fault) = ("gap:2".parse().unwrap(), "repeated:2".parse().unwrap());
        assert_eq!(shown(Intervention::None), [(1, 1), (2, 2), (3, 3), (4, 4), (5, 5)]);
        assert_eq!(shown(Intervention::Fault(2, 4, &gap)), [(1, 1), (4, 4), (5, 5)]);
        assert_eq!(shown(Intervention::Fault(2, 4, &repeated)), [(1, 1), (2, 1), (3, 1), (4, 4), (5, 5)]);
        let covered = shown(Intervention::Cover(4, 2, Cover::Black, &white));
        assert_eq!(covered, [(1, 1), (2, 2), (3, 3), (4, 0), (4, 0), (4, 4), (5, 5)]);
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
        let lengths = "mine: there are 3 frames, but the ground truth has 2 boxes for them: say which";
        assert!(error(Sequence { truth: two, ..sequence() }).starts_with(lengths));
        let unseen = Some(vec![None; 3]);
        assert!(error(Sequence { truth: unseen, ..sequence() }).contains("visible in no frame"));
    }
}
