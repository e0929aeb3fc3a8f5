//! The filter: weights for the cells of the target and around it, so that their sum is 1 on the target and 0 elsewhere.
//!
//! It learns by steepest descent with the exact length of step: the sum over all offsets of all samples of (response - label)^2,
//! and a pull towards 0 that grows where the filter reaches beyond the target.
//!
//! | number | unit | bound |
//! |---|---|---|
//! | response, label, error | 1/16384 | error 65535 |
//! | weight | 1/65536 of a response's unit for each unit of a feature | an `i32` |
//! | coded weight, coded gradient | a power of two, chosen each time | 8191 |
//! | share of a sample | 1/65536 | their sum is 65536 at most |

use super::features::CHANNELS;
use super::grid::Grid;
use super::samples::{OFFSETS, Sample, Samples};
use super::{MOST_CELLS, tuning::Tuning};
use crate::similarity::products;
use heapless::Vec;

/// Weights of the largest filter.
pub(super) const WEIGHTS: usize = MOST_CELLS * CHANNELS;
/// The largest coded number.
const CODED: u64 = 8191;
/// The largest error that is told from larger ones.
const MOST_ERROR: i64 = 65_535;
/// Errors are gathered as numbers of at most so much.
const MOST_GATHERED: u64 = 16_383;

pub(super) struct Filter {
    weights: Vec<i32, WEIGHTS>,
}

/// Scratch for responses and for learning.
pub(super) struct Desk {
    coded: Vec<i16, WEIGHTS>,
    gradient: Vec<i32, WEIGHTS>,
    errors: [[i32; OFFSETS * OFFSETS]; super::samples::SAMPLES],
}

impl Desk {
    pub(super) const fn new() -> Self {
        Self { coded: Vec::new(), gradient: Vec::new(), errors: [[0; OFFSETS * OFFSETS]; super::samples::SAMPLES] }
    }
}

/// Filter weights, coded: a coded weight stands for `weight << shift`.
#[derive(Clone, Copy)]
pub(super) struct Coded {
    pub(super) shift: u32,
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

    /// Puts the weights, coded, on the desk.
    pub(super) fn code(&self, desk: &mut Desk) -> Coded {
        let largest = self.weights.iter().map(|weight| weight.unsigned_abs()).max().unwrap_or(0);
        let shift = shift_to(largest.into(), CODED);
        desk.coded.clear();
        for &weight in &self.weights {
            let _ = desk.coded.push(code(weight.into(), shift));
        }
        Coded { shift }
    }

    /// One step of learning.
    pub(super) fn learn(&mut self, grid: &Grid, samples: &Samples, desk: &mut Desk, tuning: &Tuning) {
        let row = usize::from(grid.across) * CHANNELS;
        let coded = self.code(desk);
        let Desk { coded: code_of, gradient, errors } = desk;
        // The errors, each sample's times its share.
        let mut largest = 0;
        for (sample, errors) in samples.iter().zip(errors.iter_mut()) {
            for (y, errors) in errors.chunks_mut(OFFSETS).enumerate() {
                let mut sums = [0; OFFSETS];
                products::responses(sample.row(y), sample.stride(), CHANNELS, code_of, row, &mut sums);
                for (x, (error, sum)) in errors.iter_mut().zip(sums).enumerate() {
                    *error = weighted(sum, coded, sample, (x, y));
                    largest = largest.max(error.unsigned_abs());
                }
            }
        }
        let shift = shift_to(largest.into(), MOST_GATHERED);
        gradient.clear();
        let _ = gradient.resize_default(self.weights.len());
        for (sample, errors) in samples.iter().zip(errors.iter()) {
            for (y, errors) in errors.chunks(OFFSETS).enumerate() {
                let mut small = [0; OFFSETS];
                for (small, &error) in small.iter_mut().zip(errors) {
                    *small = code(error.into(), shift);
                }
                products::gather(sample.row(y), sample.stride(), CHANNELS, &small, row, gradient);
            }
        }
        // Where to: the gradient, coded.
        let pulls = Pulls::new(grid, tuning);
        let slope = |(at, (&weight, &sum)): (usize, (&i32, &i32))| {
            pulls.at(at) * i64::from(weight) + (i64::from(sum) << (shift + 8))
        };
        let slopes = || self.weights.iter().zip(gradient.iter()).enumerate().map(slope);
        let steepest = slopes().map(i64::unsigned_abs).max().unwrap_or(0);
        if steepest == 0 {
            return;
        }
        let scale = shift_to(steepest, CODED);
        for (code_of, slope) in code_of.iter_mut().zip(slopes()) {
            *code_of = code(slope, scale);
        }
        // How far: |g|^2 over what the step changes, |g|^2 pulled and the samples' responses to g.
        let (mut squared, mut pulled) = (0i64, 0i64);
        for (at, &slope) in code_of.iter().enumerate() {
            let square = i64::from(slope).pow(2);
            squared += square;
            pulled += pulls.at(at) * square;
        }
        let mut bend = pulled >> 18;
        for sample in samples.iter() {
            let mut sum = 0;
            for y in 0..OFFSETS {
                let mut sums = [0; OFFSETS];
                products::responses(sample.row(y), sample.stride(), CHANNELS, code_of, row, &mut sums);
                sum += sums.iter().map(|&sum| i64::from(sum >> 9).pow(2)).sum::<i64>();
            }
            bend += ((sum >> 15) * i64::from(sample.share)) >> 1;
        }
        // In units of 2^-44; 2^12 to 2^32.
        let length = (squared << 26) / bend.max(1);
        let back = 44u32.saturating_sub(scale);
        for (weight, &slope) in self.weights.iter_mut().zip(code_of.iter()) {
            let change = (i64::from(slope) * length + (1 << back >> 1)) >> back;
            *weight = i32::try_from(i64::from(*weight) - change).unwrap_or(*weight);
        }
    }
}

impl Desk {
    /// Responses to the coded weights at offsets side by side, in units of 1/16384.
    pub(super) fn responses(&self, coded: Coded, cells: &[i8], stride: usize, row: usize, out: &mut [i32]) {
        products::responses(cells, stride, CHANNELS, &self.coded, row, out);
        for out in out {
            *out = response(*out, coded);
        }
    }
}

/// A sum of products with coded weights as a response.
fn response(sum: i32, coded: Coded) -> i32 {
    // The shift is at most 18: the product is below 2^49.
    let response = (i64::from(sum) << coded.shift) >> 16;
    i32::try_from(response.clamp(-(1 << 24), 1 << 24)).unwrap_or(0)
}

/// The error at an offset of a sample, times the sample's share, in units of 1/16384 and 1/256.
fn weighted(sum: i32, coded: Coded, sample: &Sample, (x, y): (usize, usize)) -> i32 {
    let error = i64::from(response(sum, coded)) - i64::from(sample.label(x, y));
    let weighted = (error.clamp(-MOST_ERROR, MOST_ERROR) * i64::from(sample.share)) >> 8;
    i32::try_from(weighted).unwrap_or(0)
}

/// By how much numbers must be shifted to the right so that the largest is at most `most`.
fn shift_to(largest: u64, most: u64) -> u32 {
    let mut shift = 0;
    // What is rounded may be one more.
    while (largest >> shift) + 1 > most {
        shift += 1;
    }
    shift
}

/// `number >> shift`, rounded.
fn code(number: i64, shift: u32) -> i16 {
    i16::try_from((number + (1 << shift >> 1)) >> shift).unwrap_or(0)
}

/// How much each weight is pulled towards 0.
struct Pulls {
    across: i64,
    down: i64,
    least: i64,
    outside: i64,
}

impl Pulls {
    fn new(grid: &Grid, tuning: &Tuning) -> Self {
        Self { across: grid.across.into(), down: grid.down.into(), least: tuning.pull, outside: tuning.outside }
    }

    fn at(&self, weight: usize) -> i64 {
        let cell = i64::try_from(weight / CHANNELS).unwrap_or(0);
        let (x, y) = (cell % self.across, cell / self.across);
        // From the target's edge (0) to the filter's (256); the filter covers 1.4 times the target.
        let beyond = |at: i64, side: i64| (128 * (7 * (2 * at + 1 - side).abs() - 5 * side) / side).clamp(0, 256);
        let most = beyond(x, self.across).max(beyond(y, self.down));
        self.least + ((self.least * self.outside * most) >> 8)
    }
}
