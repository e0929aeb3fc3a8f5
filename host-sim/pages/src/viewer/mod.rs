//! The viewer of `host-sim view`: a page, served to this machine only, on which the user tracks and corrects targets.
//!
//! ```text
//! page  -- targets, requests -->  routes  -->  following: a thread that reads frames and asks the trackers
//! page  <-- news, pictures --     routes  <--  change_log; pictures of the recording or camera
//! ```
//!
//! `server` admits only the page. After each change, the page sends all targets with their locks (boxes that the user
//! drew). `following` determines the segments (frames from one lock to the next) that lack answers. All open pages poll
//! `news`, the log of changes; if many answers changed, a page requests them in parts. Frames come from a `recording`
//! or a `camera`. The page itself is core/web/page/viewer.html. `session` saves the user's work in a file.

mod camera;
mod change_log;
mod following;
mod frame_cache;
mod made;
mod recording;
mod routes;
mod server;
mod session;

pub use camera::Camera;
pub use following::{Followed, Lock, Row, Target, check_inside};
pub use made::{Job, Made};
pub use recording::Growing;
pub use routes::{Requests, Viewer};
pub use server::Server;
pub use session::{Session, Work};

use anyhow::Result;
use smr_recordings::{ColorFrame, Frames};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Longest side in pixels of a JPEG for the page; larger frames are scaled down.
const SIDE: u16 = 1280;

/// Locks a mutex even if a thread panicked while holding it, because every change to its data is complete.
fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

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
    fn picture(&self, number: usize) -> Option<Arc<Vec<u8>>>;

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
