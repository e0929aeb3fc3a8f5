//! The refiner in a build without the feature `refiner`: its memory is an empty struct, and its stages are an enum
//! without variants. [`Config::refines`](super::Config) is false, so the compiler removes all calls.

use super::features::Sampling;
use crate::image::{FineRect, Frame, Rect};
use crate::kernels::Backend;
use crate::track::State;
use crate::track::saved::{Reader, Writer};
use crate::track::update::Budget;
use heapless::VecView;

pub(super) const SAVED: usize = 0;
pub(super) const CROP_WORK: u32 = 0;
pub(super) const WORK: u32 = 0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Review;
pub(super) use Review as First;

impl Review {
    pub(super) const NONE: Self = Self;

    pub(super) fn agree(&mut self) -> bool {
        false
    }

    pub(super) fn begin_again(&mut self) {}

    pub(super) fn update(&mut self, (): &Outputs, _: bool) -> bool {
        false
    }

    pub(super) fn identify(&mut self, _: Logit) {}

    pub(super) fn identity(&self) -> u16 {
        0
    }

    pub(super) fn correct(&self, target: FineRect) -> FineRect {
        target
    }

    pub(super) fn state(&self) -> State {
        State::Tracking
    }

    pub(super) fn keep(&mut self, _: &[i8]) {}

    pub(super) fn save(&self, _: &mut Writer<'_>) {}

    pub(super) fn read(_: &mut Reader<'_>) -> Option<Self> {
        None
    }

    pub(super) fn restore(&mut self, _: &mut Reader<'_>) -> Option<()> {
        None
    }
}

pub(super) type Outputs = ();

#[derive(Clone, Copy)]
pub(super) struct Logit;

impl Logit {
    pub(super) const EXACT: Self = Self;

    pub(super) fn of((): &Outputs) -> Self {
        Self
    }

    pub(super) fn veto(self) -> i32 {
        0
    }

    pub(super) fn finds(self) -> bool {
        true
    }
}

#[derive(Clone, Copy)]
pub(super) enum Refiner {}
pub(super) use Refiner as FirstCrop;

impl Refiner {
    pub(super) fn begin(_: FineRect, _: Rect, _: &mut Sampling, _: &mut VecView<i8>) -> Option<Self> {
        None
    }

    pub(super) fn next_row(&mut self, _: &Frame<'_>, _: &mut Sampling, _: &mut [i8], _: &mut Budget) -> bool {
        match *self {}
    }

    pub(super) fn next_piece(
        &mut self,
        _: Backend,
        _: &Frame<'_>,
        _: &First,
        _: &mut Sampling,
        _: &mut [i8],
        _: &mut Budget,
    ) -> Option<Outputs> {
        match *self {}
    }
}

pub(super) fn reachable(_: FineRect, _: i64, _: Rect) -> Rect {
    Rect::default()
}
