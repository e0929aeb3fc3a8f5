//! What this program writes: a file is written whole or not at all, and an error names it.

use crate::cleanup::{self, Kept};
use crate::messages;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::{TempDir, TempPath};

/// A file under way. Until [`Output::finish`] nothing has its name: dropped before, it leaves what was there as it was.
pub struct Output {
    /// As it was asked for.
    name: PathBuf,
    file: BufWriter<fs::File>,
    /// `None` of a device or a pipe, which cannot be replaced.
    whole: Option<Whole>,
}

/// A file that lies beside the one that it will replace.
struct Whole {
    path: TempPath,
    target: PathBuf,
    _kept: Kept,
}

impl Output {
    /// Begins the file `name`. To be called before the work of which it will hold the result.
    /// Errors: There is no such folder, it cannot be written to, or `name` is a folder.
    pub fn create(name: &Path) -> Result<Self> {
        Self::at(name, name)
    }

    /// The same of a file that is at `place` for now.
    fn at(place: &Path, name: &Path) -> Result<Self> {
        let target = behind_links(place).with_context(|| cannot_write(name))?;
        let folder = folder_of(&target);
        ensure!(folder.is_dir(), "{}: there is no folder {}", cannot_write(name), folder.display());
        let (file, whole) = open(target).with_context(|| cannot_write(name))?;
        Ok(Self { name: name.to_owned(), file: BufWriter::new(file), whole })
    }

    /// Where another program writes what will have the name; `None` of a device or a pipe.
    pub fn path(&self) -> Option<&Path> {
        self.whole.as_ref().map(|whole| &*whole.path)
    }

    /// Writes all that is left to write, and gives the file its name.
    pub fn end(mut self, bytes: &[u8]) -> Result<()> {
        self.write(bytes)?;
        self.finish()
    }

    pub fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).with_context(|| cannot_write(&self.name))
    }

    pub fn finish(self) -> Result<()> {
        let Self { name, mut file, whole } = self;
        let finish = || {
            file.flush()?;
            whole.map_or(Ok(()), |Whole { path, target, _kept }| path.persist(target).map_err(|error| error.error))
        };
        finish().with_context(|| cannot_write(&name))
    }
}

/// For encoders, which write by themselves. Their errors are the system's alone: they do not name the file.
impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Where links lead, whether there is something or not. A link stays one: what it names is written.
pub fn behind_links(name: &Path) -> io::Result<PathBuf> {
    let mut target = name.to_owned();
    // As many as Linux follows.
    for _ in 0..40 {
        match fs::read_link(&target) {
            Ok(next) if fs::metadata(&target).is_err() => target = folder_of(&target).join(next),
            // Links to pipes, as in /proc, have no other name.
            _ => return Ok(fs::canonicalize(&target).unwrap_or(target)),
        }
    }
    Err(io::Error::other("its links lead to no end"))
}

fn open(target: PathBuf) -> io::Result<(fs::File, Option<Whole>)> {
    let there = fs::metadata(&target);
    match &there {
        Ok(data) if data.is_dir() => return Err(ErrorKind::IsADirectory.into()),
        Ok(data) if !data.is_file() => {
            return Ok((fs::OpenOptions::new().write(true).open(target)?, None));
        }
        _ => {}
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".smr-").suffix(".part");
    // Not for the eyes of the user alone, as temporary files are, but as any new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let (made, _kept) = cleanup::file(|| builder.tempfile_in(folder_of(&target)))?;
    if let Ok(data) = there {
        fs::set_permissions(made.path(), data.permissions())?;
    }
    let (file, path) = made.into_parts();
    Ok((file, Some(Whole { path, target, _kept })))
}

pub fn write(name: &Path, bytes: &[u8]) -> Result<()> {
    Output::create(name)?.end(bytes)
}

/// A new folder under way, or one that is there and empty. Until [`Folder::finish`] nothing is in it.
pub struct Folder {
    name: PathBuf,
    target: PathBuf,
    made: TempDir,
    _kept: Kept,
}

impl Folder {
    /// Begins the folder `name`, with all folders above it.
    /// Errors: There is something in it, or it cannot be made.
    pub fn create(name: &Path) -> Result<Self> {
        let target = behind_links(name).with_context(|| cannot_make(name))?;
        let is_there = fs::symlink_metadata(&target).is_ok();
        if is_there {
            let mut entries = fs::read_dir(&target).with_context(|| cannot_make(name))?;
            let empty = entries.next().is_none();
            ensure!(empty, "{} is not empty: expected an empty or a new folder", name.display());
        }
        let above = folder_of(&target);
        fs::create_dir_all(above).with_context(|| cannot_make(name))?;
        let make = |place: &Path| cleanup::folder(|| tempfile::Builder::new().prefix(".smr-").tempdir_in(place));
        let made = match make(if is_there && stays(&target) { &target } else { above }) {
            // Only the empty folder is the user's.
            Err(_) if is_there => make(&target),
            made => made,
        };
        let (made, _kept) = made.with_context(|| cannot_make(name))?;
        Ok(Self { name: name.to_owned(), target, made, _kept })
    }

    /// Where its files are written until it has its name.
    pub fn path(&self) -> &Path {
        self.made.path()
    }

    pub fn file(&self, name: &str) -> Result<Output> {
        Output::at(&self.path().join(name), &self.name.join(name))
    }

    pub fn folder(&self, name: &str) -> Result<()> {
        fs::create_dir(self.path().join(name)).with_context(|| cannot_make(&self.name.join(name)))
    }

    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        self.file(name)?.end(bytes)
    }

    pub fn finish(self) -> Result<()> {
        let Self { name, target, made, _kept } = self;
        let finish = || -> io::Result<()> {
            if made.path().parent() == Some(&target) {
                return fill(made.path(), &target);
            }
            #[cfg(unix)]
            {
                use std::os::unix::fs::PermissionsExt;
                // As the folder that it replaces, or as a new one: the temporary one is closed to others.
                let like = fs::Permissions::from_mode(0o777);
                let like = tempfile::Builder::new().permissions(like).tempdir_in(made.path())?;
                let like = fs::metadata(&target).or_else(|_| fs::metadata(like.path()))?;
                fs::set_permissions(made.path(), like.permissions())?;
            }
            // The system replaces an empty folder at once.
            fs::rename(made.path(), &target)?;
            // There is nothing to remove under the former name.
            let _ = made.keep();
            Ok(())
        };
        finish().with_context(|| cannot_make(&name))
    }
}

/// True of a folder that cannot be replaced, or should not be: the root of a file system, or the folder that this program was started in.
fn stays(folder: &Path) -> bool {
    let Ok(folder) = fs::canonicalize(folder) else { return true };
    let is_current = std::env::current_dir().is_ok_and(|current| current == folder);
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let device = |folder: &Path| fs::metadata(folder).map(|data| data.dev()).ok();
        is_current || folder.parent().is_none_or(|above| device(above) != device(&folder))
    }
    #[cfg(not(unix))]
    {
        let _ = is_current;
        true
    }
}

/// Moves all that is in `from` into `to`. After an error nothing of it is there.
fn fill(from: &Path, to: &Path) -> io::Result<()> {
    let entries = fs::read_dir(from)?.collect::<io::Result<Vec<_>>>()?;
    cleanup::undisturbed(|| {
        for (count, entry) in entries.iter().enumerate() {
            if let Err(error) = fs::rename(entry.path(), to.join(entry.file_name())) {
                for moved in &entries[..count] {
                    // What cannot be moved back cannot be removed either.
                    let _ = fs::rename(to.join(moved.file_name()), moved.path());
                }
                return Err(error);
            }
        }
        Ok(())
    })
}

/// A folder of this user alone for what this program and another one exchange. Dropped, it is removed.
pub struct Exchange {
    made: TempDir,
    _kept: Kept,
}

impl Exchange {
    /// Errors: The system has no place for it.
    pub fn create() -> Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix("smr-");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        let make = || builder.tempdir();
        let (made, _kept) = cleanup::folder(make).context("cannot make a temporary folder")?;
        Ok(Self { made, _kept })
    }

    pub fn path(&self) -> &Path {
        self.made.path()
    }

    /// Writes a file that nobody else can read, nor what takes its place by [`Output`]. Returns its place.
    /// Errors: There is such a file already, or the disk's.
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

/// Writes text to standard output, [in plain letters](messages::plain).
/// Errors: Nobody reads it any more ([`ErrorKind::BrokenPipe`]), or the disk's.
pub fn print(text: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<()> {
    let mut bytes = Vec::new();
    text(&mut bytes)?;
    let mut out = io::stdout().lock();
    let plain = messages::plain(&String::from_utf8_lossy(&bytes));
    out.write_all(plain.as_bytes()).and_then(|()| out.flush()).context("cannot write to standard output")
}

/// Says something on standard error, in one line.
#[allow(clippy::print_stderr)] // the one place
pub fn complain(text: &str) {
    eprintln!("{}", messages::line(text));
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
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link, plain) = (folder.path().join("file"), folder.path().join("link"), folder.path().join("plain"));
        fs::write(&file, "former").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&file) & 0o777, 0o640);
        fs::write(&plain, "").unwrap();
        write(&folder.path().join("fresh"), b"").unwrap();
        assert_eq!(mode(&folder.path().join("fresh")), mode(&plain));
        write(Path::new("/dev/null"), b"gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_named() {
        let mut output = Output::create(Path::new("/dev/full")).unwrap();
        output.write(b"1").unwrap();
        let error = format!("{:#}", output.finish().unwrap_err());
        assert!(error.starts_with("cannot write /dev/full: No space left"), "{error}");
    }

    #[test]
    fn a_folder_is_there_whole_or_not_at_all() {
        let above = tempfile::tempdir().unwrap();
        let name = above.path().join("new").join("folder");
        let folder = Folder::create(&name).unwrap();
        fs::write(folder.path().join("1"), "").unwrap();
        assert!(!name.exists());
        folder.finish().unwrap();
        assert_eq!((names(&name), names(&above.path().join("new"))), (vec!["1".to_owned()], vec!["folder".to_owned()]));
        let error = format!("{:#}", Folder::create(&name).err().unwrap());
        assert_eq!(error, format!("{} is not empty: expected an empty or a new folder", name.display()));

        let empty = above.path().join("empty");
        fs::create_dir(&empty).unwrap();
        drop(Folder::create(&empty).unwrap());
        let folder = Folder::create(&empty).unwrap();
        fs::write(folder.path().join("1"), "").unwrap();
        folder.finish().unwrap();
        assert_eq!(names(&empty), ["1"]);
    }

    /// Something else is in the folder when it is to be filled.
    #[test]
    fn a_folder_that_was_empty_is_filled_whole_or_not_at_all() {
        let above = tempfile::tempdir().unwrap();
        let name = above.path().join("empty");
        fs::create_dir(&name).unwrap();
        let folder = Folder::create(&name).unwrap();
        assert_eq!(names(&name), [""; 0]);
        let numbers = || (0..100).map(|number: u8| number.to_string());
        numbers().for_each(|number| folder.write(&number, b"").unwrap());
        fs::create_dir_all(name.join("50").join("other")).unwrap();
        let error = format!("{:#}", folder.finish().unwrap_err());
        assert!(error.starts_with(&format!("cannot make the folder {}: ", name.display())), "{error}");
        assert_eq!((names(&name), names(above.path())), (vec!["50".to_owned()], vec!["empty".to_owned()]));

        // A folder that stays gets what is moved into it.
        let made = tempfile::tempdir_in(above.path()).unwrap();
        numbers().for_each(|number| fs::write(made.path().join(number), "").unwrap());
        assert!(fill(made.path(), &name).is_err());
        assert_eq!((names(&name), names(made.path()).len()), (vec!["50".to_owned()], 100));
    }

    #[cfg(unix)]
    #[test]
    fn what_a_link_names_is_made() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("below")).unwrap();
        symlink("below/file", path("first")).unwrap();
        symlink("first", path("second")).unwrap();
        write(&path("second"), b"new").unwrap();
        assert!(path("first").is_symlink() && path("second").is_symlink());
        assert_eq!(fs::read(path("below/file")).unwrap(), b"new");
        symlink("below/no/file", path("nowhere")).unwrap();
        let error = format!("{:#}", write(&path("nowhere"), b"").unwrap_err());
        let begins = format!("cannot write {}: there is no folder ", path("nowhere").display());
        assert!(error.starts_with(&begins) && error.ends_with("below/no"), "{error}");
        symlink("below/folder", path("pictures")).unwrap();
        for _ in 0..2 {
            let made = Folder::create(&path("pictures")).unwrap();
            made.write("1", b"").unwrap();
            made.finish().unwrap();
            assert!(path("pictures").is_symlink());
            assert_eq!((names(&path("below/folder")), names(&path("below")).len()), (vec!["1".to_owned()], 2));
            // Empty, it is there the next time.
            fs::remove_file(path("below/folder/1")).unwrap();
        }
        symlink("circle", path("circle")).unwrap();
        assert!(Output::create(&path("circle")).is_err() && Folder::create(&path("circle")).is_err());
    }
}
