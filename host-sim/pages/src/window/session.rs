//! A window's session: the user's targets, method and shown frame, saved as JSON beside the recording at each change.

use super::{Target, lock};
use anyhow::{Context, Result, anyhow, ensure};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use smr_recordings::input::{self, Kind};
use smr_recordings::output;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

const VERSION: u32 = 1;
const KIND: Kind = Kind { expected: "a session of host-sim view", most: 64 };

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Work {
    smr_session: u32,
    pub recording: String,
    pub method: String,
    pub options: Map<String, Value>,
    pub targets: Vec<Target>,
    /// Largest id that a target ever had, so that none is given twice; 0 in sessions of former versions.
    #[serde(default)]
    ids: u32,
    pub frame: Option<usize>,
}

impl Work {
    pub fn new(recording: &str) -> Self {
        let (recording, method, options) = (recording.to_owned(), String::new(), Map::new());
        Self { smr_session: VERSION, recording, method, options, targets: Vec::new(), ids: 0, frame: None }
    }
}

pub struct Session {
    /// Path of the session file; `None` if the work is not saved.
    path: Option<PathBuf>,
    recording: String,
    kept: Mutex<SavedWork>,
}

struct SavedWork {
    work: Work,
    /// Content of the file as this window last read or wrote it; `None` before that, and after `leave_aside`.
    bytes: Option<Vec<u8>>,
    /// True if the user has been told that the file cannot be written.
    has_failed: bool,
}

impl Session {
    /// Opens the session of `recording`, and reads the session file at `path` if there is one.
    pub fn open(path: Option<PathBuf>, recording: &str) -> Result<(Self, Option<Work>)> {
        let there = path.as_deref().filter(|path| fs::symlink_metadata(path).is_ok());
        let read = there.map(|path| read(path).with_context(|| path.display().to_string())).transpose()?;
        let (bytes, work) = read.unzip();
        let former = work.clone().unwrap_or_else(|| Work::new(recording));
        let kept = SavedWork { work: former, bytes, has_failed: false };
        Ok((Self { path, recording: recording.to_owned(), kept: Mutex::new(kept) }, work))
    }

    /// Ignores the work in the file. The next change copies the file to `NAME~` before overwriting it.
    pub fn leave_aside(&self) {
        let mut kept = lock(&self.kept);
        (kept.bytes, kept.work.frame) = (None, None);
    }

    /// Returns the path of the session file as text; `None` if the work is not saved.
    pub fn name(&self) -> Option<String> {
        let path = self.path.as_ref().filter(|_| !lock(&self.kept).has_failed);
        path.map(|path| path.display().to_string())
    }

    pub(super) fn frame(&self) -> Option<usize> {
        lock(&self.kept).work.frame
    }

    /// Returns the largest id that `targets` or any targets before them had.
    pub(super) fn ids(&self, targets: &[Target]) -> u32 {
        let mut kept = lock(&self.kept);
        kept.work.ids = targets.iter().map(|target| target.id).fold(kept.work.ids, u32::max);
        kept.work.ids
    }

    /// Stores the number of the shown frame, and saves it if the file is still as this window last read or wrote it.
    /// Returns a message for the user, if there is one.
    pub(super) fn shows(&self, frame: usize) -> Option<String> {
        let mut kept = lock(&self.kept);
        kept.work.frame = Some(frame);
        let there = self.path.as_ref().and_then(|path| fs::read(path).ok());
        if there.is_some() && there == kept.bytes { self.write(&mut kept) } else { None }
    }

    /// Applies a change to the work and saves it. Returns a message for the user, if there is one.
    pub(super) fn keep(&self, change: impl FnOnce(&mut Work)) -> Option<String> {
        let mut kept = lock(&self.kept);
        change(&mut kept.work);
        kept.work.recording.clone_from(&self.recording);
        self.write(&mut kept)
    }

    fn write(&self, kept: &mut SavedWork) -> Option<String> {
        let path = self.path.as_ref()?;
        match replaced(path, kept) {
            Ok(aside) => {
                kept.has_failed = false;
                let said =
                    |aside: PathBuf| format!("{} had other work, which is in {}", path.display(), aside.display());
                aside.map(said)
            }
            Err(error) => {
                let is_new = !std::mem::replace(&mut kept.has_failed, true);
                is_new.then(|| format!("the work is not kept: {error:#}"))
            }
        }
    }
}

fn read(path: &Path) -> Result<(Vec<u8>, Work)> {
    let wrong = |error: serde_json::Error| {
        let (line, column) = (error.line(), error.column());
        anyhow!(
            "line {line}, column {column}: it is damaged, or no session of host-sim view: expected one as `view` writes it: move it away, or name another by --session"
        )
    };
    let bytes = input::bytes(path, &KIND)?;
    let value: Value = serde_json::from_slice(&bytes).map_err(wrong)?;
    let version = &value["smr_session"];
    ensure!(
        version.as_u64().is_none_or(|version| version <= VERSION.into()),
        "it is a session of version {version}, and this host-sim reads {VERSION}: take a later host-sim"
    );
    let work: Work = serde_json::from_slice(&bytes).map_err(wrong)?;
    ensure!(work.targets.iter().all(|target| !target.locks.is_empty()), "it has a target without boxes: move it away");
    Ok((bytes, work))
}

/// Writes the file. If it holds anything but `kept.bytes`, first copies it to `NAME~` and returns the copy's path.
fn replaced(path: &Path, kept: &mut SavedWork) -> Result<Option<PathBuf>> {
    let mut bytes = serde_json::to_vec_pretty(&kept.work)?;
    bytes.push(b'\n');
    let other = fs::read(path).ok().filter(|there| kept.bytes.as_ref() != Some(there));
    let mut aside = path.as_os_str().to_owned();
    aside.push("~");
    let aside = other.map(|other| output::write(aside.as_ref(), &other).map(|()| aside.into())).transpose()?;
    output::write(path, &bytes)?;
    kept.bytes = Some(bytes);
    Ok(aside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::Lock;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn work_is_kept_from_the_first_change_on_and_other_work_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.smr.json");
        let open = || Session::open(Some(file.clone()), "a").unwrap();
        let locks = vec![Lock { frame: 3, bbox: Some((-1, 2, 3, 4)) }, Lock { frame: 9, bbox: None }];
        let car = Target { id: 4, name: "car".to_owned(), locks };
        let (first, work) = open();
        assert_eq!((work, first.shows(7), names(folder.path()).len()), (None, None, 0));
        assert_eq!(first.keep(|work| work.targets = vec![car.clone()]), None);
        let ids = first.ids(std::slice::from_ref(&car));
        assert_eq!((ids, first.ids(&[])), (4, 4), "a target that is removed keeps its id");
        assert_eq!(first.shows(8), None);
        let expected = Work { targets: vec![car], ids, frame: Some(8), ..Work::new("a") };
        let (second, work) = open();
        assert_eq!((work.as_ref(), second.frame(), names(folder.path()).len()), (Some(&expected), Some(8), 1));
        second.leave_aside();
        assert_eq!((second.frame(), second.shows(1), open().1.as_ref()), (None, None, Some(&expected)));
        let said = second.keep(|work| work.targets.clear()).unwrap();
        assert!(said.ends_with("a.smr.json~"), "{said}");
        // The second session has changed the file, so the first one copies it before it writes.
        let kept: Work = serde_json::from_slice(&fs::read(folder.path().join("a.smr.json~")).unwrap()).unwrap();
        let there = fs::read(&file).unwrap();
        assert!(kept == expected && first.keep(|work| work.frame = None).unwrap().ends_with("a.smr.json~"));
        assert_eq!(fs::read(folder.path().join("a.smr.json~")).unwrap(), there, "one is kept, the last");
        assert_eq!((second.path.as_ref(), names(folder.path()).len()), (Some(&file), 2));
    }

    #[test]
    fn what_is_no_session_is_refused_and_what_cannot_be_written_is_said_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.smr.json");
        for (text, said) in [
            ("{\"smr_session\": 1, ", "line 1, column 19: it is damaged, or no session"),
            ("{\n\"smr_session\": 1}", "line 2, column 17: it is damaged, or no session"),
            ("[]", "it is damaged, or no session of host-sim view: expected one as `view` writes it: move it away"),
            ("{\"smr_session\": 2}", "it is a session of version 2, and this host-sim reads 1"),
        ] {
            fs::write(&file, text).unwrap();
            let error = format!("{:#}", Session::open(Some(file.clone()), "a").err().unwrap());
            assert!(error.contains(said) && error.starts_with(&file.display().to_string()), "{error}");
            assert!(!error.contains("field") && !error.contains("EOF"), "{error}");
        }
        let (session, _) = Session::open(Some(folder.path().join("no/a.smr.json")), "a").unwrap();
        let said = [(); 2].map(|()| session.keep(|_| ()));
        assert!(
            said[0].as_ref().unwrap().starts_with("the work is not kept: cannot write ") && said[1].is_none(),
            "{said:?}"
        );
        assert_eq!(Session::open(None, "a").unwrap().0.keep(|_| ()), None);
    }
}
