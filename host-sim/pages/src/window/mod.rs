//! The window: one page in the browser, served on this machine alone, in which a recording is followed, looked through and corrected.
//!
//! ```text
//! page  -- targets, wishes -->  routes  -->  following: a thread that reads frames and asks the trackers
//! page  <-- news, pictures --   routes  <--  news; pictures of the recording or camera
//! ```
//!
//! `server` lets in the page and nobody else. A page sends all targets with their locks after each change, and other
//! pages hear of it; `following` finds out which segments lack answers. All changes are `news`; if many answers
//! changed, a page asks for parts of them. Frames come from a `recording` or a `camera`. The page itself is
//! core/web/page/window.html. `session` keeps what the user has done in a file.

mod boxes;
mod camera;
mod following;
mod kept;
mod made;
mod news;
mod recording;
mod routes;
mod server;
mod session;

pub use boxes::read as read_boxes;
pub use camera::Camera;
pub use following::{Followed, Lock, Row, Target, check_inside};
pub use made::{Job, Made};
pub use recording::Growing;
pub use routes::{Window, Wish};
pub use server::Server;
pub use session::{Session, Work};

use anyhow::Result;
use smr_recordings::{ColorFrame, Frames};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The longest side of a picture, in pixels.
const SIDE: u16 = 1280;

/// Locks a mutex even after a thread panicked with it: each change is complete.
fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The source of a window: a recording, or a camera.
pub trait Source: Send + Sync {
    /// Returns the number of frames and their times. Both only grow.
    fn known(&self) -> Known;

    /// Errors: The frames cannot be read, or are not kept any more.
    fn gray_from(&self, number: usize) -> Result<Frames>;

    /// Returns the number of the oldest frame that a tracker can be locked in.
    fn oldest(&self) -> usize {
        1
    }

    /// Returns the frame as a JPEG, in color if the source has color; `None` if there is no such frame.
    fn picture(&self, number: usize) -> Option<Arc<Vec<u8>>>;

    /// Returns the frame with all its pixels, in color if the source has color; `None` if there is no such frame, or only
    /// its picture is kept.
    fn color(&self, _number: usize) -> Option<Arc<ColorFrame>> {
        None
    }

    /// Returns the state of a camera; `None` for a recording.
    fn live(&self) -> Option<LiveState> {
        None
    }

    fn stop(&self) {}
}

/// The number of frames, and their times in seconds, as far as they are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    pub frames: Option<usize>,
    pub times: Vec<f64>,
}

/// The frames of a camera that are kept, and how well trackers keep up.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct LiveState {
    pub oldest: usize,
    pub newest: usize,
    /// Frames that came while targets were followed, and that no tracker got.
    pub dropped: usize,
    /// Milliseconds from the arrival of a frame to its answer.
    pub latency_ms: f64,
    pub rate: f64,
    /// True if no more frames will come.
    pub has_ended: bool,
}
