//! The command `host-sim`: runs recordings through `smr-core`, the same code that a camera links.
//!
//! Built-in scenes, recordings, the float reference, evaluation and pages are crates in folders of this one
//! (`smr-scene`, `smr-recordings`, `smr-reference`, `smr-evaluation`, `smr-pages`). This crate connects them:
//!
//! - [`check`]: compares smr-core with the references, score by score.
//! - [`mod@replay`]: replays flight records, which firmware writes.
//! - [`command`]: the command line, which `main` calls.

pub mod check;
pub mod command;
pub mod replay;
