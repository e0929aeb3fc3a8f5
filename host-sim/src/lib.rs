//! The command `host-sim` replays recorded sequences through `smr-core`, the very code that is linked into a camera.
//!
//! Built-in scenes, recordings, the float reference, evaluation and pages are crates of their own (`smr-scene`, `smr-recordings`,
//! `smr-reference`, `smr-evaluation`, `smr-pages`), each in a folder of this one. Here is what connects them:
//!
//! - [`check`]: core against the references, score by score.
//! - [`mod@replay`]: flight records of firmware, run again.
//! - [`command`]: the command line, which `main` calls.

pub mod check;
pub mod command;
pub mod replay;
