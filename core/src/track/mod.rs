//! Following a target, whichever tracker does it: the [`Target`] that is remembered, the scratch memory beside it, and the [`Tracker`]
//! that holds both.
//!
//! | file | what it holds |
//! |---|---|
//! | `target.rs` | the trait that both trackers implement |
//! | `tracker.rs` | a target with its workspace, in one |
//! | `bound.rs` | the most work |
//! | `update.rs` | updates and locks in steps |
//! | `answer.rs`, `error.rs`, `quality.rs` | what comes back |
//! | `saved.rs` | a target as bytes |
//! | `record.rs` | a flight record: all that a tracker saw and answered, as bytes |
//! | `checksum.rs` | the checksum of both |
//! | `paper/`, `robust/` | the two trackers |

mod answer;
mod bound;
mod checksum;
mod error;
pub mod paper;
mod quality;
pub mod record;
pub mod robust;
mod saved;
mod target;
mod tracker;
mod update;

#[cfg(test)]
mod tests;

pub use answer::{Answer, State};
pub use bound::MostWork;
pub use error::{ConfigError, LockError, UpdateError};
pub use quality::Quality;
pub use saved::{RestoreError, SaveError};
pub use target::Target;
pub use tracker::Tracker;
pub use update::{Lock, Update};
