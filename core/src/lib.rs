//! Follows one target through 8-bit grayscale frames by the *Similarity Matching Ratio* (SMR).
//!
//! The target's last appearance, the **template**, is compared with every **offset** of a **search window** around its
//! last position. A pixel counts only if it differs by less than the **threshold** (alpha) and then adds its
//! **similarity** exp(-difference / 255): *how well* the target is matched is asked, *how badly* is not, so a hand passing in
//! front of it costs only the pixels it hides. The offset with the largest **score** is the **peak**; its patch becomes
//! the next template. The method is that of Dundar, Jin and Culurciello, "Visual Tracking with Similarity Matching
//! Ratio" (VISAPP 2013).
//!
//! The crate is `no_std`, allocates nothing, uses integers only (except in `pursuit`), and reads only the window it asks for.
//! Its scores are exact: the same frames give the same answers, bit for bit, on every platform.
//!
//! ```
//! use smr_core::paper::{Config, Radius};
//! use smr_core::{Frame, Image, Paper, Rect, State, Tracker};
//!
//! // A bright 8x8 target with a dark corner, on a 64x48 frame; it stands at (left, top).
//! fn picture(left: usize, top: usize) -> Vec<u8> {
//!     let mut pixels = vec![20; 64 * 48];
//!     for (y, x) in (0..8).flat_map(|y| (0..8).map(move |x| (y, x))) {
//!         pixels[(top + y) * 64 + left + x] = if x + y < 4 { 90 } else { 200 };
//!     }
//!     pixels
//! }
//!
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! // Room for a template of 256 pixels and for a search window of 33 offsets on each axis: +-16 pixels.
//! let mut config = Config::camera();
//! config.window = Radius { x: 12, y: 12 };
//! config.window_limit = Radius { x: 16, y: 16 };
//! let mut tracker = Tracker::<Paper<256, 33>>::new(config)?;
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
//! # Two trackers, one way to use them
//!
//! [`Paper`] is the paper's tracker: fast, exact, for a target that keeps its size. [`Robust`] goes beyond the paper: it follows changing
//! size, light and view, finds a lost target again anywhere in the frame, and takes more time and memory. Everything else is the same: a
//! [`Tracker`] locks, updates (in steps, if there is a deadline), says which window it needs, is saved and restored. Code for both takes a
//! [`Target`].
//!
//! # The way through the crate
//!
//! Data flows one way: a [`Frame`] is borrowed, [`search`] decides which offsets are scored, [`similarity`] scores
//! them, and the tracker turns what was found into an [`Answer`] and, where it may, into the next template.
//!
//! # Memory and time
//!
//! A target is what must be remembered; the scratch memory beside it, a workspace, serves any number of targets. A [`Tracker`]
//! holds one of each. There is no heap. [`Paper<PIXELS, SPAN>`] takes `PIXELS` bytes, its workspace as many and five words for each of
//! `SPAN` offsets. [`Target::most_work`] says how much work an update can be at most: for boxes of 8x8 pixels and windows of +-4 or
//! more at most 1.25 times (offsets in the window) x (pixels of the template) comparisons, and twice that in the frame in which a tracked target
//! begins to leave the picture. Where the target is seen clearly, it is about a tenth of that.
//!
//! # Features
//!
//! - `std`: asks the machine at run time which instruction sets it has; see [`similarity::Backend`].
//! - `verify`: runs the plain loops beside every call of a faster backend, and panics where they differ.
//! - `defmt`: the public types implement `defmt::Format`; `record::to_defmt` writes a flight record to its log.
//! - `pursuit`: module `pursuit` keeps the target centred with a pan/tilt head, through the traits of embedded-hal.

#![no_std]
#![deny(missing_docs)]
#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]
#![warn(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[cfg(any(test, feature = "std"))]
extern crate std;

mod correlation;
mod image;
mod kernels;
#[cfg(feature = "pursuit")]
pub mod pursuit;
pub mod search;
pub mod similarity;
mod track;

/// The example of the README is a test, too.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use image::{FineRect, Frame, FrameError, Image, ImageError, Rect};
pub use track::paper::{self, Paper};
pub use track::record;
pub use track::robust::{self, Robust};
pub use track::{
    Answer, ConfigError, Lock, LockError, MostWork, Quality, RestoreError, SaveError, State, Target, Tracker, Update,
    UpdateError,
};
