//! The result files of other trackers, to be measured and shown beside the methods.

use super::{Score, Trajectory};
use anyhow::{Context, Result};
use smr_recordings::boxes::Form;
use smr_recordings::{BoundingBox, FrameRange, RESULTS};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

pub struct ResultFile {
    /// Name of the file, without its extension.
    pub name: String,
    pub answers: Vec<Option<BoundingBox>>,
    pub note: Option<String>,
}

impl ResultFile {
    /// Reads the answers for `frames` frames, or for the frames of `part` if only a part of the recording is shown. A file that ends
    /// early has no answer from there on; lines beyond the last frame are ignored. Published files have both faults.
    /// Errors: The file cannot be read.
    pub fn read(path: &Path, part: Option<FrameRange>, frames: usize) -> Result<Self> {
        let mut answers = part.unwrap_or(FrameRange::from(1)).of(Form::Tld.read(path)?);
        let boxes = answers.len();
        let note = (boxes != frames).then(|| format!("{boxes} boxes for {frames} frames: {}", path.display()));
        answers.resize(frames, None);
        Ok(Self { name: name(path), answers, note })
    }

    /// Errors: The ground truth is of another length.
    pub fn score(&self, truth: &Trajectory) -> Result<Score> {
        Score::with_confidence(&self.answers, &vec![None; truth.len()], truth)
    }
}

pub(super) fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Returns other trackers' result files for the sequence at `path`: `trackers/*.txt` in its folder, in natural order.
/// Errors: The folder exists, but cannot be read.
pub fn result_files(path: &Path) -> Result<Vec<PathBuf>> {
    let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new(".")) };
    let folder = folder.join(RESULTS);
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let entries: std::io::Result<Vec<PathBuf>> =
        std::fs::read_dir(&folder).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    let mut files = entries.with_context(|| folder.display().to_string())?;
    files.retain(|file| file.extension() == Some(OsStr::new("txt")));
    files.sort_by(|a, b| natord::compare(&name(a), &name(b)));
    Ok(files)
}
