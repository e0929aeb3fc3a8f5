//! Writes frames with boxes drawn on them as a video (through ffmpeg) or as a folder of PNG pictures.

use super::ffmpeg::{self, Encoder};
use super::matroska;
use super::overlay::Overlay;
use super::read_back;
use super::sound::{Added, Codec, Sound};
use crate::encode::rgb_png;
use anyhow::{Context, Result, bail};
use smr_files::output::{Folder, Output};
use smr_recordings::Moment;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

pub const ENDINGS: [&str; 4] = ["mp4", "mov", "mkv", "webm"];

/// Options of ffmpeg for a kind of video.
#[derive(Clone, Copy)]
struct Kind {
    /// Codec of the pictures, if not the default one.
    images: &'static [&'static str],
    sound: Codec,
    container: &'static [&'static str],
}

const AAC: Codec =
    Codec { options: &["-c:a", "aac"], takes: "aformat=channel_layouts=mono|stereo|3.0|4.0|5.0|5.1|7.1" };
const OPUS: Codec = Codec { options: &[], takes: "aformat=channel_layouts=mono|stereo|3.0|quad|5.0|5.1|6.1|7.1" };
/// For Matroska, which does not say how much of its first and last frame AAC has added. The last frame of FLAC must have
/// 16 samples, so that silence is added up to a multiple of 64.
const FLAC: Codec = Codec {
    options: &["-c:a", "flac"],
    takes: "aformat=channel_layouts=mono|stereo|3.0|quad|5.0|5.1|6.1|7.1:sample_fmts=s16,asetnsamples=64",
};

/// Gives each frame without a duration that of the one before it. ffmpeg 5.1 knows no durations of the frames of a film of
/// one or two, which would end when its last frame begins, so that players omit this frame.
const DURATIONS: &str = "setts=pts=PTS:dts=DTS:duration='if(DURATION,DURATION,if(N,DTS-PREV_OUTDTS,1))'";

/// The kind of each of [`ENDINGS`]. `+faststart` puts the index first, as players expect. The options for VP9 make it as
/// fast as H.264.
const KINDS: [Kind; 4] = [
    Kind { images: &[], sound: AAC, container: &["-movflags", "+faststart", "-f", "mp4"] },
    Kind { images: &[], sound: AAC, container: &["-movflags", "+faststart", "-f", "mov"] },
    Kind { images: &[], sound: FLAC, container: &["-f", "matroska"] },
    Kind {
        images: &["-deadline", "realtime", "-cpu-used", "6", "-row-mt", "1", "-crf", "32", "-b:v", "0"],
        sound: OPUS,
        container: &["-f", "webm"],
    },
];

/// A video or folder being written under a temporary name, until [`VideoWriter::finish`].
pub struct VideoWriter {
    name: PathBuf,
    plan: Plan,
    way: Way,
    timeline: Timeline,
}

enum Way {
    /// ffmpeg (once started), output, kind. Fields drop in order, so that ffmpeg ends before the file is removed.
    Video(Option<Encoder>, Output, Kind),
    Images(Folder),
}

/// Settings of a film: the recording's sound, the frame number and the patience with ffmpeg.
#[derive(Clone, Debug)]
pub struct Plan {
    /// File with the sound, which is omitted if the recording's frames have no times.
    pub sound: Option<PathBuf>,
    /// True if the video ends before the recording does; its sound then ends with its last frame.
    pub is_cut: bool,
    /// Number of the next frame, for the names of pictures.
    pub number: usize,
    /// Longest time without a sign of life of ffmpeg, after which writing fails.
    pub patience: Duration,
}

impl VideoWriter {
    /// Begins the video `out`: a video if its extension is one of [`ENDINGS`], or a new folder for pictures if it has
    /// none or ends with `/`. Errors: `out` has another extension, or cannot be written.
    pub fn create(out: &Path, plan: Plan) -> Result<Self> {
        let extension = out.extension().filter(|_| !out.as_os_str().as_encoded_bytes().ends_with(b"/"));
        let extension = extension.and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
        let way = match ENDINGS.iter().position(|ending| *ending == extension) {
            Some(kind) => Way::Video(None, Output::create(out)?, KINDS[kind]),
            None if extension.is_empty() => Way::Images(Folder::create(out)?),
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
            Way::Images(folder) => folder.write(&format!("{number:05}.png"), &rgb_png(overlay.size(), &overlay.rgb())?),
            Way::Video(encoder, output, kind) => {
                let mut write = || {
                    let mut bytes = matroska::frame((time, self.timeline.interval), &overlay.rgb());
                    if encoder.is_none() {
                        bytes = [matroska::head(overlay.size()), bytes].concat();
                        let file = output.path();
                        let file = file.context("a video cannot be written to a device or a pipe: expected a file")?;
                        let aspect = moment.map_or((1, 1), |moment| moment.aspect);
                        let command = command(&self.timeline, aspect, *kind);
                        *encoder = Some(Encoder::start(command, file, self.plan.patience)?);
                    }
                    encoder.as_ref().map_or(Ok(()), |encoder| encoder.write(bytes))
                };
                write().with_context(|| cannot_write(&self.name))
            }
        }
    }

    /// Ends the film. Returns a note if it has no sound, although the recording has.
    pub fn finish(self) -> Result<Option<String>> {
        let Self { name, plan, way, timeline } = self;
        match way {
            Way::Images(folder) => folder.finish().map(|()| None),
            Way::Video(encoder, output, kind) => {
                let end = || {
                    encoder.context("there is no frame")?.end()?;
                    ended(&name, &plan, &timeline, output, kind)
                };
                let (output, note) = end().with_context(|| cannot_write(&name))?;
                output.finish()?;
                Ok(note.map(|why| format!("{} has no sound: {why}", name.display())))
            }
        }
    }
}

/// Returns the whole video: with sound if the recording has any, or else with the reason why not.
fn ended(
    name: &Path,
    plan: &Plan,
    timeline: &Timeline,
    output: Output,
    kind: Kind,
) -> Result<(Output, Option<String>)> {
    let (patience, frames) = (plan.patience, timeline.frames);
    let images = output.path().context("a video is a file")?;
    let mut note = None;
    if let Some((recording, start)) = plan.sound.clone().zip(timeline.start()) {
        let sound = Sound { recording, start, length: plan.is_cut.then(|| timeline.length()) };
        let whole = Output::create(name)?;
        let file = whole.path().context("a video is a file")?;
        match sound.add((images, frames), file, (kind.sound, kind.container), patience)? {
            Added::Sound => return Ok((whole, None)),
            Added::NoStream => {}
            Added::Unreadable(why) => note = Some(why),
        }
    }
    read_back::check(images, frames, patience)?;
    Ok((output, note))
}

fn cannot_write(name: &Path) -> String {
    format!("cannot write {}", name.display())
}

fn command(timeline: &Timeline, aspect: (u32, u32), kind: Kind) -> Command {
    let mut command = ffmpeg::command();
    command.args(["-f", "matroska", "-i", "-", "-fps_mode", "passthrough"]);
    // Players expect chroma at half the resolution, which requires even sides, and the color space BT.709.
    let even = "pad=ceil(iw/2)*2:ceil(ih/2)*2";
    let filter = format!("{even},setsar={}/{},scale=out_color_matrix=bt709", aspect.0, aspect.1);
    command.args(["-vf", &filter, "-pix_fmt", "yuv420p"]);
    command.args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"]);
    let base = timeline.base();
    command.args(["-enc_time_base", &format!("{}:{}", base.0, base.1)]);
    command.args(["-bsf:v", DURATIONS]).args(kind.images).args(kind.container);
    command
}

/// Timestamps of a video's frames: those of the recording or, if the recording has none, one every 1/25 second.
struct Timeline {
    frames: usize,
    first: Option<Moment>,
    /// Time of the last frame in microseconds; `interval` is the time between it and the frame before.
    last: u64,
    interval: u64,
}

impl Timeline {
    const fn new() -> Self {
        Self { frames: 0, first: None, last: 0, interval: 40_000 }
    }

    /// Returns the time of the next frame, in microseconds from the first one.
    fn next(&mut self, moment: Option<Moment>) -> u64 {
        self.frames += 1;
        if self.frames == 1 {
            self.first = moment;
            return 0;
        }
        let time = match (self.first, moment) {
            (Some(first), Some(moment)) => microseconds(moment.seconds() - first.seconds()),
            _ => self.last + self.interval,
        };
        // Times must increase, even if a damaged recording's do not: ffmpeg refuses two frames of one time.
        let (unit, second) = self.base();
        let least = (u64::from(unit) * 1_000_000).div_ceil(second.into()).max(1);
        self.interval = time.saturating_sub(self.last).max(least);
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

    /// Returns the length in seconds, if the last frame is shown as long as the one before it.
    fn length(&self) -> f64 {
        Duration::from_micros(self.last + self.interval).as_secs_f64()
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
        Plan { sound: None, is_cut: false, number: 1, patience: Duration::from_secs(60) }
    }

    /// Frames with odd sides, which MP4 cannot have.
    fn frames(count: u8) -> impl Iterator<Item = Overlay> {
        (0..count).map(|step| {
            let pixels = (0..61 * 43).map(|at: u32| at.to_le_bytes()[0] / 2).collect();
            let mut overlay = Overlay::new(&(&GrayFrame { width: 61, height: 43, pixels }).into()).unwrap();
            let target = BoundingBox { x: f64::from(step) + 10.0, y: 15.0, width: 20.0, height: 12.0 };
            overlay.outline(&target, of_target(1), false);
            overlay
        })
    }

    fn filmed(out: &Path, count: u8) {
        let mut film = VideoWriter::create(out, plan()).unwrap();
        for frame in frames(count) {
            film.frame(&frame, None).unwrap();
            assert!(!out.exists());
        }
        film.finish().unwrap();
    }

    #[test]
    fn a_folder_holds_the_pixels() {
        let above = tempfile::tempdir().unwrap();
        let out = above.path().join("film.7/");
        filmed(&out, 3);
        for (number, frame) in (1..).zip(frames(3)) {
            let png = fs::read(out.join(format!("{number:05}.png"))).unwrap();
            let read = decode_colors(&png).unwrap();
            assert_eq!(
                ((read.width.into(), read.height.into()), read.pixels.as_flattened()),
                (frame.size(), &frame.rgb()[..])
            );
        }
    }

    #[test]
    fn a_video_is_decoded_again() {
        let above = tempfile::tempdir().unwrap();
        if !crate::missing::has_ffmpeg("a_video_is_decoded_again") {
            return;
        }
        for (ending, count) in ENDINGS.iter().flat_map(|ending| (1..=3).map(move |count| (ending, count))) {
            let name = format!("film{count}.{ending}");
            let out = above.path().join(&name);
            filmed(&out, count);
            let sequence = smr_recordings::open(&out, &smr_recordings::OpenOptions::default()).unwrap();
            let sizes: Vec<_> =
                sequence.frames.map(|frame| frame.unwrap().gray).map(|gray| (gray.width, gray.height)).collect();
            assert_eq!(sizes, vec![(62, 44); count.into()], "{name}");
        }
    }

    #[test]
    fn what_breaks_off_or_is_unknown_leaves_nothing() {
        let above = tempfile::tempdir().unwrap();
        let mut film = VideoWriter::create(&above.path().join("film"), plan()).unwrap();
        film.frame(&frames(1).next().unwrap(), None).unwrap();
        drop(film);
        let error = VideoWriter::create(&above.path().join("film.avi"), plan()).err().unwrap().to_string();
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
        assert_eq!(times, [0, 33_000, 100_000, 167_000, 168_000, 200_000]);
        assert_eq!((timeline.base(), timeline.start()), ((1, 1000), Some(0.5)));
        let mut unknown = Timeline::new();
        assert_eq!([None, at(5), None].map(|moment| unknown.next(moment)), [0, 40_000, 80_000]);
        assert_eq!((unknown.base(), unknown.start()), ((1, 25), None));
    }
}
