//! Stands for the refiner in a build without the feature `refiner`. All types are empty, and the compiler removes the
//! calls. Signatures are those of `refiner/`; [`Config::refines`](super::Config) is false.

use super::features::Sampling;
use crate::image::{FineRect, Frame, Rect};
use crate::kernels::Backend;
use crate::track::State;
use crate::track::saved::{Reader, Writer};
use crate::track::update::Budget;
use heapless::Vec;

pub(super) const SAVED: usize = 0;
pub(super) const CROP_WORK: u32 = 0;
pub(super) const WORK: u32 = 0;

type Outputs = [i32; 6];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Correction;

impl Correction {
    pub(super) const NONE: Self = Self;

    pub(super) fn take(&mut self, _: Outputs) {}

    pub(super) fn fade(&mut self) {}

    pub(super) fn correct(&self, target: FineRect) -> FineRect {
        target
    }

    pub(super) fn save(&self, _: &mut Writer<'_>) {}

    pub(super) fn read(_: &mut Reader<'_>) -> Option<Self> {
        Some(Self)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Opinion;

impl Opinion {
    pub(super) const BEST: Self = Self;

    pub(super) fn follow(&mut self, _: Outputs) {}

    pub(super) fn agree(&mut self) {}

    pub(super) fn state(self) -> State {
        State::Tracking
    }

    pub(super) fn save(self, _: &mut Writer<'_>) {}

    pub(super) fn read(_: &mut Reader<'_>) -> Option<Self> {
        Some(Self)
    }
}

pub(super) struct First;

impl First {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self
    }

    pub(super) fn keep(&mut self, _: &[i8]) {}

    pub(super) fn save(&self, _: &mut Writer<'_>) {}

    pub(super) fn read<'a>(_: &mut Reader<'a>) -> Option<&'a [u8]> {
        Some(&[])
    }

    pub(super) fn restore(&mut self, _: &[u8]) {}
}

#[derive(Clone, Copy)]
pub(super) enum FirstCrop {}

impl FirstCrop {
    pub(super) fn begin<const N: usize>(_: FineRect, _: Rect, _: &mut Sampling, _: &mut Vec<i8, N>) -> Option<Self> {
        None
    }

    pub(super) fn next_row(&mut self, _: &Frame<'_>, _: &mut Sampling, _: &mut [i8], _: &mut Budget) -> bool {
        match *self {}
    }
}

#[derive(Clone, Copy)]
pub(super) enum Refiner {}

impl Refiner {
    pub(super) fn begin<const N: usize>(_: FineRect, _: Rect, _: &mut Sampling, _: &mut Vec<i8, N>) -> Option<Self> {
        None
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
