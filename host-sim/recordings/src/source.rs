//! The source of a recording, from which frames are read again: in color, or from any frame number on.

use crate::ffmpeg::{self, Arrivals, Image, Use};
use crate::formats::images;
use crate::frame::Moment;
use crate::raster::ColorFrame;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The source from which a recording can be read again.
#[derive(Clone, Debug, Default)]
pub enum Source {
    /// A source that cannot be read again in color: a pipe, or gray frames.
    #[default]
    Once,
    Images(Vec<images::ImageFile>),
    Video(PathBuf),
    /// A live source, whose frames carry their own color planes.
    Live(Arc<Arrivals>),
    /// A drawn recording: the function that draws a frame, given its index, and the number of frames.
    Made(fn(usize) -> ColorFrame, usize),
}

pub(crate) type Colors = Box<dyn Iterator<Item = (ColorFrame, Option<Moment>)> + Send>;

impl Source {
    /// Returns the path of a video, which may have sound.
    pub fn video(&self) -> Option<&Path> {
        if let Self::Video(file) = self { Some(file) } else { None }
    }

    pub fn image_names(&self) -> Vec<String> {
        let Self::Images(images) = self else { return Vec::new() };
        images.iter().filter_map(images::ImageFile::name).collect()
    }

    /// Returns the number of frames of a video; `None` if only decoding the whole video would show it.
    pub fn length(&self, patience: Duration) -> Option<usize> {
        ffmpeg::count(self.video()?, patience)
    }

    pub fn live(&self) -> Option<Arc<Arrivals>> {
        if let Self::Live(arrivals) = self { Some(Arc::clone(arrivals)) } else { None }
    }

    /// Returns color frames from frame number `first` on, up to the first unreadable one. Frames of a video are scaled
    /// down to at most `side` pixels in width and height.
    pub(crate) fn color_from(&self, first: usize, side: u16, patience: Duration) -> Colors {
        match self {
            Self::Once | Self::Live(_) => Box::new(std::iter::empty()),
            Self::Images(images) => {
                let rest = images.get(first - 1..).unwrap_or_default().to_owned();
                Box::new(rest.into_iter().map_while(|image| Some((image.colors().ok()?, None))))
            }
            Self::Made(frame, length) => {
                let frame = *frame;
                Box::new((first - 1..*length).map(move |index| (frame(index), None)))
            }
            Self::Video(file) => {
                Box::new(ffmpeg::good(file, Use::Color(side), patience).skip(first - 1).map(Image::color))
            }
        }
    }
}
