//! A recording that is read from any of its frames on.

use super::frame_times::Index;
use super::video::{Picture, Pictures, Use};
use super::{BUILT_IN, ColorFrame, Colors, GrayFrame, OpenOptions, Sequence, images, open, y4m};
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A recording, and the index of its frames.
///
/// Pictures and Y4M are read by their numbers, videos from the nearest place where ffmpeg can begin, if each frame that comes from there is
/// at its time in the index. If it is not, or ffmpeg complains, the video is read from its beginning, as raw dumps are.
pub struct Seekable {
    path: PathBuf,
    options: OpenOptions,
    colors: Colors,
    length: Option<usize>,
    index: Arc<Index>,
}

/// Frames in gray, each with its time in seconds if it has one.
pub type Timed = Box<dyn Iterator<Item = Result<(GrayFrame, Option<f64>)>> + Send>;

impl Seekable {
    /// Opens the recording at `path`, and also gives it as it is read in order.
    /// Errors: Those of [`open`].
    pub fn open(path: &Path, options: &OpenOptions) -> Result<(Self, Sequence)> {
        let sequence = open(path, options)?;
        let index = sequence.colors.video().map_or_else(Index::unknown, |file| Index::of(file, options.patience()));
        let (colors, length) = (sequence.colors.clone(), sequence.length);
        Ok((Self { path: path.to_owned(), options: options.clone(), colors, length, index }, sequence))
    }

    /// The number of frames, and the time of each in seconds, once both are known. A recording may know no times.
    pub fn known(&self) -> (Option<usize>, Vec<f64>) {
        self.index.times().map_or_else(|| (self.length, Vec::new()), |times| (Some(times.len()), times))
    }

    /// The gray frames from `number` on.
    /// Errors: The recording cannot be read.
    pub fn gray_from(&self, number: usize) -> Result<Timed> {
        match &self.colors {
            Colors::Pictures(files) => {
                let rest = files.get(number - 1..).unwrap_or_default();
                Ok(Box::new(images::frames(rest.to_owned(), number).map(|frame| Ok((frame?, None)))))
            }
            Colors::Video(file, _) if number > 1 => {
                if y4m::is_y4m(file) {
                    return Ok(Box::new(y4m::open(file)?.from(number as u64)));
                }
                let (path, options) = (self.path.clone(), self.options.clone());
                let rest = move |number| match read_through(&path, &options, number) {
                    Ok(rest) => rest,
                    Err(error) => Box::new(std::iter::once(Err(error))),
                };
                Ok(Box::new(self.sought(file, number, Use::Gray, |picture| Ok(picture.gray()), rest)))
            }
            _ => read_through(&self.path, &self.options, number),
        }
    }

    /// The frames from `number` on in their colors, no side of a frame of a video longer than `side`. They end where nothing more can be read.
    /// Errors: The recording cannot be read.
    pub fn color_from(&self, number: usize, side: u16) -> Result<Box<dyn Iterator<Item = ColorFrame> + Send>> {
        Ok(match &self.colors {
            Colors::Video(file, _) if number > 1 => {
                let (colors, patience) = (self.colors.clone(), self.options.patience());
                let rest = move |number| Box::new(colors.within(number, side, patience)) as Box<_>;
                Box::new(self.sought(file, number, Use::Color(side), |picture| picture.color().0, rest))
            }
            Colors::None | Colors::Live(_) => {
                Box::new(self.gray_from(number)?.map_while(Result::ok).map(|(frame, _)| (&frame).into()))
            }
            colors => Box::new(colors.clone().within(number, side, self.options.patience())),
        })
    }

    /// The frames of a video from `number` on: sought, as long as each is at its time and nothing is wrong with it, then those of `rest` from
    /// the next number on.
    fn sought<T, R: FnOnce(usize) -> Box<dyn Iterator<Item = T> + Send>>(
        &self,
        file: &Path,
        mut number: usize,
        wanted: Use,
        take: fn(Picture) -> T,
        rest: R,
    ) -> impl Iterator<Item = T> + use<T, R> {
        let index = Arc::clone(&self.index);
        let time = index.sought(number);
        let (first, mut pictures) =
            time.and_then(|time| Pictures::at(file, time, wanted, self.options.patience())).unzip();
        let (mut first, mut rest, mut others) = (first, Some(rest), None);
        std::iter::from_fn(move || {
            if let Some(sought) = &mut pictures {
                let picture = first.take().or_else(|| sought.next().ok()?);
                let is_end = picture.is_none();
                match picture.filter(|picture| !picture.is_doubtful && index.has(number, picture.seconds())) {
                    Some(picture) => {
                        number += 1;
                        return Some(take(picture));
                    }
                    None if is_end && index.ends_before(number) && sought.verdict().is_ok() => return None,
                    None => pictures = None,
                }
            }
            if let Some(rest) = rest.take() {
                others = Some(rest(number));
            }
            others.as_mut()?.next()
        })
    }
}

fn read_through(path: &Path, options: &OpenOptions, number: usize) -> Result<Timed> {
    let Sequence { frames, colors, .. } = open(path, options)?;
    let mut clock = colors.clock(number);
    Ok(Box::new(frames.skip(number - 1).map(move |frame| Ok((frame?, clock.tick().1)))))
}

/// True if frames of `path` can be read again and again: not standard input, a pipe or a device.
pub fn is_seekable(path: &Path) -> bool {
    BUILT_IN.iter().any(|name| path == Path::new(name)) || path.is_file() || path.is_dir()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FFMPEG_PATIENCE, missing, synthetic};
    use std::process::Command;

    fn gray(recording: &Seekable, number: usize) -> GrayFrame {
        recording.gray_from(number).unwrap().next().unwrap().unwrap().0
    }

    #[test]
    fn pictures_and_made_frames_are_read_from_any_place_on() {
        let names: Vec<String> = (1..=12).map(|number| format!("{number}.png")).collect();
        let folder = crate::tests::folder(&names.join(" "));
        let (recording, sequence) = Seekable::open(folder.path(), &OpenOptions::default()).unwrap();
        assert_eq!((recording.known(), sequence.frames.count()), ((Some(12), vec![]), 12));
        assert_eq!((gray(&recording, 1).pixels[0], gray(&recording, 11).pixels[0]), (1, 11));
        assert_eq!(recording.color_from(12, 100).unwrap().map(|frame| frame.pixels[0]).collect::<Vec<_>>(), [[12; 3]]);
        assert_eq!(recording.color_from(13, 100).unwrap().count() + recording.gray_from(13).unwrap().count(), 0);
        std::fs::write(folder.path().join("9.png"), "P6 4 2 255\n").unwrap();
        let error = format!("{:#}", recording.gray_from(8).unwrap().nth(1).unwrap().unwrap_err());
        assert!(error.contains("9.png (frame 9)"), "{error}");
        let (recording, _) = Seekable::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        assert_eq!(gray(&recording, 100), synthetic::frame(99));
    }

    /// A file of this name in the folder, of 30 frames made with such options; twice in a row if the name says so. `None` if this ffmpeg cannot
    /// write it.
    fn made(folder: &Path, name: &str, options: &str) -> Option<PathBuf> {
        let (file, mut ffmpeg) = (folder.join(name), Command::new("ffmpeg"));
        ffmpeg.args(["-nostdin", "-v", "error", "-f", "lavfi", "-i", "testsrc2=size=64x48:rate=10:duration=3"]);
        ffmpeg.args(["-f", "lavfi", "-i", "testsrc=size=96x64:rate=5:duration=3"]);
        ffmpeg.args(if options.contains("-map") { &[][..] } else { &["-map", "0:v"] });
        missing::runs(ffmpeg.args(options.split_whitespace()).arg(&file)).then_some(())?;
        if name.starts_with("joined") {
            std::fs::write(&file, std::fs::read(&file).unwrap().repeat(2)).unwrap();
        }
        Some(file)
    }

    const H264: &str = "-c:v libx264 -g 10 -bf 3 -flags +cgop -preset ultrafast";

    /// Each kind of file, with options, the number of frames, the time of the 12th, and true if its frames are sought.
    #[test]
    fn a_video_is_read_from_any_place_on() {
        let test = "a_video_is_read_from_any_place_on";
        if !missing::has_ffmpeg(test) {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let h264 = |options: &str| format!("{H264} {options}");
        for (name, options, count, time, is_sought) in [
            ("a.mp4", h264(""), 30, 1.1, true),
            ("varying.mkv", h264("-vf select=not(mod(n\\,3))+not(mod(n\\,7)) -fps_mode vfr"), 13, 2.7, true),
            ("from-1.4.ts", h264(""), 30, 1.1, true),
            ("open.mkv", h264("-x264-params open-gop=1"), 30, 1.1, true),
            ("a.mpg", "-c:v mpeg2video -bf 2 -g 6 -r 25".to_owned(), 75, 0.44, false),
            ("vp8.webm", "-c:v libvpx -deadline realtime -auto-alt-ref 1 -lag-in-frames 16".to_owned(), 30, 1.1, true),
            ("a.webm", "-c:v libvpx-vp9 -deadline realtime -cpu-used 8 -lag-in-frames 16".to_owned(), 30, 1.1, true),
            ("a.y4m", String::new(), 30, 1.1, true),
            ("large-second.ts", h264("-map 0:v -map 1:v"), 15, 2.2, true),
            ("sent.avi", h264(""), 30, 1.3, false),
            ("some.avi", "-c:v mpeg4 -bf 2 -g 10".to_owned(), 30, 1.2, false),
            ("raw.h264", h264(""), 30, 1.1, false),
            ("a.gif", String::new(), 30, 1.1, false),
            ("same.mkv", h264("-vf setpts='floor(N/2)/5/TB' -fps_mode passthrough -enc_time_base -1"), 30, 1.0, false),
            ("joined.mpg", "-c:v mpeg2video -bf 2 -g 6 -r 25 -t 1".to_owned(), 50, 0.44, false),
            ("joined.ts", h264("-t 1"), 20, 1.1, false),
        ] {
            let Some(file) = made(folder.path(), name, &options) else {
                missing::skipped(test, format_args!("this ffmpeg does not write {name}"));
                continue;
            };
            let (recording, sequence) = Seekable::open(&file, &OpenOptions::default()).unwrap();
            let read = |number| -> Vec<_> { recording.gray_from(number).unwrap().map(Result::unwrap).collect() };
            let all = read(1);
            let times: Vec<f64> = all.iter().map(|(_, time)| time.unwrap()).collect();
            assert!(times.len() == count && (times[11] - time).abs() < 2e-3, "{name}: {times:?}");
            assert!(times.is_sorted_by(|a, b| a < b || name == "same.mkv"), "{name}: {times:?}");
            assert_eq!(recording.index.sought(count).is_some(), is_sought, "{name}");
            assert!(sequence.frames.map(Result::unwrap).eq(all.iter().map(|(frame, _)| frame.clone())), "{name}");
            let numbers = [count / 3, count / 3 + 1, count - 1, count + 1];
            for &number in if is_sought { &numbers[..] } else { &numbers[..1] } {
                assert!(read(number) == all[number - 1..], "{name}, {number}");
            }
            let colors: Vec<_> = sequence.colors.clone().within(count / 3, 32, FFMPEG_PATIENCE).collect();
            assert!(recording.color_from(count / 3, 32).unwrap().eq(colors), "{name} in color");
            let (known, expected) = (recording.known().1, &times);
            let apart = known.iter().zip(expected).map(|(known, time)| (known - time).abs()).fold(0.0, f64::max);
            assert!(known.len() == count && apart < 1e-6, "{name}: {known:?}, expected {times:?}");
        }
    }

    #[test]
    fn what_an_edit_list_cuts_is_no_frame() {
        let folder = tempfile::tempdir().unwrap();
        let Some(whole) = made(folder.path(), "whole.mp4", H264) else {
            return missing::skipped("what_an_edit_list_cuts_is_no_frame", "no ffmpeg with libx264");
        };
        let cut = folder.path().join("cut.mp4");
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-nostdin", "-v", "error", "-ss", "0.7", "-i"]).arg(whole).args(["-c", "copy"]).arg(&cut);
        assert!(missing::runs(&mut ffmpeg));
        let (recording, sequence) = Seekable::open(&cut, &OpenOptions::default()).unwrap();
        assert_eq!((recording.index.sought(23).is_some(), sequence.frames.count()), (true, 30 - 7));
        assert_eq!(recording.known().0, Some(23));
    }
}
