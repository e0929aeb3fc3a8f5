//! The robust tracker follows targets that change in light, size and view, and reports when it is uncertain.
//!
//! A correlation filter finds the target, and learns it and its surroundings in every frame with enough evidence. An
//! early template, which learns very slowly, verifies the target: SMR (the similarity matching ratio of the paper)
//! compares it tile by tile. All arithmetic is in integers.
//!
//! ```text
//!                                                                                                M units of work
//!   frame
//!     |
//!  motion        where the target is expected
//!     |
//!  sampling      the search window on the target's grid (grid), smaller around a calm target (calm)
//!  cells         gradient orientations and gray, cell by cell                                        1.40
//!     |
//!  response      the filter at all offsets, its peak                                                 0.55
//!     |
//!  verification  the agreement with the early template (template), aligned (alignment) and relit
//!     |          (lighting)                                                                          0.62
//!  refinement    place and size to a fraction of a pixel                                             0.06
//!     |
//!  scale         the response at other scales, if refinement has not found the size                  0.82
//!     |
//!  learning      if there is enough evidence: ridge regression on a Gaussian label (gaussian)        0.97
//!     |
//!  refiner       the box by a small learned network, its opinion of it, and the identity (feature `refiner`)
//!     |
//!  confidence    the state: tracking, uncertain, lost
//!     |      \
//!     |       redetection   if the target is lost: up to four windows, searched and verified        10.28
//!     |
//!   answer        its state is the worst of confidence, opinion and identity                   13.79 in all
//! ```
//!
//! The figures are the most work of each stage in millions of units, in the largest window of the standard size and
//! without the refiner (`run/most_work.rs`; a unit is about one instruction of a Cortex-M4). The sum is that of a frame
//! with redetection instead of learning, and includes the coding of the weights.
//!
//! | folder or file | what it does |
//! |---|---|
//! | `features/`, `filter/`, `verification/`, `refiner/` | these stages |
//! | `decision/` | confidence, redetection, and the memory of a target from frame to frame, also as bytes |
//! | `run/` | runs a frame through the stages in pieces, for an update and a lock; the memory of each [`Size`] |
//! | `target.rs` | the public calls, and the workspace |
//! | `arithmetic.rs` | 64-bit division |
//! | `constants.rs` | constants that several stages share and that are not in [`Config`] |
//!
//! R, the success rate, is the fraction of frames with an IoU above 0.25, as a mean over 90 recordings, started on the
//! first frame's annotated box. Changes of R with another value of a constant have a standard error (paired
//! differences). R is 0.802 with the present values (`host-sim eval --robustness --starts 1 --method robust`). Constants
//! without such a line were not measured one by one; `host-sim/RESULTS.md` shows the effect of each part of the tracker.

mod arithmetic;
pub(crate) mod config;
mod constants;
mod decision;
mod features;
mod filter;
#[cfg(feature = "refiner")]
mod refiner;
#[cfg(not(feature = "refiner"))]
#[path = "refiner/without_feature.rs"]
mod refiner;
mod run;
pub(crate) mod target;
#[cfg(test)]
mod tests;
mod verification;

pub use config::Config;
#[cfg(feature = "unstable")]
pub(crate) use constants::SPAN;
pub use constants::{CELL, CHANNELS, REACH};
pub use features::Grid;
#[cfg(all(feature = "refiner", feature = "unstable"))]
pub(crate) use refiner::REFINER_WEIGHTS;
pub use run::{Size, Small, Standard};
#[cfg(any(test, feature = "unstable"))]
pub(crate) use target::Robust;
pub use target::Workspace;
