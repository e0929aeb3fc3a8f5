//! The viewer of `host-sim view`: a page, served to this machine only, on which the user tracks and corrects targets.
//!
//! ```text
//! page  -- targets, requests -->  routes  -->  model: targets and locks  -->  thread: reads frames, asks the trackers
//! page  <-- news, images ------   routes  <--  answers: segments and change log  <--  thread
//! ```
//!
//! `server` admits only the page. After each change, the page sends all targets with their locks (boxes that the user
//! drew). `answers` determines the segments (frames from one lock to the next) that lack answers, and `thread` fills
//! them. All open pages poll `news`, the log of changes; if many answers changed, a page requests them in parts. Frames
//! come from a `source`: a `recording` or a `camera`. The page itself is core/web/page/viewer.html. `session` saves the
//! user's work in a file. `several` serves several recordings, each with a viewer of its own.

mod answers;
mod camera;
mod frame_cache;
mod model;
mod ordered_files;
mod recording;
mod routes;
mod server;
mod session;
mod several;
mod source;
mod spans;
#[cfg(test)]
mod test_viewer;
mod thread;
mod truth;
mod truth_recording;

pub use answers::{AnsweredFrame, Followed};
pub use camera::Camera;
pub use model::{Length, Lock, Target, check_inside};
pub use ordered_files::{Job, Made};
pub use recording::Growing;
pub use routes::{Look, Requests, Viewer, plain};
pub use server::Server;
pub use session::{Session, Work, beside as session_beside, owner as session_owner};
pub use several::Several;
pub use source::{Known, LiveState, Source};

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks a mutex even if a thread panicked while holding it, because every change to its data is complete.
fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
