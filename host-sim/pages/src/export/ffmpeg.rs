//! Runs ffmpeg to write videos. Exit statuses and counts of packets decide; its words are only quoted in messages.

use anyhow::{Context, Result, bail, ensure};
use smr_files::process::Process;
use smr_recordings::silent;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};
use std::{fs, thread};

/// Number of bytes in each write to ffmpeg. A completed write is a sign that ffmpeg is alive.
const CHUNK: usize = 1 << 16;

/// Returns the command of an ffmpeg that stops at the first error and reads nothing from the terminal.
pub(super) fn command() -> Command {
    let mut command = Command::new("ffmpeg");
    command.args(["-nostdin", "-nostats", "-hide_banner", "-v", "error", "-xerror"]);
    command
}

/// A running ffmpeg; dropping it kills the process.
pub(super) struct Running {
    pub process: Process,
    said: Receiver<String>,
    pub patience: Duration,
}

impl Running {
    pub fn start(command: &mut Command, patience: Duration) -> Result<Self> {
        let process = match Process::start(command.stderr(Stdio::piped())) {
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "a video needs ffmpeg, and there is none on the PATH: install the package `ffmpeg`, or write a folder of pictures"
            ),
            other => other.context("cannot start ffmpeg")?,
        };
        Ok(Self { said: process.said(), process, patience })
    }

    /// Waits for the end of ffmpeg, and returns its exit status and a message to quote.
    pub fn end(&self, mut is_alive: impl FnMut() -> bool) -> Result<(ExitStatus, String)> {
        let status = self.process.wait_while(|_| is_alive()).context("cannot wait for ffmpeg")?;
        let status = status.ok_or_else(|| silent(self.patience))?;
        let said = self.said.recv_timeout(self.patience).unwrap_or_default();
        Ok((status, quoted(&said)))
    }
}

/// Returns the line of `said` to quote: the first one of a part of ffmpeg, without the names of the part, such as
/// `[mp4 @ 0x55f520328f40] `; without any, the last line.
fn quoted(said: &str) -> String {
    let words = |mut line: &str| {
        let mut is_of_part = false;
        while let Some((_, rest)) =
            line.split_once("] ").filter(|(part, _)| part.starts_with('[') && part.contains(" @ 0x"))
        {
            (line, is_of_part) = (rest, true);
        }
        (line.to_owned(), is_of_part)
    };
    let lines: Vec<_> = said.lines().map(str::trim).filter(|line| !line.is_empty()).map(words).collect();
    let line = lines.iter().find(|(_, is_of_part)| *is_of_part).or(lines.last());
    line.map_or("it gives no reason".to_owned(), |(words, _)| words.clone())
}

/// An ffmpeg that writes a file.
pub(super) struct Writing {
    running: Running,
    chunks: Arc<AtomicU64>,
    file: PathBuf,
}

impl Writing {
    /// Starts ffmpeg with these arguments, among which is `file`.
    pub fn start(mut command: Command, file: &Path, patience: Duration) -> Result<Self> {
        command.stdout(Stdio::null());
        let running = Running::start(&mut command, patience)?;
        Ok(Self { running, chunks: Arc::default(), file: file.to_owned() })
    }

    /// Waits for the end of ffmpeg. Errors: ffmpeg failed, or shows no sign of life for longer than the patience.
    pub fn end(&self) -> Result<()> {
        let (status, said) = self.running.end(self.watch())?;
        // The temporary name of the file means nothing to the user.
        let said = said.replace(&*self.file.to_string_lossy(), "the file");
        ensure!(status.success(), "ffmpeg cannot write the video: {said}");
        Ok(())
    }

    /// Returns a check that fails once ffmpeg has neither read frames nor written its file for longer than `patience`.
    fn watch(&self) -> impl FnMut() -> bool {
        let signs = || {
            let file = fs::metadata(&self.file).ok().and_then(|data| Some((data.len(), data.modified().ok()?)));
            (self.chunks.load(Ordering::Relaxed), file)
        };
        let (mut last, mut since) = (signs(), Instant::now());
        move || {
            let now = signs();
            if now != last {
                (last, since) = (now, Instant::now());
            }
            since.elapsed() <= self.running.patience
        }
    }
}

/// An ffmpeg that encodes frames from its standard input.
pub(super) struct Encoder {
    writing: Writing,
    /// Channel that holds one frame. A separate thread takes frames from it and writes them to ffmpeg, which may block.
    frames: SyncSender<Vec<u8>>,
}

impl Encoder {
    /// Starts ffmpeg with these arguments; it reads standard input and writes `file`.
    pub fn start(mut command: Command, file: &Path, patience: Duration) -> Result<Self> {
        command.arg("-y").arg(file).stdin(Stdio::piped());
        let writing = Writing::start(command, file, patience)?;
        let mut pipe = writing.running.process.input().context("standard input is piped")?;
        let (frames, to_write) = sync_channel::<Vec<u8>>(1);
        let count = Arc::clone(&writing.chunks);
        thread::spawn(move || {
            for frame in to_write {
                for chunk in frame.chunks(CHUNK) {
                    // The error is not reported: if ffmpeg has ended, its own message gives the reason.
                    let Ok(()) = pipe.write_all(chunk) else { return };
                    count.fetch_add(1, Ordering::Relaxed);
                }
            }
        });
        Ok(Self { writing, frames })
    }

    pub fn write(&self, mut frame: Vec<u8>) -> Result<()> {
        let mut is_alive = self.writing.watch();
        loop {
            match self.frames.try_send(frame) {
                Ok(()) => return Ok(()),
                Err(TrySendError::Disconnected(_)) => {
                    self.writing.end()?;
                    bail!("ffmpeg has ended before the last frame");
                }
                Err(TrySendError::Full(waits)) => frame = waits,
            }
            ensure!(is_alive(), silent(self.writing.running.patience));
            thread::sleep(Duration::from_millis(1));
        }
    }

    pub fn end(self) -> Result<()> {
        let Self { writing, frames } = self;
        // Dropping the sender makes the thread write the waiting frame, then close the pipe.
        drop(frames);
        writing.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_quoted_without_its_speaker() {
        for (said, expected) in [
            (
                "a loader warns\n[aac @ 0x55f5] [dec:aac @ 0x7] No space left on device\nEnd\n",
                "No space left on device",
            ),
            ("a loader warns\n\nEnd\n\n", "End"),
            ("a.mp4: [1] is odd", "a.mp4: [1] is odd"),
            (" \n", "it gives no reason"),
        ] {
            assert_eq!(quoted(said), expected);
        }
    }
}
