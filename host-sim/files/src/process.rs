//! Child processes, which end with this program.

use crate::cleanup::{Kept, end, keep_process, locked};
use std::ffi::OsStr;
use std::io::{self, Read};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

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
        let (child, _kept) = keep_process(command)?;
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

#[cfg(test)]
mod tests {
    use super::*;

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
