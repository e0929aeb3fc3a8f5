//! Replays recorded sequences through `smr-core`, the very code that is linked into a camera.
//!
//! - [`sequence`]: where frames and boxes come from.
//! - [`clock`]: how long something takes; [`spread`]: many measurements as three numbers.
//! - [`mod@reference`]: both methods in f64, the one written from the paper, the other from its description.
//! - [`check`]: core against the references, score by score.
//! - [`vectors`]: the conformance vectors, made from the reference.
//! - [`evaluate`]: how well a tracker does, by the protocol of the recordings.
//! - [`report`]: what people look at.
//! - [`output`]: how files are written: whole or not at all.
//! - `target` (feature `emulator`): the firmware in QEMU against the host.
//! - `bench` (feature `bench`): how fast it is here and on the emulated boards, beside OpenCV and a plain SAD search.
//! - [`command`]: what the command line offers; `main` only hands over.

#[cfg(feature = "bench")]
pub mod bench;
pub mod check;
pub mod clock;
pub mod command;
pub mod evaluate;
pub mod output;
pub mod reference;
pub mod report;
pub mod sequence;
pub mod spread;
#[cfg(feature = "emulator")]
pub mod target;
pub mod vectors;

/// The tracker as this program builds it: room for the largest template there can be (256x256 pixels), and for a window
/// of 4096 offsets on each axis, so the whole of a frame of up to about 4000x4000 pixels.
pub type Tracker = smr_core::Tracker<65536, 4096>;
