//! Replays recorded sequences through `smr-core`, the very code that is linked into a camera.
//!
//! - [`sequence`]: where frames and boxes come from.
//! - [`clock`]: how long something takes; [`spread`]: many measurements as three numbers.
//! - [`mod@reference`]: both methods in f64, the one written from the paper, the other from its description.
//! - [`check`]: core against the references, score by score.
//! - [`vectors`]: the conformance vectors, made from the reference.
//! - [`evaluate`]: how well a tracker does, by the protocol of the recordings.
//! - [`mod@replay`]: flight records of firmware, run again.
//! - [`report`]: what people look at.
//! - [`trax`]: both trackers behind the protocol of evaluation tools.
//! - [`soak`]: video without end, every answer compared.
//! - [`export`]: recordings as files.
//! - [`output`]: how files are written: whole or not at all.
//! - [`input`]: how files are read whole: up to a limit.
//! - [`ending`]: what a signal removes and ends before this program ends.
//! - [`words`]: errors as people read them.
//! - `emulator` (feature `emulator`): the firmware in QEMU against the host.
//! - `bench` (feature `bench`): how fast it is here and on the emulated boards, beside OpenCV and a plain SAD search.
//! - [`command`]: what the command line offers; `main` only hands over.

// What is printed goes through `output`.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

#[cfg(feature = "bench")]
pub mod bench;
pub mod check;
pub mod clock;
pub mod command;
#[cfg(feature = "emulator")]
pub mod emulator;
pub mod ending;
pub mod evaluate;
pub mod export;
pub mod input;
pub mod output;
pub mod reference;
pub mod replay;
pub mod report;
pub mod sequence;
pub mod soak;
pub mod spread;
pub mod trax;
pub mod vectors;
pub mod words;

/// The most pixels of a template: as many as the 32 bits of a score can sum, for example 256x256.
pub const MOST_PIXELS: usize = 65536;

/// The most offsets of a window on an axis: the whole of a frame of up to about 4000x4000 pixels.
pub const MOST_OFFSETS: usize = 4096;

/// A target of the paper's tracker as this program follows it, as large as it can be.
pub type Paper = smr_core::Paper<MOST_PIXELS, MOST_OFFSETS>;
