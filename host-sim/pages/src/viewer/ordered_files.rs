//! Videos, reports and recordings that the user orders on the page. A child process of host-sim writes each file, a
//! thread each recording.

use super::lock;
use anyhow::{Context, Result, ensure};
use serde::Serialize;
use smr_files::messages;
use smr_files::output::Exchange;
use smr_files::process::Process;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread;

pub struct Job {
    /// Name under which the browser saves the file: letters, digits and `-_.` only.
    pub name: String,
    /// Arguments of `host-sim`, without the path of the output file, which is appended.
    pub words: Vec<OsString>,
    /// Count of lines that the program prints until it is done, to compute its progress; 0 if it prints none.
    pub lines: usize,
}

#[derive(Clone, Serialize)]
pub(super) struct Progress {
    id: u32,
    name: String,
    /// Fraction done, 0 to 1; `None` if unknown.
    done: Option<f64>,
    file: Option<String>,
    /// Folder of a recording that is written, and a sentence about it.
    folder: Option<(PathBuf, String)>,
    error: Option<String>,
    cancelled: bool,
    #[serde(skip)]
    is_running: bool,
    /// The running process; `None` once it has ended, or if a thread writes.
    #[serde(skip)]
    process: Option<Arc<Process>>,
}

impl Progress {
    const fn begun(id: u32, name: String) -> Self {
        let (done, file, folder, error, process) = (None, None, None, None, None);
        Self { id, name, done, file, folder, error, cancelled: false, is_running: true, process }
    }
}

const MAX: usize = 2;

/// Errors: Too many files are being made already.
fn next_id(all: &BTreeMap<u32, Progress>) -> Result<u32> {
    let running = all.values().filter(|one| one.is_running).count();
    ensure!(running < MAX, "{running} files are being made already: wait until one is done");
    Ok(all.last_key_value().map_or(1, |(last, _)| last + 1))
}

/// Files ordered on the page. They are removed when the program that serves the page ends.
pub struct Made {
    folder: Exchange,
    progress: Mutex<BTreeMap<u32, Progress>>,
}

impl Made {
    pub fn new() -> Result<Self> {
        Ok(Self { folder: Exchange::create()?, progress: Mutex::default() })
    }

    fn progress(&self) -> MutexGuard<'_, BTreeMap<u32, Progress>> {
        lock(&self.progress)
    }

    pub(super) fn of(&self, id: u32) -> Option<Progress> {
        self.progress().get(&id).cloned()
    }

    /// Returns the folder that a child process writes file `id` to. If the process is cancelled or fails, the folder is
    /// removed with all leftovers.
    fn folder_of(&self, id: u32) -> PathBuf {
        self.folder.path().join(id.to_string())
    }

    pub(super) fn file(&self, id: u32) -> Result<(String, Vec<u8>)> {
        let name = self.of(id).and_then(|one| one.file).context("there is no such file, or it is not ready")?;
        let file = self.folder_of(id).join(&name);
        let bytes = fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
        Ok((name, bytes))
    }

    /// Writes an HTML file, readable by this user alone, that forwards to `address`. A browser can be started with this
    /// file's path instead of the secret address, because all users can see a program's arguments.
    pub fn door(&self, address: &str) -> Result<PathBuf> {
        let head = "<!DOCTYPE html><title>host-sim</title><meta name=\"referrer\" content=\"no-referrer\">";
        let lead = format!(
            "{head}<meta http-equiv=\"refresh\" content=\"0; url={address}\"><a href=\"{address}\">host-sim</a>\n"
        );
        self.folder.private("open.html", lead.as_bytes())
    }

    /// Starts the program that writes a file. `tell` is called with the file's id now and after each step of progress,
    /// `say` with the program's notes. Errors: Too many files are being made already, or the program does not start.
    pub(super) fn begin(
        self: &Arc<Self>,
        job: Job,
        tell: impl Fn(u32) + Send + 'static,
        say: impl Fn(String) + Send + 'static,
    ) -> Result<u32> {
        let Job { name, words, lines } = job;
        let mut all = self.progress();
        let id = next_id(&all)?;
        // The program derives the format to write from the extension of `name`.
        fs::create_dir(self.folder_of(id)).context("cannot make a temporary folder")?;
        let place = self.folder.private(&format!("{id}/{name}"), &[])?;
        let program = std::env::current_exe().context("cannot find host-sim itself")?;
        let mut command = Command::new(program);
        command.args(words).arg(&place).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let process = Arc::new(Process::start(&mut command).context("cannot start host-sim")?);
        let done = (lines > 0).then_some(0.0);
        all.insert(id, Progress { done, process: Some(Arc::clone(&process)), ..Progress::begun(id, name) });
        drop(all);
        tell(id);
        let made = Arc::clone(self);
        thread::spawn(move || {
            let ended = made.watch(&process, id, lines, &tell);
            if let Some(progress) = made.progress().get_mut(&id) {
                (progress.process, progress.is_running) = (None, false);
                match ended {
                    _ if progress.cancelled => {}
                    Ok(notes) => {
                        (progress.done, progress.file) = (Some(1.0), Some(progress.name.clone()));
                        notes.into_iter().for_each(&say);
                    }
                    Err(error) => progress.error = Some(messages::of(&error)),
                }
                if progress.file.is_none() {
                    // Files that cannot be removed now are removed when this program ends.
                    let _ = fs::remove_dir_all(made.folder_of(id));
                }
            }
            tell(id);
        });
        Ok(id)
    }

    /// Starts a thread that writes a recording. `write` returns its folder and a sentence about it; it is given a function
    /// that takes the fraction done, and returns false if the recording is cancelled. `tell` as in [`Made::begin`]. Errors:
    /// Too many files are being made already, or one of this name.
    pub(super) fn write(
        self: &Arc<Self>,
        name: String,
        write: impl FnOnce(&dyn Fn(f64) -> bool) -> Result<(PathBuf, String)> + Send + 'static,
        tell: impl Fn(u32) + Send + 'static,
    ) -> Result<u32> {
        let mut all = self.progress();
        let is_running = all.values().any(|one| one.is_running && one.name == name);
        ensure!(!is_running, "{name} is being written already: wait until it is done, or cancel it");
        let id = next_id(&all)?;
        all.insert(id, Progress { done: Some(0.0), ..Progress::begun(id, name) });
        drop(all);
        tell(id);
        let made = Arc::clone(self);
        thread::spawn(move || {
            let step = |done: f64| {
                let mut all = made.progress();
                let Some(progress) = all.get_mut(&id) else { return false };
                let (before, is_cancelled) = (progress.done.replace(done), progress.cancelled);
                drop(all);
                if before.is_none_or(|before| (before * 100.0).floor() < (done * 100.0).floor()) {
                    tell(id);
                }
                !is_cancelled
            };
            let written = write(&step);
            if let Some(progress) = made.progress().get_mut(&id) {
                progress.is_running = false;
                match written {
                    _ if progress.cancelled => {}
                    Ok(folder) => progress.folder = Some(folder),
                    Err(error) => progress.error = Some(messages::of(&error)),
                }
            }
            tell(id);
        });
        Ok(id)
    }

    /// Ends the program or the thread that writes file `id`. Errors: None is writing it.
    pub(super) fn cancel(&self, id: u32) -> Result<()> {
        let mut all = self.progress();
        let running = all.get_mut(&id).filter(|one| one.is_running);
        let progress = running.with_context(|| format!("file {id} is not being made: expected one that is"))?;
        progress.cancelled = true;
        progress.process.iter().for_each(|process| process.end());
        Ok(())
    }

    /// Waits for the program to end, and returns its notes; each line that it prints is progress. Errors: The program's
    /// message, if it fails.
    fn watch(&self, process: &Process, id: u32, lines: usize, tell: &impl Fn(u32)) -> Result<Vec<String>> {
        let said = process.said();
        let printed = process.output().into_iter().flat_map(|out| BufReader::new(out).lines()).map_while(Result::ok);
        for (count, _) in printed.enumerate() {
            // A hundred progress steps are enough for the page.
            if lines > 0 && count.is_multiple_of(lines.div_ceil(100)) {
                #[allow(clippy::cast_precision_loss)] // far below 2^52
                let done = (count as f64 / lines as f64).min(0.99);
                if let Some(progress) = self.progress().get_mut(&id) {
                    progress.done = Some(done);
                }
                tell(id);
            }
        }
        let status = process.wait_while(|_| true)?.context("host-sim does not end")?;
        let said = said.recv().unwrap_or_default();
        // Notes and warnings precede the line that begins with `error: `.
        let complaint = said.lines().find_map(|line| line.strip_prefix("error: ")).or(said.lines().next_back());
        ensure!(status.success(), "{}", complaint.unwrap_or("host-sim gives no reason"));
        // The program knows the file by its place in a temporary folder.
        let place = self.folder_of(id).join("").display().to_string();
        Ok(said.lines().filter_map(|line| Some(line.strip_prefix("note: ")?.replace(&place, ""))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn a_recording_is_ordered_once_at_a_time() {
        let made = Arc::new(Made::new().unwrap());
        let order = |name: &str| {
            let (end, ending) = mpsc::channel::<()>();
            let (say, told) = mpsc::channel();
            let write = move |_: &dyn Fn(f64) -> bool| {
                ending.recv()?;
                Ok((PathBuf::new(), String::new()))
            };
            made.write(name.to_owned(), write, move |id| _ = say.send(id)).map(|id| (id, end, told))
        };
        let (first, end, told) = order("a with truth").unwrap();
        let twice = order("a with truth").unwrap_err().to_string();
        assert!(twice.starts_with("a with truth is being written already: wait"), "{twice}");
        assert!(order("b with truth").is_ok());
        end.send(()).unwrap();
        assert_eq!(told.iter().collect::<Vec<_>>(), [first, first]);
        assert!(order("a with truth").is_ok());
    }
}
