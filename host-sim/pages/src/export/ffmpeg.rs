//! An ffmpeg process that encodes frames from its standard input to a file.

use anyhow::{Context, Result, bail, ensure};
use smr_recordings::cleanup::Process;
use smr_recordings::silent;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};
use std::{fs, thread};

/// Number of bytes in each write to ffmpeg. A completed write is a sign that ffmpeg is alive.
const CHUNK: usize = 1 << 16;

pub(super) struct Ffmpeg {
    process: Process,
    said: Receiver<String>,
    /// Channel that holds one frame. A separate thread takes frames from it and writes them to ffmpeg, which may block.
    frames: SyncSender<Vec<u8>>,
    chunks: Arc<AtomicU64>,
    file: PathBuf,
    patience: Duration,
}

impl Ffmpeg {
    /// Starts ffmpeg with these arguments; it reads standard input and writes `file`.
    pub fn start(arguments: Command, file: &Path, patience: Duration) -> Result<Self> {
        let mut command = arguments;
        command.arg("-y").arg(file).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let process = match Process::start(&mut command) {
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "a video needs ffmpeg, and there is none on the PATH: install the package `ffmpeg`, or write a folder of pictures"
            ),
            other => other.context("cannot start ffmpeg")?,
        };
        let said = process.said();
        let mut pipe = process.input().context("standard input is piped")?;
        let (frames, to_write) = sync_channel::<Vec<u8>>(1);
        let chunks = Arc::new(AtomicU64::new(0));
        let count = Arc::clone(&chunks);
        thread::spawn(move || {
            for frame in to_write {
                for chunk in frame.chunks(CHUNK) {
                    // The error is not reported: if ffmpeg has ended, its own message gives the reason.
                    let Ok(()) = pipe.write_all(chunk) else { return };
                    count.fetch_add(1, Ordering::Relaxed);
                }
            }
        });
        Ok(Self { process, said, frames, chunks, file: file.to_owned(), patience })
    }

    pub fn write(&self, mut frame: Vec<u8>) -> Result<()> {
        let mut is_alive = self.watch();
        loop {
            match self.frames.try_send(frame) {
                Ok(()) => return Ok(()),
                Err(TrySendError::Disconnected(_)) => return self.verdict(),
                Err(TrySendError::Full(waits)) => frame = waits,
            }
            ensure!(is_alive(), silent(self.patience));
            thread::sleep(Duration::from_millis(1));
        }
    }

    pub fn end(mut self) -> Result<()> {
        // Dropping the sender makes the thread write the waiting frame, then close the pipe.
        self.frames = sync_channel(0).0;
        self.verdict()
    }

    /// Waits for the end of ffmpeg. Errors: ffmpeg failed, or shows no sign of life for longer than `patience`.
    fn verdict(&self) -> Result<()> {
        let mut is_alive = self.watch();
        let status = self.process.wait_while(|_| is_alive());
        let status = status.context("cannot wait for ffmpeg")?.ok_or_else(|| silent(self.patience))?;
        let said = self.said.recv_timeout(self.patience).unwrap_or_default();
        let reason = said.trim().lines().next_back().unwrap_or("it gives no reason");
        ensure!(status.success(), "ffmpeg cannot write the video: {reason}");
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
            since.elapsed() <= self.patience
        }
    }
}
