//! Decodes videos by ffmpeg, picture by picture, each with its time.
//!
//! Gray pixels are those of `ffmpeg -i FILE -pix_fmt gray -fps_mode passthrough -f rawvideo -`; `showinfo` has times.

use super::tones::Tones;
use super::{Ffmpeg, Moment, Shown, command, input};
use crate::input::Patient;
use crate::{ColorFrame, Frame, GrayFrame, MOST_PIXELS, has_extension};
use anyhow::{Context, Result};
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::time::Duration;

/// Extensions that mark a video in a folder. A file that the user names goes to ffmpeg whatever its extension.
const EXTENSIONS: [&str; 22] = [
    "mpg", "mpeg", "mp4", "m4v", "mov", "avi", "mkv", "webm", "wmv", "flv", "ts", "mts", "m2ts", "ogv", "3gp", "m1v",
    "m2v", "h264", "h265", "hevc", "ivf", "mjpeg",
];

pub(crate) fn is_video(file: &Path) -> bool {
    has_extension(file, &EXTENSIONS)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Use {
    Gray,
    /// Color frames for display, scaled down to at most this many pixels on a side.
    Color(u16),
    Times,
}

/// Returns all pictures of a file, then an error if ffmpeg reports damage. Errors: No ffmpeg, or no picture.
pub(crate) fn open(
    program: &str,
    file: &Path,
    wanted: Use,
    patience: Duration,
) -> Result<impl Iterator<Item = Result<Picture>> + use<>> {
    let name = file.display().to_string();
    // With several threads, ffmpeg fills damaged areas with different pixels in each run.
    let options = if wanted == Use::Times { &[][..] } else { &["-threads", "1"] };
    let cannot_read = || format!("cannot read {name} through ffmpeg");
    let mut pictures = Pictures::start((program, file), options, "", wanted, patience)?;
    let mut first = pictures.next().with_context(cannot_read)?;
    if first.is_none() {
        pictures.ffmpeg.no_frame()?;
    }
    let (mut number, mut is_over) = (0, false);
    Ok(std::iter::from_fn(move || {
        if is_over {
            return None;
        }
        number += 1;
        let next = match first.take().map_or_else(|| pictures.next(), |first| Ok(Some(first))) {
            Ok(Some(picture)) => return Some(Ok(picture)),
            Ok(None) => pictures.verdict().err(),
            Err(error) => Some(error.context(format!("{name}, frame {number}"))),
        };
        is_over = true;
        next.map(Err)
    }))
}

/// Returns the pictures of a file up to the first error.
pub(crate) fn good(file: &Path, wanted: Use, patience: Duration) -> impl Iterator<Item = Picture> + use<> {
    open("ffmpeg", file, wanted, patience).into_iter().flatten().map_while(Result::ok)
}

pub(crate) struct Picture {
    size: (u16, u16),
    pub moment: Option<Moment>,
    bytes: Vec<u8>,
    /// True if ffmpeg has reported an error, a damaged packet or a change of format before this picture.
    pub is_doubtful: bool,
}

impl Picture {
    pub fn seconds(&self) -> Option<f64> {
        self.moment.map(|moment| moment.seconds())
    }

    pub fn gray(self, number: usize) -> Frame {
        let (seconds, (width, height)) = (self.seconds(), self.size);
        Frame::new(number, seconds, GrayFrame { width, height, pixels: self.bytes })
    }

    pub fn color(self) -> (ColorFrame, Option<Moment>) {
        let (width, height) = self.size;
        (ColorFrame { width, height, pixels: self.bytes.as_chunks().0.to_vec() }, self.moment)
    }
}

pub(crate) struct Pictures {
    ffmpeg: Ffmpeg,
    pixels: Patient,
    /// Size, time and flags of the next picture; `None` if not read yet.
    shown: Option<Shown>,
    tones: Option<Tones>,
    depth: usize,
    times: Continued,
}

/// ffmpeg options that count times from the start of the file, also after a seek.
pub(crate) const FROM_ZERO: [&str; 2] = ["-copyts", "-start_at_zero"];

/// Time error in seconds from which a seek is a miss; rounding to milliseconds alone causes errors of up to 0.0005 s.
const SEEK_TOLERANCE: f64 = 0.0006;

impl Pictures {
    /// Starts ffmpeg on a file; `filters` run before all other filters.
    fn start(
        (program, file): (&str, &Path),
        options: &[&str],
        filters: &str,
        wanted: Use,
        patience: Duration,
    ) -> Result<Self> {
        // If the frame size changed, ffmpeg would silently scale the frames; with `-reinit_filter 0` it at least warns.
        let options = [&FROM_ZERO, &["-reinit_filter", "0"], options].concat();
        let (scale, format, depth) = match wanted {
            Use::Gray => (String::new(), "gray", 1),
            Use::Color(side) => {
                (format!("scale='min({side},iw)':'min({side},ih)':force_original_aspect_ratio=decrease,"), "rgb24", 3)
            }
            Use::Times => ("scale=1:1:flags=neighbor,".to_owned(), "gray", 1),
        };
        let start = |format, depth| -> Result<Self> {
            let mut command = command(program, "level+info", &input(file), &options);
            // `showinfo` prints the times; `setpts` then makes them ascend: ffmpeg drops a frame whose time goes back.
            let filters = format!("{filters}{scale}format={format},showinfo=checksum=0,setpts=N*1000/TB");
            command.args(["-vf", &filters, "-fps_mode", "passthrough", "-f", "rawvideo", "-"]);
            let mut ffmpeg = Ffmpeg::run(&mut command, &file.display().to_string(), patience)?;
            Ok(Self { pixels: ffmpeg.output(), ffmpeg, shown: None, tones: None, depth, times: Continued::default() })
        };
        let mut pictures = start(format, depth)?;
        if matches!(wanted, Use::Color(_)) {
            pictures.shown = pictures.ffmpeg.shown()?;
            if let Some(transfer) = pictures.shown.as_ref().and_then(|shown| shown.transfer) {
                pictures = Self { tones: Some(Tones::of(transfer)), ..start("rgb48le", 6)? };
            }
        }
        Ok(pictures)
    }

    /// Seeks the picture shown at `time`, in seconds; returns it and all later ones, or `None` if the seek misses it.
    pub fn at(file: &Path, time: f64, wanted: Use, patience: Duration) -> Option<(Picture, Self)> {
        let select = format!("select='gte(t,{:.6})',", time - SEEK_TOLERANCE / 2.0);
        // Seeks 0.1 ms before `time`; after a miss, 10 s before: some files cannot be decoded from just before it.
        [0.0001, 10.0].iter().find_map(|before| {
            let seek = format!("{:.6}", (time - before).max(0.0));
            let mut pictures = Self::start(("ffmpeg", file), &["-ss", &seek], &select, wanted, patience).ok()?;
            let first = pictures.next().ok()??;
            first.seconds().is_some_and(|found| (found - time).abs() < SEEK_TOLERANCE).then_some((first, pictures))
        })
    }

    pub fn next(&mut self) -> Result<Option<Picture>> {
        let shown = self.shown.take().map_or_else(|| self.ffmpeg.shown(), |shown| Ok(Some(shown)))?;
        let Some(Shown { size: (width, height), moment, is_doubtful, .. }) = shown else { return Ok(None) };
        let sides = u16::try_from(width).ok().zip(u16::try_from(height).ok());
        let size = sides.filter(|_| u64::from(width) * u64::from(height) <= MOST_PIXELS);
        let size = size.with_context(|| {
            format!("it is {width}x{height}: expected sides of at most 65535 and at most {MOST_PIXELS} pixels")
        })?;
        let mut bytes = vec![0; usize::from(size.0) * usize::from(size.1) * self.depth];
        match self.pixels.read_exact(&mut bytes) {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
            other => other?,
        }
        let bytes = self.tones.as_ref().map(|tones| tones.of_all(&bytes)).unwrap_or(bytes);
        let second = |Moment { base: (unit, second), .. }| i64::from(second.div_ceil(unit));
        let moment = moment.map(|moment| Moment { time: self.times.next(moment.time, second(moment)), ..moment });
        Ok(Some(Picture { size, moment, bytes, is_doubtful }))
    }

    /// Returns an error if ffmpeg has failed, or has reported damage or a change of format. A damaged packet counts as
    /// damage only if frames are missing.
    pub fn verdict(&mut self) -> Result<()> {
        self.ffmpeg.verdict(self.times.has_gap)
    }
}

/// Largest step in seconds between the times of successive frames of one video. A larger step is a join of two videos:
/// where times go back in MPEG-TS, ffmpeg assumes a clock overflow and turns this into a large step forward.
pub(crate) const MAX_TIME_JUMP: u32 = 43_200;

/// Times that never go back: in a file of joined videos, each video continues the times of the one before.
#[derive(Default)]
struct Continued {
    last: Option<i64>,
    step: i64,
    /// Offset added to the times of the file, in their unit.
    shift: i64,
    /// True after a gap of over 1.5 frame intervals but under a second; a longer gap may be a join of two videos.
    has_gap: bool,
}

impl Continued {
    /// Returns `time` continued over joined videos; `second` is one second in the unit of `time`.
    fn next(&mut self, time: i64, second: i64) -> i64 {
        let mut now = time + self.shift;
        if let Some(last) = self.last {
            // A step back by less than `step`, the frame interval, is a wrong time stamp, not the start of a video.
            if now <= last - self.step || now - last > i64::from(MAX_TIME_JUMP) * second {
                now = last + self.step;
                self.shift = now - time;
            }
            self.has_gap |= self.step > 0 && 2 * (now - last) > 3 * self.step && now - last < second;
            now = now.max(last);
            self.step = if now > last { now - last } else { self.step };
        }
        self.last = Some(now);
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FFMPEG_PATIENCE as PATIENCE;

    #[test]
    fn a_missing_ffmpeg_is_asked_for() {
        let error = open("no-such-ffmpeg", Path::new("a.mp4"), Use::Gray, PATIENCE).err().unwrap();
        assert_eq!(
            format!("{error:#}"),
            "a.mp4 needs ffmpeg to be decoded, and there is none on the PATH: install the package `ffmpeg` (5.1 or later)"
        );
    }

    #[cfg(unix)]
    fn program(folder: &Path, script: &str) -> String {
        use std::os::unix::fs::PermissionsExt;
        let file = folder.join("ffmpeg");
        std::fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
        file.to_str().unwrap().to_owned()
    }

    #[cfg(unix)]
    #[test]
    fn a_hanging_ffmpeg_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let short = Duration::from_millis(300);
        let frame = "echo '[Parsed_showinfo_1 @ 0x5] [info] n: 0 pts: 0 s:2x1' >&2; printf ab";
        let begin = std::time::Instant::now();
        let silent = "ffmpeg has done nothing for 0.3 s (--ffmpeg-timeout)";

        let never = program(folder.path(), "exec sleep 60");
        let error = format!("{:#}", open(&never, Path::new("a.mp4"), Use::Gray, short).err().unwrap());
        assert_eq!(error, format!("cannot read a.mp4 through ffmpeg: {silent}"));
        for then in ["", "exec >&-;"] {
            let stops = program(folder.path(), &format!("{frame}; {then} exec sleep 60"));
            let mut frames = open(&stops, Path::new("a.mp4"), Use::Gray, short).unwrap();
            assert!(frames.next().unwrap().is_ok());
            assert_eq!(format!("{:#}", frames.next().unwrap().err().unwrap()), format!("a.mp4, frame 2: {silent}"));
        }
        assert!(begin.elapsed() < Duration::from_secs(30));
    }

    /// The test picture, at half of the signal range, shows 92 cd/m2 in PQ (ITU-R BT.2100), and 51 cd/m2 in HLG.
    #[test]
    fn light_of_more_than_a_screen_has_is_mapped_to_what_it_has() {
        let test = "light_of_more_than_a_screen_has_is_mapped_to_what_it_has";
        if !crate::missing::has_ffmpeg(test) {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        for (transfer, shown) in [("bt709", 128), ("smpte2084", 153), ("arib-std-b67", 124)] {
            let file = folder.path().join(format!("{transfer}.mkv"));
            let colors = format!("-color_trc {transfer} -color_primaries bt2020 -colorspace bt2020nc");
            let input = "-f lavfi -i color=gray:size=32x16:duration=0.1 -c:v ffv1 -pix_fmt yuv420p10le";
            assert!(crate::tests::ffmpeg(&format!("{input} {colors}"), &file));
            let (frame, _) = good(&file, Use::Color(16), PATIENCE).next().unwrap().color();
            let apart = frame.pixels[70].map(|level| level.abs_diff(shown)).into_iter().max();
            assert!((frame.width, frame.height) == (16, 8) && apart <= Some(4), "{transfer}: {:?}", frame.pixels[70]);
            assert!(good(&file, Use::Gray, PATIENCE).next().unwrap().bytes[70].abs_diff(128) <= 2);
        }
    }

    #[test]
    fn times_go_on_where_a_file_begins_anew() {
        let mut times = Continued::default();
        let found = [0, 40, 80, 0, 40, 40, 30, 5000, 50_000_000].map(|time| times.next(time, 1000));
        assert_eq!((found, times.has_gap), ([0, 40, 80, 120, 160, 160, 160, 5120, 10_080], false));
        assert_eq!((times.next(50_000_040, 1000), times.next(50_000_120, 1000), times.has_gap), (10_120, 10_200, true));
    }
}
