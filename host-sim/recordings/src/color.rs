//! The frames of a recording in its own colors and at their own times: what boxes are drawn on. Trackers see gray frames only.

use super::live::LiveFrame;
use super::resize::resized;
use super::video::{self, Moment};
use super::{ColorFrame, GrayFrame, Picture, frame_times};
use crate::cleanup::locked;
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

impl From<&GrayFrame> for ColorFrame {
    fn from(GrayFrame { width, height, pixels }: &GrayFrame) -> Self {
        Self { width: *width, height: *height, pixels: pixels.iter().map(|&gray| [gray; 3]).collect() }
    }
}

/// Where the colors of a recording are.
#[derive(Clone, Debug, Default)]
pub enum Colors {
    /// The recording is gray, or can be read only once.
    #[default]
    None,
    /// One picture a frame.
    Pictures(Vec<Picture>),
    /// And the time of the frame that was read last.
    Video(PathBuf, Time),
    /// Those of the frame that was read last.
    Live(Now),
    /// Drawn by this from their indices, and how many there are.
    Made(fn(usize) -> ColorFrame, usize),
}

/// The time of the frame of a video that was read last, in seconds, if it has one.
#[derive(Clone, Debug, Default)]
pub struct Time(Arc<Mutex<Option<f64>>>);

impl Time {
    /// The frames alone. Their times are told to whoever asks.
    pub(super) fn told_by<F: Iterator<Item = Result<(GrayFrame, Option<f64>)>>>(
        &self,
        frames: F,
    ) -> impl Iterator<Item = Result<GrayFrame>> + use<F> {
        let time = self.clone();
        frames.map(move |frame| {
            let (frame, now) = frame?;
            *locked(&time.0) = now;
            Ok(frame)
        })
    }
}

/// What was read last from a live source.
#[derive(Clone, Debug, Default)]
pub struct Now(Arc<Mutex<Last>>);

#[derive(Debug, Default)]
struct Last {
    frame: Option<LiveFrame>,
    dropped: usize,
    ended: Option<String>,
}

impl Now {
    pub(super) fn set(&self, frame: Option<LiveFrame>, dropped: usize, ended: Option<String>) {
        let mut last = locked(&self.0);
        *last = Last { frame: frame.or(last.frame.take()), dropped, ended };
    }

    /// Its number and its time.
    fn tick(&self) -> Option<(usize, f64)> {
        locked(&self.0).frame.as_ref().map(|frame| (frame.number, frame.seconds))
    }

    fn color(&self) -> Option<(ColorFrame, Option<Moment>)> {
        let last = locked(&self.0);
        let frame = last.frame.as_ref()?;
        #[allow(clippy::cast_possible_truncation)] // it saturates
        let time = (frame.seconds * 1e6) as i64;
        Some((frame.planes.color(), Some(Moment { time, base: (1, 1_000_000), aspect: (1, 1) })))
    }

    /// How many frames came that nobody took.
    pub fn dropped(&self) -> usize {
        locked(&self.0).dropped
    }

    /// Why it has ended, if that is known.
    pub fn ended(&self) -> Option<String> {
        locked(&self.0).ended.clone()
    }
}

/// The numbers of frames in the recording, and the seconds at which they are shown, if they are known.
pub struct Clock {
    next: usize,
    of: Colors,
}

impl Clock {
    /// Of the frame that was read last.
    pub fn tick(&mut self) -> (usize, Option<f64>) {
        self.next += 1;
        match &self.of {
            Colors::Live(now) => now.tick().map_or((self.next - 1, None), |(number, seconds)| (number, Some(seconds))),
            Colors::Video(_, time) => (self.next - 1, *locked(&time.0)),
            _ => (self.next - 1, None),
        }
    }
}

impl Colors {
    /// The file that may have sound.
    pub fn video(&self) -> Option<&Path> {
        if let Self::Video(file, _) = self { Some(file) } else { None }
    }

    /// The frames from the one with the number `first` on. An ffmpeg that does nothing for as long as `patience` is not waited for.
    pub fn open(self, first: usize, patience: Duration) -> ColorFrames {
        ColorFrames(self.frames(first, u16::MAX, patience))
    }

    /// The same, as long as there are any, with no side of a frame of a video longer than `side`: ffmpeg makes them smaller, which is
    /// quick.
    pub fn within(self, first: usize, side: u16, patience: Duration) -> impl Iterator<Item = ColorFrame> {
        self.frames(first, side, patience).map(|(frame, _)| frame)
    }

    /// Of pictures: what they are called.
    pub fn picture_names(&self) -> Vec<String> {
        let Self::Pictures(pictures) = self else { return Vec::new() };
        pictures.iter().filter_map(Picture::name).collect()
    }

    /// How many frames a video has, as far as it says so itself.
    pub fn length(&self, patience: Duration) -> Option<usize> {
        frame_times::count(self.video()?, patience)
    }

    /// What is known of a live source.
    pub fn now(&self) -> Option<Now> {
        if let Self::Live(now) = self { Some(now.clone()) } else { None }
    }

    /// To be asked after each frame, from the one with the number `first` on.
    pub fn clock(&self, first: usize) -> Clock {
        Clock { next: first, of: self.clone() }
    }

    fn frames(self, first: usize, side: u16, patience: Duration) -> Source {
        match self {
            Self::None => Box::new(std::iter::empty()),
            Self::Pictures(pictures) => {
                let read = |picture: Picture| Some((picture.colors().ok()?, None));
                Box::new(pictures.into_iter().skip(first - 1).map_while(read))
            }
            Self::Made(frame, length) => Box::new((first - 1..length).map(move |index| (frame(index), None))),
            Self::Video(file, _) => Box::new(video::colors(&file, side, patience).skip(first - 1)),
            Self::Live(now) => Box::new(std::iter::from_fn(move || now.color())),
        }
    }
}

type Source = Box<dyn Iterator<Item = (ColorFrame, Option<Moment>)> + Send>;

/// Frames in color, one for each gray one.
pub struct ColorFrames(Source);

impl ColorFrames {
    /// The next frame in the size of the gray one, which it is in place of. Where there is no color, it is the gray one: what is wrong with
    /// a recording is said by those who read it in gray.
    pub fn next(&mut self, gray: &GrayFrame) -> (ColorFrame, Option<Moment>) {
        let Some((frame, moment)) = self.0.next() else { return (gray.into(), None) };
        let stretch =
            (f64::from(frame.width) / f64::from(gray.width)) / (f64::from(frame.height) / f64::from(gray.height));
        let moment = moment.map(|moment| Moment { aspect: stretched(moment.aspect, stretch), ..moment });
        (resized(frame, gray.width, gray.height), moment)
    }
}

/// The shape of a pixel that is so many times as wide. What is shown keeps its shape.
fn stretched((width, height): (u32, u32), by: f64) -> (u32, u32) {
    if (by - 1.0).abs() < 0.01 {
        // Half of an odd side is rounded.
        return (width, height);
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // positive, and it saturates
    let thousandths = (f64::from(width) / f64::from(height) * by * 1000.0).round() as u32;
    (thousandths.max(1), 1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_keep_their_colors_and_get_the_size_of_the_gray_ones() {
        let folder = tempfile::tempdir().unwrap();
        let file = |number: u8| {
            let file = folder.path().join(format!("{number}.ppm"));
            std::fs::write(&file, [b"P6 4 2 255\n".as_slice(), &[number, 200, 3].repeat(8)].concat()).unwrap();
            file
        };
        let mut frames = Colors::Pictures([file(1), file(2)].map(Picture::from).to_vec()).open(2, Duration::ZERO);
        let gray = GrayFrame { width: 2, height: 1, pixels: vec![0; 2] };
        let (frame, _) = frames.next(&gray);
        assert_eq!(frame, ColorFrame { width: 2, height: 1, pixels: vec![[2, 200, 3]; 2] });
        assert_eq!(frames.next(&gray).0.pixels, [[0; 3]; 2]);
    }

    #[test]
    fn what_is_shown_keeps_its_shape() {
        assert_eq!(stretched((1, 1), 1.0), (1, 1));
        assert_eq!(stretched((12, 11), 1.005), (12, 11));
        assert_eq!(stretched((1, 1), 2.0), (2000, 1000));
    }
}
