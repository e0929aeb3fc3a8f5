//! Writes frames with boxes drawn on them as a video (through ffmpeg) or as a folder of PNG pictures.

use super::ffmpeg::Ffmpeg;
use super::matroska;
use super::overlay::Overlay;
use crate::encode::rgb_png;
use anyhow::{Context, Result, bail};
use smr_recordings::output::{Folder, Output};
use smr_recordings::{Moment, ffmpeg_input};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

pub const ENDINGS: [&str; 4] = ["mp4", "mov", "mkv", "webm"];

/// Options of ffmpeg for each of [`ENDINGS`]: codecs, if not the default ones, and container. `+faststart` puts the
/// index first, as players expect. The options for VP9 make it as fast as H.264.
const CODECS: [&[&str]; 4] = [
    &["-c:a", "aac", "-movflags", "+faststart", "-f", "mp4"],
    &["-c:a", "aac", "-movflags", "+faststart", "-f", "mov"],
    &["-c:a", "aac", "-f", "matroska"],
    &["-deadline", "realtime", "-cpu-used", "6", "-row-mt", "1", "-crf", "32", "-b:v", "0", "-f", "webm"],
];

/// A video or folder being written under a temporary name, until [`Film::finish`].
pub struct Film {
    name: PathBuf,
    plan: Plan,
    way: Way,
    timeline: Timeline,
}

enum Way {
    /// ffmpeg (once started), output, options. Fields drop in order, so that ffmpeg ends before the file is removed.
    Video(Option<Ffmpeg>, Output, &'static [&'static str]),
    Pictures(Folder),
}

/// Settings of a film: the recording's sound, the frame number and the patience with ffmpeg.
#[derive(Clone, Debug)]
pub struct Plan {
    /// File with the sound, which is omitted if the recording's frames have no times.
    pub sound: Option<PathBuf>,
    /// Number of the next frame, for the names of pictures.
    pub number: usize,
    /// Longest time without a sign of life of ffmpeg, after which writing fails.
    pub patience: Duration,
}

impl Film {
    /// Begins the film `out`: a video if its extension is one of [`ENDINGS`], or a new folder for pictures if it has
    /// none or ends with `/`. Errors: `out` has another extension, or cannot be written.
    pub fn create(out: &Path, plan: Plan) -> Result<Self> {
        let extension = out.extension().filter(|_| !out.as_os_str().as_encoded_bytes().ends_with(b"/"));
        let extension = extension.and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
        let way = match ENDINGS.iter().position(|ending| *ending == extension) {
            Some(kind) => Way::Video(None, Output::create(out)?, CODECS[kind]),
            None if extension.is_empty() => Way::Pictures(Folder::create(out)?),
            None => bail!(
                "{}: expected a video that ends in .{}, or a folder (no ending, or a / after it)",
                out.display(),
                ENDINGS.join(", .")
            ),
        };
        Ok(Self { name: out.to_owned(), plan, way, timeline: Timeline::new() })
    }

    /// Adds a frame; `moment` is its time in the recording, if known. All frames must have the size of the first.
    pub fn frame(&mut self, overlay: &Overlay, moment: Option<Moment>) -> Result<()> {
        let (time, number) = (self.timeline.next(moment), self.plan.number);
        self.plan.number += 1;
        match &mut self.way {
            Way::Pictures(folder) => {
                folder.write(&format!("{number:05}.png"), &rgb_png(overlay.size(), overlay.rgb())?)
            }
            Way::Video(ffmpeg, output, codecs) => {
                let mut write = || {
                    let mut bytes = matroska::frame(time, overlay.rgb());
                    if ffmpeg.is_none() {
                        bytes = [matroska::head(overlay.size()), bytes].concat();
                        let file = output.path();
                        let file = file.context("a video cannot be written to a device or a pipe: expected a file")?;
                        let aspect = moment.map_or((1, 1), |moment| moment.aspect);
                        let command = command(&self.plan, &self.timeline, aspect, codecs);
                        *ffmpeg = Some(Ffmpeg::start(command, file, self.plan.patience)?);
                    }
                    ffmpeg.as_mut().map_or(Ok(()), |ffmpeg| ffmpeg.write(bytes))
                };
                write().with_context(|| cannot_write(&self.name))
            }
        }
    }

    pub fn finish(self) -> Result<()> {
        match self.way {
            Way::Pictures(folder) => folder.finish(),
            Way::Video(ffmpeg, output, _) => {
                ffmpeg.map_or(Ok(()), Ffmpeg::end).with_context(|| cannot_write(&self.name))?;
                output.finish()
            }
        }
    }
}

fn cannot_write(name: &Path) -> String {
    format!("cannot write {}", name.display())
}

fn command(plan: &Plan, timeline: &Timeline, aspect: (u32, u32), codecs: &[&str]) -> Command {
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-f", "matroska", "-i", "-"]);
    if let Some((recording, start)) = plan.sound.as_deref().zip(timeline.start()) {
        command.args(["-ss", &format!("{start:.6}"), "-i"]).arg(ffmpeg_input(recording));
        // `apad` appends silence to the sound, so that `-shortest` cuts the sound and never the picture.
        command.args(["-map", "0:v", "-map", "1:a:0?", "-af", "apad", "-shortest"]);
    }
    command.args(["-fps_mode", "passthrough"]);
    // Players expect chroma at half the resolution, which requires even sides, and the color space BT.709.
    let even = "pad=ceil(iw/2)*2:ceil(ih/2)*2";
    let filter = format!("{even},setsar={}/{},scale=out_color_matrix=bt709", aspect.0, aspect.1);
    command.args(["-vf", &filter, "-pix_fmt", "yuv420p"]);
    command.args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"]);
    let base = timeline.base();
    command.args(["-enc_time_base", &format!("{}:{}", base.0, base.1)]).args(codecs);
    command
}

/// Timestamps of a video's frames: those of the recording or, if the recording has none, one every 1/25 second.
struct Timeline {
    is_begun: bool,
    first: Option<Moment>,
    /// Time of the last frame in microseconds; `interval` is the time between it and the frame before.
    last: u64,
    interval: u64,
}

impl Timeline {
    const fn new() -> Self {
        Self { is_begun: false, first: None, last: 0, interval: 40_000 }
    }

    /// Returns the time of the next frame, in microseconds from the first one.
    fn next(&mut self, moment: Option<Moment>) -> u64 {
        if !self.is_begun {
            (self.is_begun, self.first) = (true, moment);
            return 0;
        }
        let time = match (self.first, moment) {
            (Some(first), Some(moment)) => microseconds(moment.seconds() - first.seconds()),
            _ => self.last + self.interval,
        };
        // Times must increase, even if a damaged recording's do not.
        self.interval = time.saturating_sub(self.last).max(1);
        self.last += self.interval;
        self.last
    }

    /// Returns the time base of the recording as a fraction of a second: numerator and denominator.
    fn base(&self) -> (u32, u32) {
        self.first.map_or((1, 25), |first| first.base)
    }

    fn start(&self) -> Option<f64> {
        self.first.map(|first| first.seconds())
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::of_target;
    use smr_recordings::{BoundingBox, GrayFrame, decode_colors};
    use std::fs;

    fn plan() -> Plan {
        Plan { sound: None, number: 1, patience: Duration::from_secs(60) }
    }

    /// Frames with odd sides, which MP4 cannot have.
    fn frames() -> impl Iterator<Item = Overlay> {
        (0..3u8).map(|step| {
            let pixels = (0..61 * 43).map(|at: u32| at.to_le_bytes()[0] / 2).collect();
            let mut overlay = Overlay::new((&GrayFrame { width: 61, height: 43, pixels }).into());
            overlay
                .outline(&BoundingBox { x: f64::from(step) + 10.0, y: 15.0, width: 20.0, height: 12.0 }, of_target(1));
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
            let read = decode_colors(&png).unwrap();
            assert_eq!(
                ((read.width.into(), read.height.into()), read.pixels.as_flattened()),
                (frame.size(), frame.rgb())
            );
        }
    }

    #[test]
    fn a_video_is_decoded_again() {
        let above = tempfile::tempdir().unwrap();
        if !crate::missing::has_ffmpeg("a_video_is_decoded_again") {
            return;
        }
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

    #[test]
    fn times_of_frames_are_kept() {
        let at = |time| Some(Moment { time, base: (1, 1000), aspect: (1, 1) });
        let mut timeline = Timeline::new();
        let times = [at(500), at(533), at(600), None, at(590), at(700)].map(|moment| timeline.next(moment));
        assert_eq!(times, [0, 33_000, 100_000, 167_000, 167_001, 200_000]);
        assert_eq!((timeline.base(), timeline.start()), ((1, 1000), Some(0.5)));
        let mut unknown = Timeline::new();
        assert_eq!([None, at(5), None].map(|moment| unknown.next(moment)), [0, 40_000, 80_000]);
        assert_eq!((unknown.base(), unknown.start()), ((1, 25), None));
    }
}
