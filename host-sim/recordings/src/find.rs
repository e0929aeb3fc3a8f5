//! Finds the recordings at a path of the command line: the path itself if it is a recording, else those below it.

use crate::folder::{INNER, check_images, entries, files_in, is_of_boxes, is_of_frames, is_recording};
use crate::formats::images::is_image;
use crate::open::is_sequence;
use anyhow::{Context, Result, bail};
use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

/// Returns the recordings at `paths`: each path that is a recording, and for a folder of recordings its videos and the
/// recordings in its subfolders of any depth, in natural order.
pub fn recordings(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let found: Result<Vec<_>> = paths.iter().map(|path| of_path(path)).collect();
    Ok(found?.concat())
}

fn of_path(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() && is_sequence(path) {
        return Ok(vec![path.to_owned()]);
    }
    entries(path).with_context(|| format!("{}: neither a recording nor a folder", path.display()))?;
    let mut found = Vec::new();
    look_into(path.to_owned(), &mut found, &mut HashSet::new())?;
    if found.is_empty() {
        check_images(path)?;
        bail!("{}: no recording in it: expected one, or folders of recordings", path.display());
    }
    Ok(found)
}

/// Finds the recordings in a folder, but does not search inside a recording. `seen` holds canonical paths of visited
/// folders, because a link to a parent folder would otherwise be followed for ever.
fn look_into(folder: PathBuf, found: &mut Vec<PathBuf>, seen: &mut HashSet<PathBuf>) -> Result<()> {
    let cannot_list = || format!("cannot list the folder {}", folder.display());
    if !seen.insert(folder.canonicalize().with_context(cannot_list)?) {
        return Ok(());
    }
    let videos = videos_in(&folder);
    if videos.is_empty() && is_sequence(&folder) {
        found.push(folder);
        return Ok(());
    }
    let (before, is_single) = (found.len(), videos.len() == 1);
    found.extend(videos);
    for inner in folders(&folder).with_context(cannot_list)? {
        look_into(inner, found, seen)?;
    }
    // A folder with a video alone is a recording of the folder's name.
    if is_single && found.len() == before + 1 {
        found[before] = folder;
    }
    Ok(())
}

/// Returns the videos (also Y4M files and raw dumps) in a folder. There is none if pictures or files of boxes lie beside
/// them: the folder is one recording then, or it is not clear which of the videos those belong to.
fn videos_in(folder: &Path) -> Vec<PathBuf> {
    let mut files = files_in(folder).unwrap_or_default();
    files.retain(|file| is_of_frames(file) || is_of_boxes(file));
    files.sort_by(|a, b| natord::compare(&a.to_string_lossy(), &b.to_string_lossy()));
    let is_clear = files.iter().all(|file| is_recording(file)) && (files.len() > 1 || !has_inner_images(folder));
    if is_clear { files } else { Vec::new() }
}

fn has_inner_images(folder: &Path) -> bool {
    INNER.iter().any(|inner| files_in(&folder.join(inner)).is_ok_and(|files| files.iter().any(|file| is_image(file))))
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
    fn videos_and_recordings_in_subfolders_are_recordings_of_one_folder() {
        let above = folder(
            "clips/b.y4m clips/a.y4m clips/.trash/x.y4m clips/.c.y4m clips/tag10/c.y4m clips/tag2/Nacht/d.y4m clips/tag2/e/1.png \
             one/top.y4m one/d1/a.y4m lone/top.y4m lone/notes/x.txt=1 otb/1.y4m otb/img/1.png boxed/1.y4m boxed/gt.txt=1 boxed/old/2.y4m",
        );
        let found = |name: &str| {
            let found = of_path(&above.path().join(name)).unwrap();
            let name = |path: &PathBuf| path.strip_prefix(above.path()).unwrap().display().to_string();
            found.iter().map(name).collect::<Vec<_>>()
        };
        let clips = ["clips/a.y4m", "clips/b.y4m", "clips/tag2/Nacht", "clips/tag2/e", "clips/tag10"];
        assert_eq!(found("clips"), clips);
        assert_eq!(found("one"), ["one/top.y4m", "one/d1"]);
        for whole in ["lone", "otb", "boxed"] {
            assert_eq!(found(whole), [whole]);
        }
        assert_eq!(found(""), [&["boxed"], &clips[..], &["lone", "one/top.y4m", "one/d1", "otb"]].concat());
    }

    #[test]
    fn built_in_recordings_are_found_by_their_names() {
        let names = ["synthetic", "synthetic:1", "synthetic:2"].map(PathBuf::from);
        assert_eq!(recordings(&names).unwrap(), names);
        assert!(recordings(&["synthetic:a".into()]).is_err());
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
