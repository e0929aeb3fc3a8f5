//! A recording or a camera, as the viewer reads it.

use anyhow::Result;
use smr_recordings::{ColorFrame, Frames};
use std::sync::Arc;

/// Longest side in pixels of a JPEG for the page; larger frames are scaled down.
pub(super) const SIDE: u16 = 1280;

/// A source of frames for the viewer: a recording or a camera. Frame numbers start at 1.
pub trait Source: Send + Sync {
    /// Returns the count of frames known so far and the list of their times in seconds. Neither ever gets shorter.
    fn known(&self) -> Known;

    /// Reads the gray frames from frame `number` on. Errors: They cannot be read, or are not kept any more.
    fn gray_from(&self, number: usize) -> Result<Frames>;

    /// Returns the number of the oldest frame that a tracker can be locked in.
    fn oldest(&self) -> usize {
        1
    }

    /// Returns the frame as a JPEG, in color if the source has color; `None` if there is no such frame.
    fn image(&self, number: usize) -> Option<Arc<Vec<u8>>>;

    /// Returns the frame at full resolution; `None` if there is no such frame, or only its JPEG is kept.
    fn color(&self, _number: usize) -> Option<Arc<ColorFrame>> {
        None
    }

    fn live(&self) -> Option<LiveState> {
        None
    }

    fn stop(&self) {}
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    pub frames: Option<usize>,
    pub times: Vec<f64>,
}

/// State of a camera: the range of frames that are kept, and how well the trackers keep up.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct LiveState {
    pub oldest: usize,
    pub newest: usize,
    /// Count of frames that arrived while targets were tracked, but that no tracker received.
    pub dropped: usize,
    /// Moving average of the milliseconds from a frame's arrival to its answer.
    pub latency_ms: f64,
    pub rate: f64,
    pub has_ended: bool,
}
