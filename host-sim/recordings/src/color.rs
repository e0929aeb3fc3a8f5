//! The frames of a recording in its own colors and at their own times: what boxes are drawn on. Trackers see gray frames only.

use super::resize::resized;
use super::{ColorFrame, GrayFrame, images, video_color};
use std::path::{Path, PathBuf};
use std::time::Duration;

impl From<&GrayFrame> for ColorFrame {
    fn from(GrayFrame { width, height, pixels }: &GrayFrame) -> Self {
        Self { width: *width, height: *height, pixels: pixels.iter().map(|&gray| [gray; 3]).collect() }
    }
}

/// When a frame of a video is shown, and how wide its pixels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// In units of `base`.
    pub time: i64,
    /// In seconds, as a fraction.
    pub base: (u32, u32),
    /// The width of a pixel over its height.
    pub aspect: (u32, u32),
}

impl Moment {
    pub fn seconds(&self) -> f64 {
        self.time as f64 * f64::from(self.base.0) / f64::from(self.base.1)
    }
}

/// Where the colors of a recording are.
#[derive(Clone, Debug, Default)]
pub enum Colors {
    /// The recording is gray, or can be read only once.
    #[default]
    None,
    /// One picture a frame.
    Pictures(Vec<PathBuf>),
    Video(PathBuf),
    /// Drawn by this from their indices, and how many there are.
    Made(fn(usize) -> ColorFrame, usize),
}

impl Colors {
    /// The file that may have sound.
    pub fn video(&self) -> Option<&Path> {
        if let Self::Video(file) = self { Some(file) } else { None }
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

    fn frames(self, first: usize, side: u16, patience: Duration) -> Source {
        match self {
            Self::None => Box::new(std::iter::empty()),
            Self::Pictures(files) => {
                let read = |file: PathBuf| Some((images::read_colors(&file).ok()?, None));
                Box::new(files.into_iter().skip(first - 1).map_while(read))
            }
            Self::Made(frame, length) => Box::new((first - 1..length).map(move |index| (frame(index), None))),
            Self::Video(file) => Box::new(video_color::open(&file, first, side, patience).into_iter().flatten()),
        }
    }
}

type Source = Box<dyn Iterator<Item = (ColorFrame, Option<Moment>)>>;

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
    use super::super::synthetic;
    use super::*;

    #[test]
    fn without_colors_frames_are_gray() {
        let gray = synthetic::frames().next().unwrap();
        let (frame, moment) = Colors::None.open(1, Duration::ZERO).next(&gray);
        assert_eq!((frame.width, frame.pixels.len(), moment), (gray.width, gray.pixels.len(), None));
        assert_eq!(frame.pixels[77], [gray.pixels[77]; 3]);
    }

    #[test]
    fn pictures_keep_their_colors_and_get_the_size_of_the_gray_ones() {
        let folder = tempfile::tempdir().unwrap();
        let file = |number: u8| {
            let file = folder.path().join(format!("{number}.ppm"));
            std::fs::write(&file, [b"P6 4 2 255\n".as_slice(), &[number, 200, 3].repeat(8)].concat()).unwrap();
            file
        };
        let mut frames = Colors::Pictures(vec![file(1), file(2)]).open(2, Duration::ZERO);
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
