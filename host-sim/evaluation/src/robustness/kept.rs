//! What was measured before, in a folder: a measurement that was stopped goes on where it was.

use super::calibration::Calibration;
use super::{Figures, Row, Score, Start, folder_of};
use crate::Variant;
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use smr_core::Rect;
use smr_recordings::{input, is_of_boxes, output};
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// A folder with a file for each method on each recording.
pub struct Kept {
    folder: PathBuf,
    /// What all rows have in common: this program, and how recordings are read and started.
    common: String,
}

#[derive(Serialize, Deserialize)]
struct Stored {
    sequence: String,
    figures: Figures,
    calibration: Calibration,
    starts: Vec<StoredStart>,
}

#[derive(Serialize, Deserialize)]
struct StoredStart {
    name: String,
    frame: usize,
    target: (i32, i32, u16, u16),
    score: Score,
}

impl Kept {
    /// `options`: how recordings are read and started, as text.
    /// Errors: The folder cannot be made.
    pub fn in_folder(folder: &Path, options: &str) -> Result<Self> {
        fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        // Another build may have other answers.
        let program = std::env::current_exe().map(|program| stamp(&program)).unwrap_or_default();
        Ok(Self { folder: folder.to_owned(), common: format!("{} {program} {options}", env!("CARGO_PKG_VERSION")) })
    }

    pub(super) fn read(&self, path: &Path, variant: &Variant) -> Option<Row> {
        let text = input::text(&self.file(path, variant), &input::FORMER).ok()?;
        let Stored { sequence, figures, calibration, starts } = serde_json::from_str(&text).ok()?;
        let start = |StoredStart { name, frame, target: (x, y, width, height), score }| {
            (Start { name, frame, target: Rect::new(x, y, width, height) }, score)
        };
        Some(Row {
            origin: variant.origin(),
            tracker: variant.name.clone(),
            sequence,
            path: path.to_owned(),
            folder: folder_of(path),
            figures,
            calibration,
            starts: starts.into_iter().map(start).collect(),
        })
    }

    pub(super) fn write(&self, variant: &Variant, row: &Row) -> Result<()> {
        let start = |(Start { name, frame, target }, score): &(Start, Score)| StoredStart {
            name: name.clone(),
            frame: *frame,
            target: (target.x, target.y, target.width, target.height),
            score: *score,
        };
        let stored = Stored {
            sequence: row.sequence.clone(),
            figures: row.figures,
            calibration: row.calibration.clone(),
            starts: row.starts.iter().map(start).collect(),
        };
        output::write(&self.file(&row.path, variant), &serde_json::to_vec(&stored)?)
    }

    fn file(&self, path: &Path, variant: &Variant) -> PathBuf {
        let mut hasher = DefaultHasher::new();
        // Built-in recordings have a name alone.
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        (&self.common, format!("{variant:?}"), place, state(path)).hash(&mut hasher);
        self.folder.join(format!("{:016x}.json", hasher.finish()))
    }
}

/// What changes when a recording or the boxes beside it do.
fn state(path: &Path) -> Vec<String> {
    let folder = if path.is_dir() { Some(path) } else { path.parent() };
    let files = |folder: &Path| -> Vec<PathBuf> {
        fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
    };
    let mut all: Vec<PathBuf> = folder.map(files).unwrap_or_default();
    if path.is_dir() {
        let inner: Vec<PathBuf> = all.iter().filter(|file| file.is_dir()).flat_map(|inner| files(inner)).collect();
        all.extend(inner);
    } else {
        all.retain(|file| is_of_boxes(file) || file.file_name() == path.file_name());
    }
    all.sort();
    all.iter().map(|file| stamp(file)).collect()
}

/// The name of a file, its length and when it was changed.
fn stamp(file: &Path) -> String {
    let data = fs::metadata(file).ok();
    let changed = data.as_ref().and_then(|data| data.modified().ok());
    format!("{} {:?} {changed:?}", file.display(), data.map(|data| data.len()))
}

#[cfg(test)]
mod tests {
    use super::super::{Starts, measure_again};
    use crate::{MethodKind, Variant};
    use smr_core::paper::Config;
    use std::fs;
    use std::path::{Path, PathBuf};

    #[test]
    fn what_was_measured_is_not_measured_again() {
        let (folder, kept) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let clip = folder.path().join("clip.y4m");
        fs::write(&clip, "frames").unwrap();
        let variants = [MethodKind::Smr, MethodKind::Sad].map(|kind| Variant::new(kind, &Config::paper().into()));
        let measured = |options: &str, is_there: bool| {
            let open = |_: &Path| {
                anyhow::ensure!(is_there, "it is read again");
                Ok(crate::tests::sequence())
            };
            let kept = super::Kept::in_folder(kept.path(), options).unwrap();
            let paths: [PathBuf; 1] = [clip.clone()];
            let robustness = measure_again(&paths, open, &variants, Starts::Near, Some(&kept), &|_| ());
            (serde_json::to_string(&robustness.tables()).unwrap(), robustness.failures.len())
        };
        let first = measured("a", true);
        assert_eq!((measured("a", false), first.1), (first, 0));
        assert_eq!(measured("b", false).1, 1, "with other options it is another measurement");
        fs::write(&clip, "other frames").unwrap();
        assert_eq!(measured("a", false).1, 1, "the recording has changed");
    }
}
