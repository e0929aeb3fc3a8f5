//! The command `host-sim` replays recorded sequences through `smr-core`, the very code that is linked into a camera.
//!
//! Recordings, the float reference, evaluation and pages are crates of their own (`smr-recordings`, `smr-reference`, `smr-evaluation`,
//! `smr-pages`), each in a folder of this one. Here is what connects them:
//!
//! - [`check`]: core against the references, score by score.
//! - [`vectors`]: the conformance vectors, made from the reference.
//! - [`mod@replay`]: flight records of firmware, run again.
//! - [`trax`]: both trackers behind the protocol of evaluation tools.
//! - [`soak`]: video without end, every answer compared.
//! - [`spread`]: many measurements as three numbers.
//! - `emulator` (feature `emulator`): the firmware in QEMU against the host.
//! - `bench` (feature `bench`): how fast it is here and on the emulated boards, beside OpenCV and a plain SAD search.
//! - [`command`]: what the command line offers; `main` only hands over.

// What is printed goes through `output`.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

#[cfg(feature = "bench")]
pub mod bench;
pub mod check;
pub mod command;
#[cfg(feature = "emulator")]
pub mod emulator;
pub mod replay;
pub mod soak;
pub mod spread;
pub mod trax;
pub mod vectors;
