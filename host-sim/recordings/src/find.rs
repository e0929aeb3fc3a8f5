//! Finds the recordings at a path of the command line: the path itself if it is a recording, else those below it.

use crate::folder::{check_images, entries, files_in, is_of_boxes, is_of_frames, is_recording};
use crate::open::is_sequence;
use anyhow::{Context, Result, bail};
use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

/// Returns the recordings at `paths`: each path that is a recording, for a folder with several videos and no boxes these
/// videos, and for any other folder the recordings among its subfolders of any depth, in natural order.
pub fn recordings(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let found: Result<Vec<_>> = paths.iter().map(|path| of_path(path)).collect();
    Ok(found?.concat())
}

fn of_path(path: &Path) -> Result<Vec<PathBuf>> {
    if let Some(videos) = several_in(path) {
        return Ok(videos);
    }
    if is_sequence(path) {
        return Ok(vec![path.to_owned()]);
    }
    let entries = folders(path).with_context(|| format!("{}: neither a recording nor a folder", path.display()))?;
    let mut found = Vec::new();
    look_into(entries, &mut found, &mut path.canonicalize().into_iter().collect())?;
    if found.is_empty() {
        check_images(path)?;
        bail!("{}: no recording in it: expected one, or folders of recordings", path.display());
    }
    Ok(found)
}

/// Finds the recordings in folders, but does not search inside a recording. `seen` holds canonical paths of visited
/// folders, because a link to a parent folder would otherwise be followed for ever.
fn look_into(entries: Vec<PathBuf>, found: &mut Vec<PathBuf>, seen: &mut HashSet<PathBuf>) -> Result<()> {
    for folder in entries {
        let cannot_list = || format!("cannot list the folder {}", folder.display());
        if !seen.insert(folder.canonicalize().with_context(cannot_list)?) {
            continue;
        }
        if let Some(videos) = several_in(&folder) {
            found.extend(videos);
        } else if is_sequence(&folder) {
            found.push(folder);
        } else {
            look_into(folders(&folder).with_context(cannot_list)?, found, seen)?;
        }
    }
    Ok(())
}

/// Returns the videos (also Y4M files and raw dumps) in a folder that has several. `None` if pictures or files of boxes
/// lie beside them, because it is not clear which of the videos those belong to.
fn several_in(folder: &Path) -> Option<Vec<PathBuf>> {
    let mut files = files_in(folder).ok()?;
    files.retain(|file| is_of_frames(file) || is_of_boxes(file));
    files.sort_by(|a, b| natord::compare(&a.to_string_lossy(), &b.to_string_lossy()));
    (files.len() > 1 && files.iter().all(|file| is_recording(file))).then_some(files)
}

fn folders(path: &Path) -> io::Result<Vec<PathBuf>> {
    let mut folders = entries(path)?;
    folders.retain(|entry| entry.is_dir());
    folders.sort_by(|a, b| natord::compare(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(folders)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::folder;

    #[test]
    fn recordings_in_folders_of_folders_come_in_natural_order() {
        let names =
            "more/vot/bag/color/1.png more/Man/img/1.png tld/1.png tld/trackers/x=1 a/.hidden/1.png a/b/c/d/1.png";
        let link = if cfg!(unix) { "a/b/again->../.." } else { "" };
        let above = folder(&format!("{names} {link} s10/frames.y4m s2/frames.y4m empty/notes=1 README.md=1"));
        let expected = ["a/b/c/d", "more/Man", "more/vot/bag", "s2", "s10", "tld"].map(|name| above.path().join(name));
        assert_eq!(of_path(above.path()).unwrap(), expected);
        assert_eq!(of_path(&expected[3]).unwrap(), expected[3..4]);
    }

    #[test]
    fn a_folder_of_videos_is_a_folder_of_recordings_unless_boxes_lie_beside_them() {
        let above = folder(
            "clips/c10.y4m clips/c9.y4m clips/c9.y4m.smr.json=1 clips/notes.txt=1 one/1.y4m boxed/1.y4m boxed/2.y4m boxed/gt.txt=1",
        );
        let path = |name: &str| above.path().join(name);
        assert_eq!(of_path(&path("clips")).unwrap(), ["clips/c9.y4m", "clips/c10.y4m"].map(path));
        for whole in ["one", "boxed"] {
            assert_eq!(of_path(&path(whole)).unwrap(), [path(whole)]);
        }
        assert_eq!(of_path(above.path()).unwrap(), ["boxed", "clips/c9.y4m", "clips/c10.y4m", "one"].map(path));
    }

    #[test]
    fn a_path_without_a_recording_is_named() {
        let folder = folder("");
        let error = of_path(folder.path()).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: no recording in it", folder.path().display())), "{error}");
        let missing = format!("{:#}", of_path(&folder.path().join("missing")).unwrap_err());
        assert!(missing.contains("missing: neither a recording nor a folder"), "{missing}");
    }
}
