//! Reads a written video back: lists its packets by ffmpeg, and checks that none is missing.

use super::ffmpeg::{Running, command};
use anyhow::{Context, Result, bail};
use smr_files::input::Patient;
use smr_recordings::silent;
use std::io::BufRead;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Kind of a stream in ffmpeg's list of packets (`-f framecrc`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stream {
    Image,
    Sound,
    Other,
}

/// The packets that an ffmpeg lists on its standard output by `-f framecrc -`.
pub(super) struct Packets {
    running: Running,
    lines: Patient,
    /// Kind and time base of each stream, which the list names before the first packet.
    streams: Vec<(Stream, (u32, u32))>,
}

impl Packets {
    pub fn start(mut command: Command, patience: Duration) -> Result<Self> {
        command.stdin(Stdio::null()).stdout(Stdio::piped());
        let running = Running::start(&mut command, patience)?;
        let list = running.process.output().context("standard output is piped")?;
        Ok(Self { running, lines: Patient::new(|| Ok(list), patience, silent), streams: Vec::new() })
    }

    /// Returns the kind of the next packet and its decoding time in seconds; `None` at the end.
    pub fn next(&mut self) -> Result<Option<(Stream, f64)>> {
        let mut line = String::new();
        while self.lines.read_line(&mut line)? > 0 {
            if let Some(packet) = self.read(line.trim()) {
                return Ok(Some(packet));
            }
            line.clear();
        }
        Ok(None)
    }

    pub fn has(&self, stream: Stream) -> bool {
        self.streams.iter().any(|(kind, _)| *kind == stream)
    }

    /// Parses `#media_type 1: audio`, `#tb 1: 1/44100`, and a packet: stream, decoding time, time, duration, size, CRC.
    fn read(&mut self, line: &str) -> Option<(Stream, f64)> {
        let Some(fact) = line.strip_prefix('#') else {
            let mut fields = line.split(',').map(str::trim);
            let (stream, time): (usize, f64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
            let (kind, (unit, second)) = *self.streams.get(stream)?;
            return Some((kind, time * f64::from(unit) / f64::from(second)));
        };
        let (name, rest) = fact.split_once(' ')?;
        let (number, value) = rest.split_once(": ")?;
        let number: usize = number.parse().ok().filter(|&number| number < 1000)?;
        if self.streams.len() <= number {
            self.streams.resize(number + 1, (Stream::Other, (1, 1)));
        }
        let (kind, base) = &mut self.streams[number];
        match name {
            "media_type" if value == "video" => *kind = Stream::Image,
            "media_type" if value == "audio" => *kind = Stream::Sound,
            "tb" => {
                let (unit, second) = value.split_once('/')?;
                *base = (unit.parse().ok()?, second.parse().ok()?);
            }
            _ => {}
        }
        None
    }

    /// Waits for the end of ffmpeg, and returns a message to quote.
    pub fn words(self) -> Result<String> {
        let begin = Instant::now();
        Ok(self.running.end(|| begin.elapsed() <= self.running.patience)?.1)
    }

    /// Counts the packets of pictures and of sound up to the end. Returns ffmpeg's message instead if ffmpeg failed.
    pub fn count(mut self) -> Result<std::result::Result<(usize, usize), String>> {
        let (mut images, mut sounds) = (0, 0);
        while let Some((kind, _)) = self.next()? {
            images += usize::from(kind == Stream::Image);
            sounds += usize::from(kind == Stream::Sound);
        }
        let begin = Instant::now();
        let (status, said) = self.running.end(|| begin.elapsed() <= self.running.patience)?;
        Ok(if status.success() { Ok((images, sounds)) } else { Err(said) })
    }
}

/// Reads a written video back, and returns its number of sound packets. Errors: it is not whole, or does not have
/// `frames` pictures. On a full disk, ffmpeg may end with success and leave part of a file.
pub(super) fn check(file: &Path, frames: usize, patience: Duration) -> Result<usize> {
    let mut command = command();
    command.arg("-i").arg(smr_recordings::ffmpeg_input(file));
    command.args(["-map", "0", "-c", "copy", "-copyinkf", "-f", "framecrc", "-"]);
    match Packets::start(command, patience)?.count()? {
        Ok((images, sounds)) if images == frames => Ok(sounds),
        Ok((images, _)) => bail!("ffmpeg has written {images} of {frames} frames: is the disk full?"),
        Err(said) => bail!("ffmpeg has not written a whole video (is the disk full?): {said}"),
    }
}
