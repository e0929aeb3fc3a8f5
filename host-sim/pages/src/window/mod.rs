//! The window: one page in the browser, served on this machine alone, in which a recording is followed, looked through and corrected.
//!
//! ```text
//! page  -- targets, wishes -->  routes  -->  following: a thread that reads frames and asks the trackers
//! page  <-- news, pictures --   routes  <--  news, pictures
//! ```
//!
//! `server` lets in the page and nobody else. A page sends all targets and their corrections after each change, which the other pages are told;
//! `following` finds out what is to be followed again. What changed is `news`; where many answers did, a page asks for parts of them. `pictures`
//! gives any frame as a JPEG, and `growing` opens a file anew that has grown.
//! The page itself is core/web/page/window.html.

mod camera;
mod following;
mod growing;
mod made;
mod news;
mod pictures;
mod routes;
mod server;

pub use camera::Camera;
pub use following::{Followed, Lock, Row, Target};
pub use growing::Growing;
pub use made::{Job, Made};
use pictures::Recorded;
pub use routes::{Window, Wish};
pub use server::Server;

use anyhow::Result;
use smr_recordings::GrayFrame;
use std::sync::Arc;

/// Frames with their numbers, from some number on, and with their times in seconds, if they have any.
pub type Numbered = Box<dyn Iterator<Item = Result<(usize, Option<f64>, GrayFrame)>>>;

/// Where the frames of a window come from: a recording, or a camera.
pub trait Source: Send + Sync {
    /// Returns the number of frames, as far as that is known, and their times in seconds. Both only grow.
    fn known(&self) -> Known;

    /// The frames from `number` on.
    /// Errors: They cannot be read, or are not kept any more.
    fn gray_from(&self, number: usize) -> Result<Numbered>;

    /// The number of the oldest frame that a tracker can be locked in.
    fn oldest(&self) -> usize {
        1
    }

    /// The frame as a JPEG, in color if there is color; `None` if there is no such frame.
    fn picture(&self, number: usize) -> Option<Arc<Vec<u8>>>;

    /// Of a camera: what is kept, and how well trackers keep up.
    fn live(&self) -> Option<LiveState> {
        None
    }

    /// Ends a camera.
    fn stop(&self) {}
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    pub frames: Option<usize>,
    pub times: Vec<f64>,
}

/// What is said of a camera.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LiveState {
    /// The numbers of the oldest frame that is kept, and of the newest.
    pub oldest: usize,
    pub newest: usize,
    /// Frames of the source that no tracker got.
    pub dropped: usize,
    /// From the arrival of a frame to its answer.
    pub latency_ms: f64,
    /// Frames that came in a second, on average.
    pub rate: f64,
    /// No more frames will come.
    pub has_ended: bool,
}
