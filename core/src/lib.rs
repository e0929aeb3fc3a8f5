//! Visual tracking of one target in 8-bit grayscale frames by the *Similarity Matching Ratio* (SMR).
//!
//! The **template** G is the last appearance of the target. It is compared with the frame F at every **offset** of a
//! **search window** around the last position:
//!
//! score = sum of exp(-|F - G| / 255) over the pixels with |F - G| < alpha
//!
//! The offset with the largest **score** is the **peak**. Its patch becomes the next template. alpha is the
//! **threshold**: a pixel that differs more adds 0. So a hand in front of the target costs only the pixels it hides.
//! From Dundar, Jin and Culurciello, "Visual Tracking with Similarity Matching Ratio" (VISAPP 2013).
//!
//! The crate is `no_std`, allocates nothing, and uses integers only (except in `pursuit`). Its answers are the same,
//! bit for bit, on every platform.
//!
//! ```
//! use smr_core::paper::{Config, Radius};
//! use smr_core::{Frame, Image, Paper, Rect, State, Tracker};
//!
//! // A 64x48 frame with a bright 8x8 target with a dark corner at (left, top).
//! fn picture(left: usize, top: usize) -> Vec<u8> {
//!     let mut pixels = vec![20; 64 * 48];
//!     for (y, x) in (0..8).flat_map(|y| (0..8).map(move |x| (y, x))) {
//!         pixels[(top + y) * 64 + left + x] = if x + y < 4 { 90 } else { 200 };
//!     }
//!     pixels
//! }
//!
//! # fn main() -> Result<(), smr_core::Error> {
//! // Room for a template of 256 pixels and a search window of 33 offsets (+-16 pixels) on each axis.
//! let mut config = Config::camera();
//! config.window = Radius { x: 12, y: 12 };
//! config.window_limit = Radius { x: 16, y: 16 };
//! let mut tracker = Tracker::<Paper<256, 33>>::with(config)?;
//!
//! let first = picture(20, 10);
//! tracker.lock(&Frame::whole(Image::new(&first, 64, 48)?), Rect::new(20, 10, 8, 8))?;
//!
//! let second = picture(25, 12);
//! let answer = tracker.update(&Frame::whole(Image::new(&second, 64, 48)?))?;
//! assert_eq!(answer.bbox, Rect::new(25, 12, 8, 8));
//! assert_eq!(answer.state, State::Tracking);
//! assert_eq!(answer.ratio, 65535); // every pixel matched exactly
//! # Ok(())
//! # }
//! ```
//!
//! # Two trackers with the same calls
//!
//! [`Paper`] is the paper tracker: fast, for a target that keeps its size. [`Robust`] also follows changes of size,
//! light and view, and searches the whole frame for a lost target, part by part (not always with success). It takes
//! more time and memory. A [`Tracker`] of either kind locks, updates (in steps, if there is a deadline), reports the
//! window that it reads, and is saved and restored. Generic code takes a [`Target`].
//!
//! # Data flow
//!
//! A [`Frame`] borrows its pixels; a [`Readout`](readout::Readout) fills one line by line. A tracker scores the offsets
//! of its window (see [`similarity`]), decides on the [`Answer`], and updates the template.
//!
//! # Memory and time
//!
//! A target is the state kept from frame to frame, a workspace the scratch memory that any number of targets can share.
//! A [`Tracker`] holds one of each. [`Paper<PIXELS, SPAN>`] takes `PIXELS` bytes, its workspace `PIXELS + 20 * SPAN`.
//! [`Robust`] takes 11.4 KB and its workspace 39.2, `Robust<Small>` 9.2 and 34.2: see [`robust::Size`].
//!
//! [`Target::most_work`] computes an upper bound of the work of an update. For [`Paper`], boxes of at least 8x8 pixels
//! and windows of at least +-4 it is at most 1.25 * (offsets in the window) * (pixels of the template) comparisons, or
//! twice that in a frame in which the target begins to leave the frame. A clearly visible target takes about a tenth.
//!
//! # Features
//!
//! - `std`: detects the instruction sets of the machine at run time; see [`similarity::Backend`].
//! - `defmt`: the public types implement `defmt::Format`; `record::to_defmt` writes a flight record to the log.
//! - `unstable`: the module `unstable` gives tests access to the inside of the trackers. It may change in any version.
//! - `refiner`: a small learned network corrects the box of [`Robust`]. 26 KB of flash.
//! - `pursuit`: the module `pursuit` keeps the target centred with a pan/tilt head, through the traits of embedded-hal.

#![no_std]
// docs.rs shows which feature an item needs.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![deny(missing_docs, missing_debug_implementations)]
#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]
#![warn(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

// Rules for inlining. Flash and stack are scarce in firmware, so attributes decide, not the compiler:
//
// - `#[inline(never)]`: several callers share one copy of the function in flash. With `cfg_attr(smr_small, ...)` only
//   where every byte of code counts: on bare metal and in WebAssembly (see build.rs).
// - `#[inline(always)]`: the function has one caller, or only forwards its arguments, or returns a large value that is
//   then built in place. In `kernels`: vector code must become part of a function with `#[target_feature]`.
// - `#[inline]`: other crates may inline it, too.
//
// A comment beside the attribute gives any other reason.

#[cfg(any(test, feature = "std"))]
extern crate std;

#[macro_use]
mod error_enums;

mod error;
mod image;
mod kernels;
#[cfg(test)]
#[path = "../../tests/missing.rs"]
mod missing;
#[cfg(feature = "pursuit")]
pub mod pursuit;
pub mod similarity;
mod track;
#[cfg(feature = "unstable")]
pub mod unstable;

/// Runs the examples of the README as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use error::Error;
pub use image::readout;
pub use image::{FineRect, Frame, FrameError, Image, ImageError, Rect, WindowError, Windows};
pub use track::calls;
pub use track::paper;
pub use track::paper::target::Paper;
pub use track::record;
pub use track::robust;
pub use track::robust::target::Robust;
pub use track::{
    Answer, ConfigError, LockError, MostWork, Quality, RestoreError, SaveError, Setting, Settings, Shape, State, Steps,
    Target, Tracker, UpdateError,
};
