//! The result file of another tracker, to be shown beside the methods.

use crate::sequence::{BoundingBox, FrameRange, boxes};
use anyhow::Result;
use std::path::Path;

pub struct ResultFile {
    /// The file's, without its extension.
    pub name: String,
    /// One for each frame.
    pub answers: Vec<Option<BoundingBox>>,
}

impl ResultFile {
    /// The answers for `frames` frames, those of `part` if only a part of the recording is shown. A file that ends early has no
    /// answer from there on; lines beyond the last frame are ignored.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(super) fn read(path: &Path, part: Option<FrameRange>, frames: usize) -> Result<Self> {
        let mut answers = boxes::read_tld(path)?;
        if let Some(part) = part {
            answers = part.of(answers);
        }
        answers.resize(frames, None);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, answers })
    }
}
