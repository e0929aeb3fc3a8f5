//! Output of files, folders and text: a file is written whole or not at all, and an error names it.

use crate::cleanup::{self, Kept};
use crate::messages;
use anyhow::{Context, Result, ensure};
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::{fmt, fs};
use tempfile::{TempDir, TempPath};

/// A file being written under a temporary name. [`Output::finish`] renames it; a drop leaves the former file unchanged.
pub struct Output {
    name: PathBuf,
    file: BufWriter<fs::File>,
    place: Place,
}

enum Place {
    /// A temporary file, which becomes the target.
    Temporary(Whole),
    /// A file of a [`Folder`], a device, a pipe or an open file, which stays in place.
    Fixed,
    StandardOutput,
}

struct Whole {
    path: TempPath,
    target: PathBuf,
    _kept: Kept,
}

impl Output {
    /// Begins the file `name`. Call it before computing the content, so that an unwritable path fails early.
    /// Errors: The folder is missing or cannot be written to, or `name` is a folder.
    pub fn create(name: &Path) -> Result<Self> {
        let target = if is_open(name) { name.to_owned() } else { behind_links(name) };
        let folder = folder_of(&target);
        ensure!(folder.is_dir(), "{}: there is no folder {}", cannot_write(name), folder.display());
        let (file, place) = open(target).with_context(|| cannot_write(name))?;
        Ok(Self { name: name.to_owned(), file: BufWriter::new(file), place })
    }

    /// Returns the temporary path for another program to write; `None` in a `Folder`, or for a device, pipe or open
    /// file.
    pub fn path(&self) -> Option<&Path> {
        if let Place::Temporary(whole) = &self.place { Some(&whole.path) } else { None }
    }

    pub fn end(mut self, bytes: &[u8]) -> Result<()> {
        self.write(bytes)?;
        self.finish()
    }

    pub fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.file.write_all(bytes);
        written.map_err(|error| self.failed(error))
    }

    /// Writes all bytes to the disk, so that `finish` only renames the file. Of several outputs, each is settled before
    /// the first is finished: a full disk then leaves all former files.
    pub fn settle(&mut self) -> Result<()> {
        let is_whole = matches!(self.place, Place::Temporary(_));
        let settled = self.file.flush().and_then(|()| if is_whole { synced(self.file.get_ref()) } else { Ok(()) });
        settled.map_err(|error| self.failed(error))
    }

    pub fn finish(mut self) -> Result<()> {
        self.settle()?;
        let Self { name, place, .. } = self;
        let Place::Temporary(Whole { path, target, _kept }) = place else { return Ok(()) };
        path.persist(target).map_err(|error| error.error).with_context(|| cannot_write(&name))
    }

    /// Like `finish`, but returns false, and leaves the file that is there, if a file of this name exists.
    pub fn finish_new(mut self) -> Result<bool> {
        self.settle()?;
        let Self { name, place, .. } = self;
        let Place::Temporary(Whole { path, target, _kept }) = place else { return Ok(false) };
        match path.persist_noclobber(target) {
            Ok(()) => Ok(true),
            Err(error) if error.error.kind() == ErrorKind::AlreadyExists => Ok(false),
            Err(error) => Err(error.error).with_context(|| cannot_write(&name)),
        }
    }

    fn failed(&self, error: io::Error) -> anyhow::Error {
        if matches!(self.place, Place::StandardOutput) && error.kind() == ErrorKind::BrokenPipe {
            return ReaderGone.into();
        }
        anyhow::Error::new(error).context(cannot_write(&self.name))
    }
}

/// Writes a file to the disk: some file systems report only then that it is full.
fn synced(file: &fs::File) -> io::Result<()> {
    match file.sync_all() {
        // Not every file system has this call.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        other => other,
    }
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Resolves a link, also one to a file that does not exist yet, so that writing keeps the link.
pub fn behind_links(name: &Path) -> PathBuf {
    match fs::read_link(name) {
        Ok(next) if fs::metadata(name).is_err() => folder_of(name).join(next),
        // A link in /proc to a pipe resolves to no path, so the path of the link is kept.
        _ => fs::canonicalize(name).unwrap_or_else(|_| name.to_owned()),
    }
}

/// True for a path of an already open file, such as /dev/stdout. `Output` appends to such a file.
fn is_open(name: &Path) -> bool {
    let behind = fs::read_link(name).unwrap_or_default();
    [name, &behind].iter().any(|path| path.starts_with("/dev/fd") || path.starts_with("/proc"))
}

fn open(target: PathBuf) -> io::Result<(fs::File, Place)> {
    let there = fs::metadata(&target);
    match &there {
        Ok(data) if data.is_dir() => return Err(ErrorKind::IsADirectory.into()),
        // A second handle of standard output would have its own position, and the two would overwrite each other.
        #[cfg(unix)]
        Ok(_) if ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| target == Path::new(name)) => {
            let file = std::os::fd::AsFd::as_fd(&io::stdout()).try_clone_to_owned()?.into();
            return Ok((file, Place::StandardOutput));
        }
        Ok(data) if !data.is_file() || is_open(&target) => {
            return Ok((fs::OpenOptions::new().append(true).open(target)?, Place::Fixed));
        }
        _ => {}
    }
    // By default, only this user can read a temporary file; 0o666 gives it the permissions of any new file.
    let make = || temporary(".smr-", 0o666).suffix(".part").tempfile_in(folder_of(&target));
    let (made, _kept) = cleanup::keep_path(make)?;
    if let Ok(data) = there {
        fs::set_permissions(made.path(), data.permissions())?;
    }
    let (file, path) = made.into_parts();
    Ok((file, Place::Temporary(Whole { path, target, _kept })))
}

#[cfg_attr(not(unix), allow(unused_variables))]
fn temporary(prefix: &str, mode: u32) -> tempfile::Builder<'_, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(mode));
    builder
}

/// A new or empty folder that is being filled. Its files appear together in [`Folder::finish`]. They are not synced, as
/// an [`Output`] is: that takes about 10 ms for each image.
pub struct Folder {
    name: PathBuf,
    target: PathBuf,
    made: TempDir,
    _kept: Kept,
}

impl Folder {
    /// Begins the folder `name`, and creates its parent folders. Errors: The folder is not empty, or cannot be created.
    pub fn create(name: &Path) -> Result<Self> {
        let target = behind_links(name);
        let is_there = fs::symlink_metadata(&target).is_ok();
        if is_there {
            let mut entries = fs::read_dir(&target).with_context(|| cannot_make(name))?;
            let empty = entries.next().is_none();
            ensure!(empty, "{} is not empty: expected an empty or a new folder", name.display());
        }
        let place = if is_there { &target } else { folder_of(&target) };
        fs::create_dir_all(place).with_context(|| cannot_make(name))?;
        let make = || temporary(".smr-", 0o777).tempdir_in(place);
        let (made, _kept) = cleanup::keep_path(make).with_context(|| cannot_make(name))?;
        Ok(Self { name: name.to_owned(), target, made, _kept })
    }

    pub fn file(&self, name: &str) -> Result<Output> {
        let (place, name) = (self.made.path().join(name), self.name.join(name));
        let file = fs::File::create(place).with_context(|| cannot_write(&name))?;
        Ok(Output { name, file: BufWriter::new(file), place: Place::Fixed })
    }

    pub fn folder(&self, name: &str) -> Result<()> {
        fs::create_dir(self.made.path().join(name)).with_context(|| cannot_make(&self.name.join(name)))
    }

    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        self.file(name)?.end(bytes)
    }

    /// Returns the path of the temporary folder, for another writer to fill.
    pub fn path(&self) -> &Path {
        self.made.path()
    }

    /// Like `finish`, but gives the folder the first of `names` that nothing has, and returns it.
    pub fn finish_new(self, names: impl IntoIterator<Item = PathBuf>) -> Result<PathBuf> {
        let Self { name, made, _kept, .. } = self;
        let finish = || -> io::Result<PathBuf> {
            let is_there = |name: &Path| fs::symlink_metadata(name).is_ok();
            for name in names.into_iter().filter(|name| !is_there(name)) {
                match fs::rename(made.path(), &name) {
                    // Another program has taken the name meanwhile.
                    Err(_) if is_there(&name) => {}
                    renamed => {
                        renamed?;
                        // The rename has moved the temporary folder, so nothing is left to remove.
                        let _ = made.keep();
                        return Ok(name);
                    }
                }
            }
            Err(io::Error::other("no name is free"))
        };
        cleanup::undisturbed(finish).with_context(|| cannot_make(&name))
    }

    pub fn finish(self) -> Result<()> {
        let Self { name, target, made, _kept } = self;
        let finish = || -> io::Result<()> {
            if made.path().parent() == Some(&target) {
                if fs::read_dir(&target)?.count() > 1 {
                    return Err(ErrorKind::DirectoryNotEmpty.into());
                }
                return move_all(made.path(), &target);
            }
            fs::rename(made.path(), &target)?;
            // The rename has moved the temporary folder, so nothing is left to remove.
            let _ = made.keep();
            Ok(())
        };
        cleanup::undisturbed(finish).with_context(|| cannot_make(&name))
    }
}

/// Moves all entries of a folder into another one; after an error, moves them back.
fn move_all(from: &Path, to: &Path) -> io::Result<()> {
    let names: Vec<_> = fs::read_dir(from)?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<_>>()?;
    for (at, name) in names.iter().enumerate() {
        if let Err(error) = fs::rename(from.join(name), to.join(name)) {
            // An entry that cannot be moved back stays: nothing more can be done for it.
            names[..at].iter().for_each(|moved| drop(fs::rename(to.join(moved), from.join(moved))));
            return Err(error);
        }
    }
    Ok(())
}

/// A private temporary folder for files that this program and another one exchange. Dropping it removes it.
pub struct Exchange {
    made: TempDir,
    _kept: Kept,
}

impl Exchange {
    /// Creates the folder; an error if the system has no place for temporary folders.
    pub fn create() -> Result<Self> {
        let make = || temporary("smr-", 0o700).tempdir();
        let (made, _kept) = cleanup::keep_path(make).context("cannot make a temporary folder")?;
        Ok(Self { made, _kept })
    }

    pub fn path(&self) -> &Path {
        self.made.path()
    }

    /// Writes a file that only this user can read, even after an [`Output`] replaces it, and returns its path. Errors:
    /// The file exists already, or cannot be written.
    pub fn private(&self, name: &str, bytes: &[u8]) -> Result<PathBuf> {
        let place = self.path().join(name);
        let mut options = fs::OpenOptions::new();
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let written = options.write(true).create_new(true).open(&place).and_then(|mut file| file.write_all(bytes));
        written.with_context(|| cannot_write(&place))?;
        Ok(place)
    }
}

/// Error of a write to standard output whose reader has closed the pipe (`| head`).
#[derive(Debug)]
pub struct ReaderGone;

impl fmt::Display for ReaderGone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the reader of standard output has ended")
    }
}

impl std::error::Error for ReaderGone {}

/// Writes text to standard output, with control characters escaped by [`messages::plain`].
/// Errors: [`ReaderGone`], or writing fails.
pub fn print(text: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<()> {
    let mut bytes = Vec::new();
    text(&mut bytes)?;
    let mut out = io::stdout().lock();
    let plain = messages::plain(&String::from_utf8_lossy(&bytes));
    match out.write_all(plain.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Err(ReaderGone.into()),
        written => written.context("cannot write to standard output"),
    }
}

pub fn complain(text: &str) {
    // Standard error may be closed, so an error is ignored.
    let _ = writeln!(io::stderr(), "{}{}", if has_cursor() { ERASE } else { "" }, messages::line(text));
}

/// Escape sequence that erases a line of progress on a terminal.
pub const ERASE: &str = "\r\x1b[2K";

/// True if standard error is a terminal whose lines can be erased.
pub fn has_cursor() -> bool {
    io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|kind| kind != "dumb")
}

fn cannot_write(name: &Path) -> String {
    format!("cannot write {}", name.display())
}

fn cannot_make(folder: &Path) -> String {
    format!("cannot make the folder {}", folder.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(name: &Path, bytes: &[u8]) -> Result<()> {
        Output::create(name)?.end(bytes)
    }

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_is_there_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("boxes.txt");
        let mut output = Output::create(&file).unwrap();
        output.write(b"1,2").unwrap();
        assert!(!file.exists());
        drop(output);
        assert_eq!(names(folder.path()), [""; 0]);

        write(&file, b"former").unwrap();
        let mut output = Output::create(&file).unwrap();
        output.write(b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"former");
        output.finish().unwrap();
        assert_eq!((fs::read(&file).unwrap().as_slice(), names(folder.path()).len()), (&b"new"[..], 1));
    }

    #[test]
    fn a_new_file_replaces_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        let written = |bytes: &[u8]| {
            let mut output = Output::create(&file).unwrap();
            output.write(bytes).unwrap();
            output.finish_new().unwrap()
        };
        assert_eq!((written(b"first"), written(b"second")), (true, false));
        assert_eq!((fs::read(&file).unwrap(), names(folder.path()).len()), (b"first".to_vec(), 1));
    }

    #[test]
    fn of_moved_files_all_or_none_are_there() {
        let above = tempfile::tempdir().unwrap();
        let [from, to] = ["from", "to"].map(|name| above.path().join(name));
        [&from, &to].into_iter().for_each(|folder| fs::create_dir(folder).unwrap());
        for name in ["1", "2", "3", "4"] {
            fs::write(from.join(name), "").unwrap();
        }
        // A file cannot take the place of a folder.
        for name in ["1", "3"] {
            fs::create_dir(to.join(name)).unwrap();
            assert!(move_all(&from, &to).is_err());
            assert_eq!((names(&from).len(), names(&to)), (4, vec![name.to_owned()]));
            fs::remove_dir(to.join(name)).unwrap();
        }
        move_all(&from, &to).unwrap();
        assert_eq!((names(&from).len(), names(&to).len()), (0, 4));
    }

    #[test]
    fn what_cannot_be_written_is_said_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        for name in [folder.path().to_owned(), folder.path().join("no").join("such")] {
            let error = format!("{:#}", Output::create(&name).err().unwrap());
            assert!(error.starts_with(&format!("cannot write {}: ", name.display())), "{error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_devices_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let mode = |name: &str| fs::metadata(path(name)).unwrap().permissions().mode() & 0o777;
        fs::write(path("file"), "former").unwrap();
        fs::set_permissions(path("file"), fs::Permissions::from_mode(0o640)).unwrap();
        for (link, target) in [("link", "file"), ("new", "fresh"), ("nowhere", "no/file"), ("images", "made")] {
            symlink(target, path(link)).unwrap();
        }
        write(&path("link"), b"new").unwrap();
        write(&path("new"), b"").unwrap();
        assert!(path("link").is_symlink() && path("new").is_symlink());
        assert_eq!((fs::read(path("file")).unwrap(), mode("file")), (b"new".to_vec(), 0o640));
        fs::write(path("plain"), "").unwrap();
        assert_eq!(mode("fresh"), mode("plain"));
        write(Path::new("/dev/null"), b"gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        let error = format!("{:#}", write(&path("nowhere"), b"").unwrap_err());
        let begins = format!("cannot write {}: there is no folder ", path("nowhere").display());
        assert!(error.starts_with(&begins) && error.ends_with("/no"), "{error}");
        for _ in 0..2 {
            let made = Folder::create(&path("images")).unwrap();
            made.write("1", b"").unwrap();
            made.finish().unwrap();
            assert!(path("images").is_symlink());
            assert_eq!(names(&path("made")), ["1"]);
            // The second round starts from an empty folder.
            fs::remove_file(path("made/1")).unwrap();
        }
        fs::create_dir(path("plain folder")).unwrap();
        assert_eq!(mode("made"), mode("plain folder"));
    }

    #[test]
    fn a_folder_is_there_whole_or_not_at_all() {
        let above = tempfile::tempdir().unwrap();
        let name = above.path().join("new").join("folder");
        let folder = Folder::create(&name).unwrap();
        folder.write("1", b"").unwrap();
        assert!(!name.exists());
        folder.finish().unwrap();
        assert_eq!((names(&name), names(&above.path().join("new"))), (vec!["1".to_owned()], vec!["folder".to_owned()]));
        let error = format!("{:#}", Folder::create(&name).err().unwrap());
        assert_eq!(error, format!("{} is not empty: expected an empty or a new folder", name.display()));

        fs::remove_file(name.join("1")).unwrap();
        drop(Folder::create(&name).unwrap());
        assert_eq!(names(&name), [""; 0]);
    }

    #[test]
    fn a_new_folder_replaces_none() {
        let above = tempfile::tempdir().unwrap();
        let name = |number: u8| above.path().join(number.to_string());
        let folders = [(); 3].map(|()| Folder::create(&name(1)).unwrap());
        // Made by another while the folders are filled.
        fs::create_dir(name(1)).unwrap();
        for (folder, number) in folders.into_iter().zip([Some(2), Some(3), None]) {
            folder.write("1", b"").unwrap();
            let finished = folder.finish_new((1..=3).map(name));
            assert_eq!(finished.as_ref().ok(), number.map(name).as_ref(), "{finished:?}");
        }
        assert_eq!((names(&name(1)), names(&name(2)), names(above.path()).len()), (vec![], vec!["1".to_owned()], 3));
    }
}
