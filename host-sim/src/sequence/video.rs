//! Any video that an `ffmpeg` on the PATH (5.1 or later) decodes, as a recording.
//!
//! ffmpeg converts to full-range gray and hands the frames over as YUV4MPEG2: the pixels are those of
//! `ffmpeg -i FILE -pix_fmt gray -fps_mode passthrough -f rawvideo -`, and the size comes with them.

use super::{GrayFrame, has_extension, y4m};
use anyhow::{Context, Result, bail, ensure};
use std::ffi::OsString;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::{self, JoinHandle};

/// What is looked for in a folder. A file that is named is given to ffmpeg whatever its extension.
const EXTENSIONS: [&str; 22] = [
    "mpg", "mpeg", "mp4", "m4v", "mov", "avi", "mkv", "webm", "wmv", "flv", "ts", "mts", "m2ts", "ogv", "3gp", "m1v",
    "m2v", "h264", "h265", "hevc", "ivf", "mjpeg",
];

pub(super) fn is_video(file: &Path) -> bool {
    has_extension(file, &EXTENSIONS)
}

pub(super) fn open(file: &Path) -> Result<Frames> {
    let name = file.display().to_string();
    let mut ffmpeg = Ffmpeg::start("ffmpeg", file)?;
    let mut stream = ffmpeg.output();
    // No byte at all means that ffmpeg has ended, and knows why.
    if stream.fill_buf().with_context(|| format!("cannot read {name} through ffmpeg"))?.is_empty() {
        ffmpeg.end()?;
        bail!("{name} holds no frame that ffmpeg decodes");
    }
    Ok(Frames { decoded: Some(y4m::Frames::new(stream, name)?), ffmpeg })
}

/// The frames as ffmpeg decodes them, then its verdict.
pub(super) struct Frames {
    // Before the process: the pipe is closed before the process is waited for.
    decoded: Option<y4m::Frames<BufReader<ChildStdout>>>,
    ffmpeg: Ffmpeg,
}

impl Iterator for Frames {
    type Item = Result<GrayFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = self.decoded.as_mut()?.next();
        if let Some(Ok(_)) = next {
            return next;
        }
        self.decoded = None;
        // If it failed, that is the reason for whatever is wrong with the stream.
        self.ffmpeg.end().err().map(Err).or(next)
    }
}

/// A running ffmpeg. Dropped, it is ended and reaped.
struct Ffmpeg {
    process: Child,
    last_words: Option<JoinHandle<String>>,
    file: String,
}

impl Ffmpeg {
    fn start(program: &str, file: &Path) -> Result<Self> {
        let mut process = match command(program, file).spawn() {
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "{} needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)",
                file.display()
            ),
            other => other.context("cannot start ffmpeg")?,
        };
        let complaints = process.stderr.take().expect("standard error is piped");
        let last_words = Some(thread::spawn(move || last_line(complaints)));
        Ok(Self { process, last_words, file: file.display().to_string() })
    }

    fn output(&mut self) -> BufReader<ChildStdout> {
        BufReader::with_capacity(1 << 16, self.process.stdout.take().expect("standard output is piped"))
    }

    /// Waits for the end. ffmpeg conceals what is damaged or missing, goes on, and ends without an error code: what it
    /// has complained about is an error here, because such pixels are not those of the recording.
    fn end(&mut self) -> Result<()> {
        let status = self.process.wait().context("cannot wait for ffmpeg")?;
        let words = self.last_words.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        let words = words.trim_start_matches(&format!("file:{}: ", self.file));
        let reason = if words.is_empty() { status.to_string() } else { words.to_owned() };
        ensure!(status.success(), "ffmpeg cannot decode {}: {reason}", self.file);
        ensure!(words.is_empty(), "{} is damaged, says ffmpeg: {reason}", self.file);
        Ok(())
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // Both fail only if the process has ended and been reaped.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn command(program: &str, file: &Path) -> Command {
    // Without the protocol, a colon in the name is taken for the end of one.
    let mut input = OsString::from("file:");
    input.push(file);
    let mut command = Command::new(program);
    command.args(["-nostdin", "-v", "error", "-i"]).arg(input);
    command.args(["-pix_fmt", "gray", "-fps_mode", "passthrough", "-f", "yuv4mpegpipe", "-strict", "-1", "-"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The last line that is not blank. Everything is read, or the writer would block.
fn last_line(stream: impl Read) -> String {
    let mut last = String::new();
    for line in BufReader::new(stream).split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line);
        if !line.trim().is_empty() {
            last = without_address(line.trim()).to_owned();
        }
    }
    last
}

/// `[h264 @ 0x55f520328f40] missing picture`: the address is another one in every run.
fn without_address(line: &str) -> &str {
    match line.split_once("] ") {
        Some((speaker, words)) if speaker.starts_with('[') && speaker.contains(" @ 0x") => words,
        _ => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_ffmpeg_is_asked_for() {
        let error = Ffmpeg::start("no-such-ffmpeg", Path::new("a.mp4")).err().unwrap();
        assert_eq!(
            format!("{error:#}"),
            "a.mp4 needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)"
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn no_zombie_is_left() {
        let Ok(ffmpeg) = Ffmpeg::start("ffmpeg", Path::new("missing.mp4")) else {
            println!("skipped: no_zombie_is_left: no ffmpeg on the PATH");
            return;
        };
        let process = format!("/proc/{}", ffmpeg.process.id());
        assert!(Path::new(&process).exists());
        drop(ffmpeg);
        assert!(!Path::new(&process).exists());
    }

    #[test]
    fn of_what_ffmpeg_says_the_last_line_is_kept() {
        let said = b"[NULL @ 0x55f5] Invalid NAL unit size\n[mov,mp4 @ 0x7f] partial file\r\n\n".as_slice();
        assert_eq!(last_line(said), "partial file");
        assert_eq!(last_line(b"a.mp4: Invalid [data] found".as_slice()), "a.mp4: Invalid [data] found");
        assert_eq!(last_line(b"".as_slice()), "");
    }
}
