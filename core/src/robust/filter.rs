//! The filter: a weight for each byte of the cells on the target and around it, so that their sum is 1 where the target is and 0
//! elsewhere.
//!
//! It learns what the target is not, too: by steepest descent it lessens the sum, over all offsets of all samples, of
//! (response - label)^2, and the sum of its squared weights. Each step is as long as is best in its direction, which takes one
//! division.
//!
//! | number | unit | bound |
//! |---|---|---|
//! | response, label | 1/16384 | responses 2^24 |
//! | error | 1/16384 | 65,535, farther ones count as much |
//! | weight | 1/65536 of a response's unit | an `i32` |
//! | coded weight, coded slope | a power of two, chosen each time | 8191 |
//! | gathered error | a power of two, chosen each time | 16,383 |
//! | share of a sample | 1/65536 | all together 65,536 |

use super::MOST_CELLS;
use super::features::CHANNELS;
use super::grid::Grid;
use super::label::Bell;
use super::samples::{OFFSETS, SAMPLES, Sample, Samples};
use crate::similarity::{Layout, Products};
use heapless::Vec;

/// Weights of the largest filter.
const WEIGHTS: usize = MOST_CELLS * CHANNELS;
/// The largest coded number: 2000 of them times a byte stay below 2^31.
const CODED: u64 = 8191;
/// The largest gathered error: 4 samples of 169 of them times a byte stay below 2^31.
const GATHERED: u64 = 16_383;
/// The largest error.
const MOST_ERROR: i64 = 65_535;
/// How much squared weights count: 0.05 where a feature of 1 is 318, which squared is 5056.
const PULL: i64 = 5056;

/// One offset after another.
type Row<T> = [T; OFFSETS];

/// What has been learned.
pub(super) struct Filter {
    weights: Vec<i32, WEIGHTS>,
}

/// Scratch: coded weights, and what it takes to learn.
pub(super) struct Desk {
    coded: Vec<i16, WEIGHTS>,
    gradient: Vec<i32, WEIGHTS>,
    errors: [[Row<i32>; OFFSETS]; SAMPLES],
}

impl Desk {
    pub(super) const fn new() -> Self {
        Self { coded: Vec::new(), gradient: Vec::new(), errors: [[[0; OFFSETS]; OFFSETS]; SAMPLES] }
    }

    /// Responses at all offsets, to the weights that were coded last by `shift`.
    pub(super) fn responses<const N: usize>(
        &self,
        products: Products,
        shift: u32,
        cells: &[i8],
        layout: Layout,
        out: &mut [[i32; N]],
    ) {
        products.responses(cells, layout, &self.coded, out);
        out.as_flattened_mut().iter_mut().for_each(|out| *out = response(*out, shift));
    }
}

/// How the filter lies on cells that reach `span / 2` farther to each side.
pub(super) fn layout(grid: &Grid, span: usize) -> Layout {
    let row = usize::from(grid.across) * CHANNELS;
    Layout { row, stride: row + span.saturating_sub(1) * CHANNELS, step: CHANNELS, span }
}

impl Filter {
    pub(super) const fn new() -> Self {
        Self { weights: Vec::new() }
    }

    /// Knows nothing.
    pub(super) fn start(&mut self, grid: &Grid) {
        self.weights.clear();
        // Cannot fail: a grid has at most MOST_CELLS cells.
        let _ = self.weights.resize_default(usize::from(grid.across) * usize::from(grid.down) * CHANNELS);
    }

    /// Products for each weight that a step of learning takes.
    pub(super) fn work(samples: &Samples) -> u32 {
        let offsets = u32::try_from(OFFSETS * OFFSETS).unwrap_or(0);
        3 * offsets * u32::try_from(samples.count()).unwrap_or(0)
    }

    /// The weights.
    pub(super) fn weights(&self) -> &[i32] {
        &self.weights
    }

    /// Puts the weights on the desk, coded: each stands for itself times 2 to the power that is returned.
    pub(super) fn code(&self, desk: &mut Desk) -> u32 {
        let largest = self.weights.iter().map(|weight| weight.unsigned_abs()).max().unwrap_or(0);
        let shift = shift_to(largest.into(), CODED);
        desk.coded.clear();
        for &weight in &self.weights {
            // Cannot fail: there is room for as many. Not extend, which has a path to a panic.
            let _ = desk.coded.push(code(weight.into(), shift));
        }
        shift
    }

    /// One step of learning. Cost: three products for each weight, offset and sample.
    #[inline(never)] // one copy in flash
    pub(super) fn learn(&mut self, grid: &Grid, samples: &Samples, desk: &mut Desk, products: Products) {
        let layout = layout(grid, OFFSETS);
        let largest = self.errors(grid, samples, desk, products);
        let Desk { coded, gradient, errors } = desk;
        // Where to.
        let shift = shift_to(largest.into(), GATHERED);
        gradient.clear();
        let _ = gradient.resize_default(self.weights.len());
        for (sample, errors) in samples.iter().zip(errors.iter()) {
            let mut coded = [[0; OFFSETS]; OFFSETS];
            let errors = errors.as_flattened().iter();
            coded.as_flattened_mut().iter_mut().zip(errors).for_each(|(to, &error)| *to = code(error.into(), shift));
            products.gather(sample.cells(), layout, &coded, gradient);
        }
        // Errors have their share in 1/65536, of which 1/256 were taken away. Both terms are below 2^51.
        let slope = |(&weight, &sum): (&i32, &i32)| PULL * i64::from(weight) + (i64::from(sum) << (shift + 8));
        let slopes = || self.weights.iter().zip(gradient.iter()).map(slope);
        let steepest = slopes().map(i64::unsigned_abs).max().unwrap_or(0);
        let scale = shift_to(steepest, CODED);
        coded.iter_mut().zip(slopes()).for_each(|(coded, slope)| *coded = code(slope, scale));
        // How far.
        let length = length(samples, coded, layout, products, errors);
        // Lengths have 44 binary places; a product is below 2^46.
        let back = 44u32.saturating_sub(scale);
        for (weight, &slope) in self.weights.iter_mut().zip(coded.iter()) {
            let change = (i64::from(slope) * length + (1 << back >> 1)) >> back;
            *weight = i32::try_from(i64::from(*weight) - change).unwrap_or(*weight);
        }
    }

    /// The errors at all offsets of all samples, each times its sample's share, in units of 1/256 of that; says how large the
    /// largest is.
    fn errors(&self, grid: &Grid, samples: &Samples, desk: &mut Desk, products: Products) -> u32 {
        let bell = Bell::of(grid);
        let (shift, layout) = (self.code(desk), layout(grid, OFFSETS));
        let mut largest = 0;
        for (number, sample) in samples.iter().enumerate() {
            let [across, down] = sample.bell(bell);
            // There are as many as samples.
            let Some(errors) = desk.errors.get_mut(number) else { continue };
            products.responses(sample.cells(), layout, &desk.coded, errors);
            for (errors, down) in errors.iter_mut().zip(down) {
                for (error, across) in errors.iter_mut().zip(across) {
                    let response = response(*error, shift);
                    *error = weighted(response - ((across * down + (1 << 13)) >> 14), sample);
                    largest = largest.max(error.unsigned_abs());
                }
            }
        }
        largest
    }
}

/// How long the step along the coded slopes is, with 44 binary places, below 2^33: the slopes squared over what the step bends, which
/// is their pull and the samples' responses to them, squared. What errors there are is written over.
fn length(
    samples: &Samples,
    slopes: &[i16],
    layout: Layout,
    products: Products,
    [sums, ..]: &mut [[Row<i32>; OFFSETS]; SAMPLES],
) -> i64 {
    // At most 2000 * 8191^2 < 2^37.
    let squared: i64 = slopes.iter().map(|&slope| i64::from(slope).pow(2)).sum();
    let mut bend = (PULL * squared) >> 18;
    for sample in samples.iter() {
        // A sum is below 2^31, of which 9 places are taken away, squared twice that: 169 of them are below 2^52.
        products.responses(sample.cells(), layout, slopes, sums);
        let sum: i64 = sums.as_flattened().iter().map(|&sum| i64::from(sum >> 9).pow(2)).sum();
        bend += ((sum >> 15) * i64::from(sample.share)) >> 1;
    }
    (squared << 26) / bend.max(1)
}

/// A sum of products with coded weights as a response.
fn response(sum: i32, shift: u32) -> i32 {
    // The shift is at most 19: the product is below 2^50.
    let response = (i64::from(sum) << shift) >> 16;
    i32::try_from(response.clamp(-(1 << 24), 1 << 24)).unwrap_or(0)
}

/// An error times its sample's share.
fn weighted(error: i32, sample: &Sample) -> i32 {
    let weighted = (i64::from(error).clamp(-MOST_ERROR, MOST_ERROR) * i64::from(sample.share)) >> 8;
    i32::try_from(weighted).unwrap_or(0)
}

/// By how much numbers must be shifted to the right so that the largest is at most `most`, rounded.
fn shift_to(largest: u64, most: u64) -> u32 {
    let mut shift = 0;
    while (largest >> shift) + 1 > most {
        shift += 1;
    }
    shift
}

/// `number >> shift`, rounded.
fn code(number: i64, shift: u32) -> i16 {
    i16::try_from((number + (1 << shift >> 1)) >> shift).unwrap_or(0)
}
