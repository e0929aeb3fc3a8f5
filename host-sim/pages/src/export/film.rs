//! Frames that were drawn on, as something to watch: an MP4 file (through ffmpeg), an animated GIF, or a folder of PNG pictures.

use super::animation::Gif;
use super::draw::Overlay;
use super::mp4::Mp4;
use super::picture::rgb_png;
use super::timeline::{Rate, Timeline};
use anyhow::{Context, Result, bail};
use smr_recordings::Moment;
use smr_recordings::output::{Folder, Output};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A film under way. Until [`Film::finish`] nothing has its name.
pub struct Film {
    name: PathBuf,
    way: Way,
    timeline: Timeline,
    /// Of the next frame.
    number: usize,
}

enum Way {
    Mp4(Mp4),
    Gif(Gif),
    Pictures(Folder),
}

/// What a film takes from the recording.
#[derive(Clone, Debug)]
pub struct Plan {
    /// `None`: frames are shown at the times that they have in the recording, or 25 a second where it has none.
    pub rate: Option<Rate>,
    /// The file with the sound. It is left out if frames do not keep their times.
    pub sound: Option<PathBuf>,
    /// The number of the first frame in the recording.
    pub first: usize,
    /// How long ffmpeg may do nothing.
    pub patience: Duration,
}

impl Film {
    /// Begins the film `out`: .mp4, .gif, or a new folder for pictures.
    ///
    /// # Errors
    /// It cannot be written there, or its extension is that of another kind of video.
    pub fn create(out: &Path, plan: Plan) -> Result<Self> {
        let extension = out.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
        let Plan { rate, sound, first, patience } = plan;
        let way = match extension.as_str() {
            "mp4" => Way::Mp4(Mp4::new(Output::create(out)?, sound, patience)),
            "gif" => Way::Gif(Gif::new(Output::create(out)?)),
            "" => Way::Pictures(Folder::create(out)?),
            _ => {
                bail!("{}: expected a video that ends in .mp4 or .gif, or a folder without an extension", out.display())
            }
        };
        Ok(Self { name: out.to_owned(), way, timeline: Timeline::new(rate), number: first })
    }

    /// Adds a frame, and when it is shown in the recording, if that is known. All must be of the size of the first.
    ///
    /// # Errors
    /// The disk's, or ffmpeg's.
    pub fn frame(&mut self, overlay: &Overlay, moment: Option<Moment>) -> Result<()> {
        let time = self.timeline.next(moment);
        let number = self.number;
        self.number += 1;
        let written = match &mut self.way {
            Way::Mp4(mp4) => mp4.frame(overlay, &self.timeline, time, moment),
            Way::Gif(gif) => gif.frame(overlay, time),
            Way::Pictures(folder) => {
                let png = rgb_png(overlay.size(), overlay.rgb())?;
                return folder.write(&format!("{number:05}.png"), &png);
            }
        };
        written.with_context(|| cannot_write(&self.name))
    }

    /// Ends it, and gives it its name.
    ///
    /// # Errors
    /// The disk's, or ffmpeg's.
    pub fn finish(self) -> Result<()> {
        let context = || cannot_write(&self.name);
        match self.way {
            Way::Mp4(mp4) => mp4.finish().with_context(context)?.finish(),
            Way::Gif(gif) => gif.finish(self.timeline.interval()).with_context(context)?.map_or(Ok(()), Output::finish),
            Way::Pictures(folder) => folder.finish(),
        }
    }
}

fn cannot_write(name: &Path) -> String {
    format!("cannot write {}", name.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::GREEN;
    use crate::report::canvas::Canvas;
    use smr_recordings::{BoundingBox, GrayFrame};
    use std::fs::{self, File};

    fn plan() -> Plan {
        Plan { rate: Some("25".parse().unwrap()), sound: None, first: 1, patience: Duration::from_secs(60) }
    }

    /// Odd sides, which MP4 cannot have.
    fn frames() -> impl Iterator<Item = Overlay> {
        (0..3u8).map(|step| {
            let pixels = (0..61 * 43).map(|at: u32| at.to_le_bytes()[0] / 2).collect();
            let mut overlay = Overlay::new((&GrayFrame { width: 61, height: 43, pixels }).into());
            overlay.outline(&BoundingBox { x: f64::from(step) + 10.0, y: 15.0, width: 20.0, height: 12.0 }, GREEN);
            overlay
        })
    }

    fn filmed(out: &Path) {
        let mut film = Film::create(out, plan()).unwrap();
        for frame in frames() {
            film.frame(&frame, None).unwrap();
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
            let png = fs::read(out.join(format!("{number:05}.png"))).unwrap();
            assert_eq!(Canvas::decoded(&png), *frame.picture());
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
        if !crate::missing::has_ffmpeg("an_mp4_is_decoded_again") {
            return;
        }
        filmed(&out);
        let sequence = smr_recordings::open(&out, &smr_recordings::OpenOptions::default()).unwrap();
        let sizes: Vec<_> =
            sequence.frames.map(|frame| frame.map(|frame| (frame.width, frame.height)).unwrap()).collect();
        assert_eq!(sizes, [(62, 44); 3]);
    }

    #[test]
    fn what_breaks_off_or_is_unknown_leaves_nothing() {
        let above = tempfile::tempdir().unwrap();
        for name in ["film.gif", "film"] {
            let mut film = Film::create(&above.path().join(name), plan()).unwrap();
            film.frame(&frames().next().unwrap(), None).unwrap();
        }
        let error = Film::create(&above.path().join("film.avi"), plan()).err().unwrap().to_string();
        assert!(
            error.ends_with("film.avi: expected a video that ends in .mp4 or .gif, or a folder without an extension")
        );
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 0);
    }
}
