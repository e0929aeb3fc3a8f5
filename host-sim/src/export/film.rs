//! Frames that were drawn on, as something to watch: an MP4 file (through ffmpeg), an animated GIF, or a folder of PNG pictures.

use super::draw::{Ink, Overlay};
use crate::output::{self, Folder, Output};
use anyhow::{Context, Result, bail, ensure};
use image::{ExtendedColorType, ImageFormat};
use std::borrow::Cow;
use std::fs::{File, OpenOptions};
use std::io::{Cursor, ErrorKind, Read, Write};
use std::num::NonZeroU16;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

/// A film under way. Until [`Film::finish`] nothing has its name.
pub struct Film {
    way: Way,
    /// Frames a second.
    rate: u16,
    frames: usize,
}

enum Way {
    Mp4 { output: Output, ffmpeg: Option<Ffmpeg> },
    Gif { output: Output, encoder: Option<gif::Encoder<File>> },
    Pictures(Folder),
}

impl Film {
    /// Begins the film `out`: .mp4, .gif, or a new folder for pictures.
    ///
    /// # Errors
    /// It cannot be written there, or its extension is that of another kind of video.
    pub fn create(out: &Path, rate: NonZeroU16) -> Result<Self> {
        let extension = out.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
        let way = match extension.as_str() {
            "mp4" => Way::Mp4 { output: Output::create(out)?, ffmpeg: None },
            "gif" => Way::Gif { output: Output::create(out)?, encoder: None },
            "" => Way::Pictures(Folder::create(out)?),
            _ => {
                bail!("{}: expected a video that ends in .mp4 or .gif, or a folder without an extension", out.display())
            }
        };
        Ok(Self { way, rate: rate.get(), frames: 0 })
    }

    /// Adds a frame. All must be of the size of the first.
    ///
    /// # Errors
    /// The disk's, or ffmpeg's.
    pub fn frame(&mut self, overlay: &Overlay) -> Result<()> {
        self.frames += 1;
        let (width, height) = overlay.size();
        match &mut self.way {
            Way::Mp4 { output, ffmpeg } => {
                if ffmpeg.is_none() {
                    *ffmpeg = Some(Ffmpeg::start(file_of(output)?, overlay.size(), self.rate)?);
                }
                ffmpeg.as_mut().map_or(Ok(()), |ffmpeg| ffmpeg.write(&overlay.rgb()))
            }
            Way::Gif { output, encoder } => {
                if encoder.is_none() {
                    *encoder = Some(gif_encoder(file_of(output)?, overlay.size())?);
                }
                let Some(encoder) = encoder else { return Ok(()) };
                let indices: Vec<u8> = overlay.pixels().map(|(gray, ink)| index(gray, ink)).collect();
                // In hundredths of a second; shorter than 2 is taken for 10 by browsers.
                let delay = ((100 + self.rate / 2) / self.rate).max(2);
                let frame = gif::Frame { width, height, delay, buffer: Cow::Owned(indices), ..gif::Frame::default() };
                encoder.write_frame(&frame).context("cannot write the animation")
            }
            Way::Pictures(folder) => {
                let mut bytes = Cursor::new(Vec::new());
                let (rgb, color) = (overlay.rgb(), ExtendedColorType::Rgb8);
                image::write_buffer_with_format(
                    &mut bytes,
                    &rgb,
                    width.into(),
                    height.into(),
                    color,
                    ImageFormat::Png,
                )?;
                output::write(&folder.path().join(format!("{:05}.png", self.frames)), &bytes.into_inner())
            }
        }
    }

    /// Ends it, and gives it its name.
    ///
    /// # Errors
    /// The disk's, or ffmpeg's.
    pub fn finish(self) -> Result<()> {
        match self.way {
            Way::Mp4 { output, ffmpeg } => {
                ffmpeg.map_or(Ok(()), Ffmpeg::end)?;
                output.finish()
            }
            Way::Gif { output, encoder } => {
                // What is written last is the end of the file.
                encoder
                    .map_or(Ok(()), |encoder| encoder.into_inner().map(drop))
                    .context("cannot write the animation")?;
                output.finish()
            }
            Way::Pictures(folder) => folder.finish(),
        }
    }
}

/// Where others write to.
fn file_of(output: &Output) -> Result<&Path> {
    output.path().context("a video cannot be written to a device or a pipe: expected a file")
}

/// Gray levels of a GIF: so many that the inks fit in its 256 colours, too.
const LEVELS: usize = 256 - Ink::ALL.len();

fn gif_encoder(file: &Path, (width, height): (u16, u16)) -> Result<gif::Encoder<File>> {
    let levels = (0..LEVELS).map(|level| (level * 255 / (LEVELS - 1)).to_le_bytes()[0]);
    let palette: Vec<u8> = levels.map(|level| [level; 3]).chain(Ink::ALL.map(Ink::color)).flatten().collect();
    let file = OpenOptions::new().write(true).truncate(true).open(file).context("cannot write the animation")?;
    let mut encoder = gif::Encoder::new(file, width, height, &palette).context("cannot write the animation")?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    Ok(encoder)
}

fn index(gray: u8, ink: Option<Ink>) -> u8 {
    let index = match ink {
        None => (usize::from(gray) * (LEVELS - 1) + 127) / 255,
        Some(ink) => LEVELS + Ink::ALL.iter().position(|&known| known == ink).unwrap_or(0),
    };
    index.to_le_bytes()[0]
}

/// An ffmpeg that writes a video. Dropped, it is ended.
struct Ffmpeg {
    process: Child,
    said: Option<JoinHandle<String>>,
}

impl Ffmpeg {
    fn start(file: &Path, (width, height): (u16, u16), rate: u16) -> Result<Self> {
        let mut command = Command::new("ffmpeg");
        command.args(["-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
        command.args(["-video_size", &format!("{width}x{height}"), "-framerate", &rate.to_string(), "-i", "-"]);
        // Players want half as many columns and rows of colour; what is there to scroll through stands at the beginning.
        command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart"]);
        command.args(["-f", "mp4", "-y"]).arg(file);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut process = match command.spawn() {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                bail!(
                    "an MP4 video needs ffmpeg, and there is none on the PATH: install the package `ffmpeg`, or write a .gif"
                )
            }
            other => other.context("cannot start ffmpeg")?,
        };
        let mut complaints = process.stderr.take().context("standard error is piped")?;
        let said = std::thread::spawn(move || {
            let mut text = Vec::new();
            let _ = complaints.read_to_end(&mut text);
            String::from_utf8_lossy(&text).into_owned()
        });
        Ok(Self { process, said: Some(said) })
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.process.stdin.as_mut().map_or(Ok(()), |pipe| pipe.write_all(bytes));
        // It has ended, and knows why.
        written.or_else(|_| self.verdict())
    }

    fn end(mut self) -> Result<()> {
        self.verdict()
    }

    fn verdict(&mut self) -> Result<()> {
        drop(self.process.stdin.take());
        let status = self.process.wait().context("cannot wait for ffmpeg")?;
        let said = self.said.take().and_then(|said| said.join().ok()).unwrap_or_default();
        let last = said.trim().lines().next_back().unwrap_or("");
        ensure!(
            status.success(),
            "ffmpeg cannot write the video: {}",
            if last.is_empty() { "it gives no reason" } else { last }
        );
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{self, BoundingBox, GrayFrame};
    use std::fs;

    /// Odd sides, which MP4 cannot have.
    fn frames() -> impl Iterator<Item = Overlay> {
        (0..3u8).map(|step| {
            let pixels = (0..61 * 43).map(|at: u32| at.to_le_bytes()[0] / 2).collect();
            let mut overlay = Overlay::new(GrayFrame { width: 61, height: 43, pixels });
            overlay.outline(&BoundingBox { x: f64::from(step) + 10.0, y: 15.0, width: 20.0, height: 12.0 }, Ink::Green);
            overlay
        })
    }

    fn filmed(out: &Path) {
        let mut film = Film::create(out, NonZeroU16::new(25).unwrap()).unwrap();
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
            assert_eq!(picture.into_raw(), frame.rgb());
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
            for (found, expected) in decoded.buffer.chunks_exact(4).zip(frame.rgb().chunks_exact(3)) {
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
            let mut film = Film::create(&above.path().join(name), NonZeroU16::MIN).unwrap();
            film.frame(&frames().next().unwrap()).unwrap();
        }
        let error = Film::create(&above.path().join("film.avi"), NonZeroU16::MIN).err().unwrap().to_string();
        assert!(
            error.ends_with("film.avi: expected a video that ends in .mp4 or .gif, or a folder without an extension")
        );
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 0);
    }
}
