//! A recording that is open, and the trackers that follow its targets.

use super::Track;
use crate::command::session::Kept;
use anyhow::{Context, Result};
use smr_evaluation::{Follower, Origin};
use smr_pages::export::PixelsPerMetre;
use smr_pages::export::boxes::{About, Format, Printer};
use smr_pages::viewer::Target as Drawn;
use smr_recordings::{BoundingBox, Sequence};
use std::path::Path;

pub struct Opened {
    pub sequence: Sequence,
    pub targets: Vec<Follower>,
    /// Each target as the user drew it in `view`, if it is of a session.
    pub drawn: Vec<Option<Drawn>>,
    /// Index and first box of the target that a video is cropped to, if it is.
    pub cropped: Option<(usize, BoundingBox)>,
    /// The option or the file that gave the boxes.
    pub boxes_of: String,
    /// Pixels of a metre, by the option or the session.
    pub pixels_per_metre: Option<PixelsPerMetre>,
    origin: Origin,
}

impl Opened {
    /// Opens a recording, and makes a tracker for each target of `--init`, of the session, or beside the recording.
    pub fn of(track: &Track, path: &Path, kept: Option<&Kept>) -> Result<Self> {
        let variant = match kept.filter(|_| !track.has_method()) {
            Some(kept) => kept.variant()?,
            None => track.given_variant()?,
        };
        let (sequence, targets) = track.recording.open_with_targets(path, true, kept)?;
        let cropped = track.cropped(&targets).with_context(|| sequence.name.clone())?;
        let targets = Follower::all(targets, &variant).with_context(|| sequence.name.clone())?;
        let drawn = |target: &Follower| kept?.drawn(target.name.as_deref()).cloned();
        let drawn = targets.iter().map(drawn).collect();
        let boxes_of = kept.map_or("--init", |kept| &kept.file).to_owned();
        let pixels_per_metre = track.pixels_per_metre.or_else(|| kept?.pixels_per_metre());
        Ok(Self { sequence, targets, drawn, cropped, boxes_of, pixels_per_metre, origin: variant.origin() })
    }

    pub fn printer(&self, format: Format, is_one_of_several: bool, has_metres: bool) -> Printer {
        let about = About {
            name: self.sequence.name.clone(),
            is_one_of_several,
            origin: self.origin.clone(),
            targets: self.targets.iter().map(|target| target.name.clone()).collect(),
            images: self.sequence.source.image_names(),
            has_metres,
            pixels_per_metre: self.pixels_per_metre.map(|metre| metre.resized(self.sequence.scale)),
        };
        Printer::new(format, about)
    }
}

/// Reads the session whose boxes are followed in the recording of this name, and tells of it.
pub fn session(track: &Track, path: &Path, name: &str) -> Result<Option<Kept>> {
    let kept = track.recording.kept(path)?;
    kept.iter().for_each(|kept| kept.tell(name, !track.has_method()));
    Ok(kept)
}
