//! Facts about a video file, known before an image is decoded.

use super::matroska;
use super::packets::{KEY, Packets, Stream};
use super::process::{FROM_ZERO, Input};
use super::tones::{self, Transfer};
use anyhow::{Result, bail, ensure};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

#[derive(Clone, Debug, Default)]
pub(super) struct Facts {
    /// Number among the video streams of the one that is read. Cover images do not count.
    pub stream: usize,
    pub codec: String,
    /// Unit of the stream's times in seconds, as a fraction.
    pub base: Option<(u32, u32)>,
    /// Width and height of a pixel, as a ratio.
    pub aspect: (u32, u32),
    /// False if the recording begins between two key frames.
    pub begins_at_key: bool,
    /// Count of complaints before the first packet: about other streams, or about what comes before a key frame.
    pub notes: usize,
    /// The last of these complaints.
    pub noted: String,
}

/// A video file with its facts.
#[derive(Debug)]
pub(crate) struct Video {
    pub(super) input: Input,
    pub(super) facts: Facts,
    transfer: OnceLock<Option<Transfer>>,
}

impl Video {
    /// Reads a file up to its first packet; of a Matroska file also the checksums. Errors: no ffmpeg, or the file has no
    /// video stream.
    pub fn of(program: &str, file: &Path, patience: Duration) -> Result<Self> {
        let mut input = Input::new(program, file, patience);
        // A pipe can be read only once.
        let facts = if file.is_file() {
            let facts = Facts::of(&input)?;
            input.end = matroska::damage(file);
            facts
        } else {
            Facts { begins_at_key: true, aspect: (1, 1), ..Facts::default() }
        };
        Ok(Self { input, facts, transfer: OnceLock::new() })
    }

    /// Starts to read the packets of the stream, with times from the start of the file.
    pub(super) fn packets(&self) -> Result<Packets> {
        Packets::of(&self.input, &FROM_ZERO, &["-map", &self.facts.map()])
    }

    /// Returns the HDR transfer function; `None` without HDR. The first call decodes an image.
    pub(super) fn transfer(&self) -> Option<Transfer> {
        *self.transfer.get_or_init(|| tones::transfer(&self.input, &self.facts.map()).ok().flatten())
    }
}

impl Facts {
    /// Reads a file up to its first packet. Errors: no ffmpeg, or the file has no video stream.
    pub fn of(input: &Input) -> Result<Self> {
        let mut packets = Packets::of(input, &[], &["-map", "0:V", "-frames:v", "1"])?;
        let mut chosen = None;
        while let Some(packet) = packets.next()? {
            let stream = match chosen {
                Some(stream) => stream,
                None => *chosen.insert(default_stream(input, &packets.streams)?),
            };
            if packet.stream == stream {
                let (begins_at_key, notes) = (packet.flags & KEY != 0, packets.ffmpeg.complaints);
                let noted = if notes > 0 { packets.ffmpeg.words() } else { String::new() };
                return Ok(Self { begins_at_key, notes, noted, ..Self::stated(stream, &packets.streams[stream]) });
            }
        }
        if packets.streams.is_empty() {
            return Self::refuse(input, packets);
        }
        // The stream has no packet. Decoding then says what is wrong.
        let stream = default_stream(input, &packets.streams)?;
        Ok(Self { begins_at_key: true, ..Self::stated(stream, &packets.streams[stream]) })
    }

    /// Returns the stream in the words of ffmpeg's option `-map`.
    pub fn map(&self) -> String {
        format!("0:V:{}", self.stream)
    }

    fn stated(stream: usize, stated: &Stream) -> Self {
        let Stream { codec, base, aspect, .. } = stated.clone();
        Self { stream, codec, base, aspect, ..Self::default() }
    }

    /// Tells a file without images, such as a sound recording, from one that ffmpeg cannot read.
    fn refuse(input: &Input, mut packets: Packets) -> Result<Self> {
        let mut all = Packets::of(input, &[], &["-map", "0", "-t", "0"])?;
        while all.next()?.is_some() {}
        ensure!(all.streams.is_empty(), "{} holds no pictures: expected a video", input.name);
        bail!("ffmpeg cannot decode {}: {}: {EXPECTED}", input.name, packets.ffmpeg.last_words()?)
    }
}

/// Returns the number of the stream that ffmpeg reads by default: one that the file marks, else the one with the most
/// pixels. Streams that state the same are not told apart: the first one is meant.
fn default_stream(input: &Input, streams: &[Stream]) -> Result<usize> {
    if streams.len() < 2 {
        return Ok(0);
    }
    let mut packets = Packets::of(input, &[], &["-an", "-sn", "-dn", "-frames:v", "1"])?;
    packets.next()?;
    Ok(packets.streams.first().and_then(|chosen| streams.iter().position(|stream| stream == chosen)).unwrap_or(0))
}

pub(super) const EXPECTED: &str = "expected a whole video, or else pictures, Y4M or a raw dump (--size)";
