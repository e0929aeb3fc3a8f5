//! Adds the recording's sound to a written video: a second pass, which copies the pictures.
//!
//! One pass for both would need `-shortest`, which cuts the sound by what the muxer has buffered, up to seconds.

use super::ffmpeg::{Writing, command};
use super::read_back::{Packets, Stream, check};
use anyhow::Result;
use smr_recordings::ffmpeg_input;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

/// The part of a recording's sound that belongs to a video.
pub(super) struct Sound {
    pub recording: PathBuf,
    /// Time in seconds at which the first frame is shown.
    pub start: f64,
    /// Length in seconds; `None` if the video has the recording's last frame: the sound then ends as in the recording.
    pub length: Option<f64>,
}

/// Encoder of the sound, and the filter that converts any sound to what the encoder takes.
#[derive(Clone, Copy)]
pub(super) struct Codec {
    pub options: &'static [&'static str],
    pub takes: &'static str,
}

pub(super) enum Added {
    Sound,
    /// The recording has no stream of sound.
    NoStream,
    /// No sound can be added, for this reason.
    Unreadable(String),
}

enum Shift {
    Of(f64),
    NoSound,
    /// ffmpeg lists no streams, for this reason.
    Unknown(String),
}

impl Sound {
    /// Writes the video `images`, which has `frames` frames, with this sound to `out`; `container` are the options of
    /// its format. Errors: the file cannot be written.
    pub fn add(
        &self,
        (images, frames): (&Path, usize),
        out: &Path,
        (codec, container): (Codec, &[&str]),
        patience: Duration,
    ) -> Result<Added> {
        let recording = self.recording.display();
        let unreadable = |said| Added::Unreadable(format!("that of {recording} cannot be read, says ffmpeg: {said}"));
        let shift = match self.shift(patience)? {
            Shift::Of(shift) => shift,
            Shift::NoSound => return Ok(Added::NoStream),
            Shift::Unknown(said) => return Ok(unreadable(said)),
        };
        let filter = self.filter(shift, codec);
        let mut written = Ok(0);
        // Where recordings are joined, ffmpeg takes the last packets of a part for damaged, also those of the pictures.
        for before in [&[][..], &["-fflags", "+discardcorrupt"]] {
            written = self.write(before, (images, frames), out, (&filter, codec, container), patience);
            if written.as_ref().is_ok_and(|&sounds| sounds > 0) {
                return Ok(Added::Sound);
            }
        }
        // Either the sound cannot be read, or the file cannot be written: encodes the sound alone, into no file.
        let mut alone = command();
        alone.arg("-i").arg(ffmpeg_input(&self.recording));
        alone.args(["-map", "0:a:0", "-af", &filter]).args(codec.options).args(["-f", "framecrc", "-"]);
        alone.args(unread_images(0));
        match Packets::start(alone, patience)?.count()? {
            Ok((_, 0)) => Ok(Added::Unreadable(format!("{recording} has no sound in these frames"))),
            Ok(_) => written.map(|_| Added::Sound),
            Err(said) => Ok(unreadable(said)),
        }
    }

    /// Writes the video with the sound that `filter` cuts; `before` are options of the recording. Returns the number of
    /// sound packets in the file.
    fn write(
        &self,
        before: &[&str],
        (images, frames): (&Path, usize),
        out: &Path,
        (filter, codec, container): (&str, Codec, &[&str]),
        patience: Duration,
    ) -> Result<usize> {
        let mut both = command();
        both.arg("-i").arg(ffmpeg_input(images)).args(before).arg("-i").arg(ffmpeg_input(&self.recording));
        both.args(["-map", "0:v", "-c:v", "copy", "-map", "1:a:0", "-af", filter]).args(codec.options);
        // Sound that begins late makes ffmpeg hold back all pictures before it.
        both.args(["-map_chapters", "-1", "-max_muxing_queue_size", "1000000000"]);
        both.args(container).arg("-y").arg(out).args(unread_images(1)).stdin(Stdio::null());
        Writing::start(both, out, patience)?.end()?;
        check(out, frames, patience)
    }

    /// Returns how much later ffmpeg counts times when it reads both pictures and sound than when it reads pictures
    /// alone, in seconds: in MPEG streams zero is the start of the first stream that is read.
    fn shift(&self, patience: Duration) -> Result<Shift> {
        let first = |before: &[&str], streams: &[&str]| {
            let mut command = command();
            command.args(before).arg("-i").arg(ffmpeg_input(&self.recording)).args(streams);
            command.args(["-c", "copy", "-f", "framecrc", "-"]);
            let mut packets = Packets::start(command, patience)?;
            while let Some((kind, at)) = packets.next()? {
                if kind == Stream::Image {
                    return Ok((Some(at), packets));
                }
            }
            anyhow::Ok((None, packets))
        };
        let (both, packets) = first(&[], &["-map", "0:V:0", "-map", "0:a:0?"])?;
        if !packets.has(Stream::Sound) {
            let is_read = both.is_some() || packets.has(Stream::Image);
            return Ok(if is_read { Shift::NoSound } else { Shift::Unknown(packets.words()?) });
        }
        // The options by which the frames of the recording get their times.
        let (alone, _) = first(&["-copyts", "-start_at_zero"], &["-map", "0:V:0"])?;
        Ok(Shift::Of(both.zip(alone).map_or(0.0, |(both, alone)| both - alone)))
    }

    fn filter(&self, shift: f64, codec: Codec) -> String {
        let start = (self.start + shift).max(0.0);
        let end = self.length.map_or(String::new(), |length| format!(":end={:.6}", start + length));
        // `aresample` fills gaps between packets by silence, and cuts what overlaps.
        format!("atrim=start={start:.6}{end},asetpts=PTS-{start:.6}/TB,aresample=async=1,{}", codec.takes)
    }
}

/// Options for an output that drops the pictures of input `number`. They must be read, because `shift` counts on it.
fn unread_images(number: u32) -> [String; 7] {
    ["-map", &format!("{number}:V:0"), "-c", "copy", "-f", "null", "-"].map(str::to_owned)
}
