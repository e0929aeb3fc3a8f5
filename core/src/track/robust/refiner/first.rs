//! The crop of the first frame, with which the network compares the present one.

use super::super::sampling::Sampling;
use super::crop::{Crop, SAMPLES};
use crate::image::{FineRect, Frame, Rect};
use crate::track::budget::Budget;
use crate::track::saved::{Reader, Writer};
use heapless::Vec;

/// The target in the first frame, as the network sees it. Empty before the first lock, and without the refiner.
pub(in super::super) struct First {
    crop: Vec<i8, SAMPLES>,
}

impl First {
    /// Bytes of the saved form.
    pub(super) const SAVED: usize = SAMPLES;

    #[inline(always)]
    pub(in super::super) const fn new() -> Self {
        Self { crop: Vec::new() }
    }

    pub(super) fn crop(&self) -> &[i8] {
        &self.crop
    }

    /// Keeps the crop that [`FirstCrop`] has sampled.
    pub(in super::super) fn keep(&mut self, bytes: &[i8]) {
        self.crop.clear();
        // Cannot fail: there is room for all.
        let _ = self.crop.extend_from_slice(bytes.get(..SAMPLES).unwrap_or_default());
    }

    pub(in super::super) fn save(&self, to: &mut Writer<'_>) {
        self.crop.iter().for_each(|input| to.put(&input.to_le_bytes()));
    }

    /// Reads a saved crop for [`First::restore`]; `None` if a sample is out of range.
    pub(in super::super) fn read<'a>(from: &mut Reader<'a>) -> Option<&'a [u8]> {
        from.slice(SAMPLES).filter(|crop| crop.iter().all(|&input| input <= 127))
    }

    pub(in super::super) fn restore(&mut self, crop: &[u8]) {
        self.crop.clear();
        // Cannot fail: there is room for all.
        let _ = self.crop.resize_default(SAMPLES);
        self.crop.iter_mut().zip(crop).for_each(|(to, input)| *to = input.cast_signed());
    }
}

/// The stage of a lock that samples the crop of the first frame.
#[derive(Clone, Copy)]
pub(in super::super) struct FirstCrop(Crop);

impl FirstCrop {
    /// Begins the crop of the box `target` in `bytes`.
    pub(in super::super) fn begin<const N: usize>(
        target: FineRect,
        bounds: Rect,
        sampling: &mut Sampling,
        bytes: &mut Vec<i8, N>,
    ) -> Option<Self> {
        // Cannot fail: the features at one scale take more.
        let _ = bytes.resize_default(SAMPLES);
        Some(Self(Crop::begin(target, bounds, sampling)))
    }

    /// Samples a row. True after the last row.
    pub(in super::super) fn next_row(
        &mut self,
        frame: &Frame<'_>,
        sampling: &mut Sampling,
        bytes: &mut [i8],
        budget: &mut Budget,
    ) -> bool {
        bytes.first_chunk_mut().is_none_or(|crop| self.0.next_row(frame, sampling, crop, budget))
    }
}
