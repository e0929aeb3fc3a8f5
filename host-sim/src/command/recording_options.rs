//! How recordings are opened, the same for every command that reads them.

use super::number::whole;
use super::recordings::recordings;
use super::tracker_options::Pair;
use crate::sequence::{
    self, BoundingBox, Damage, FFMPEG_PATIENCE, FrameRange, Frames, GrayFrame, OpenOptions, Resize, Sequence,
};
use anyhow::{Result, bail, ensure};
use clap::Args;
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Recording")]
pub struct RecordingOptions {
    /// The box to start from, in pixels: left, top, width, height [default: the one beside the recording]
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true)]
    init: Option<BoundingBox>,
    /// Count the right and lower edges as part of the box to start from: it is one pixel wider and higher
    #[arg(long)]
    inclusive: bool,
    /// The size of the frames of raw dumps
    #[arg(long, value_name = "WxH")]
    size: Option<Pair>,
    /// Resize all frames to this size or fraction; --init and the boxes beside the recording are in pixels of the original size
    #[arg(long, value_name = "WxH|1/2")]
    resize: Option<Resize>,
    /// Use only these frames, for example 20..80, 20.. or ..80; the first is 1
    ///
    /// The first of them is then frame 1, and the box to start from is the one that the ground truth has there.
    #[arg(long, value_name = "A..B")]
    pub frames: Option<FrameRange>,
    /// Continue after damage in a recording, and print on standard error how many frames are damaged
    ///
    /// Without it, damage is an error: a picture that is cut, a dump that ends within a frame, anything that ffmpeg complains about.
    #[arg(long)]
    lenient: bool,
    /// End ffmpeg, as an error, if it reads or writes nothing for this many seconds [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = whole::<NonZeroU16>(1..=65535))]
    ffmpeg_timeout: Option<NonZeroU16>,
}

impl RecordingOptions {
    /// Whether the box to start from is given, not found beside the recording.
    pub fn gives_init(&self) -> bool {
        self.init.is_some()
    }

    /// The same with frames in the size of the recording: boxes in them are what --init takes.
    pub fn in_own_size(&self) -> Self {
        Self { resize: None, ..self.clone() }
    }

    /// The smallest box, in the size of the recording, that has a pixel in frames of the size that trackers get.
    pub fn least_box(&self, width: u16, height: u16) -> (u16, u16) {
        match self.resize {
            None => (1, 1),
            Some(Resize::By(numerator, denominator)) => {
                let least = denominator.div_ceil(numerator);
                (least, least)
            }
            Some(Resize::To(to_width, to_height)) => (width.div_ceil(to_width), height.div_ceil(to_height)),
        }
    }

    /// The options as they are typed, but for those of the box to start from.
    pub fn words(&self) -> Vec<String> {
        let resize = self.resize.map(|resize| match resize {
            Resize::To(width, height) => format!("{width}x{height}"),
            Resize::By(numerator, denominator) => format!("{numerator}/{denominator}"),
        });
        let given = [
            ("--size", self.size.map(|size| size.to_string())),
            ("--resize", resize),
            ("--frames", self.frames.map(|frames| frames.to_string())),
            ("--ffmpeg-timeout", self.ffmpeg_timeout.map(|seconds| seconds.to_string())),
        ];
        let given = given.into_iter().filter_map(|(option, value)| Some([option.to_owned(), value?])).flatten();
        given.chain(self.lenient.then(|| "--lenient".to_owned())).collect()
    }

    /// How long ffmpeg may do nothing.
    pub fn ffmpeg_patience(&self) -> Duration {
        self.ffmpeg_timeout.map_or(FFMPEG_PATIENCE, |seconds| Duration::from_secs(seconds.get().into()))
    }

    /// Opens the recording at `path`.
    pub fn open(&self, path: &Path) -> Result<Sequence> {
        let options = OpenOptions {
            size: self.size.map(|Pair(width, height)| (width, height)),
            init: self.init,
            lenient: self.lenient,
            ffmpeg_patience: Some(self.ffmpeg_patience()),
        };
        let mut sequence = sequence::open(path, &options)?;
        if let Some(part) = self.frames {
            if let Some(length) = sequence.length.filter(|&length| part.first() > length) {
                bail!(
                    "{}: there is no frame {} (--frames {part}): expected 1 to {length}",
                    sequence.name,
                    part.first()
                );
            }
            sequence = sequence.part(part);
            sequence.init = self.init.or(sequence.init);
        }
        if let Some(init) = sequence.init.as_mut().filter(|_| self.inclusive) {
            (init.width, init.height) = (init.width + 1.0, init.height + 1.0);
        }
        if let Some(resize) = self.resize {
            sequence = sequence.resized(resize)?;
        }
        let Sequence { name, frames, damage, .. } = sequence;
        let frames: Frames = Box::new(Announced { name: name.clone(), frames, damage: damage.clone() });
        Ok(Sequence { name, frames, damage, ..sequence })
    }

    /// True if no option changes the box to start from, or the frames.
    pub fn says_nothing_of_start(&self) -> bool {
        self.init.is_none() && !self.inclusive && self.frames.is_none() && self.resize.is_none()
    }

    /// The recordings at `paths`, and in folders there.
    /// Errors: There is none, or one box is given for several of them.
    pub fn find(&self, paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
        let found = recordings(paths)?;
        self.check_for(found.len())?;
        Ok(found)
    }

    /// Errors: One box is given for several recordings.
    pub fn check_for(&self, recordings: usize) -> Result<()> {
        ensure!(
            self.init.is_none() || recordings <= 1,
            "--init is the box of one recording, and there are {recordings}: expected one recording with it"
        );
        Ok(())
    }
}

/// Frames that tell in the end how many of them were damaged.
struct Announced {
    name: String,
    frames: Frames,
    damage: Damage,
}

impl Iterator for Announced {
    type Item = Result<GrayFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        self.frames.next()
    }
}

impl Drop for Announced {
    fn drop(&mut self) {
        match self.damage.frames() {
            0 => {}
            1 => eprintln!("note: {}: a frame is damaged", self.name),
            frames => eprintln!("note: {}: {frames} frames are damaged", self.name),
        }
    }
}
