//! Frames that were drawn on, as something to watch: an MP4 file (through ffmpeg), an animated GIF, or a folder of PNG pictures.

use super::draw::{INKS, Overlay};
use crate::ending::Process;
use crate::output::{Folder, Output};
use crate::report::Color;
use crate::sequence::silent;
use anyhow::{Context, Error, Result, bail, ensure};
use gif::{Encoder, EncodingError};
use image::ImageFormat;
use std::borrow::Cow;
use std::fs;
use std::io::{Cursor, ErrorKind, Read, Write};
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

/// A film under way. Until [`Film::finish`] nothing has its name.
pub struct Film {
    name: PathBuf,
    way: Way,
    /// Frames a second.
    rate: u16,
    frames: usize,
    /// How long ffmpeg may do nothing.
    patience: Duration,
}

enum Way {
    /// ffmpeg first: it ends before its file is removed.
    Mp4 {
        ffmpeg: Option<Ffmpeg>,
        output: Output,
    },
    /// The first frame, which tells the size, makes the encoder.
    Gif {
        output: Option<Output>,
        encoder: Option<Encoder<Output>>,
    },
    Pictures(Folder),
}

impl Film {
    /// Begins the film `out`: .mp4, .gif, or a new folder for pictures. An ffmpeg that does nothing for as long as `patience` is ended.
    ///
    /// # Errors
    /// It cannot be written there, or its extension is that of another kind of video.
    pub fn create(out: &Path, rate: NonZeroU16, patience: Duration) -> Result<Self> {
        let extension = out.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
        let way = match extension.as_str() {
            "mp4" => Way::Mp4 { ffmpeg: None, output: Output::create(out)? },
            "gif" => Way::Gif { output: Some(Output::create(out)?), encoder: None },
            "" => Way::Pictures(Folder::create(out)?),
            _ => {
                bail!("{}: expected a video that ends in .mp4 or .gif, or a folder without an extension", out.display())
            }
        };
        Ok(Self { name: out.to_owned(), way, rate: rate.get(), frames: 0, patience })
    }

    /// Adds a frame. All must be of the size of the first.
    ///
    /// # Errors
    /// The disk's, or ffmpeg's.
    pub fn frame(&mut self, overlay: &Overlay) -> Result<()> {
        self.frames += 1;
        match &mut self.way {
            Way::Mp4 { ffmpeg, output } => {
                if ffmpeg.is_none() {
                    *ffmpeg =
                        Some(Ffmpeg::start(file_of(output)?, overlay.pixels().dimensions(), self.rate, self.patience)?);
                }
                let written = ffmpeg.as_mut().map_or(Ok(()), |ffmpeg| ffmpeg.write(overlay.pixels().to_vec()));
                written.with_context(|| cannot_write(&self.name))
            }
            Way::Gif { output, encoder } => {
                let written = match (output.take(), encoder) {
                    (Some(output), encoder) => gif_encoder(output, overlay)
                        .and_then(|made| gif_frame(encoder.insert(made), overlay, self.rate)),
                    (None, Some(encoder)) => gif_frame(encoder, overlay, self.rate),
                    (None, None) => Ok(()),
                };
                written.map_err(of_gif).with_context(|| cannot_write(&self.name))
            }
            Way::Pictures(folder) => {
                let mut bytes = Cursor::new(Vec::new());
                overlay.pixels().write_to(&mut bytes, ImageFormat::Png)?;
                folder.write(&format!("{:05}.png", self.frames), &bytes.into_inner())
            }
        }
    }

    /// Ends it, and gives it its name.
    ///
    /// # Errors
    /// The disk's, or ffmpeg's.
    pub fn finish(self) -> Result<()> {
        let name = self.name;
        match self.way {
            Way::Mp4 { ffmpeg, output } => {
                ffmpeg.map_or(Ok(()), Ffmpeg::end).with_context(|| cannot_write(&name))?;
                output.finish()
            }
            Way::Gif { output, encoder } => {
                // What is written last is the end of the file.
                let output = match encoder {
                    Some(encoder) => Some(encoder.into_inner().map_err(of_gif).with_context(|| cannot_write(&name))?),
                    None => output,
                };
                output.map_or(Ok(()), Output::finish)
            }
            Way::Pictures(folder) => folder.finish(),
        }
    }
}

fn cannot_write(name: &Path) -> String {
    format!("cannot write {}", name.display())
}

/// Where others write to.
fn file_of(output: &Output) -> Result<&Path> {
    output.path().context("a video cannot be written to a device or a pipe: expected a file")
}

/// Gray levels of a GIF: so many that the inks fit in its 256 colours, too.
const LEVELS: usize = 256 - INKS.len();

fn gif_encoder(output: Output, overlay: &Overlay) -> Result<Encoder<Output>, EncodingError> {
    let (width, height) = gif_size(overlay);
    let levels = (0..LEVELS).map(|level| (level * 255 / (LEVELS - 1)).to_le_bytes()[0]);
    let palette: Vec<u8> = levels.map(|level| [level; 3]).chain(INKS).flatten().collect();
    let mut encoder = Encoder::new(output, width, height, &palette)?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    Ok(encoder)
}

fn gif_frame(encoder: &mut Encoder<Output>, overlay: &Overlay, rate: u16) -> Result<(), EncodingError> {
    let (width, height) = gif_size(overlay);
    let indices: Vec<u8> = overlay.pixels().pixels().map(|pixel| index(pixel.0)).collect();
    // In hundredths of a second; shorter than 2 is taken for 10 by browsers.
    let delay = ((100 + rate / 2) / rate).max(2);
    encoder.write_frame(&gif::Frame { width, height, delay, buffer: Cow::Owned(indices), ..gif::Frame::default() })
}

/// No frame has longer sides.
fn gif_size(overlay: &Overlay) -> (u16, u16) {
    let side = |length: u32| u16::try_from(length).unwrap_or(u16::MAX);
    (side(overlay.pixels().width()), side(overlay.pixels().height()))
}

/// What the disk says is told as it is.
fn of_gif(error: EncodingError) -> Error {
    match error {
        EncodingError::Io(error) => error.into(),
        other => other.into(),
    }
}

fn index(color: Color) -> u8 {
    let ink = INKS.iter().position(|ink| *ink == color).map(|ink| LEVELS + ink);
    ink.unwrap_or((usize::from(color[0]) * (LEVELS - 1) + 127) / 255).to_le_bytes()[0]
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
    fn start(file: &Path, (width, height): (u32, u32), rate: u16, patience: Duration) -> Result<Self> {
        let mut command = Command::new("ffmpeg");
        command.args(["-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
        command.args(["-video_size", &format!("{width}x{height}"), "-framerate", &rate.to_string(), "-i", "-"]);
        // Players want half as many columns and rows of colour; what is there to scroll through stands at the beginning.
        command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart"]);
        command.args(["-f", "mp4", "-y"]).arg(file);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let process = match Process::start(&mut command) {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                bail!(
                    "an MP4 video needs ffmpeg, and there is none on the PATH: install the package `ffmpeg`, or write a .gif"
                )
            }
            other => other.context("cannot start ffmpeg")?,
        };
        let mut complaints = process.complaints().context("standard error is piped")?;
        let (sender, said) = channel();
        thread::spawn(move || {
            let mut text = Vec::new();
            let _ = complaints.read_to_end(&mut text);
            sender.send(String::from_utf8_lossy(&text).into_owned())
        });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::GREEN;
    use crate::sequence::{self, BoundingBox, GrayFrame};
    use std::fs::File;

    const PATIENCE: Duration = Duration::from_secs(60);

    /// Odd sides, which MP4 cannot have.
    fn frames() -> impl Iterator<Item = Overlay> {
        (0..3u8).map(|step| {
            let pixels = (0..61 * 43).map(|at: u32| at.to_le_bytes()[0] / 2).collect();
            let mut overlay = Overlay::new(&GrayFrame { width: 61, height: 43, pixels });
            overlay.outline(&BoundingBox { x: f64::from(step) + 10.0, y: 15.0, width: 20.0, height: 12.0 }, GREEN);
            overlay
        })
    }

    fn filmed(out: &Path) {
        let mut film = Film::create(out, NonZeroU16::new(25).unwrap(), PATIENCE).unwrap();
        for frame in frames() {
            film.frame(&frame).unwrap();
            assert!(!out.exists());
        }
        film.finish().unwrap();
    }

    #[test]
    fn a_folder_holds_the_pixels() {
        let above = tempfile::tempdir().unwrap();
        let out = above.path().join("film");
        filmed(&out);
        for (number, frame) in (1..).zip(frames()) {
            let picture = image::open(out.join(format!("{number:05}.png"))).unwrap().into_rgb8();
            assert_eq!(picture, *frame.pixels());
        }
    }

    #[test]
    fn a_gif_holds_the_boxes() {
        let above = tempfile::tempdir().unwrap();
        let out = above.path().join("film.gif");
        filmed(&out);
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(File::open(&out).unwrap()).unwrap();
        for frame in frames() {
            let decoded = decoder.read_next_frame().unwrap().unwrap();
            assert_eq!(decoded.delay, 4);
            for (found, expected) in decoded.buffer.chunks_exact(4).zip(frame.pixels().chunks_exact(3)) {
                // Gray levels are a few less.
                assert!(found.iter().zip(expected).all(|(found, expected)| found.abs_diff(*expected) <= 1));
            }
        }
        assert!(decoder.read_next_frame().unwrap().is_none());
    }

    #[test]
    fn an_mp4_is_decoded_again() {
        let above = tempfile::tempdir().unwrap();
        let out = above.path().join("film.mp4");
        if Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).status().is_err() {
            println!("skipped: an_mp4_is_decoded_again: no ffmpeg on the PATH");
            return;
        }
        filmed(&out);
        let sequence = sequence::open(&out, &sequence::OpenOptions::default()).unwrap();
        let sizes: Vec<_> =
            sequence.frames.map(|frame| frame.map(|frame| (frame.width, frame.height)).unwrap()).collect();
        assert_eq!(sizes, [(62, 44); 3]);
    }

    #[test]
    fn what_breaks_off_or_is_unknown_leaves_nothing() {
        let above = tempfile::tempdir().unwrap();
        for name in ["film.gif", "film"] {
            let mut film = Film::create(&above.path().join(name), NonZeroU16::MIN, PATIENCE).unwrap();
            film.frame(&frames().next().unwrap()).unwrap();
        }
        let error = Film::create(&above.path().join("film.avi"), NonZeroU16::MIN, PATIENCE).err().unwrap().to_string();
        assert!(
            error.ends_with("film.avi: expected a video that ends in .mp4 or .gif, or a folder without an extension")
        );
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 0);
    }
}
