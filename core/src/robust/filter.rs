//! The filter: a weight for each byte of the cells on the target and around it, so that their sum is 1 where the target is and 0
//! elsewhere.
//!
//! It learns what the target is not, too: by steepest descent it lessens the sum, over all offsets of a window, of
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

use super::MOST_CELLS;
use super::features::CHANNELS;
use super::grid::Grid;
use super::label::Bell;
use super::responses::{Responses, SPAN};
use crate::similarity::{Layout, Products};
use heapless::Vec;

/// Weights of the largest filter.
const WEIGHTS: usize = MOST_CELLS * CHANNELS;
/// The largest coded number: 2000 of them times a byte stay below 2^31.
const CODED: u64 = 8191;
/// The largest gathered error: 289 of them times a byte stay below 2^31.
const GATHERED: u64 = 16_383;
/// The largest error.
const MOST_ERROR: i32 = 65_535;
/// How much squared weights count: 0.05 where a feature of 1 is 318, which squared is 5056.
const PULL: i64 = 5056;

/// What has been learned.
pub(super) struct Filter {
    weights: Vec<i32, WEIGHTS>,
}

/// Scratch: coded numbers, and what it takes to learn.
pub(super) struct Desk {
    coded: Vec<i16, WEIGHTS>,
    gradient: Vec<i32, WEIGHTS>,
    sums: [[i32; SPAN]; SPAN],
}

impl Desk {
    pub(super) const fn new() -> Self {
        Self { coded: Vec::new(), gradient: Vec::new(), sums: [[0; SPAN]; SPAN] }
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

/// A window in which the target was seen.
pub(super) struct Sample<'a> {
    /// Its cells, [`super::REACH`] more on each side than the filter has.
    pub(super) cells: &'a [i8],
    /// The filter's responses to them.
    pub(super) responses: &'a Responses,
    /// Where the target is, from the middle, in units of 1/256 cell.
    pub(super) target: (i32, i32),
}

impl Sample<'_> {
    /// Response less label at all offsets; says how large the largest is.
    fn errors(&self, grid: &Grid, errors: &mut [[i32; SPAN]; SPAN]) -> u32 {
        let [across, down] = Bell::of(grid).around(self.target);
        let mut largest = 0;
        for ((errors, responses), down) in errors.iter_mut().zip(&self.responses.rows).zip(down) {
            for ((error, response), across) in errors.iter_mut().zip(responses).zip(across) {
                let label = (across * down + (1 << 13)) >> 14;
                *error = (response - label).clamp(-MOST_ERROR, MOST_ERROR);
                largest = largest.max(error.unsigned_abs());
            }
        }
        largest
    }
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

    /// One step of learning. Cost: two products for each weight and each of 289 offsets.
    #[inline(never)] // one copy in flash
    pub(super) fn learn(&mut self, grid: &Grid, sample: &Sample<'_>, desk: &mut Desk, products: Products) {
        let layout = layout(grid, SPAN);
        let Desk { coded, gradient, sums } = desk;
        // Where to.
        let shift = shift_to(sample.errors(grid, sums).into(), GATHERED);
        let errors = sums.map(|errors| errors.map(|error| code(error.into(), shift)));
        gradient.clear();
        let _ = gradient.resize_default(self.weights.len());
        products.gather(sample.cells, layout, &errors, gradient);
        // Both terms are below 2^48.
        let slope = |(&weight, &sum): (&i32, &i32)| PULL * i64::from(weight) + (i64::from(sum) << (shift + 16));
        let slopes = || self.weights.iter().zip(gradient.iter()).map(slope);
        let steepest = slopes().map(i64::unsigned_abs).max().unwrap_or(0);
        let scale = shift_to(steepest, CODED);
        coded.iter_mut().zip(slopes()).for_each(|(coded, slope)| *coded = code(slope, scale));
        // How far. Lengths have 44 binary places; a product is below 2^46.
        let length = length(sample.cells, coded, layout, products, sums);
        let back = 44u32.saturating_sub(scale);
        for (weight, &slope) in self.weights.iter_mut().zip(coded.iter()) {
            let change = (i64::from(slope) * length + (1 << back >> 1)) >> back;
            *weight = i32::try_from(i64::from(*weight) - change).unwrap_or(*weight);
        }
    }
}

/// How long the step along the coded slopes is, with 44 binary places, below 2^33: 5/8 of the best length, which is the slopes squared
/// over what the step bends: their pull, and the responses to them, squared. The whole length would follow each frame too closely.
fn length(cells: &[i8], slopes: &[i16], layout: Layout, products: Products, sums: &mut [[i32; SPAN]; SPAN]) -> i64 {
    // At most 2000 * 8191^2 < 2^37.
    let squared: i64 = slopes.iter().map(|&slope| i64::from(slope).pow(2)).sum();
    products.responses(cells, layout, slopes, sums);
    // A sum is below 2^31, of which 9 places are taken away; 289 squares of that are below 2^53.
    let bends = sums.as_flattened().iter().map(|&sum| i64::from(sum >> 9).pow(2));
    let bend = ((PULL * squared) >> 18) + bends.sum::<i64>();
    (5 * ((squared << 26) / bend.max(1))) >> 3
}

/// A sum of products with coded weights as a response.
fn response(sum: i32, shift: u32) -> i32 {
    // The shift is at most 19: the product is below 2^50.
    let response = (i64::from(sum) << shift) >> 16;
    i32::try_from(response.clamp(-(1 << 24), 1 << 24)).unwrap_or(0)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coded_numbers_are_rounded_and_bounded() {
        for largest in [0, 1, 8190, 8191, 8192, 1 << 31, 1 << 48, i64::MAX as u64 / 2] {
            let shift = shift_to(largest, CODED);
            let largest = i64::try_from(largest).unwrap();
            assert!(u64::from(code(largest, shift).unsigned_abs()) <= CODED && code(-largest, shift) >= -8191);
        }
        assert_eq!([code(5, 1), code(-5, 1), code(5, 2), code(7, 0)], [3, -2, 1, 7]);
    }

    #[test]
    fn what_is_learned_is_answered() {
        let grid = Grid::new(crate::Rect::new(0, 0, 40, 40));
        let cells: std::vec::Vec<i8> = (0..30 * 30 * CHANNELS as u32)
            .map(|at| ((at ^ at >> 9).wrapping_mul(2_654_435_761) >> 24) as u8 as i8)
            .collect();
        let (mut filter, mut desk, products) =
            (Filter::new(), Desk::new(), Products::new(crate::similarity::Backend::Scalar));
        filter.start(&grid);
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        for _ in 0..20 {
            filter.learn(
                &grid,
                &Sample { cells: &cells, responses: &responses, target: (512, -256) },
                &mut desk,
                products,
            );
            let shift = filter.code(&mut desk);
            desk.responses(products, shift, &cells, layout(&grid, SPAN), &mut responses.rows);
        }
        let peak = responses.peak(false);
        assert!((peak.x - 512).abs() < 40 && (peak.y + 256).abs() < 40 && peak.response > 13_000, "{peak:?}");
    }
}
