//! The crop of a target, the input of the network: 32x32 samples of its box and surroundings.
//!
//! ```text
//! sides = 1.75 * sides of the box                         with a sampling step each for width and height
//! x     = 64 + (pixel - mean) * 2^21 / (sqrt(sum of (pixel - mean)^2) + 128) / 2^12,  clamped to 0 to 127
//! ```
//!
//! So x is 64 at the mean and changes by 16 for each standard deviation. The 128 limits the noise of a plain crop.

use super::super::features::{Lattice, SAMPLED, Sampling};
use crate::image::{FineRect, Frame, Rect};
use crate::kernels::{rolled, root};
use crate::track::saved::{Reader, Writer};
use crate::track::update::{Budget, units};
use heapless::{Vec, VecView};

pub(super) const SIDE: usize = ROWS as usize;
/// `SIDE` in the type of a lattice's columns and rows.
const ROWS: u16 = 32;
pub(super) const SAMPLES: usize = SIDE * SIDE;
/// Units of work for each sample that is normalised.
const NORMALISED: u32 = 16;
/// Upper bound of the work for a crop, in units. The sampling steps across and down average less than two sides of a
/// block of pixels, so the crop covers at most (2 * `side` + 2)^2 blocks. It reads at most four pixels of each.
pub(super) const WORK: u32 = {
    let side = ROWS as u32;
    side * side * (SAMPLED + NORMALISED) + 4 * (2 * side + 2) * (2 * side + 2)
};
/// The input of the network for a sample whose gray level is the mean of the crop.
pub(super) const MEAN: i8 = 64;

#[derive(Clone, Copy)]
pub(crate) struct Crop(());

/// The crop's sampling steps in units of 1/4096 pixel: 1.75 / 32 of the box's sides, which have units of 1/256 pixel.
fn steps([width, height]: [u32; 2]) -> [i64; 2] {
    [width, height].map(|side| ((7 * i64::from(side)) >> 3).max(1))
}

/// The middle of a box, in units of 1/4096 pixel. A pixel's position is that of its middle, half a pixel from its edge.
fn middle(FineRect { x, y, width, height }: FineRect) -> [i64; 2] {
    [(x, width), (y, height)].map(|(from, side)| ((i64::from(from) + i64::from(side / 2)) << 4) - (1 << 11))
}

#[inline(never)]
fn crop_of(target: FineRect) -> Lattice {
    let ([x, y], [step, step_down]) = (middle(target), steps([target.width, target.height]));
    Lattice { x, y, step, step_down, columns: ROWS, rows: ROWS }
}

/// The rectangle of frame pixels that the crop of a box may read, if the box moves by up to `by` / 4096 pixels. A crop
/// reads less than two blocks beyond its samples. A block's side is one pixel, or at most the mean of both steps.
#[inline(never)]
pub(crate) fn reachable(target: FineRect, by: i64, bounds: Rect) -> Rect {
    let ([x, y], [right, down]) = (middle(target), steps([target.width, target.height]));
    let blocks = right + down + (2 << 12);
    let (left, width) = range(x, 16 * right + blocks + by, bounds.width);
    let (top, height) = range(y, 16 * down + blocks + by, bounds.height);
    Rect::new(left, top, width, height)
}

/// The first pixel and the number of pixels of `middle` +- `reach` (1/4096 pixel), on an axis of `size` frame pixels.
#[inline(never)]
fn range(middle: i64, reach: i64, size: u16) -> (i32, u16) {
    let last = i64::from(size.max(1)) - 1;
    let at = |place: i64| i32::try_from((place >> 12).clamp(0, last)).unwrap_or(0);
    // The crop of a box beyond the frame's edge reads the blocks at the edge.
    let middle = middle.clamp(0, last << 12);
    let (from, to) = (at(middle - reach), at(middle + reach));
    (from, u16::try_from(to - from + 1).unwrap_or(u16::MAX))
}

impl Crop {
    #[inline(never)]
    pub(super) fn begin(target: FineRect, bounds: Rect, sampling: &mut Sampling) -> Self {
        crop_of(target).prepare(bounds, sampling);
        Self(())
    }

    /// Samples the next row of `crop`. After the last row normalises the crop and returns true.
    #[inline(never)]
    pub(super) fn next_row(
        &mut self,
        frame: &Frame<'_>,
        sampling: &mut Sampling,
        crop: &mut [i8; SAMPLES],
        budget: &mut Budget,
    ) -> bool {
        let (mut samples, row) = ([0; SIDE], usize::from(sampling.next()));
        let done = sampling.next_row_alone(frame, &mut samples);
        let (rows, _) = crop.as_chunks_mut::<SIDE>();
        if let Some(row) = rows.get_mut(row) {
            rolled(row.iter_mut().zip(samples)).for_each(|(to, sample)| *to = sample.cast_signed());
        }
        budget.spend(sampling.take_work(SAMPLED));
        if !done {
            return false;
        }
        normalise(crop);
        budget.spend(NORMALISED * units(SAMPLES));
        true
    }
}

/// Replaces samples by network inputs. Nothing overflows: `squares` is below 2^26, and a sample's deviation from the
/// mean times `gain` is at most 255 * 2^14.
#[inline(never)]
fn normalise(crop: &mut [i8; SAMPLES]) {
    let sample = |&sample: &i8| i32::from(sample.cast_unsigned());
    let mean = (rolled(crop.iter()).map(sample).sum::<i32>() + (1 << 9)) >> 10;
    let squares = rolled(crop.iter()).map(|at| (sample(at) - mean).unsigned_abs().pow(2)).sum::<u32>();
    let gain = ((1 << 21) / (root(squares) + 128)).cast_signed();
    for at in rolled(crop.iter_mut()) {
        let input = (((sample(at) - mean) * gain) >> 12) + i32::from(MEAN);
        *at = i8::try_from(input.max(0)).unwrap_or(i8::MAX);
    }
}

/// The crop of the target in the first frame. Empty before the first lock, and without the refiner.
pub(crate) struct First {
    crop: Vec<i8, SAMPLES>,
}

impl First {
    pub(super) const SAVED: usize = SAMPLES;

    pub(crate) const NONE: Self = Self { crop: Vec::new() };

    pub(super) fn crop(&self) -> &[i8] {
        &self.crop
    }

    /// Stores the crop that [`FirstCrop`] has sampled.
    pub(crate) fn keep(&mut self, bytes: &[i8]) {
        self.crop.clear();
        // Cannot fail: the capacity is that of a crop.
        let _ = self.crop.extend_from_slice(bytes.get(..SAMPLES).unwrap_or_default());
    }

    pub(crate) fn save(&self, to: &mut Writer<'_>) {
        self.crop.iter().for_each(|input| to.put(&input.to_le_bytes()));
    }

    /// Restores a saved crop. `None`, and no change, if the bytes are fewer or more than a crop or one is above 127.
    pub(crate) fn restore(&mut self, from: &mut Reader<'_>) -> Option<()> {
        let crop = from.slice(SAMPLES).filter(|crop| from.is_empty() && crop.iter().all(|&input| input <= 127))?;
        self.crop.clear();
        // Cannot fail: the capacity is that of a crop.
        let _ = self.crop.resize_default(SAMPLES);
        self.crop.iter_mut().zip(crop).for_each(|(to, input)| *to = input.cast_signed());
        Some(())
    }
}

/// The stage of a lock that samples the crop of the first frame.
#[derive(Clone, Copy)]
pub(crate) struct FirstCrop(Crop);

impl FirstCrop {
    /// Begins to sample the crop of the box `target` into `bytes`.
    pub(crate) fn begin(
        target: FineRect,
        bounds: Rect,
        sampling: &mut Sampling,
        bytes: &mut VecView<i8>,
    ) -> Option<Self> {
        // Cannot fail: the memory has room for the features at one scale, which take more bytes than a crop.
        let _ = bytes.resize_default(SAMPLES);
        Some(Self(Crop::begin(target, bounds, sampling)))
    }

    pub(crate) fn next_row(
        &mut self,
        frame: &Frame<'_>,
        sampling: &mut Sampling,
        bytes: &mut [i8],
        budget: &mut Budget,
    ) -> bool {
        bytes.first_chunk_mut().is_none_or(|crop| self.0.next_row(frame, sampling, crop, budget))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_64_at_the_mean_and_have_bounds() {
        let mut crop = [0; SAMPLES];
        crop.iter_mut().enumerate().for_each(|(at, to)| *to = if at % 2 == 0 { -56 } else { 100 }); // 200 and 100
        normalise(&mut crop);
        assert_eq!([crop[0], crop[1]], [78, 49]);
        let mut plain = [-1; SAMPLES];
        normalise(&mut plain);
        assert_eq!(plain, [MEAN; SAMPLES]);
        let mut spot = [0; SAMPLES];
        spot[7] = -1;
        normalise(&mut spot);
        assert_eq!([spot[0], spot[7]], [64, 127]);
    }

    /// Checks that `reachable` contains every pixel that a crop reads.
    #[test]
    fn a_crop_stays_within_reach() {
        let bounds = Rect::new(0, 0, 900, 700);
        for (width, height) in [(40, 40), (13, 9), (300, 40), (30, 600), (5, 5), (420, 420)] {
            for (x, y) in [(200, 150), (3, 640), (-20, -5), (850, 20)] {
                let target =
                    FineRect { x: x * 256 + 77, y: y * 256 - 31, width: width * 256 + 11, height: height * 256 };
                let (read, reach) = (crop_of(target).pixels(bounds), reachable(target, 0, bounds));
                assert!(reach.contains(read), "{target:?}: {read:?} is not within {reach:?}");
            }
        }
    }
}
