//! A video, written by an ffmpeg that takes frames with their times, and the sound of the recording.

use super::frame_times::Timeline;
use super::matroska;
use super::overlay::Overlay;
use anyhow::{Context, Result, bail, ensure};
use smr_recordings::cleanup::Process;
use smr_recordings::output::Output;
use smr_recordings::{Moment, ffmpeg_input, silent};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant, SystemTime};
use std::{fs, thread};

#[derive(Clone, Copy)]
pub(super) enum Kind {
    Mp4,
    Mov,
    Mkv,
    Webm,
}

impl Kind {
    pub fn of(extension: &str) -> Option<Self> {
        let kinds = [Self::Mp4, Self::Mov, Self::Mkv, Self::Webm];
        super::video::ENDINGS.iter().zip(kinds).find(|(ending, _)| **ending == extension).map(|(_, kind)| kind)
    }

    /// The codecs and the container. What is not said is ffmpeg's usual codec of the container.
    const fn options(self) -> &'static [&'static str] {
        match self {
            // Players want the index at the beginning of the file.
            Self::Mp4 => &["-c:a", "aac", "-movflags", "+faststart", "-f", "mp4"],
            Self::Mov => &["-c:a", "aac", "-movflags", "+faststart", "-f", "mov"],
            Self::Mkv => &["-c:a", "aac", "-f", "matroska"],
            // As quick as that of the others.
            Self::Webm => {
                &["-deadline", "realtime", "-cpu-used", "6", "-row-mt", "1", "-crf", "32", "-b:v", "0", "-f", "webm"]
            }
        }
    }
}

pub(super) struct Encoded {
    kind: Kind,
    /// First: ffmpeg ends before its file is removed.
    ffmpeg: Option<Ffmpeg>,
    output: Output,
    /// The recording, if it may have sound.
    sound: Option<PathBuf>,
    patience: Duration,
}

impl Encoded {
    pub fn new(kind: Kind, output: Output, sound: Option<PathBuf>, patience: Duration) -> Self {
        Self { kind, ffmpeg: None, output, sound, patience }
    }

    pub fn frame(&mut self, overlay: &Overlay, timeline: &Timeline, time: u64, moment: Option<Moment>) -> Result<()> {
        let mut bytes = matroska::frame(time, overlay.rgb());
        if self.ffmpeg.is_none() {
            bytes = [matroska::head(overlay.size()), bytes].concat();
            let file = file_of(&self.output)?;
            let sound = self.sound.as_deref().zip(timeline.start());
            let aspect = moment.map_or((1, 1), |moment| moment.aspect);
            self.ffmpeg = Some(Ffmpeg::start((self.kind, file), timeline.base(), aspect, sound, self.patience)?);
        }
        self.ffmpeg.as_mut().map_or(Ok(()), |ffmpeg| ffmpeg.write(bytes))
    }

    /// Ends it. The output has all bytes then, but not its name.
    pub fn finish(self) -> Result<Output> {
        self.ffmpeg.map_or(Ok(()), Ffmpeg::end)?;
        Ok(self.output)
    }
}

fn file_of(output: &Output) -> Result<&Path> {
    output.path().context("a video cannot be written to a device or a pipe: expected a file")
}

/// How many frames wait for ffmpeg.
const WAITING: usize = 2;

/// So many bytes are written at a time: each is a sign of life.
const CHUNK: usize = 1 << 16;

/// An ffmpeg that writes a video.
struct Ffmpeg {
    process: Process,
    said: Receiver<String>,
    /// To the thread that writes into ffmpeg, which may block.
    frames: Sender<Vec<u8>>,
    /// From it, one for each frame.
    taken: Receiver<()>,
    waiting: usize,
    chunks: Arc<AtomicU64>,
    file: PathBuf,
    patience: Duration,
}

impl Ffmpeg {
    /// `base`: what times are multiples of. `sound`: a file, and the seconds in it at which the first frame is shown.
    fn start(
        (kind, file): (Kind, &Path),
        base: (u32, u32),
        aspect: (u32, u32),
        sound: Option<(&Path, f64)>,
        patience: Duration,
    ) -> Result<Self> {
        let mut command = Command::new("ffmpeg");
        command.args(["-v", "error", "-f", "matroska", "-i", "-"]);
        if let Some((recording, start)) = sound {
            command.args(["-ss", &format!("{start:.6}"), "-i"]).arg(ffmpeg_input(recording));
            // Silence behind the sound, so that -shortest cuts the sound and never the picture.
            command.args(["-map", "0:v", "-map", "1:a:0?", "-af", "apad", "-shortest"]);
        }
        command.args(["-fps_mode", "passthrough"]);
        // Players want color at half the size, and BT.709.
        let even = "pad=ceil(iw/2)*2:ceil(ih/2)*2";
        let filter = format!("{even},setsar={}/{},scale=out_color_matrix=bt709", aspect.0, aspect.1);
        command.args(["-vf", &filter, "-pix_fmt", "yuv420p"]);
        command.args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"]);
        command.args(["-enc_time_base", &format!("{}:{}", base.0, base.1)]);
        command.args(kind.options());
        command.arg("-y").arg(file);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let process = match Process::start(&mut command) {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                bail!(
                    "a video needs ffmpeg, and there is none on the PATH: install the package `ffmpeg`, or write a folder of pictures"
                )
            }
            other => other.context("cannot start ffmpeg")?,
        };
        let said = process.said();
        let mut pipe = process.input().context("standard input is piped")?;
        let ((frames, to_write), (written, taken)) = (channel::<Vec<u8>>(), channel());
        let chunks = Arc::new(AtomicU64::new(0));
        let count = Arc::clone(&chunks);
        thread::spawn(move || {
            for frame in to_write {
                for chunk in frame.chunks(CHUNK) {
                    // It has ended, and knows why.
                    let Ok(()) = pipe.write_all(chunk) else { return };
                    count.fetch_add(1, Ordering::Relaxed);
                }
                let Ok(()) = written.send(()) else { return };
            }
        });
        Ok(Self { process, said, frames, taken, waiting: 0, chunks, file: file.to_owned(), patience })
    }

    fn write(&mut self, bytes: Vec<u8>) -> Result<()> {
        while self.waiting >= WAITING {
            let before = self.chunks.load(Ordering::Relaxed);
            match self.taken.recv_timeout(self.patience) {
                Ok(()) => self.waiting -= 1,
                Err(RecvTimeoutError::Disconnected) => return self.verdict(),
                Err(RecvTimeoutError::Timeout) => {
                    ensure!(before != self.chunks.load(Ordering::Relaxed), silent(self.patience));
                }
            }
        }
        self.waiting += 1;
        // If nobody takes it, the next one waits in vain, and learns why.
        let _ = self.frames.send(bytes);
        Ok(())
    }

    fn end(mut self) -> Result<()> {
        // The thread writes what waits, then closes the pipe.
        self.frames = channel().0;
        self.verdict()
    }

    fn verdict(&self) -> Result<()> {
        let (mut last, mut since) = (self.signs_of_life(), Instant::now());
        let status = self.process.wait_while(|_| {
            let now = self.signs_of_life();
            if now != last {
                (last, since) = (now, Instant::now());
            }
            since.elapsed() <= self.patience
        });
        let status = status.context("cannot wait for ffmpeg")?.ok_or_else(|| silent(self.patience))?;
        let said = self.said.recv_timeout(self.patience).unwrap_or_default();
        let last = said.trim().lines().next_back().unwrap_or("");
        ensure!(
            status.success(),
            "ffmpeg cannot write the video: {}",
            if last.is_empty() { "it gives no reason" } else { last }
        );
        Ok(())
    }

    /// What changes as long as it reads frames or writes its file.
    fn signs_of_life(&self) -> (u64, Option<(u64, SystemTime)>) {
        let file = fs::metadata(&self.file).ok().and_then(|data| Some((data.len(), data.modified().ok()?)));
        (self.chunks.load(Ordering::Relaxed), file)
    }
}
