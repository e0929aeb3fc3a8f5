//! Checks of a command's paths: outputs differ, have allowed extensions, and neither are nor belong to an input.

use super::HostSim;
use anyhow::{Error, Result, anyhow, bail, ensure};
use clap::CommandFactory;
use smr_files::output;
use smr_pages::export::boxes::Format;
use smr_pages::viewer::session_beside;
use std::path::{Path, PathBuf};
use std::{fmt, fs};

/// Input and output paths of a command line, checked before anything is read or written.
pub struct Places<'a> {
    recordings: Vec<&'a Path>,
    /// Outputs: option, path, and the file names that the option accepts (`None` for any).
    outputs: Vec<(&'static str, &'a Path, Option<Taken>)>,
}

/// File names that an option accepts: without an extension, or with one of `endings`. If `is_folder` is set, a name
/// without an extension or with a final `/` is a folder's.
#[derive(Clone, Copy)]
pub struct Taken {
    pub endings: [&'static [&'static str]; 2],
    pub is_folder: bool,
}

impl Taken {
    fn takes(self, output: &Path) -> bool {
        // An existing device or folder may have any name. If the output must be a file, its writer refuses a folder.
        if fs::metadata(output).is_ok_and(|data| !data.is_file()) {
            return true;
        }
        let Some(ending) = output.extension() else { return true };
        let is_folder = self.is_folder && output.as_os_str().as_encoded_bytes().ends_with(b"/");
        is_folder || self.endings.concat().iter().any(|known| ending.eq_ignore_ascii_case(known))
    }
}

impl fmt::Display for Taken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bare = if self.is_folder { "a folder (no ending, or a / after it)" } else { "has no ending" };
        match self.endings.concat()[..] {
            [] => f.write_str(bare),
            ref endings => write!(f, "a file that ends in {}, or {bare}", listed(endings)),
        }
    }
}

/// Lists file extensions for a message: `.csv, .json or .txt`.
pub fn listed(endings: &[&str]) -> String {
    match endings {
        [others @ .., last] if !others.is_empty() => format!(".{} or .{last}", others.join(", .")),
        _ => format!(".{}", endings.concat()),
    }
}

/// Finds several recordings; `None` if there is one path, and it is no folder of recordings. Errors: A path has no
/// recording, or a live source stands beside others. `lacks_out` is true if a path may be that of `--out`.
pub fn several(paths: &[PathBuf], lacks_out: bool) -> Result<Option<Vec<PathBuf>>> {
    if matches!(paths, [one] if !one.is_dir()) {
        return Ok(None);
    }
    let found = smr_recordings::recordings(paths).map_err(|error| meant(paths, lacks_out).unwrap_or(error))?;
    let is_live = |path: &&PathBuf| *path == Path::new("-") || smr_recordings::is_live(path);
    if let Some(live) = found.iter().find(is_live).filter(|_| found.len() > 1) {
        bail!("{} is followed alone: expected it as the only recording, or recordings that are files", live.display());
    }
    Ok((found.len() > 1 || found != paths).then_some(found))
}

/// Returns what was probably meant by the first path that is not there: a command, or the value of an option.
fn meant(paths: &[PathBuf], lacks_out: bool) -> Option<Error> {
    let at = paths.iter().position(|path| !path.exists())?;
    let words: Vec<_> = paths[at..].iter().map(|path| path.to_string_lossy()).collect();
    let word = &words[0];
    let is_box = words.len() == 4 && words.iter().all(|word| word.parse::<f64>().is_ok());
    Some(match Format::of_file(&paths[at]) {
        _ if HostSim::command().find_subcommand(&**word).is_some() => {
            anyhow!("{word} is a command: expected it first, as in host-sim {word}")
        }
        _ if is_box => anyhow!("{word}: there is no such recording; did you mean --init {}?", words.join(",")),
        Some(_) if lacks_out => anyhow!("{word}: there is no such recording; did you mean --out {word}?"),
        _ => return None,
    })
}

impl<'a> Places<'a> {
    pub fn of(recordings: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        Self { recordings: recordings.into_iter().map(PathBuf::as_path).collect(), outputs: Vec::new() }
    }

    pub fn writes(mut self, option: &'static str, output: Option<&'a PathBuf>, taken: Option<Taken>) -> Self {
        self.outputs.extend(output.map(|output| (option, output.as_path(), taken)));
        self
    }

    /// Errors: An output has an unknown extension, two outputs are the same file, or an output belongs to an input.
    pub fn check(&self) -> Result<()> {
        for (index, &(option, output, _)) in self.outputs.iter().enumerate() {
            let shown = output.display();
            if let Some((other, ..)) = self.outputs[..index].iter().find(|(_, other, _)| is_same(output, other)) {
                bail!("{other} and {option} are one file, {shown}: expected two");
            }
            let is_session = |recording: &Path| session_beside(recording).is_some_and(|file| is_same(output, &file));
            let is_read = |recording: &&Path| {
                is_same(output, recording)
                    || is_part(output, recording)
                    || option != "--session" && is_session(recording)
            };
            ensure!(
                !self.recordings.iter().any(is_read),
                "{option} {shown} belongs to the recording that is read: expected another file"
            );
        }
        for &(option, output, taken) in &self.outputs {
            if let Some(taken) = taken.filter(|taken| !taken.takes(output)) {
                bail!("{option} {}: expected {taken}", output.display());
            }
        }
        Ok(())
    }
}

/// True if both paths are the same file or folder. A device does not count, because it can be written to several times.
fn is_same(one: &Path, other: &Path) -> bool {
    if let (Ok(first), Ok(second)) = (fs::metadata(one), fs::metadata(other)) {
        if !(first.is_file() || first.is_dir()) {
            return false;
        }
        // Hard links give a file several names.
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            return (first.dev(), first.ino()) == (second.dev(), second.ino());
        }
        #[cfg(not(unix))]
        let _ = second;
    }
    real(one) == real(other)
}

/// Resolves symbolic links, also in the path of a file that does not exist yet if its folder exists.
fn real(path: &Path) -> PathBuf {
    let path = &output::behind_links(path);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let in_folder = || Some(fs::canonicalize(folder).ok()?.join(path.file_name()?));
    fs::canonicalize(path).ok().or_else(in_folder).unwrap_or_else(|| path.to_owned())
}

/// True if `file` is an annotation file beside the recording `path`, or lies in the folder `path`, at any depth, and is
/// a file of frames, annotations or results. A file that does not exist yet counts only if it has the name of an
/// annotation file.
fn is_part(file: &Path, path: &Path) -> bool {
    let (file, path) = (real(file), real(path));
    let folder = if path.is_dir() { path.as_path() } else { path.parent().unwrap_or(&path) };
    let beside = file.parent() == Some(folder);
    (file.is_file() || smr_recordings::boxes::is_known(&file))
        && file.starts_with(folder)
        && (smr_recordings::is_of_boxes(&file) && (beside || path.is_dir())
            || path.is_dir() && smr_recordings::is_of_frames(&file))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_is_found_by_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "").unwrap();
        assert!(is_same(&path("a"), &path("./a")));
        assert!(is_same(&path("new"), &path("./new")) && !is_same(&path("new"), &path("a")));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(path("a"), path("link")).unwrap();
            fs::hard_link(path("a"), path("hard")).unwrap();
            assert!(is_same(&path("link"), &path("a")) && is_same(&path("hard"), &path("a")));
            std::os::unix::fs::symlink("new", path("early")).unwrap();
            assert!(is_same(&path("early"), &path("new")));
            assert!(!is_same(Path::new("/dev/null"), Path::new("/dev/null")));
        }
    }
}
