//! A folder as a recording: which of its files are frames, and which are boxes.

use crate::annotations::boxes;
use crate::ffmpeg;
use crate::formats::{images, names, raw, y4m};
use anyhow::{Context, Result, bail, ensure};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Folder beside a recording that holds result files of other trackers.
pub const RESULTS: &str = "trackers";

/// Subfolders that hold a recording's images: `img` in the layout of OTB, `color` in that of VOT.
pub const INNER: [&str; 2] = ["img", "color"];

/// Returns the images in a folder and its subfolders `INNER`, sorted by name. Errors: The images have several
/// formats or lie in several of these folders, or two images have the same number.
pub(crate) fn images_in(folder: &Path, files: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let inner = INNER.map(|inner| folder.join(inner)).into_iter().filter(|inner| inner.is_dir());
    let mut kinds: Vec<Vec<PathBuf>> = Vec::new();
    for place in [Ok(files.to_owned())].into_iter().chain(inner.map(|inner| files_in(&inner))) {
        let mut of_kind = BTreeMap::<String, Vec<PathBuf>>::new();
        for (kind, file) in place?.into_iter().filter_map(|file| Some((images::kind(&file)?, file))) {
            of_kind.entry(kind).or_default().push(file);
        }
        kinds.extend(of_kind.into_values());
    }
    let at = folder.display();
    kinds.iter_mut().for_each(|files| names::sort(files));
    if let [one, other, ..] = &kinds[..] {
        let (count, others) = (one.len(), other.len());
        let [one, other] = [one, other].map(|files| files[0].display());
        bail!(
            "{at} holds pictures with two kinds of names, {count} like {one} and {others} like {other}: expected one kind; move the others away"
        );
    }
    let images = kinds.pop().unwrap_or_default();
    if let Some([one, other]) = names::twins(&images).map(|both| both.map(Path::display)) {
        bail!(
            "{at} holds {one} and {other}, two pictures with the same number: expected one for each frame; move the others away"
        );
    }
    Ok(images)
}

pub(crate) fn only_recording<'a>(folder: &Path, files: &'a [PathBuf]) -> Result<&'a Path> {
    let mut recordings = files.iter().filter(|file| is_recording(file));
    let Some(recording) = recordings.next() else {
        bail!("{} holds no recording: expected pictures (PNG, JPEG, PGM, PPM, PAM) or one video", folder.display());
    };
    if let Some(second) = recordings.next() {
        let (first, second) = (recording.display(), second.display());
        bail!("{} holds several recordings, among them {first} and {second}: name the one meant", folder.display());
    }
    check_file(recording, &recording.display().to_string())?;
    Ok(recording)
}

/// Returns the video (also Y4M file or raw dump) that is the only recording among the files of its folder, if `path` is
/// this video or the folder.
pub fn lone_video(path: &Path) -> Option<PathBuf> {
    let beside = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = if path.is_dir() { path } else { beside };
    let files = files_in(folder).ok()?;
    let video =
        only_recording(folder, &files).ok().filter(|_| images_in(folder, &files).is_ok_and(|all| all.is_empty()))?;
    if path.is_dir() {
        return Some(video.to_owned());
    }
    (video.file_name() == path.file_name()).then(|| path.to_owned())
}

/// Returns an error if `file`, called `name` in messages, is a broken link, a pipe or a device.
pub(crate) fn check_file(file: &Path, name: &str) -> Result<()> {
    ensure!(file.exists(), "{name} is a link to a file that is not there");
    ensure!(file.is_file(), "{name} is a pipe or a device: expected a file, or nothing of that name in the folder");
    Ok(())
}

pub(crate) fn is_recording(file: &Path) -> bool {
    y4m::is_y4m(file) || raw::is_raw(file) || ffmpeg::is_video(file)
}

pub(crate) fn check_images(folder: &Path) -> Result<()> {
    images_in(folder, &files_in(folder)?)?.first().map_or(Ok(()), |first| images::check_kind(first))
}

/// Returns the name of a folder, also of `.` and `..`.
pub(crate) fn folder_name(folder: &Path) -> String {
    let absolute = fs::canonicalize(folder).unwrap_or_default();
    let name = folder.file_name().or(absolute.file_name());
    name.map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into_owned())
}

/// True if the extension is that of an image, video, Y4M file or raw dump.
pub fn is_of_frames(file: &Path) -> bool {
    images::is_image(file) || is_recording(file)
}

/// True if the file has the name of an annotation file, or lies in the folder of other trackers' results.
pub fn is_of_boxes(file: &Path) -> bool {
    boxes::is_known(file) || file.parent().is_some_and(|folder| folder.ends_with(RESULTS))
}

/// Returns the entries of a folder except subfolders: files, broken links, pipes and devices.
pub(crate) fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = entries(folder).with_context(|| format!("cannot list the folder {}", folder.display()))?;
    files.retain(|path| !path.is_dir());
    files.sort();
    Ok(files)
}

/// Returns the entries of a folder except hidden ones, such as the thumbnails of a file manager.
pub(crate) fn entries(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries: io::Result<Vec<PathBuf>> = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect();
    let hidden = |path: &Path| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
    Ok(entries?.into_iter().filter(|path| !hidden(path)).collect())
}
