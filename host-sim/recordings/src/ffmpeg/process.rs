//! A running ffmpeg: its output, and the lines of its standard error, sorted by kind.

use anyhow::{Context, Result, bail};
use smr_files::input::Patient;
use smr_files::process::Process;
use smr_files::wait;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

/// Default time without output after which ffmpeg counts as hanging.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// ffmpeg's arguments in every command here. Only messages of level error and above are printed, each with its level.
const ALWAYS: [&str; 5] = ["-nostdin", "-nostats", "-hide_banner", "-v", "level+error"];

/// ffmpeg options that count times from the start of the file, also after a seek.
pub(super) const FROM_ZERO: [&str; 2] = ["-copyts", "-start_at_zero"];

/// Returns the path with the prefix `file:`, without which ffmpeg takes a colon in the name for the end of a protocol.
pub fn input(file: &Path) -> OsString {
    let mut input = OsString::from("file:");
    input.push(file);
    input
}

/// Begins a command of ffmpeg; its output and messages are piped.
pub(super) fn command(program: &str) -> Command {
    let mut command = Command::new(program);
    command.args(ALWAYS).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A file that ffmpeg reads, and the ffmpeg that reads it.
#[derive(Clone, Debug)]
pub(super) struct Input {
    pub program: String,
    pub file: PathBuf,
    /// Number of bytes that are read; `None` for the whole file.
    pub end: Option<u64>,
    /// Name of the file in messages.
    pub name: String,
    pub patience: Duration,
}

impl Input {
    pub fn new(program: &str, file: &Path, patience: Duration) -> Self {
        let (program, name) = (program.to_owned(), file.display().to_string());
        Self { program, file: file.to_owned(), end: None, name, patience }
    }

    /// Begins a command that reads the file; `options` are those of the input.
    pub fn command(&self, options: &[&str]) -> Command {
        let mut command = command(&self.program);
        let mut name = OsString::new();
        if let Some(end) = self.end {
            name.push(format!("subfile,,start,0,end,{end},,:"));
        }
        name.push(input(&self.file));
        command.args(options).arg("-i").arg(name);
        command
    }

    pub fn run(&self, command: &mut Command) -> Result<Ffmpeg> {
        Ffmpeg::run(command, &self.name, self.patience)
    }
}

pub fn silent(patience: Duration) -> io::Error {
    let seconds = patience.as_secs_f64();
    io::Error::new(ErrorKind::TimedOut, format!("ffmpeg has done nothing for {seconds} s (--ffmpeg-timeout)"))
}

/// A line of standard error, by its kind.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// A message of level error or above.
    Complaint(String),
    /// An image that has passed the filter [`MARK`]: its time in the unit of the stream, if known.
    Image(Option<i64>),
    /// A line of `framecrc`: `#name stream: value`, or the fields of a packet.
    Row(String),
    /// A line without a level: of a loader, or the rest of a message.
    Other(String),
}

/// Filters that print a line for each image on standard error, in order with the complaints about it.
pub(super) const MARK: &str = "metadata=mode=add:key=smr:value=1,metadata=mode=print:key=smr:file='pipe\\:2':direct=1";

/// Second line that [`MARK`] prints for an image.
const KEY: &str = "smr=1";

impl Line {
    /// Sorts a line. ffmpeg's threads may write an image's line inside a complaint, which then is both.
    fn sort(line: &str, add: impl Fn(Self)) {
        let words = ["[error] ", "[fatal] ", "[panic] "].iter().find_map(|level| Some(line.split_once(level)?.1));
        let image = image_time(line);
        let is_row = line.starts_with(|first: char| first == '#' || first.is_ascii_digit());
        if let Some(words) = words {
            let own = words.find("frame:").filter(|_| image.is_some()).unwrap_or(words.len());
            add(Self::Complaint(words[..own].trim().to_owned()));
        }
        match (image, words) {
            (Some(time), _) => add(Self::Image(time)),
            (None, None) if line.ends_with(KEY) => {}
            (None, None) if is_row => add(Self::Row(line.to_owned())),
            (None, None) => add(Self::Other(line.to_owned())),
            (None, Some(_)) => {}
        }
    }
}

/// Parses `frame:1    pts:512     pts_time:0.04`, which may stand inside a torn line.
fn image_time(line: &str) -> Option<Option<i64>> {
    let (_, fields) = line.split_once("frame:")?;
    let mut fields = fields.split_whitespace();
    let _number: u64 = fields.next()?.parse().ok()?;
    let time = fields.next()?.strip_prefix("pts:")?;
    fields.next()?.strip_prefix("pts_time:")?;
    Some(time.parse().ok())
}

/// A running ffmpeg; dropping it kills the process.
pub(super) struct Ffmpeg {
    process: Process,
    lines: Receiver<Line>,
    /// Count of complaints so far.
    pub complaints: usize,
    /// Text of the last complaint; before the first one, the last line without a level.
    words: String,
    name: String,
    patience: Duration,
}

impl Ffmpeg {
    /// Starts ffmpeg. Errors call its input `name`.
    pub fn run(command: &mut Command, name: &str, patience: Duration) -> Result<Self> {
        let process = match Process::start(command) {
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "{name} needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)"
            ),
            other => other.context("cannot start ffmpeg")?,
        };
        let errors = process.complaints().expect("standard error is piped");
        let (sender, lines) = channel();
        // Reads all lines, even if nobody receives them any more, because ffmpeg blocks on a full pipe.
        thread::spawn(move || read_lines(errors, &sender));
        Ok(Self { process, lines, complaints: 0, words: String::new(), name: name.to_owned(), patience })
    }

    /// Returns standard output, for another process to read.
    pub fn pipe(&self) -> ChildStdout {
        self.process.output().expect("standard output is piped")
    }

    /// Returns standard output, whose reads fail after the time `patience` without data.
    pub fn output(&self) -> Patient {
        let stream = self.pipe();
        Patient::new(|| Ok(stream), self.patience, silent)
    }

    /// Waits for the next line of standard error; `None` at its end.
    pub fn line(&mut self) -> Result<Option<Line>> {
        let line = match wait::receive(&self.lines, self.patience) {
            Err(RecvTimeoutError::Timeout) => return Err(silent(self.patience).into()),
            line => line.ok(),
        };
        match &line {
            Some(Line::Complaint(words)) => {
                self.complaints += 1;
                if !words.is_empty() {
                    self.words.clone_from(words);
                }
            }
            Some(Line::Other(words)) if self.complaints == 0 && !words.is_empty() => self.words.clone_from(words),
            _ => {}
        }
        Ok(line)
    }

    /// Waits for the end of ffmpeg and reads the rest of its lines. Returns true if it ended with success.
    pub fn succeeded(&mut self) -> Result<bool> {
        self.ended().map(|status| status.success())
    }

    fn ended(&mut self) -> Result<ExitStatus> {
        let is_waited_for = |waited| waited <= self.patience && !wait::has_ended();
        let status = self.process.wait_while(is_waited_for).context("cannot wait for ffmpeg")?;
        let Some(status) = status else {
            return Err(silent(self.patience)).with_context(|| format!("cannot read {}", self.name));
        };
        // A process that ffmpeg started may keep the stream open, so a line that does not come is no error.
        while let Ok(Some(_)) = self.line() {}
        Ok(status)
    }

    /// Returns the last words so far, to be quoted, or else the exit status.
    pub fn words(&self) -> String {
        if let Some(words) = self.words.strip_prefix(&format!("file:{}: ", self.name)) {
            return words.to_owned();
        }
        match self.process.ended() {
            Ok(Some(status)) if self.words.is_empty() => status.to_string(),
            _ => self.words.clone(),
        }
    }

    /// Waits for the end of ffmpeg, and returns its last words.
    pub fn last_words(&mut self) -> Result<String> {
        self.ended().map(|_| self.words())
    }

    /// Returns ffmpeg's last words, if it has ended with an error.
    pub fn failure(&mut self) -> Option<String> {
        let is_ended = self.process.ended().is_ok_and(|status| status.is_some_and(|status| !status.success()));
        is_ended.then(|| self.last_words().ok())?
    }
}

fn read_lines(errors: impl Read, lines: &Sender<Line>) {
    for line in BufReader::new(errors).split(b'\n').map_while(Result::ok) {
        Line::sort(String::from_utf8_lossy(&line).trim(), |line| drop(lines.send(line)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn lines_are_sorted_by_level_and_not_by_their_words() {
        let complaint = |words: &str| Line::Complaint(words.to_owned());
        let other = |words: &str| Line::Other(words.to_owned());
        for (line, expected) in [
            ("[NULL @ 0x55f5] [error] Invalid NAL", vec![complaint("Invalid NAL")]),
            ("[in#0 @ 0x1] [fatal] error", vec![complaint("error")]),
            ("[error] file:a.mp4: Invalid [data] found", vec![complaint("file:a.mp4: Invalid [data] found")]),
            ("cannot load a library", vec![other("cannot load a library")]),
            ("smr=1", vec![]),
            ("frame:1    pts:512     pts_time:0.04", vec![Line::Image(Some(512))]),
            ("frame:0    pts:NOPTS   pts_time:NOPTS", vec![Line::Image(None)]),
            ("[h264 @ 0x5] frame:3 pts:-7 pts_time:-1", vec![Line::Image(Some(-7))]),
            ("[h264 @ 0x5] [error] frame:3 pts:7 pts_time:1", vec![complaint(""), Line::Image(Some(7))]),
            ("#tb 0: 1/25", vec![Line::Row("#tb 0: 1/25".to_owned())]),
            ("0, 1, 2, 3, 4, 0x5", vec![Line::Row("0, 1, 2, 3, 4, 0x5".to_owned())]),
        ] {
            let found = RefCell::new(Vec::new());
            Line::sort(line, |line| found.borrow_mut().push(line));
            assert_eq!(found.into_inner(), expected, "{line}");
        }
    }
}
