//! A recording that is read from any frame on, more than once.

use crate::built_in::BUILT_IN;
use crate::ffmpeg::{self, Image, Index, Use};
use crate::formats::{images, y4m};
use crate::frame::Frames;
use crate::open::{OpenOptions, open};
use crate::raster::ColorFrame;
use crate::sequence::Sequence;
use crate::source::Source;
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A recording that can be read from any frame on: images and Y4M by frame number, a video after a seek. Raw dumps
/// are read from their start; so is a video if a sought frame's time differs from the index or ffmpeg reports an error.
pub struct Seekable {
    path: PathBuf,
    options: OpenOptions,
    source: Source,
    length: Option<usize>,
    index: Arc<Index>,
}

impl Seekable {
    /// Returns the recording at `path` twice: seekable, and as a sequence read in order. Errors are those of [`open`].
    pub fn open(path: &Path, options: &OpenOptions) -> Result<(Self, Sequence)> {
        let sequence = open(path, options)?;
        let index = sequence.source.video().map_or_else(Index::unknown, |file| Index::of(file, options.patience()));
        let (source, length) = (sequence.source.clone(), sequence.length);
        Ok((Self { path: path.to_owned(), options: options.clone(), source, length, index }, sequence))
    }

    /// Returns the number of frames (`None` if unknown), and the time of each in seconds (empty if unknown).
    pub fn known(&self) -> (Option<usize>, Vec<f64>) {
        self.index.times().map_or_else(|| (self.length, Vec::new()), |times| (Some(times.len()), times))
    }

    /// Returns the gray frames from `number` on; an error if the recording cannot be read.
    pub fn gray_from(&self, number: usize) -> Result<Frames> {
        Ok(match &self.source {
            Source::Images(files) => Box::new(images::frames(files, number)),
            Source::Video(file) if number > 1 && y4m::is_y4m(file) => Box::new(y4m::open(file)?.from(number)),
            Source::Video(file) if number > 1 => {
                let images = self.images_from(file, number, Use::Gray);
                Box::new((number..).zip(images).map(|(number, image)| Ok(image?.gray(number))))
            }
            _ => Box::new(open(&self.path, &self.options)?.frames.skip(number - 1)),
        })
    }

    /// Returns the color frames from `number` on, up to the first unreadable one; those of a video have sides of at
    /// most `side` pixels. An error if the recording cannot be opened.
    pub fn color_from(&self, number: usize, side: u16) -> Result<Box<dyn Iterator<Item = ColorFrame> + Send>> {
        Ok(match &self.source {
            Source::Video(file) if number > 1 => {
                let images = self.images_from(file, number, Use::Color(side));
                Box::new(images.map_while(Result::ok).map(|image| image.color().0))
            }
            Source::Once | Source::Live(_) => {
                Box::new(self.gray_from(number)?.map_while(Result::ok).map(|frame| (&frame.gray).into()))
            }
            source => Box::new(source.color_from(number, side, self.options.patience()).map(|(frame, _)| frame)),
        })
    }

    /// Returns the images of a video from `number` on: after a seek, as long as their times agree with the index and
    /// ffmpeg reports no error; after that by decoding from the start.
    fn images_from(&self, file: &Path, mut number: usize, wanted: Use) -> impl Iterator<Item = Result<Image>> + use<> {
        let (index, file, patience) = (Arc::clone(&self.index), file.to_owned(), self.options.patience());
        let video = index.video();
        let found = video.zip(index.sought(number)).and_then(|(video, time)| ffmpeg::sought(&video, time, wanted));
        let (mut first, mut decoder) = found.unzip();
        let mut rest: Option<Box<dyn Iterator<Item = Result<Image>> + Send>> = None;
        std::iter::from_fn(move || {
            if let Some(sought) = &mut decoder {
                let image = first.take().or_else(|| sought.next().ok()?);
                match image.filter(|image| index.has(number, image.seconds())) {
                    Some(image) => {
                        number += 1;
                        return Some(Ok(image));
                    }
                    None if sought.is_whole() && index.ends_before(number) => return None,
                    None => decoder = None,
                }
            }
            let begin = || -> Box<dyn Iterator<Item = _> + Send> {
                match ffmpeg::open("ffmpeg", &file, wanted, patience) {
                    Ok(all) => Box::new(all.skip(number - 1)),
                    Err(error) => Box::new(std::iter::once(Err(error))),
                }
            };
            rest.get_or_insert_with(begin).next()
        })
    }
}

/// True if `path` can be read repeatedly: a file, folder or built-in recording, not a pipe or a device.
pub fn is_seekable(path: &Path) -> bool {
    BUILT_IN.iter().any(|name| path == Path::new(name)) || path.is_file() || path.is_dir()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in::synthetic;
    use crate::raster::GrayFrame;
    use crate::{fixtures::ffmpeg, missing};

    fn gray(recording: &Seekable, number: usize) -> GrayFrame {
        recording.gray_from(number).unwrap().next().unwrap().unwrap().gray
    }

    #[test]
    fn images_and_made_frames_are_read_from_any_place_on() {
        let names: Vec<String> = (1..=12).map(|number| format!("{number}.png")).collect();
        let folder = crate::fixtures::folder(&names.join(" "));
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

    /// Encodes a test video, two copies in a row if `name` begins with `joined`; `None` if this ffmpeg cannot write it.
    fn made(folder: &Path, name: &str, options: &str) -> Option<PathBuf> {
        let (file, map) = (folder.join(name), if options.contains("-map") { "" } else { "-map 0:v" });
        let inputs =
            "-f lavfi -i testsrc2=size=64x48:rate=10:duration=3 -f lavfi -i testsrc=size=96x64:rate=5:duration=3";
        ffmpeg(&format!("{inputs} {map} {options}"), &file).then_some(())?;
        if name.starts_with("joined") {
            std::fs::write(&file, std::fs::read(&file).unwrap().repeat(2)).unwrap();
        }
        Some(file)
    }

    const H264: &str = "-c:v libx264 -g 10 -bf 3 -flags +cgop -preset ultrafast";

    /// Each case: file name, ffmpeg options, number of frames, time in s of frame 12, true if the index allows seeks.
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
            let in_order = |frames: Frames| -> Vec<_> {
                frames.map(Result::unwrap).map(|frame| (frame.number, frame.seconds.unwrap(), frame.gray)).collect()
            };
            let read = |number| in_order(recording.gray_from(number).unwrap());
            let all = read(1);
            let times: Vec<f64> = all.iter().map(|(_, time, _)| *time).collect();
            assert!(all.iter().map(|(number, ..)| *number).eq(1..=count), "{name}");
            assert!(times.len() == count && (times[11] - time).abs() < 2e-3, "{name}: {times:?}");
            assert!(times.is_sorted_by(|a, b| a < b || name == "same.mkv"), "{name}: {times:?}");
            assert_eq!(recording.index.sought(count).is_some(), is_sought, "{name}");
            assert!(in_order(sequence.frames) == all, "{name}");
            let numbers = [count / 3, count / 3 + 1, count - 1, count + 1];
            for &number in if is_sought { &numbers[..] } else { &numbers[..1] } {
                assert!(read(number) == all[number - 1..], "{name}, {number}");
            }
            let colors = sequence.source.color_from(count / 3, 32, ffmpeg::PATIENCE).map(|(frame, _)| frame);
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
        assert!(ffmpeg(&format!("-ss 0.7 -i {} -c copy", whole.display()), &cut));
        let (recording, sequence) = Seekable::open(&cut, &OpenOptions::default()).unwrap();
        assert_eq!((recording.index.sought(23).is_some(), sequence.frames.count()), (true, 30 - 7));
        assert_eq!(recording.known().0, Some(23));
    }
}
