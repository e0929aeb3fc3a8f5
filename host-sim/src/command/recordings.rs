//! What a path on the command line stands for: a recording, or a folder with several.

use crate::sequence;
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};

/// `path` if it is a recording, else the recordings in it, in natural order.
pub fn recordings(path: &Path) -> Result<Vec<PathBuf>> {
    if sequence::is_sequence(path) {
        return Ok(vec![path.to_owned()]);
    }
    let entries = std::fs::read_dir(path).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    let mut found: Vec<PathBuf> =
        entries.with_context(|| format!("{}: neither a recording nor a folder", path.display()))?;
    found.retain(|entry| entry.is_dir() && sequence::is_sequence(entry));
    if found.is_empty() {
        bail!("{}: no recording in it: expected one, or a folder whose subfolders are recordings", path.display());
    }
    found.sort_by(|a, b| natord::compare(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_folder_of_recordings_is_taken_in_natural_order() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["s10", "s2"] {
            fs::create_dir(folder.path().join(name)).unwrap();
            fs::write(folder.path().join(name).join("frames.y4m"), "").unwrap();
        }
        fs::create_dir(folder.path().join("empty")).unwrap();
        fs::write(folder.path().join("README.md"), "").unwrap();
        let expected = ["s2", "s10"].map(|name| folder.path().join(name));
        assert_eq!(recordings(folder.path()).unwrap(), expected);
        assert_eq!(recordings(&expected[0]).unwrap(), expected[..1]);
    }

    #[test]
    fn a_path_without_a_recording_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = recordings(folder.path()).unwrap_err().to_string();
        assert!(error.starts_with(&folder.path().display().to_string()), "{error}");
        assert!(error.contains("no recording in it"), "{error}");
        let missing = folder.path().join("missing");
        assert!(
            format!("{:#}", recordings(&missing).unwrap_err()).contains("missing: neither a recording nor a folder")
        );
    }
}
