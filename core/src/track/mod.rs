//! The code that both trackers share: calls, answers, errors, saved targets, flight records.
//!
//! | file | contents |
//! |---|---|
//! | `answer.rs`, `error.rs`, `quality.rs` | the results of the calls |
//! | `update.rs` | updates and locks in steps, and the work of a step |
//! | `target.rs` | the trait [`Target`], which both trackers implement |
//! | `tracker.rs` | a target together with its workspace |
//! | `saved.rs`, `checksum.rs` | a target as bytes; the CRC-32 of these and of records |
//! | `settings.rs` | the macro for the settings of both trackers |
//! | `record.rs` | the flight record: everything a tracker saw and answered, as bytes |
//! | `paper/`, `robust/` | the two trackers |

#[macro_use]
mod settings;

mod answer;
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

pub use answer::{Answer, MostWork, State};
pub use error::{ConfigError, LockError, RestoreError, SaveError, UpdateError};
pub use quality::Quality;
pub use settings::{Setting, Settings, Shape};
pub use target::Target;
pub use tracker::Tracker;
pub use update::Steps;
pub use update::calls;
