//! Result files of other trackers, which are scored and shown beside the trackers run here.

use super::Score;
use anyhow::{Context, Result};
use smr_recordings::boxes::Form;
use smr_recordings::{BoundingBox, FrameRange, RESULTS, Trajectory};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

pub struct ResultFile {
    pub name: String,
    pub answers: Vec<Option<BoundingBox>>,
    pub note: Option<String>,
}

impl ResultFile {
    /// Reads the answers for `frames` frames, from the first one of `part` on. Published files may be too short or too
    /// long: missing lines are frames without an answer, extra lines are ignored. An error if the file cannot be read.
    pub fn read(path: &Path, part: Option<FrameRange>, frames: usize) -> Result<Self> {
        let mut answers = part.unwrap_or(FrameRange::ALL).of(Form::Tld.read(path)?);
        let boxes = answers.len();
        let note = (boxes != frames).then(|| format!("{boxes} boxes for {frames} frames: {}", path.display()));
        answers.resize(frames, None);
        Ok(Self { name: name(path), answers, note })
    }

    /// Scores the answers; an error if the ground truth has another length.
    pub fn score(&self, truth: &Trajectory) -> Result<Score> {
        Score::with_confidence(&self.answers, &vec![None; truth.len()], truth)
    }
}

pub(super) fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Returns the result files `trackers/*.txt` beside the recording, in natural order. Errors: The folder cannot be read.
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
