//! The refiner: a small learned network that corrects the box of the answer. It needs the feature `refiner`.
//!
//! The filter finds the target, but its box has one scale for width and height, and lags behind a target that comes
//! nearer or turns. The network compares the target in the first frame and in the present one, and estimates the error
//! of the box ([`network`]). The estimates are carried from frame to frame ([`correction`]). It corrects only the
//! answer: place and scale of the tracker, and what it learns, stay as they are. (Moving the place or changing the
//! scale by the estimates gained nothing on the recordings.)
//!
//! ```text
//! after learning:  crop -> layers 1 to 4 -> two full layers -> correction
//! at a lock:       crop, which is kept
//! ```
//!
//! It runs only in frames that the tracker learns from, so that an uncertain view changes no box. It does not run if
//! the early template gives the exact place and size. Cost: 1024 samples and 428,176 products.

mod correction;
mod crop;
mod network;

pub(super) use correction::Correction;
pub(super) use crop::{Crop, FIRST, reachable};
#[cfg(feature = "unstable")]
pub(crate) use network::REFINER_WEIGHTS;
pub(super) use network::{ROOM, WORK};

use super::sampling::Sampling;
use crate::image::Frame;
use crate::kernels::Dense;
use crate::track::budget::Budget;
use network::{Layers, Outputs};

/// The stages of the refiner in one frame.
#[derive(Clone, Copy)]
pub(super) enum Refiner {
    /// Samples the present target.
    Crop(Crop),
    /// Runs the layers of the network.
    Layers(Layers),
}

impl Refiner {
    /// Does one piece of work. Returns the network's estimate after the last piece. `first` is the crop of the first
    /// frame, `cells` scratch memory.
    pub(super) fn next_piece(
        &mut self,
        dense: Dense,
        frame: &Frame<'_>,
        first: &[i8],
        sampling: &mut Sampling,
        cells: &mut [i8],
        budget: &mut Budget,
    ) -> Option<Outputs> {
        match self {
            Self::Crop(crop) => {
                let present = network::room_for_crop(cells);
                if present.is_none_or(|present| crop.next_row(frame, sampling, present, budget)) {
                    *self = Self::Layers(Layers::begin(first, cells, budget));
                }
                None
            }
            Self::Layers(layers) => layers.next_row(dense, cells, budget),
        }
    }
}
