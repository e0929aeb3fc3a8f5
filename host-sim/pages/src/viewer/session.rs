//! A viewer's session: the user's targets, method and shown frame, saved as JSON beside the recording at each change.

use super::lock;
use super::model::{Length, Target};
use anyhow::{Context, Result, anyhow, bail, ensure};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use smr_files::input::{self, Kind};
use smr_files::messages;
use smr_files::output::Output;
use smr_recordings::{BUILT_IN, is_live, lone_video};
use std::collections::HashSet;
use std::fs;
use std::io::ErrorKind;
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
    /// Program and options that made the boxes that the user has looked at; empty in sessions of former versions.
    #[serde(default)]
    pub made_by: String,
    pub frame: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<Length>,
}

impl Work {
    pub fn new(recording: &str) -> Self {
        let (recording, method, options) = (recording.to_owned(), String::new(), Map::new());
        let (targets, made_by) = (Vec::new(), String::new());
        Self { smr_session: VERSION, recording, method, options, targets, ids: 0, made_by, frame: None, length: None }
    }

    /// Reads the session file at `path`; `None` if there is none. An error says `way_out`: what the user can do beside
    /// moving the file away.
    pub fn read(path: &Path, way_out: &str) -> Result<Option<Self>> {
        Ok(there(path, way_out)?.map(|(_, work)| work))
    }

    /// Forgets what the user has looked at, because other boxes are to come. Returns true if there was anything.
    pub fn forget_checked(&mut self) -> bool {
        let checked = self.targets.iter_mut().map(|target| std::mem::take(&mut target.checked));
        checked.filter(|checked| !checked.is_empty()).count() > 0
    }
}

/// The saved work of a viewer. It replaces only the file that this viewer has last read or written, byte for byte;
/// beside any other file, it takes a name that no file has.
pub struct Session {
    recording: String,
    kept: Mutex<SavedWork>,
}

struct SavedWork {
    work: Work,
    /// Path of the session file; `None` if the work is not saved.
    path: Option<PathBuf>,
    /// Content of the file as this viewer last read or wrote it.
    bytes: Option<Vec<u8>>,
    /// True if the file's work stays: the first change keeps the file under another name before replacing it.
    is_set_aside: bool,
    /// True if the user has been told that the file cannot be written.
    has_failed: bool,
}

#[derive(PartialEq)]
enum There {
    Nothing,
    /// The file that this viewer has last read or written.
    Own,
    /// Any other file, or one that is read-only.
    Other,
}

impl Session {
    /// Opens the session of `recording`, and reads the session file at `path` if there is one.
    pub fn open(path: Option<PathBuf>, recording: &str) -> Result<(Self, Option<Work>)> {
        let read =
            path.as_deref().map(|path| there(path, "name another by host-sim view SEQ --session FILE")).transpose()?;
        let (bytes, work) = read.flatten().unzip();
        let former = work.clone().unwrap_or_else(|| Work::new(recording));
        let is_set_aside = former.recording != recording;
        let kept = SavedWork { work: former, path, bytes, is_set_aside, has_failed: false };
        Ok((Self { recording: recording.to_owned(), kept: Mutex::new(kept) }, work))
    }

    /// Ignores the work in the file. The first change keeps the file under another name.
    pub fn leave_aside(&self) {
        let mut kept = lock(&self.kept);
        (kept.is_set_aside, kept.work.frame) = (true, None);
    }

    /// Returns the name under which the first change keeps the former file, if it does so.
    pub fn aside(&self) -> Option<String> {
        let kept = lock(&self.kept);
        let path = kept.path.as_deref().filter(|_| kept.is_set_aside)?;
        let free = aside_names(path).find(|name| fs::symlink_metadata(name).is_err());
        free.map(|name| name.display().to_string())
    }

    /// Returns the path of the session file as text; `None` if the work is not saved.
    pub fn name(&self) -> Option<String> {
        let kept = lock(&self.kept);
        kept.path.as_ref().filter(|_| !kept.has_failed).map(|path| path.display().to_string())
    }

    /// True if the session beside `recording` holds these targets: then other commands follow them without options.
    pub fn holds(&self, targets: &[Target], recording: &Path) -> bool {
        let kept = lock(&self.kept);
        let is_beside = kept.path.is_some() && kept.path == beside(recording);
        is_beside
            && !kept.is_set_aside
            && !kept.has_failed
            && kept.there() == There::Own
            && kept.work.targets == targets
    }

    pub(super) fn frame(&self) -> Option<usize> {
        lock(&self.kept).work.frame
    }

    pub fn length(&self) -> Option<Length> {
        lock(&self.kept).work.length.clone()
    }

    /// Sets the known length, which the next change saves.
    pub fn set_length(&self, length: Option<Length>) {
        lock(&self.kept).work.length = length;
    }

    /// Returns the largest id that `targets` or any targets before them had.
    pub(super) fn ids(&self, targets: &[Target]) -> u32 {
        let mut kept = lock(&self.kept);
        kept.work.ids = targets.iter().map(|target| target.id).fold(kept.work.ids, u32::max);
        kept.work.ids
    }

    /// Stores the number of the shown frame, and saves it if the file is still as this viewer last read or wrote it.
    /// Returns a message for the user, if there is one.
    pub(super) fn shows(&self, frame: usize) -> Option<String> {
        let mut kept = lock(&self.kept);
        kept.work.frame = Some(frame);
        if !kept.is_set_aside && kept.there() == There::Own { kept.save() } else { None }
    }

    /// Applies a change to the work and saves it. Returns a message for the user, if there is one.
    pub(super) fn keep(&self, change: impl FnOnce(&mut Work)) -> Option<String> {
        let mut kept = lock(&self.kept);
        change(&mut kept.work);
        kept.work.recording.clone_from(&self.recording);
        kept.save()
    }
}

impl SavedWork {
    /// Saves the work. Returns a message for the user, if there is one.
    fn save(&mut self) -> Option<String> {
        match self.write() {
            Ok(said) => {
                self.has_failed = false;
                said
            }
            Err(error) => {
                let is_new = !std::mem::replace(&mut self.has_failed, true);
                is_new.then(|| format!("the work is not kept: {}", messages::of(&error)))
            }
        }
    }

    fn write(&mut self) -> Result<Option<String>> {
        let Some(path) = self.path.clone() else { return Ok(None) };
        let mut bytes = serde_json::to_vec_pretty(&self.work)?;
        bytes.push(b'\n');
        let said = match self.replace(&path, &bytes)? {
            Some(aside) => {
                aside.map(|aside| format!("{} had other work, which is in {}", path.display(), aside.display()))
            }
            None => {
                let names = numbered(&path);
                let name = written_as(names, &bytes)?;
                let said = format!(
                    "{} is not the file of this viewer: the work is kept in {}",
                    path.display(),
                    name.display()
                );
                self.path = Some(name);
                Some(said)
            }
        };
        (self.bytes, self.is_set_aside) = (Some(bytes), false);
        Ok(said)
    }

    /// Writes the file `path`, if there is none or if it is this viewer's own; returns `None` otherwise. Returns the
    /// new name of the former file, if its work stays.
    fn replace(&self, path: &Path, bytes: &[u8]) -> Result<Option<Option<PathBuf>>> {
        if self.there() == There::Other {
            return Ok(None);
        }
        let mut output = Output::create(path)?;
        output.write(bytes)?;
        output.settle()?;
        // The file is looked at once more right before it is replaced, because writing takes time.
        Ok(match self.there() {
            There::Nothing => output.finish_new()?.then_some(None),
            There::Own => {
                let former = self.bytes.as_ref().filter(|_| self.is_set_aside);
                let aside = former.map(|former| written_as(aside_names(path), former)).transpose()?;
                output.finish()?;
                Some(aside)
            }
            There::Other => None,
        })
    }

    fn there(&self) -> There {
        let Some(path) = &self.path else { return There::Nothing };
        match fs::metadata(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => There::Nothing,
            Ok(data) if data.is_file() && !data.permissions().readonly() => {
                let is_own = input::bytes(path, &KIND).is_ok_and(|there| self.bytes.as_ref() == Some(&there));
                if is_own { There::Own } else { There::Other }
            }
            _ => There::Other,
        }
    }
}

/// Returns `a.json~`, `a.json~2`, ... for `a.json`.
fn aside_names(path: &Path) -> impl Iterator<Item = PathBuf> {
    (1..).map(move |number: usize| {
        let mut name = path.as_os_str().to_owned();
        name.push(if number == 1 { "~".to_owned() } else { format!("~{number}") });
        name.into()
    })
}

/// Returns `a-2.json`, `a-3.json`, ... for `a.json`.
fn numbered(path: &Path) -> impl Iterator<Item = PathBuf> {
    (2..).map(move |number: usize| {
        let mut name = path.file_stem().unwrap_or_default().to_owned();
        name.push(format!("-{number}"));
        if let Some(ending) = path.extension() {
            name.push(".");
            name.push(ending);
        }
        path.with_file_name(name)
    })
}

/// Writes a file under the first of `names` that no file has, and returns the name.
fn written_as(names: impl Iterator<Item = PathBuf>, bytes: &[u8]) -> Result<PathBuf> {
    for name in names.filter(|name| fs::symlink_metadata(name).is_err()) {
        let mut output = Output::create(&name)?;
        output.write(bytes)?;
        if output.finish_new()? {
            return Ok(name);
        }
    }
    bail!("no name is free")
}

/// Returns the path of the session that a viewer keeps beside a recording. Cameras, standard input and built-in
/// recordings have none.
pub fn beside(recording: &Path) -> Option<PathBuf> {
    if recording == Path::new("-") || is_live(recording) || BUILT_IN.iter().any(|name| recording == Path::new(name)) {
        return None;
    }
    of_path(&owner(recording).unwrap_or_else(|| recording.to_owned()))
}

/// Returns the path that a recording's session is called by, if the recording is a video alone in its folder: one path,
/// whether the user names the video or the folder. It is the video, or its folder if only that has a session, as former
/// versions made it.
pub fn owner(recording: &Path) -> Option<PathBuf> {
    let video = lone_video(recording)?;
    let folder = video.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let has_session = |path: &Path| of_path(path).is_some_and(|file| fs::symlink_metadata(file).is_ok());
    if has_session(folder) && !has_session(&video) { Some(folder.to_owned()) } else { Some(video) }
}

fn of_path(recording: &Path) -> Option<PathBuf> {
    let named = recording.file_name().map_or_else(|| recording.canonicalize().ok(), |_| Some(recording.to_owned()))?;
    let mut name = named.file_name()?.to_owned();
    name.push(".smr.json");
    Some(named.with_file_name(name))
}

/// Reads the session at `path`, if anything is there: its bytes, and its work.
fn there(path: &Path, way_out: &str) -> Result<Option<(Vec<u8>, Work)>> {
    if fs::symlink_metadata(path).is_err() {
        return Ok(None);
    }
    read(path, way_out).map(Some).with_context(|| path.display().to_string())
}

fn read(path: &Path, way_out: &str) -> Result<(Vec<u8>, Work)> {
    let wrong = |error: serde_json::Error| {
        let (line, column) = (error.line(), error.column());
        anyhow!(
            "line {line}, column {column}: it is damaged, or no session of host-sim view: expected one as `view` writes it: move it away, or {way_out}"
        )
    };
    // A pipe or a device may never end, and cannot be replaced by a later session.
    let is_stream = fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir());
    ensure!(!is_stream, "it is a pipe or a device: expected {}", KIND.expected);
    let bytes = input::bytes(path, &KIND)?;
    let value: Value = serde_json::from_slice(&bytes).map_err(wrong)?;
    let version = &value["smr_session"];
    ensure!(
        version.as_u64().is_none_or(|version| version <= VERSION.into()),
        "it is a session of version {version}, and this host-sim reads {VERSION}: take a later host-sim, or {way_out}"
    );
    let work: Work = serde_json::from_slice(&bytes).map_err(wrong)?;
    check(&work.targets).map_err(|what| anyhow!("{what}: move it away, or {way_out}"))?;
    Ok((bytes, work))
}

/// Errors: A target has no boxes, or one in frame 0, or two targets have one id or name.
fn check(targets: &[Target]) -> Result<()> {
    let (mut ids, mut names) = (HashSet::new(), HashSet::new());
    for target in targets {
        let (id, name) = (target.id, target.name());
        ensure!(!target.locks.is_empty(), "it has a target without boxes");
        let begins = target.locks.iter().all(|lock| lock.frame > 0);
        ensure!(begins, "{name} has a box in frame 0: expected frames from 1 on");
        ensure!(ids.insert(id), "two targets have the id {id}: expected one");
        ensure!(names.insert(&target.name), "two targets are called {name}: expected one");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::model::Lock;
    use crate::viewer::spans::Spans;
    use smr_core::Rect;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_video_alone_in_its_folder_has_one_session() {
        let above = tempfile::tempdir().unwrap();
        let path = |name: &str| above.path().join(name);
        let put = |name: &str| fs::write(path(name), "").unwrap();
        fs::create_dir(path("tag")).unwrap();
        put("tag/a.y4m");
        let both = |session: &str| {
            for named in ["tag", "tag/a.y4m"] {
                assert_eq!(beside(&path(named)), Some(path(session)), "{named}");
            }
        };
        both("tag/a.y4m.smr.json");
        put("tag.smr.json");
        both("tag.smr.json");
        assert_eq!(owner(&path("tag/a.y4m")), Some(path("tag")));
        put("tag/a.y4m.smr.json");
        both("tag/a.y4m.smr.json");
        assert_eq!(owner(&path("tag")), Some(path("tag/a.y4m")));
        put("tag/b.y4m");
        assert_eq!(beside(&path("tag/b.y4m")), Some(path("tag/b.y4m.smr.json")));
        put("tag/1.png");
        assert_eq!((owner(&path("tag")), beside(&path("tag"))), (None, Some(path("tag.smr.json"))));
    }

    #[test]
    fn work_is_kept_from_the_first_change_on_and_other_work_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.smr.json");
        let open = || Session::open(Some(file.clone()), "a").unwrap();
        let by_hand = Lock { by_hand: true, ..Lock::new(3, Some(Rect::new(-1, 2, 3, 4))) };
        let (hidden, checked) = (vec![(5, 6)].into(), vec![(3, 8)].into());
        let car = Target { id: 4, name: "car".to_owned(), locks: vec![by_hand, Lock::new(9, None)], hidden, checked };
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
        let kept: Work = serde_json::from_slice(&fs::read(folder.path().join("a.smr.json~")).unwrap()).unwrap();
        assert!(kept == expected);
        // The second session has changed the file, so the first one leaves it and goes on in a file of its own.
        let there = fs::read(&file).unwrap();
        let own = folder.path().join("a.smr-2.json");
        let said = first.keep(|work| work.frame = None).unwrap();
        assert_eq!(
            said,
            format!("{} is not the file of this viewer: the work is kept in {}", file.display(), own.display())
        );
        assert_eq!((first.keep(|work| work.frame = Some(2)), second.keep(|work| work.frame = Some(3))), (None, None));
        assert_eq!(
            (first.name().unwrap(), second.name().unwrap()),
            (own.display().to_string(), file.display().to_string())
        );
        assert_eq!((fs::read(&file).unwrap() == there, names(folder.path()).len()), (false, 3));
    }

    #[test]
    fn a_length_is_saved_by_the_next_change_and_former_sessions_have_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.smr.json");
        let former = r#"{"smr_session":1,"recording":"a","method":"robust","options":{},"targets":[],"frame":null}"#;
        fs::write(&file, former).unwrap();
        let open = || Session::open(Some(file.clone()), "a").unwrap().0;
        let session = open();
        assert_eq!(session.length(), None);
        let pixels_per_metre = "120.41594578792295".parse().unwrap();
        let length = Length { pixels_per_metre, line: Some([1, 2, 3, 400]) };
        session.set_length(Some(length.clone()));
        assert_eq!(open().length(), None);
        assert_eq!(session.keep(|_| ()), None);
        assert_eq!(open().length(), Some(length));
        fs::write(&file, former.replace("null}", r#"null,"length":{"pixels_per_metre":0,"line":null}}"#)).unwrap();
        assert!(Session::open(Some(file.clone()), "a").is_err());
    }

    /// Puts something in the place of the session file while a viewer is open: the viewer must not touch it.
    #[test]
    fn what_another_has_put_there_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let other = serde_json::to_vec(&Work::new("another recording")).unwrap();
        for (name, content) in
            [("notes", Some(&b"my notes"[..])), ("empty", Some(b"")), ("session", Some(&other)), ("folder", None)]
        {
            let put = |file: &Path| content.map_or_else(|| fs::create_dir(file), |bytes| fs::write(file, bytes));
            for is_first in [true, false] {
                let file = path(&format!("{name}-{is_first}.json"));
                let (session, _) = Session::open(Some(file.clone()), "a").unwrap();
                if !is_first {
                    assert_eq!(session.keep(|_| ()), None);
                    fs::remove_file(&file).unwrap();
                }
                put(&file).unwrap();
                let before = (file.is_dir(), fs::read(&file).ok());
                assert_eq!(session.shows(5), None);
                let said = session.keep(|_| ()).unwrap();
                assert!(said.ends_with(&format!("{name}-{is_first}-2.json")), "{said}");
                assert_eq!((session.shows(6), session.keep(|_| ())), (None, None));
                assert_eq!((file.is_dir(), fs::read(&file).ok()), before, "{name}");
                assert!(read(&path(&format!("{name}-{is_first}-2.json")), "").is_ok());
            }
        }
    }

    #[test]
    fn a_former_file_gets_a_name_that_no_file_has() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let file = path("a.json");
        Session::open(Some(file.clone()), "another recording").unwrap().0.keep(|_| ());
        let former = fs::read(&file).unwrap();
        fs::write(path("a.json~"), "mine").unwrap();
        let (session, _) = Session::open(Some(file.clone()), "a").unwrap();
        assert_eq!(session.aside(), Some(path("a.json~2").display().to_string()));
        assert_eq!(session.shows(3), None);
        assert!(session.keep(|_| ()).unwrap().ends_with("a.json~2"));
        assert_eq!((session.keep(|_| ()), session.aside(), names(folder.path()).len()), (None, None, 3));
        assert_eq!(
            (fs::read(path("a.json~")).unwrap(), fs::read(path("a.json~2")).unwrap()),
            (b"mine".to_vec(), former)
        );
        assert_eq!(read(&file, "").unwrap().1.recording, "a");
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("a.smr.json");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let error = messages::of(&Work::read(&pipe, "").unwrap_err());
        assert!(
            error.ends_with("a.smr.json: it is a pipe or a device: expected a session of host-sim view"),
            "{error}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn links_and_read_only_files_are_kept() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        symlink("real.json", path("link.json")).unwrap();
        assert!(Session::open(Some(path("link.json")), "a").is_err(), "the link leads nowhere");
        Session::open(Some(path("real.json")), "a").unwrap().0.keep(|_| ());
        let (session, _) = Session::open(Some(path("link.json")), "a").unwrap();
        assert_eq!(session.keep(|work| work.frame = Some(4)), None);
        assert!(path("link.json").is_symlink() && read(&path("real.json"), "").unwrap().1.frame == Some(4));
        let mut permissions = fs::metadata(path("real.json")).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(path("real.json"), permissions).unwrap();
        let said = session.keep(|work| work.frame = Some(5)).unwrap();
        assert!(said.ends_with("link-2.json") && read(&path("real.json"), "").unwrap().1.frame == Some(4), "{said}");
    }

    #[test]
    fn targets_that_cannot_be_told_apart_and_frame_0_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.smr.json");
        let target = |id, name: &str, frames: &[usize]| Target {
            id,
            name: name.to_owned(),
            locks: frames.iter().map(|&frame| Lock::new(frame, Some(Rect::new(1, 2, 3, 4)))).collect(),
            hidden: Spans::default(),
            checked: Spans::default(),
        };
        for (targets, why) in [
            (vec![target(1, "a", &[1]), target(2, "b", &[1]), target(3, "a", &[2])], "two targets are called a"),
            (vec![target(1, "a", &[1]), target(1, "b", &[1])], "two targets have the id 1"),
            (vec![target(1, "a", &[1]), target(2, "b", &[])], "it has a target without boxes"),
            (vec![target(1, "a", &[3, 0])], "a has a box in frame 0: expected frames from 1 on"),
        ] {
            fs::write(&file, serde_json::to_vec(&Work { targets, ..Work::new("a") }).unwrap()).unwrap();
            let error = messages::of(&Work::read(&file, "give --init").unwrap_err());
            assert!(error.contains(why) && error.ends_with(": move it away, or give --init"), "{error}");
        }
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
