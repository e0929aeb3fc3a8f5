//! What a command reads and writes: no two outputs are one file, and none of them is an input.

use anyhow::{Result, bail, ensure};
use smr_recordings::output;
use std::path::{Path, PathBuf};
use std::{fmt, fs};

/// The files of a command line, before anything is read or written.
#[derive(Default)]
pub struct Places<'a> {
    /// Paths of recordings, or of folders of recordings.
    pub recordings: Vec<&'a Path>,
    /// Other files that are read.
    pub files: Vec<&'a Path>,
    /// Options, and what is written by them.
    pub outputs: Vec<(&'static str, &'a Path)>,
    /// Outputs whose names say what is written.
    named: Vec<(&'static str, &'a Path, Taken)>,
}

/// The kinds of output that an option takes: endings of files, and the meaning of a name without one.
#[derive(Clone, Copy)]
pub struct Taken {
    pub endings: &'static [&'static str],
    pub bare: Bare,
}

/// A name without an ending.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Bare {
    Refused,
    File,
    Folder,
}

impl Taken {
    pub const FOLDER: Self = Self { endings: &[], bare: Bare::Folder };
    /// A page, or a folder for it.
    pub const PAGE: Self = Self { endings: &["html"], bare: Bare::Folder };

    fn takes(self, output: &Path) -> bool {
        // A device takes anything. A file in place of a folder, or the other way round, is refused by who writes it.
        if fs::metadata(output).is_ok_and(|data| !data.is_file()) {
            return true;
        }
        let Some(ending) = output.extension() else { return self.bare != Bare::Refused };
        let is_folder = output.as_os_str().as_encoded_bytes().ends_with(b"/");
        self.bare == Bare::Folder && is_folder || self.endings.iter().any(|known| ending.eq_ignore_ascii_case(known))
    }
}

impl fmt::Display for Taken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let folder = "a folder (no ending, or a / after it)";
        if self.endings.is_empty() {
            return f.write_str(folder);
        }
        write!(f, "a file that ends in {}", listed(self.endings))?;
        match self.bare {
            Bare::Refused => Ok(()),
            Bare::File => f.write_str(", or has no ending"),
            Bare::Folder => write!(f, ", or {folder}"),
        }
    }
}

/// Endings of files, as a sentence names them.
pub fn listed(endings: &[&str]) -> String {
    match endings {
        [others @ .., last] if !others.is_empty() => format!(".{} or .{last}", others.join(", .")),
        _ => format!(".{}", endings.concat()),
    }
}

impl<'a> Places<'a> {
    /// Of a command that reads recordings.
    pub fn of(recordings: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        Self { recordings: recordings.into_iter().map(PathBuf::as_path).collect(), ..Self::default() }
    }

    /// The same with a file that is read, if one is.
    pub fn reads(mut self, file: Option<&'a PathBuf>) -> Self {
        self.files.extend(file.map(PathBuf::as_path));
        self
    }

    /// The same with what an option writes, if it is given.
    pub fn writes(mut self, option: &'static str, output: Option<&'a PathBuf>) -> Self {
        self.outputs.extend(output.map(|output| (option, output.as_path())));
        self
    }

    /// The same of an output whose name says what is written.
    pub fn writes_as(mut self, option: &'static str, output: Option<&'a PathBuf>, taken: Taken) -> Self {
        self.named.extend(output.map(|output| (option, output.as_path(), taken)));
        self.writes(option, output)
    }

    /// Errors: The name of an output does not say what it is, two outputs are one file, or an output is an input.
    pub fn check(&self) -> Result<()> {
        for (index, &(option, output)) in self.outputs.iter().enumerate() {
            let shown = output.display();
            if let Some((other, _)) = self.outputs[..index].iter().find(|(_, other)| is_same(output, other)) {
                bail!("{other} and {option} are one file, {shown}: expected two");
            }
            if self.files.iter().any(|file| is_same(output, file)) {
                bail!("{option} {shown} is a file that is read: expected another one");
            }
            if self.recordings.iter().any(|recording| is_same(output, recording) || is_part(output, recording)) {
                bail!("{option} {shown} belongs to the recording that is read: expected another file");
            }
        }
        for &(option, output, taken) in &self.named {
            ensure!(taken.takes(output), "{option} {}: expected {taken}", output.display());
        }
        Ok(())
    }
}

/// True if both names stand for one file or folder. A device can be written to several times.
fn is_same(one: &Path, other: &Path) -> bool {
    if let (Ok(first), Ok(second)) = (fs::metadata(one), fs::metadata(other)) {
        if !(first.is_file() || first.is_dir()) {
            return false;
        }
        // A file can have several names.
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

/// A name without links; of what is not there yet, in the folder where it will be.
fn real(path: &Path) -> PathBuf {
    let path = &output::behind_links(path);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let in_folder = || Some(fs::canonicalize(folder).ok()?.join(path.file_name()?));
    fs::canonicalize(path).ok().or_else(in_folder).unwrap_or_else(|| path.to_owned())
}

/// True if `file` is one of those that a recording at or below `path` is read from.
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
        fs::write(path("b"), "").unwrap();
        assert!(is_same(&path("a"), &path("./a")) && !is_same(&path("a"), &path("b")));
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

    #[test]
    fn a_name_says_what_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let check = |name: &str, taken| {
            let output = folder.path().join(name);
            let checked = Places::default().writes_as("--out", Some(&output), taken).check();
            checked.map_err(|error| error.to_string().split_once(": expected ").unwrap().1.to_owned())
        };
        fs::create_dir(folder.path().join("run.7")).unwrap();
        for name in ["page.HTML", "pages", "new.7/", "run.7"] {
            assert_eq!(check(name, Taken::PAGE), Ok(()), "{name}");
        }
        let expected = "a file that ends in .html, or a folder (no ending, or a / after it)";
        assert_eq!(check("page.pdf", Taken::PAGE).unwrap_err(), expected);
        assert!(check("x.png", Taken::FOLDER).is_err());
        let text = Taken { endings: &["txt"], bare: Bare::File };
        assert_eq!((check("x", text), check("x.txt", text)), (Ok(()), Ok(())));
        assert_eq!(check("x.", text).unwrap_err(), "a file that ends in .txt, or has no ending");
    }

    #[test]
    fn pictures_and_boxes_belong_to_a_recording() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir_all(path("clip/img")).unwrap();
        for name in ["clip/1.png", "clip/img/1.png", "clip/gt.txt", "clip/notes.txt", "clip/a.mp4"] {
            fs::write(path(name), "").unwrap();
            assert_eq!(is_part(&path(name), &path("clip")), name != "clip/notes.txt", "{name}");
        }
        assert!(!is_part(&path("clip/2.png"), &path("clip")), "it is not there");
        assert!(is_part(&path("clip/init.txt"), &path("clip")), "it would be read from then on");
        let of_file = |name: &str| is_part(&path(name), &path("clip/a.mp4"));
        assert!(of_file("clip/gt.txt") && !of_file("clip/1.png") && !of_file("clip/img/1.png"));
    }
}
