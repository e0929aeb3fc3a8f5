//! Frames that were drawn on, as something to watch: a video (through ffmpeg), or a folder of PNG pictures.

use super::ffmpeg::{Encoded, Kind};
use super::frame_times::Timeline;
use super::overlay::Overlay;
use crate::encode::rgb_png;
use anyhow::{Context, Result, bail};
use smr_recordings::Moment;
use smr_recordings::output::{Folder, Output};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The extensions of films that are files.
pub const ENDINGS: [&str; 4] = ["mp4", "mov", "mkv", "webm"];

/// A film under way. Until [`Film::finish`] nothing has its name.
pub struct Film {
    name: PathBuf,
    way: Way,
    timeline: Timeline,
    /// Of the next frame.
    number: usize,
}

enum Way {
    Encoded(Encoded),
    Pictures(Folder),
}

/// What a film takes from the recording.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The file with the sound. It is left out if the recording has no times.
    pub sound: Option<PathBuf>,
    pub first: usize,
    /// How long ffmpeg may do nothing.
    pub patience: Duration,
}

impl Film {
    /// Begins the film `out`: a file with one of [`ENDINGS`], or a new folder for pictures.
    /// Errors: It cannot be written there, or its extension is that of another kind of video.
    pub fn create(out: &Path, plan: Plan) -> Result<Self> {
        let extension = out.extension().filter(|_| !out.as_os_str().as_encoded_bytes().ends_with(b"/"));
        let extension = extension.and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
        let Plan { sound, first, patience } = plan;
        let way = match Kind::of(&extension) {
            Some(kind) => Way::Encoded(Encoded::new(kind, Output::create(out)?, sound, patience)),
            None if extension.is_empty() => Way::Pictures(Folder::create(out)?),
            None => {
                let endings = ENDINGS.join(", .");
                bail!(
                    "{}: expected a video that ends in .{endings}, or a folder (no ending, or a / after it)",
                    out.display()
                )
            }
        };
        Ok(Self { name: out.to_owned(), way, timeline: Timeline::new(), number: first })
    }

    /// Adds a frame, and when it is shown in the recording, if that is known. All must be of the size of the first.
    pub fn frame(&mut self, overlay: &Overlay, moment: Option<Moment>) -> Result<()> {
        let time = self.timeline.next(moment);
        let number = self.number;
        self.number += 1;
        let written = match &mut self.way {
            Way::Encoded(encoded) => encoded.frame(overlay, &self.timeline, time, moment),
            Way::Pictures(folder) => {
                let png = rgb_png(overlay.size(), overlay.rgb())?;
                return folder.write(&format!("{number:05}.png"), &png);
            }
        };
        written.with_context(|| cannot_write(&self.name))
    }

    /// Ends it, and gives it its name.
    pub fn finish(self) -> Result<()> {
        let context = || cannot_write(&self.name);
        match self.way {
            Way::Encoded(encoded) => encoded.finish().with_context(context)?.finish(),
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
    use crate::colors::GREEN;
    use crate::report::canvas::Canvas;
    use smr_recordings::{BoundingBox, GrayFrame};
    use std::fs;

    fn plan() -> Plan {
        Plan { sound: None, first: 1, patience: Duration::from_secs(60) }
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
        let out = above.path().join("film.7/");
        filmed(&out);
        for (number, frame) in (1..).zip(frames()) {
            let png = fs::read(out.join(format!("{number:05}.png"))).unwrap();
            let read = Canvas::decoded(&png);
            assert_eq!(((read.width, read.height), read.pixels.as_flattened()), (frame.size(), frame.rgb()));
        }
    }

    #[test]
    fn a_video_is_decoded_again() {
        let above = tempfile::tempdir().unwrap();
        if !crate::missing::has_ffmpeg("a_video_is_decoded_again") {
            return;
        }
        // Color at half the size has no odd sides.
        for name in ENDINGS.map(|ending| format!("film.{ending}")) {
            let out = above.path().join(&name);
            filmed(&out);
            let sequence = smr_recordings::open(&out, &smr_recordings::OpenOptions::default()).unwrap();
            let sizes: Vec<_> =
                sequence.frames.map(|frame| frame.unwrap().gray).map(|gray| (gray.width, gray.height)).collect();
            assert_eq!(sizes, [(62, 44); 3], "{name}");
        }
    }

    #[test]
    fn what_breaks_off_or_is_unknown_leaves_nothing() {
        let above = tempfile::tempdir().unwrap();
        let mut film = Film::create(&above.path().join("film"), plan()).unwrap();
        film.frame(&frames().next().unwrap(), None).unwrap();
        drop(film);
        let error = Film::create(&above.path().join("film.avi"), plan()).err().unwrap().to_string();
        assert!(error.ends_with(
            "film.avi: expected a video that ends in .mp4, .mov, .mkv, .webm, or a folder (no ending, or a / after it)"
        ));
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 0);
    }
}
