//! Clean-up on a signal: removes unfinished files and folders, and kills child processes, before this program ends.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use std::{fs, thread};

enum Resource {
    Path(PathBuf),
    Process(Arc<Mutex<Child>>),
}

/// All registered files, folders and child processes, by the id in their [`Kept`].
static RESOURCES: Mutex<BTreeMap<u64, Resource>> = Mutex::new(BTreeMap::new());

/// True after a signal that ends this program.
static ENDING: AtomicBool = AtomicBool::new(false);

/// True if the first signal only requests a stop. [`STOPPED`] is then the number of the latest signal, 0 before any.
static STOPS_FIRST: AtomicBool = AtomicBool::new(false);
static STOPPED: AtomicI32 = AtomicI32::new(0);

/// Makes the first signal from here on only request a stop (see [`is_stopped`]); the second one ends this program.
pub fn stop_first() {
    STOPS_FIRST.store(true, Ordering::SeqCst);
}

pub fn is_stopped() -> bool {
    stopped_by().is_some()
}

/// Returns the number of the signal that has requested a stop.
pub fn stopped_by() -> Option<i32> {
    Some(STOPPED.load(Ordering::SeqCst)).filter(|&signal| signal > 0)
}

/// After `stop_first`, records `signal`. Returns true if it is the first signal since, which only requests a stop.
fn asks_to_stop(signal: i32) -> bool {
    STOPS_FIRST.load(Ordering::SeqCst) && STOPPED.swap(signal, Ordering::SeqCst) == 0
}

/// Locks a mutex even if a thread panicked while holding it, because registered files must still be removed.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Registration of a file, folder or child process for clean-up on a signal. A drop unregisters the resource.
pub struct Kept(u64);

impl Drop for Kept {
    fn drop(&mut self) {
        locked(&RESOURCES).remove(&self.0);
    }
}

/// Creates a file, folder or process and registers it; no signal is handled in between.
fn keep<T>(make: impl FnOnce() -> io::Result<T>, resource: impl FnOnce(&T) -> Resource) -> io::Result<(T, Kept)> {
    let mut resources = locked(&RESOURCES);
    let made = make()?;
    let number = resources.last_key_value().map_or(0, |(last, _)| last + 1);
    resources.insert(number, resource(&made));
    Ok((made, Kept(number)))
}

pub fn keep_path<T: AsRef<Path>>(make: impl FnOnce() -> io::Result<T>) -> io::Result<(T, Kept)> {
    keep(make, |made| Resource::Path(made.as_ref().to_owned()))
}

/// Runs `act` without interruption: a signal that arrives meanwhile ends this program afterwards.
pub fn undisturbed<T>(act: impl FnOnce() -> T) -> T {
    let _resources = locked(&RESOURCES);
    act()
}

/// A child process; dropping it kills and reaps it.
pub struct Process {
    child: Arc<Mutex<Child>>,
    _kept: Kept,
}

impl Process {
    pub fn start(command: &mut Command) -> io::Result<Self> {
        // In its own process group, the child gets no Ctrl-C. This program gets the signal and ends the child itself.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        for (name, _) in std::env::vars_os().filter(|(name, _)| changes_ffmpeg(name)) {
            command.env_remove(name);
        }
        let start = || Ok(Arc::new(Mutex::new(command.spawn()?)));
        let (child, _kept) = keep(start, |child| Resource::Process(Arc::clone(child)))?;
        Ok(Self { child, _kept })
    }

    pub fn input(&self) -> Option<ChildStdin> {
        locked(&self.child).stdin.take()
    }

    pub fn output(&self) -> Option<ChildStdout> {
        locked(&self.child).stdout.take()
    }

    pub fn complaints(&self) -> Option<ChildStderr> {
        locked(&self.child).stderr.take()
    }

    /// Returns a receiver, which gets all text of the child's standard error once that stream is closed. A process
    /// started by the child may keep the stream open.
    pub fn said(&self) -> Receiver<String> {
        let (sender, said) = channel();
        if let Some(mut complaints) = self.complaints() {
            thread::spawn(move || {
                let mut bytes = Vec::new();
                // Reads to the end, because a full pipe would block the writer. After an error, sends the text so far.
                let _ = complaints.read_to_end(&mut bytes);
                sender.send(String::from_utf8_lossy(&bytes).into_owned())
            });
        }
        said
    }

    pub fn end(&self) {
        end(&self.child);
    }

    /// Returns the exit status; `None` while the process runs. If this program ignores SIGCHLD, the system forgets the
    /// status: the process then counts as ended with success, so a caller needs another proof of what it has done.
    pub fn ended(&self) -> io::Result<Option<ExitStatus>> {
        match locked(&self.child).try_wait() {
            Err(error) if is_forgotten(&error) => Ok(Some(ExitStatus::default())),
            ended => ended,
        }
    }

    /// Waits until the process ends. Returns `None` when `more`, called with the time waited so far, returns false.
    pub fn wait_while(&self, mut more: impl FnMut(Duration) -> bool) -> io::Result<Option<ExitStatus>> {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.ended()? {
                return Ok(Some(status));
            }
            if !more(begin.elapsed()) {
                return Ok(None);
            }
            thread::sleep(Duration::from_millis(1));
        }
    }
}

/// True for an environment variable by which ffmpeg changes its messages or writes a report.
fn changes_ffmpeg(name: &OsStr) -> bool {
    // Windows does not tell capitals.
    let name = name.to_string_lossy().to_ascii_uppercase();
    name.starts_with("AV_LOG_") || name == "FFREPORT"
}

/// True for ECHILD, number 10 on Linux, macOS and the BSDs: there is no such child, or none any more.
fn is_forgotten(error: &io::Error) -> bool {
    cfg!(unix) && error.raw_os_error() == Some(10)
}

impl Drop for Process {
    fn drop(&mut self) {
        self.end();
    }
}

fn end(child: &Mutex<Child>) {
    let mut child = locked(child);
    // `kill` and `wait` fail only if the process has ended and been reaped.
    let _ = child.kill();
    let _ = child.wait();
}

/// Handles SIGINT, SIGTERM and SIGHUP (unless ignored, as by `nohup`): cleans up, then exits with 128 + signal.
#[cfg(unix)]
pub fn heed_signals() -> io::Result<()> {
    use signal_hook::consts::{SIGCHLD, SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    // A write above a limit of the size of files is then an error, and not the end of this program.
    signal_hook::flag::register(SIGXFSZ, Arc::default())?;
    // A parent may have set SIGCHLD to be ignored; the system would then forget the exit status of every child.
    signal_hook::flag::register(SIGCHLD, Arc::default())?;
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| signal != SIGHUP || !is_ignored(signal));
    let mut signals = signal_hook::iterator::Signals::new(wanted)?;
    thread::spawn(move || {
        if let Some(signal) = signals.forever().find(|&signal| !asks_to_stop(signal)) {
            end_by(signal);
        }
    });
    Ok(())
}

/// Handles Ctrl-C and similar events, the only signals outside Unix: cleans up, then exits with 130.
#[cfg(not(unix))]
pub fn heed_signals() -> io::Result<()> {
    let heed = || {
        if !asks_to_stop(2) {
            end_by(2);
        }
    };
    ctrlc::set_handler(heed).map_err(io::Error::other)
}

/// True if this process ignores the signal. Always false outside Linux, where only unsafe code could find out.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    ignored >> (signal - 1) & 1 == 1
}

fn end_by(signal: i32) -> ! {
    ENDING.store(true, Ordering::SeqCst);
    // Holds the lock until this process exits, so that nothing new is registered.
    let resources = locked(&RESOURCES);
    // Kills processes first, because they write into the files.
    for resource in resources.values() {
        if let Resource::Process(child) = resource {
            end(child);
        }
    }
    for resource in resources.values() {
        if let Resource::Path(path) = resource {
            // The path may have been renamed by now, or be gone.
            let _ = remove(path);
        }
    }
    std::process::exit(128 + signal)
}

/// Removes a file or a folder. A folder is renamed first, so that threads that still write do not find it.
fn remove(path: &Path) -> io::Result<()> {
    if path.is_file() {
        return fs::remove_file(path);
    }
    let gone = path.with_extension("gone");
    fs::rename(path, &gone).and_then(|()| fs::remove_dir_all(gone)).or_else(|_| fs::remove_dir_all(path))
}

/// Blocks for good if a signal is ending this program. Call it before printing an error that the signal may have
/// caused.
pub fn yield_to_signal() {
    while ENDING.load(Ordering::SeqCst) {
        thread::park();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Windows renames no folder in which a file is open.
    #[cfg(unix)]
    #[test]
    fn a_folder_goes_while_pictures_are_written_into_it() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join(".smr-pictures");
        fs::create_dir(&folder).unwrap();
        let write = |number: u32| fs::write(folder.join(number.to_string()), "a picture");
        (0..100).try_for_each(write).unwrap();
        thread::scope(|scope| {
            let writer = scope.spawn(|| (100..50_000).try_for_each(write));
            remove(&folder).unwrap();
            assert!(writer.join().unwrap().is_err());
        });
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn a_program_that_is_not_waited_for_is_ended() {
        let process = Process::start(Command::new("sleep").arg("600")).unwrap();
        assert!(process.wait_while(|waited| waited < Duration::from_millis(20)).unwrap().is_none());
        let id = locked(&process.child).id().to_string();
        drop(process);
        // Runs `kill` in a shell, because not every system has it as a program.
        assert!(!crate::missing::runs(Command::new("sh").args(["-c", "kill -0 \"$0\"", &id])));
    }
}
