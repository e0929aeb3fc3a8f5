//! Runs an `ffmpeg` (5.1 or later) from the PATH: its process, its output, and its messages on standard error.
//!
//! All readers of videos start it by [`command`], so that they read the same stream, the one with the most pixels.

pub(super) mod index;
pub(super) mod live;
pub(super) mod pictures;
mod tones;

use crate::cleanup::Process;
use crate::damage::damaged;
use crate::input::Patient;
use anyhow::{Context, Result, bail, ensure};
use std::ffi::{OsStr, OsString};
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;
use tones::Transfer;

/// Default time without output after which ffmpeg counts as hanging.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Presentation time of a frame, and the aspect ratio of its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// Time in units of `base`.
    pub time: i64,
    /// Unit of `time` in seconds, as a fraction.
    pub base: (u32, u32),
    /// Width and height of a pixel, as a ratio.
    pub aspect: (u32, u32),
}

impl Moment {
    pub fn seconds(&self) -> f64 {
        self.time as f64 * f64::from(self.base.0) / f64::from(self.base.1)
    }
}

/// Returns the path with the prefix `file:`, without which ffmpeg takes a colon in the name for the end of a protocol.
pub fn input(file: &Path) -> OsString {
    let mut input = OsString::from("file:");
    input.push(file);
    input
}

/// Builds the command of an ffmpeg that reads one video stream; its output and messages are piped.
pub(super) fn command(program: &str, level: &str, input: &OsStr, options: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(["-nostdin", "-nostats", "-hide_banner", "-v", level]).args(options).arg("-i").arg(input);
    command.args(["-an", "-sn", "-dn"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

pub fn silent(patience: Duration) -> io::Error {
    let seconds = patience.as_secs_f64();
    io::Error::new(ErrorKind::TimedOut, format!("ffmpeg has done nothing for {seconds} s (--ffmpeg-timeout)"))
}

/// A running ffmpeg; dropping it kills the process.
pub(super) struct Ffmpeg {
    process: Process,
    shown: Receiver<Shown>,
    messages: Receiver<Messages>,
    file: String,
    patience: Duration,
}

impl Ffmpeg {
    /// Starts ffmpeg. Errors call its input `file`.
    pub fn run(command: &mut Command, file: &str, patience: Duration) -> Result<Self> {
        let process = match Process::start(command) {
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "{file} needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)"
            ),
            other => other.context("cannot start ffmpeg")?,
        };
        let complaints = process.complaints().expect("standard error is piped");
        let ((sender, messages), (pictures, shown)) = (channel(), channel());
        let name = file.to_owned();
        thread::spawn(move || {
            // Reads all messages, even if no receiver of pictures is left, because ffmpeg blocks on a full pipe.
            let said = Messages::read(complaints, &name, |one| drop(pictures.send(one)));
            let _ = sender.send(said);
        });
        Ok(Self { process, shown, messages, file: file.to_owned(), patience })
    }

    /// Returns standard output, whose reads fail after the time `patience` without data.
    pub fn output(&mut self) -> Patient {
        let stream = self.process.output().expect("standard output is piped");
        Patient::new(|| Ok(stream), self.patience, silent)
    }

    /// Waits for the size and time of the next picture, which come before its pixels; `None` at the end.
    pub fn shown(&self) -> Result<Option<Shown>> {
        match self.shown.recv_timeout(self.patience) {
            Err(RecvTimeoutError::Timeout) => Err(silent(self.patience).into()),
            shown => Ok(shown.ok()),
        }
    }

    fn end(&mut self) -> Result<(ExitStatus, Messages)> {
        let status = self.process.wait_while(|waited| waited <= self.patience).context("cannot wait for ffmpeg")?;
        let Some(status) = status else {
            return Err(silent(self.patience)).with_context(|| format!("cannot read {}", self.file));
        };
        Ok((status, self.messages.recv_timeout(self.patience).unwrap_or_default()))
    }

    /// Waits for ffmpeg to end, and returns its last error message, or else its exit status.
    pub fn last_words(&mut self) -> Result<String> {
        self.end().map(|(status, said)| said.error_or(status))
    }

    /// Returns ffmpeg's last error message or exit status, if it has ended with an error.
    pub fn failure(&mut self) -> Option<String> {
        let is_ended = self.process.ended().is_ok_and(|status| status.is_some_and(|status| !status.success()));
        is_ended.then(|| self.last_words().ok())?
    }

    pub fn no_frame(&mut self) -> Result<()> {
        let ((status, said), name) = (self.end()?, &self.file);
        ensure!(!said.last.contains("does not contain any stream"), "{name} holds no pictures: expected a video");
        let (words, is_silent) = (said.error_or(status), said.last.is_empty() && status.success());
        let expected = "expected a whole video, or else pictures, Y4M or a raw dump (--size)";
        ensure!(is_silent, "ffmpeg cannot decode {name}: {words}: {expected}");
        bail!("{name} holds no frame that ffmpeg decodes");
    }

    /// Returns an error if ffmpeg has failed, or has reported an error or a change of format: ffmpeg fills damaged
    /// areas and exits with success. A warning of a damaged packet counts only if frames are missing (`has_gap`),
    /// because joined videos also cause it.
    pub fn verdict(&mut self, has_gap: bool) -> Result<()> {
        let (status, mut said) = self.end()?;
        if has_gap && said.last.is_empty() {
            said.last = std::mem::take(&mut said.packet);
        }
        let (file, changed) = (&self.file, "the frame size or the pixel format changes during the video");
        ensure!(!said.changed, "{file}: {changed}: expected the same in all frames");
        if said.last.is_empty() && status.success() {
            return Ok(());
        }
        Err(damaged(format!("{file} is damaged, says ffmpeg: {}", said.error_or(status))))
    }
}

/// Facts about a picture: size and time from ffmpeg's filter `showinfo`, the rest from ffmpeg's earlier messages.
#[derive(Debug, PartialEq)]
pub(super) struct Shown {
    pub size: (u32, u32),
    pub moment: Option<Moment>,
    /// True if ffmpeg has reported an error, a damaged packet or a change of format before this picture.
    pub is_doubtful: bool,
    /// HDR transfer function of the chosen stream; `None` without HDR.
    pub transfer: Option<Transfer>,
}

#[derive(Debug, Default, PartialEq, Eq)]
struct Messages {
    last: String,
    /// Text of the last warning about a damaged packet.
    packet: String,
    /// True if the size or pixel format changes between frames.
    changed: bool,
    /// True after the first `[info]` message. A line without a level is an error before then, and later ignored,
    /// because it then continues a message.
    has_begun: bool,
    base: Option<(u32, u32)>,
    /// Names of HDR streams, such as `#0:1`, with their transfer functions.
    transfers: Vec<(String, Transfer)>,
    transfer: Option<Transfer>,
}

impl Messages {
    /// Reads all messages of ffmpeg; `show` is called for each picture.
    fn read(stream: impl Read, file: &str, mut show: impl FnMut(Shown)) -> Self {
        let mut said = Self::default();
        for line in BufReader::new(stream).split(b'\n').map_while(Result::ok) {
            if let Some(shown) = said.add(String::from_utf8_lossy(&line).trim(), file) {
                show(shown);
            }
        }
        said
    }

    /// Parses a line such as `[h264 @ 0x55f520328f40] [error] missing picture`: speaker, level, words.
    fn add(&mut self, mut line: &str, file: &str) -> Option<Shown> {
        // Some parts of ffmpeg print their name twice.
        while let Some((speaker, words)) = line.split_once("] ")
            && speaker.starts_with('[')
            && speaker.contains(" @ 0x")
        {
            if let Some(words) = words.strip_prefix("[info] ")
                && speaker.starts_with("[Parsed_showinfo")
            {
                return self.picture(words);
            }
            line = words;
        }
        if let Some(words) = line.strip_prefix("[info] ") {
            self.has_begun = true;
            self.stream(words.trim_start());
            return None;
        }
        let (is_warning, words) = match line.strip_prefix("[warning] ") {
            Some(words) => (true, words),
            None => match ["[error] ", "[fatal] ", "[panic] "].iter().find_map(|level| line.strip_prefix(level)) {
                Some(words) => (false, words),
                None if self.has_begun => return None,
                None => (false, line),
            },
        };
        self.changed |= words.contains("Changing video frame properties");
        let of_frame = words.contains("corrupt decoded frame");
        let words = words.trim_start_matches(&format!("file:{file}: "));
        // Only two warnings report damage: that of a corrupt packet, and that of a corrupt decoded frame.
        if words.contains("corrupt input packet") {
            words.clone_into(&mut self.packet);
        } else if !words.is_empty() && (!is_warning || of_frame) {
            words.clone_into(&mut self.last);
        }
        None
    }

    /// Parses a line of `showinfo`: ` n:   1 pts:    512 pos: 5000 fmt:yuv420p sar:1/1 s:640x480 i:P iskey:0 ...`
    fn picture(&mut self, line: &str) -> Option<Shown> {
        self.base = line.split_once("time_base: ").and_then(|(_, base)| fraction(base)).or(self.base);
        let field = |name: &str| line.split_once(name)?.1.split_whitespace().next();
        let (width, height) = field(" s:")?.split_once('x')?;
        let time = field(" pts:").and_then(|time| time.parse().ok());
        let aspect = field(" sar:").and_then(fraction).unwrap_or((1, 1));
        let moment = time.zip(self.base).map(|(time, base)| Moment { time, base, aspect });
        let size = (width.parse().ok()?, height.parse().ok()?);
        let is_doubtful = self.changed || !self.packet.is_empty() || !self.last.is_empty();
        Some(Shown { size, moment, is_doubtful, transfer: self.transfer })
    }

    /// Parses `Stream #0:1[0x1e0]: Video: hevc (Main 10), yuv420p10le(tv, bt2020nc/bt2020/smpte2084), ...`, and the
    /// line of the selected stream, `Stream #0:1 -> #0:0 (hevc (native) -> rawvideo (native))`.
    fn stream(&mut self, line: &str) -> Option<()> {
        let line = line.strip_prefix("Stream ")?;
        if let Some((stream, _)) = line.split_once(" -> #0:0") {
            self.transfer = self.transfers.iter().find(|(of, _)| of == stream).map(|(_, transfer)| *transfer);
            return None;
        }
        let (file, rest) = line.split_once(':')?;
        let number = rest.split(|letter: char| !letter.is_ascii_digit()).next()?;
        let coded = [("smpte2084", Transfer::Pq), ("arib-std-b67", Transfer::Hlg)];
        let (_, transfer) = coded.iter().find(|(name, _)| rest.contains(name))?;
        self.transfers.push((format!("{file}:{number}"), *transfer));
        None
    }

    fn error_or(&self, status: ExitStatus) -> String {
        if self.last.is_empty() { status.to_string() } else { self.last.clone() }
    }
}

/// Parses a fraction such as `1/15360` at the start of `text`; `None` if a part is 0.
pub(super) fn fraction(text: &str) -> Option<(u32, u32)> {
    let (numerator, rest) = text.split_once('/')?;
    let denominator = rest.split(|letter: char| !letter.is_ascii_digit()).next()?;
    let number = |text: &str| text.parse().ok().filter(|&number: &u32| number > 0);
    number(numerator).zip(number(denominator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_what_ffmpeg_says_the_last_complaint_is_kept() {
        let said = |text: &str| Messages::read(text.as_bytes(), "a.mp4", |_| ());
        for (text, last) in [
            ("[NULL @ 0x55f5] [error] Invalid NAL\n[mov,mp4 @ 0x7f] [error] partial file\r\n\n", "partial file"),
            ("[error] file:a.mp4: Invalid [data] found", "Invalid [data] found"),
            ("[swscaler @ 0x55] [swscaler @ 0x55] [warning] deprecated pixel format used", ""),
            ("", ""),
            ("[warning] a.mp4: corrupt decoded frame in stream 0\n", "a.mp4: corrupt decoded frame in stream 0"),
            ("cannot load a library", "cannot load a library"),
            ("[info] title: a\n   : b", ""),
        ] {
            assert_eq!(said(text).last, last, "{text}");
        }
        let changed = "[graph 0 input @ 0x5] [warning] Changing video frame properties on the fly is not supported";
        assert_eq!(said(changed), Messages { changed: true, ..Messages::default() });
    }

    #[test]
    fn what_showinfo_says() {
        let config = "[Parsed_showinfo_1 @ 0x55d] [info] config in time_base: 1/15360, frame_rate: 30/1\n";
        let line = "[Parsed_showinfo_1 @ 0x55d] [info] n:   1 pts:    512 pts_time:0.0333333 pos:     5000 fmt:yuv420p sar:12/11 s:720x576 i:P iskey:0";
        let streams = "[info]   Stream #0:0[0x1]: Video: h264 (High), yuv420p(tv, bt709), 8x8\n\
            [info]   Stream #0:1[0x2](und): Video: hevc (Main 10), yuv420p10le(tv, bt2020nc/bt2020/smpte2084), 8x8\n[info] Stream mapping:\n";
        let mapped = |number: usize| {
            let mapping = format!("[info]   Stream #0:{number} -> #0:0 (hevc (native) -> rawvideo (native))");
            format!("{streams}{mapping}\n{config}{line}")
        };
        let moment = Some(Moment { time: 512, base: (1, 15360), aspect: (12, 11) });
        for (text, moment, is_doubtful, transfer) in [
            (format!("{config}{line}"), moment, false, None),
            (format!("{config}[h264 @ 0x5] [error] lost\n{line}"), moment, true, None),
            (line.replace("    512", " NOPTS"), None, false, None),
            (mapped(0), moment, false, None),
            (mapped(1), moment, false, Some(Transfer::Pq)),
        ] {
            let mut shown = Vec::new();
            Messages::read(text.as_bytes(), "a.mp4", |one| shown.push(one));
            assert_eq!(shown, [Shown { size: (720, 576), moment, is_doubtful, transfer }], "{text}");
        }
        assert_eq!(fraction("1001/30000, frame_rate: 30/1"), Some((1001, 30000)));
        assert_eq!((fraction("0/1"), fraction("1/"), fraction("x")), (None, None, None));
    }
}
