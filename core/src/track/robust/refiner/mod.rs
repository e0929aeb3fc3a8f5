//! The refiner: a small learned network that corrects the box of the answer (feature `refiner`).
//!
//! The filter's box has one scale for width and height, and lags behind a target that comes nearer or turns. The
//! network compares the target in the first and in the present frame, and estimates the error of the box ([`network`]).
//! The correction follows the estimates from frame to frame ([`correction`]). It changes only the answer: moving or
//! scaling the tracker's place by them gained nothing on the recordings. The network also estimates how large its
//! errors may be ([`opinion`]), and judges whether the box shows the target at all ([`identity`]). Both can make the
//! state worse. A low identity also takes evidence from the frame, and refuses what redetection finds.
//!
//! ```text
//! before the decision:            crop -> layers 1 to 4 -> two full layers -> identity, correction, opinion
//! in a window of redetection:     crop -> layers 1 to 4 -> two full layers -> identity, if the evidence suffices
//! at a lock:                      crop, which is kept as the first
//! ```
//!
//! The correction changes only in frames that the tracker learns from, so that an uncertain view changes no box. The
//! network does not run if the early template gives the exact place and size, or if the patch cannot show the target.
//! Cost of a run: 1024 samples and 428,200 products.

mod correction;
mod crop;
mod identity;
mod network;
mod opinion;

pub(super) use crop::{First, FirstCrop, reachable};
pub(super) use identity::Logit;
#[cfg(feature = "unstable")]
pub(crate) use network::REFINER_WEIGHTS;

use super::features::Sampling;
use crate::image::{FineRect, Frame, Rect};
use crate::kernels::{Backend, Dense};
use crate::track::State;
use crate::track::saved::{Reader, Writer};
use crate::track::update::Budget;
use correction::Correction;
use crop::Crop;
use heapless::VecView;
use identity::Identity;
pub(super) use network::Outputs;
use network::{Layers, ROOM};
use opinion::Opinion;

pub(super) const SAVED: usize = Correction::SAVED + Opinion::SAVED + Identity::SAVED + First::SAVED;
/// Upper bounds of the work for sampling a crop, and for the refiner in a frame.
pub(super) const CROP_WORK: u32 = crop::WORK;
pub(super) const WORK: u32 = CROP_WORK + network::WORK;

/// The refiner's results, from frame to frame: the correction of the box, the mean trust in the box (the opinion), and
/// the identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Review {
    correction: Correction,
    opinion: Opinion,
    identity: Identity,
}

impl Review {
    pub(super) const NONE: Self =
        Self { correction: Correction::NONE, opinion: Opinion::BEST, identity: Identity::SURE };

    /// Updates the review in a frame in which the early template gives the exact place and size. Returns true if the
    /// opinion doubts the target even so.
    pub(super) fn agree(&mut self) -> bool {
        self.correction.fade();
        self.opinion.agree();
        self.opinion.doubts()
    }

    /// Updates the review by an estimate. The correction changes only if the tracker has `learned` from the frame.
    /// Returns true if the opinion doubts the target.
    pub(super) fn update(&mut self, estimate: &Outputs, learned: bool) -> bool {
        self.opinion.update(estimate);
        if learned {
            self.correction.add(estimate);
        }
        self.opinion.doubts()
    }

    pub(super) fn identify(&mut self, logit: Logit) {
        self.identity.update(logit);
    }

    pub(super) fn correct(&self, target: FineRect) -> FineRect {
        self.correction.correct(target)
    }

    /// Starts again as *uncertain*, for a target that redetection has found.
    pub(super) fn begin_again(&mut self) {
        self.opinion.begin_again();
        self.identity.begin_again();
    }

    /// The best state that the opinion and the identity allow.
    pub(super) fn state(&self) -> State {
        let (opinion, identity) = (self.opinion.state(), self.identity.state());
        if identity.code() > opinion.code() { identity } else { opinion }
    }

    /// The identity for the answer, in units of 1/65535.
    pub(super) fn identity(&self) -> u16 {
        self.identity.value()
    }

    pub(super) fn save(&self, to: &mut Writer<'_>) {
        self.correction.save(to);
        self.opinion.save(to);
        self.identity.save(to);
    }

    pub(super) fn read(from: &mut Reader<'_>) -> Option<Self> {
        Some(Self {
            correction: Correction::read(from)?,
            opinion: Opinion::read(from)?,
            identity: Identity::read(from)?,
        })
    }
}

#[derive(Clone, Copy)]
pub(super) enum Refiner {
    /// Samples the box and its surroundings in the present frame.
    Crop(Crop),
    Layers(Layers),
}

impl Refiner {
    /// Begins with the crop of the box `target`. `bytes` become the memory of patches and layers.
    #[inline(always)] // its only caller is a function that is not inlined
    pub(super) fn begin(
        target: FineRect,
        bounds: Rect,
        sampling: &mut Sampling,
        bytes: &mut VecView<i8>,
    ) -> Option<Self> {
        bytes.clear();
        // Cannot fail: `bytes` has room for the features of a search window, which take more memory than `ROOM`.
        let _ = bytes.resize_default(ROOM);
        Some(Self::Crop(Crop::begin(target, bounds, sampling)))
    }

    /// Runs one piece of work. Returns the network's estimate after the last piece.
    pub(super) fn next_piece(
        &mut self,
        backend: Backend,
        frame: &Frame<'_>,
        first: &First,
        sampling: &mut Sampling,
        bytes: &mut [i8],
        budget: &mut Budget,
    ) -> Option<Outputs> {
        match self {
            Self::Crop(crop) => {
                let present = network::room_for_crop(bytes);
                if present.is_none_or(|present| crop.next_row(frame, sampling, present, budget)) {
                    *self = Self::Layers(Layers::begin(first.crop(), bytes, budget));
                }
                None
            }
            Self::Layers(layers) => layers.next_row(Dense::new(backend), bytes, budget),
        }
    }
}
