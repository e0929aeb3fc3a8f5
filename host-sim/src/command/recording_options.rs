//! How recordings are opened, the same for every command that reads them.

use super::tracker_options::Pair;
use crate::sequence::{self, BoundingBox, OpenOptions, Sequence};
use anyhow::Result;
use clap::Args;
use std::path::Path;

#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Recording")]
pub struct RecordingOptions {
    /// The box to start from, in pixels: left, top, width, height [default: the one beside the recording]
    #[arg(long, value_name = "X,Y,W,H")]
    init: Option<BoundingBox>,
    /// The right and lower edges of the box to start from belong to it: one pixel wider and higher
    #[arg(long)]
    inclusive: bool,
    /// The size of the frames of raw dumps
    #[arg(long, value_name = "WxH")]
    size: Option<Pair>,
}

impl RecordingOptions {
    /// Whether the box to start from is given, not found beside the recording.
    pub fn gives_init(&self) -> bool {
        self.init.is_some()
    }

    /// Opens the recording at `path`.
    pub fn open(&self, path: &Path) -> Result<Sequence> {
        let options = OpenOptions { size: self.size.map(|Pair(width, height)| (width, height)), init: self.init };
        let mut sequence = sequence::open(path, &options)?;
        if let Some(init) = sequence.init.as_mut().filter(|_| self.inclusive) {
            (init.width, init.height) = (init.width + 1.0, init.height + 1.0);
        }
        Ok(sequence)
    }
}
