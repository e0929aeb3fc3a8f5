//! A recording that is read from any of its frames on.

use super::{BUILT_IN, ColorFrame, Colors, FFMPEG_PATIENCE, Frames, OpenOptions, Sequence};
use super::{color_frames_at, frame_times, gray_frames_at, images, open};
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// A recording, and the index of its frames: of a video the time of each, which a thread reads without decoding anything.
///
/// Pictures are read by their names, videos and Y4M from the nearest place where ffmpeg can begin. A raw dump is read through from its
/// beginning.
pub struct Seekable {
    path: PathBuf,
    options: OpenOptions,
    colors: Colors,
    length: Option<usize>,
    index: Arc<(Mutex<Index>, Condvar)>,
}

#[derive(Default)]
struct Index {
    times: Vec<f64>,
    /// All times are there, or there will be none.
    is_whole: bool,
}

impl Seekable {
    /// Opens the recording at `path`, and also gives it as it is read in order.
    /// Errors: Those of [`open`].
    pub fn open(path: &Path, options: &OpenOptions) -> Result<(Self, Sequence)> {
        let sequence = open(path, options)?;
        let index = Arc::new((Mutex::new(Index::default()), Condvar::new()));
        let patience = options.ffmpeg_patience.unwrap_or(FFMPEG_PATIENCE);
        match sequence.colors.video().map(Path::to_owned) {
            Some(file) => {
                let index = Arc::clone(&index);
                thread::spawn(move || read_index(&file, patience, &index));
            }
            None => locked(&index.0).is_whole = true,
        }
        let (colors, length) = (sequence.colors.clone(), sequence.length);
        Ok((Self { path: path.to_owned(), options: options.clone(), colors, length, index }, sequence))
    }

    /// How many frames there are, and the time of each in seconds, once both are known. A recording may know no times.
    pub fn known(&self) -> (Option<usize>, Vec<f64>) {
        let index = locked(&self.index.0);
        match index.is_whole && !index.times.is_empty() {
            true => (Some(index.times.len()), index.times.clone()),
            false => (self.length, Vec::new()),
        }
    }

    fn patience(&self) -> Duration {
        self.options.ffmpeg_patience.unwrap_or(FFMPEG_PATIENCE)
    }

    /// The time of a frame. Waits until the index is so far.
    fn time(&self, number: usize) -> Option<f64> {
        let (index, grown) = &*self.index;
        let mut index = locked(index);
        while index.times.len() < number && !index.is_whole {
            index = grown.wait(index).unwrap_or_else(PoisonError::into_inner);
        }
        index.times.get(number - 1).copied()
    }

    /// The gray frames from `number` on.
    /// Errors: The recording cannot be read.
    pub fn gray_from(&self, number: usize) -> Result<Frames> {
        if number > 1 {
            match &self.colors {
                Colors::Pictures(files) => {
                    let rest = files.get(number - 1..).unwrap_or_default();
                    return Ok(Box::new(images::frames(rest.to_owned(), number)));
                }
                Colors::Video(file) => {
                    let frames = self.time(number).and_then(|time| gray_frames_at(file, time, self.patience()));
                    if let Some(frames) = frames {
                        return Ok(Box::new(frames.map(Ok)));
                    }
                }
                Colors::None | Colors::Live(_) | Colors::Made(..) => {}
            }
        }
        Ok(Box::new(open(&self.path, &self.options)?.frames.skip(number - 1)))
    }

    /// The frames from `number` on in their colors, no side of a frame of a video longer than `side`. They end where nothing more can be read.
    /// Errors: The recording cannot be read.
    pub fn color_from(&self, number: usize, side: u16) -> Result<Box<dyn Iterator<Item = ColorFrame> + Send>> {
        Ok(match &self.colors {
            Colors::Pictures(files) => {
                let rest = files.get(number - 1..).unwrap_or_default().to_owned();
                Box::new(rest.into_iter().map_while(|picture| picture.colors().ok()))
            }
            Colors::Video(file) => {
                let frames = self.time(number).and_then(|time| color_frames_at(file, time, side, self.patience()));
                Box::new(frames.into_iter().flatten().map(|(frame, _)| frame))
            }
            &Colors::Made(frame, length) => Box::new((number - 1..length).map(frame)),
            Colors::None | Colors::Live(_) => {
                Box::new(self.gray_from(number)?.map_while(Result::ok).map(|frame| (&frame).into()))
            }
        })
    }
}

/// True if frames of `path` can be read again and again: not standard input, a pipe or a device.
pub fn is_seekable(path: &Path) -> bool {
    BUILT_IN.iter().any(|name| path == Path::new(name)) || path.is_file() || path.is_dir()
}

fn locked(index: &Mutex<Index>) -> MutexGuard<'_, Index> {
    index.lock().unwrap_or_else(PoisonError::into_inner)
}

fn read_index(file: &Path, patience: Duration, (index, grown): &(Mutex<Index>, Condvar)) {
    for time in frame_times(file, patience).into_iter().flatten() {
        locked(index).times.push(time);
        grown.notify_all();
    }
    locked(index).is_whole = true;
    grown.notify_all();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GrayFrame, missing, synthetic};

    fn gray(recording: &Seekable, number: usize) -> GrayFrame {
        recording.gray_from(number).unwrap().next().unwrap().unwrap()
    }

    #[test]
    fn pictures_and_made_frames_are_read_from_any_place_on() {
        let folder = tempfile::tempdir().unwrap();
        for number in 1..=12_u8 {
            let file = folder.path().join(format!("{number}.ppm"));
            std::fs::write(file, [b"P6 4 2 255\n".as_slice(), &[number, number, number].repeat(8)].concat()).unwrap();
        }
        let (recording, sequence) = Seekable::open(folder.path(), &OpenOptions::default()).unwrap();
        assert_eq!((recording.known(), sequence.frames.count()), ((Some(12), vec![]), 12));
        assert_eq!((gray(&recording, 1).pixels[0], gray(&recording, 11).pixels[0]), (1, 11));
        assert_eq!(recording.color_from(12, 100).unwrap().map(|frame| frame.pixels[0]).collect::<Vec<_>>(), [[12; 3]]);
        assert_eq!(recording.color_from(13, 100).unwrap().count() + recording.gray_from(13).unwrap().count(), 0);
        std::fs::write(folder.path().join("9.ppm"), "P6 4 2 255\n").unwrap();
        let error = format!("{:#}", recording.gray_from(8).unwrap().nth(1).unwrap().unwrap_err());
        assert!(error.contains("9.ppm (frame 9)"), "{error}");
        let (recording, _) = Seekable::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        assert_eq!(gray(&recording, 100), synthetic::frame(99));
    }

    #[test]
    fn a_video_is_read_from_any_place_on() {
        let test = "a_video_is_read_from_any_place_on";
        if !missing::has_ffmpeg(test) {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.mp4");
        let mut ffmpeg = std::process::Command::new("ffmpeg");
        ffmpeg.args(["-nostdin", "-v", "error", "-f", "lavfi", "-i", "testsrc2=size=64x48:rate=30:duration=4"]);
        if !missing::runs(ffmpeg.arg(&file)) {
            return missing::skipped(test, "this ffmpeg writes no mp4");
        }
        let (recording, sequence) = Seekable::open(&file, &OpenOptions::default()).unwrap();
        let frames: Vec<GrayFrame> = sequence.frames.map(Result::unwrap).collect();
        for number in [1, 2, 50, 120] {
            assert!(gray(&recording, number) == frames[number - 1], "{number}");
            let color = recording.color_from(number, 32).unwrap().next().unwrap();
            assert_eq!((color.width, color.height), (32, 24));
        }
        assert_eq!((recording.known().0, recording.known().1[30].round()), (Some(120), 1.0));
        assert!(recording.color_from(121, 32).unwrap().next().is_none());
    }
}
