//! Any video that an `ffmpeg` on the PATH (5.1 or later) decodes, as a recording.
//!
//! ffmpeg converts to full-range gray and hands the frames over as YUV4MPEG2: the pixels are those of
//! `ffmpeg -i FILE -pix_fmt gray -fps_mode passthrough -f rawvideo -`, and the size comes with them.

use super::damage::Damaged;
use super::{GrayFrame, has_extension, y4m};
use crate::cleanup::Process;
use crate::input::chunks;
use anyhow::{Context, Result, bail, ensure};
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// How long ffmpeg may be silent, unless said otherwise.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// What is looked for in a folder. A file that is named is given to ffmpeg whatever its extension.
const EXTENSIONS: [&str; 22] = [
    "mpg", "mpeg", "mp4", "m4v", "mov", "avi", "mkv", "webm", "wmv", "flv", "ts", "mts", "m2ts", "ogv", "3gp", "m1v",
    "m2v", "h264", "h265", "hevc", "ivf", "mjpeg",
];

pub(super) fn is_video(file: &Path) -> bool {
    has_extension(file, &EXTENSIONS)
}

pub(super) fn open(file: &Path, patience: Duration) -> Result<Frames> {
    open_with("ffmpeg", file, patience)
}

fn open_with(program: &str, file: &Path, patience: Duration) -> Result<Frames> {
    let name = file.display().to_string();
    let mut ffmpeg = Ffmpeg::start(program, file, patience)?;
    let mut stream = ffmpeg.output();
    // No byte at all means that ffmpeg has ended, and knows why.
    if stream.fill_buf().with_context(|| format!("cannot read {name} through ffmpeg"))?.is_empty() {
        let (status, said) = ffmpeg.end()?;
        ensure!(!said.last.contains("does not contain any stream"), "{name} holds no pictures: expected a video");
        ensure!(
            said.last.is_empty() && status.success(),
            "ffmpeg cannot decode {name}: {}: expected a whole video, or else pictures, Y4M or a raw dump (--size)",
            said.or(status)
        );
        bail!("{name} holds no frame that ffmpeg decodes");
    }
    Ok(Frames { decoded: Some(y4m::Frames::new(stream, name)?), ffmpeg })
}

/// The frames as ffmpeg decodes them, then its verdict.
pub(super) struct Frames {
    decoded: Option<y4m::Frames<Patient>>,
    ffmpeg: Ffmpeg,
}

impl Iterator for Frames {
    type Item = Result<GrayFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = self.decoded.as_mut()?.next();
        if let Some(Ok(_)) = next {
            return next;
        }
        // First of all the pipe is closed: what still writes into it ends.
        self.decoded = None;
        if let Some(Err(error)) = &next
            && error.chain().any(|cause| cause.downcast_ref::<io::Error>().is_some())
        {
            return next;
        }
        // If it failed, that is the reason for whatever is wrong with the stream.
        self.ffmpeg.verdict().err().map(Err).or(next)
    }
}

/// What ffmpeg writes, as long as it writes.
pub(super) struct Patient {
    chunks: Receiver<io::Result<Vec<u8>>>,
    chunk: Vec<u8>,
    read: usize,
    patience: Duration,
}

impl Patient {
    pub fn new(stream: ChildStdout, patience: Duration) -> Self {
        Self { chunks: chunks(|| Ok(stream)), chunk: Vec::new(), read: 0, patience }
    }
}

impl BufRead for Patient {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.read == self.chunk.len() {
            (self.chunk, self.read) = match self.chunks.recv_timeout(self.patience) {
                Ok(chunk) => (chunk?, 0),
                Err(RecvTimeoutError::Disconnected) => (Vec::new(), 0),
                Err(RecvTimeoutError::Timeout) => return Err(silent(self.patience)),
            };
        }
        Ok(&self.chunk[self.read..])
    }

    fn consume(&mut self, amount: usize) {
        self.read += amount;
    }
}

impl Read for Patient {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.fill_buf()?.read(buffer)?;
        self.consume(length);
        Ok(length)
    }
}

/// What ffmpeg that does nothing is told about.
pub fn silent(patience: Duration) -> io::Error {
    let seconds = patience.as_secs_f64();
    io::Error::new(ErrorKind::TimedOut, format!("ffmpeg has done nothing for {seconds} s (--ffmpeg-timeout)"))
}

pub(super) struct Ffmpeg {
    process: Process,
    said: Receiver<Said>,
    file: String,
    patience: Duration,
}

impl Ffmpeg {
    fn start(program: &str, file: &Path, patience: Duration) -> Result<Self> {
        let mut command = command(program, "level+warning", file, &["-threads", "1"]);
        command.args(["-pix_fmt", "gray", "-fps_mode", "passthrough", "-f", "yuv4mpegpipe", "-strict", "-1", "-"]);
        Self::run(&mut command, &file.display().to_string(), patience)
    }

    /// `file`: what is read, as it is called in errors.
    pub fn run(command: &mut Command, file: &str, patience: Duration) -> Result<Self> {
        let process = match Process::start(command) {
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "{file} needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)"
            ),
            other => other.context("cannot start ffmpeg")?,
        };
        let complaints = process.complaints().expect("standard error is piped");
        let (sender, said) = channel();
        let name = file.to_owned();
        thread::spawn(move || sender.send(Said::read(complaints, &name)));
        Ok(Self { process, said, file: file.to_owned(), patience })
    }

    pub fn output(&mut self) -> Patient {
        Patient::new(self.process.output().expect("standard output is piped"), self.patience)
    }

    fn end(&mut self) -> Result<(ExitStatus, Said)> {
        let status = self.process.wait_while(|waited| waited <= self.patience).context("cannot wait for ffmpeg")?;
        let Some(status) = status else {
            return Err(silent(self.patience)).with_context(|| format!("cannot read {}", self.file));
        };
        Ok((status, self.said.recv_timeout(self.patience).unwrap_or_default()))
    }

    /// What it ended with.
    pub fn last_words(&mut self) -> Result<String> {
        self.end().map(|(status, said)| said.or(status))
    }

    /// The same if it has ended, and not as it should.
    pub fn failure(&mut self) -> Option<String> {
        let is_ended = self.process.ended().is_ok_and(|status| status.is_some_and(|status| !status.success()));
        is_ended.then(|| self.last_words().ok())?
    }

    /// ffmpeg conceals what is damaged or missing, goes on, and ends without an error code: what it has complained about is
    /// damage, because such pixels are not those of the recording.
    fn verdict(&mut self) -> Result<()> {
        let (status, said) = self.end()?;
        let file = &self.file;
        ensure!(
            !said.changed,
            "{file}: the size of its frames or the format of their pixels changes on the way: expected one"
        );
        if said.last.is_empty() && status.success() {
            return Ok(());
        }
        Err(Damaged::new(format!("{file} is damaged, says ffmpeg: {}", said.or(status))).into())
    }
}

/// The file as ffmpeg takes it: without the protocol, a colon in its name is taken for the end of one.
pub fn input(file: &Path) -> OsString {
    let mut input = OsString::from("file:");
    input.push(file);
    input
}

/// An ffmpeg that reads the file, with such options. What it writes and says is piped. Whole recordings are decoded on one thread: with several,
/// what it puts in place of damage is different in every run.
pub(super) fn command(program: &str, level: &str, file: &Path, options: &[&str]) -> Command {
    let mut command = Command::new(program);
    // Frames of another size would be scaled without a word: without a new filter there is at least a warning.
    command.args(["-nostdin", "-nostats", "-v", level, "-reinit_filter", "0"]).args(options).arg("-i").arg(input(file));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[derive(Debug, Default, PartialEq, Eq)]
struct Said {
    /// The last complaint.
    last: String,
    /// Frames of another size came, or with pixels of another format.
    changed: bool,
}

impl Said {
    /// Everything is read, or the writer would block.
    fn read(stream: impl Read, file: &str) -> Self {
        let mut said = Self::default();
        for line in BufReader::new(stream).split(b'\n').map_while(Result::ok) {
            said.add(String::from_utf8_lossy(&line).trim(), file);
        }
        said
    }

    /// A line is `[h264 @ 0x55f520328f40] [error] missing picture`: who (the address is another one in every run), level, words.
    fn add(&mut self, mut line: &str, file: &str) {
        // Some say twice who they are.
        while let Some((speaker, words)) = line.split_once("] ")
            && speaker.starts_with('[')
            && speaker.contains(" @ 0x")
        {
            line = words;
        }
        let (is_warning, words) = match line.strip_prefix("[warning] ") {
            Some(words) => (true, words),
            None => (
                false,
                ["[error] ", "[fatal] ", "[panic] "].iter().find_map(|level| line.strip_prefix(level)).unwrap_or(line),
            ),
        };
        self.changed |= words.contains("Changing video frame properties");
        let of_frame = words.contains("corrupt decoded frame");
        // Of the warnings only these are about damage.
        if !words.is_empty() && (!is_warning || of_frame || words.contains("corrupt input packet")) {
            words.trim_start_matches(&format!("file:{file}: ")).clone_into(&mut self.last);
        }
    }

    /// The last complaint; without one, what the process ended with.
    fn or(&self, status: ExitStatus) -> String {
        if self.last.is_empty() { status.to_string() } else { self.last.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_ffmpeg_is_asked_for() {
        let error = Ffmpeg::start("no-such-ffmpeg", Path::new("a.mp4"), PATIENCE).err().unwrap();
        assert_eq!(
            format!("{error:#}"),
            "a.mp4 needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)"
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn no_zombie_is_left() {
        let Ok(ffmpeg) = Ffmpeg::start("ffmpeg", Path::new("missing.mp4"), PATIENCE) else {
            return crate::missing::skipped("no_zombie_is_left", "no ffmpeg on the PATH");
        };
        let process = format!("/proc/{}", ffmpeg.process.id());
        assert!(Path::new(&process).exists());
        drop(ffmpeg);
        assert!(!Path::new(&process).exists());
    }

    /// A program in place of ffmpeg.
    #[cfg(unix)]
    fn program(folder: &Path, script: &str) -> String {
        use std::os::unix::fs::PermissionsExt;
        let file = folder.join("ffmpeg");
        std::fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
        file.to_str().unwrap().to_owned()
    }

    #[cfg(unix)]
    #[test]
    fn a_hanging_ffmpeg_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let short = Duration::from_millis(300);
        let frame = r"printf 'YUV4MPEG2 W2 H1 F25:1 Cmono\nFRAME\nab'";
        let begin = std::time::Instant::now();
        let silent = "ffmpeg has done nothing for 0.3 s (--ffmpeg-timeout)";

        let never = program(folder.path(), "exec sleep 60");
        let error = format!("{:#}", open_with(&never, Path::new("a.mp4"), short).err().unwrap());
        assert_eq!(error, format!("cannot read a.mp4 through ffmpeg: {silent}"));

        let stops = program(folder.path(), &format!("{frame}; exec sleep 60"));
        let mut frames = open_with(&stops, Path::new("a.mp4"), short).unwrap();
        assert!(frames.next().unwrap().is_ok());
        assert_eq!(format!("{:#}", frames.next().unwrap().unwrap_err()), format!("a.mp4, frame 2: {silent}"));
        assert!(frames.next().is_none());
        drop(frames);

        let stays = program(folder.path(), &format!("{frame}; exec >&-; exec sleep 60"));
        let mut frames = open_with(&stays, Path::new("a.mp4"), short).unwrap();
        assert!(frames.next().unwrap().is_ok());
        assert_eq!(format!("{:#}", frames.next().unwrap().unwrap_err()), format!("cannot read a.mp4: {silent}"));
        drop(frames);
        assert!(begin.elapsed() < Duration::from_secs(30));
    }

    #[test]
    fn of_what_ffmpeg_says_the_last_complaint_is_kept() {
        let said = |text: &str| Said::read(text.as_bytes(), "a.mp4");
        let last = |text: &str| said(text).last;
        assert_eq!(
            last("[NULL @ 0x55f5] [error] Invalid NAL\n[mov,mp4 @ 0x7f] [error] partial file\r\n\n"),
            "partial file"
        );
        assert_eq!(last("[error] file:a.mp4: Invalid [data] found"), "Invalid [data] found");
        assert_eq!(last("[swscaler @ 0x55] [swscaler @ 0x55] [warning] deprecated pixel format used"), "");
        assert_eq!(last(""), "");
        let corrupt = "[warning] a.mp4: corrupt decoded frame in stream 0\n";
        assert_eq!(last(corrupt), "a.mp4: corrupt decoded frame in stream 0");
        let changed = "[graph 0 input @ 0x5] [warning] Changing video frame properties on the fly is not supported";
        assert_eq!(said(changed), Said { changed: true, ..Said::default() });
    }
}
