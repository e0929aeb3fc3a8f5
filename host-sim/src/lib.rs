//! The command `host-sim`: runs recordings through `smr-core`, the same code that a camera links.
//!
//! Scenes, recordings, references, evaluation and pages are crates in folders of this one. This crate connects them:
//!
//! - [`check`]: compares smr-core with the references, score by score.
//! - [`mod@replay`]: replays flight records, which firmware writes.
//! - [`command`]: the command line, which `main` calls.

pub mod check;
pub mod command;
pub mod replay;
