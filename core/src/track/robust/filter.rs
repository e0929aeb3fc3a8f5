//! The filter: a weight for each byte of the cells on the target and around it, so that their sum is 1 where the target is and 0
//! elsewhere.
//!
//! It learns what the target is not, too: by steepest descent it lessens the sum, over all offsets of a window, of
//! (response - label)^2, and the sum of its squared weights. Each step is as long as is best in its direction, which takes one
//! division. It goes less far for cells far from the middle: what lies there is the target less often, and moves on its own.
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
use crate::similarity::{Layout, Products, Room};
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

/// A step of learning: its length, with 44 binary places, and by how much its way was shifted to be coded.
#[derive(Clone, Copy)]
pub(super) struct Change {
    length: i64,
    scale: u32,
}

/// Scratch: coded numbers, and what it takes to learn.
pub(super) struct Desk {
    coded: Vec<i16, WEIGHTS>,
    gradient: Vec<i32, WEIGHTS>,
    sums: [[i32; SPAN]; SPAN],
    errors: [[i16; SPAN]; SPAN],
}

impl Desk {
    #[inline(always)] // made where it stays
    pub(super) const fn new() -> Self {
        Self { coded: Vec::new(), gradient: Vec::new(), sums: [[0; SPAN]; SPAN], errors: [[0; SPAN]; SPAN] }
    }

    /// How many weights were coded.
    pub(super) fn weights(&self) -> usize {
        self.coded.len()
    }

    /// A part of the responses at all offsets, to the weights that were coded last by `shift`; true when this was the last part.
    #[inline(never)] // one copy in flash
    pub(super) fn responses<const N: usize>(
        &self,
        products: Products,
        room: &mut Room,
        shift: u32,
        (cells, layout): (&[i8], Layout),
        part: usize,
        out: &mut [[i32; N]],
    ) -> bool {
        products.responses(part..part + 1, room, cells, layout, &self.coded, out);
        if part + 1 < products.parts(layout, self.coded.len()) {
            return false;
        }
        out.as_flattened_mut().iter_mut().for_each(|out| *out = response(*out, shift));
        true
    }

    /// A part of what the errors say of each weight; true when this was the last part.
    pub(super) fn gather(
        &mut self,
        products: Products,
        room: &mut Room,
        (cells, layout): (&[i8], Layout),
        part: usize,
    ) -> bool {
        products.gather(part..part + 1, room, cells, layout, &self.errors, &mut self.gradient);
        part + 1 >= products.gather_parts(layout, self.gradient.len())
    }

    /// A part of the responses to the way that stands on the desk; true when this was the last part.
    pub(super) fn bends(
        &mut self,
        products: Products,
        room: &mut Room,
        (cells, layout): (&[i8], Layout),
        part: usize,
    ) -> bool {
        products.responses(part..part + 1, room, cells, layout, &self.coded, &mut self.sums);
        part + 1 >= products.parts(layout, self.coded.len())
    }

    /// How far to go the way that stands on the desk, whose responses are known at all offsets: so many 256ths of the best
    /// length, which is how steep it goes down over what it bends: the pull of the directions, and the responses to them, squared. The whole
    /// length would follow each frame too closely.
    #[inline(never)] // its loops have registers of their own
    pub(super) fn change(&self, (scale, descent): (u32, i64), learning_rate: u16) -> Change {
        // At most 2000 * 8191^2 < 2^37.
        let squared: i64 = self.coded.iter().map(|&direction| i64::from(direction).pow(2)).sum();
        // A sum is below 2^31, of which 9 places are taken away; 289 squares of that are below 2^53.
        let bends = self.sums.as_flattened().iter().map(|&sum| i64::from(sum >> 9).pow(2));
        let bend = ((PULL * squared) >> 18) + bends.sum::<i64>();
        // Below 2^47.
        Change { length: (i64::from(learning_rate) * ((descent << 26) / bend.max(1))) >> 8, scale }
    }
}

/// How the filter lies on cells that reach `span / 2` farther to each side.
pub(super) fn layout(grid: &Grid, span: usize) -> Layout {
    let row = usize::from(grid.across) * CHANNELS;
    Layout { row, stride: row + span.saturating_sub(1) * CHANNELS, step: CHANNELS, span }
}

/// A window in which the target was seen.
pub(super) struct Sample<'a> {
    /// Its cells, `reach` more on each side than the filter has.
    pub(super) cells: &'a [i8],
    /// The filter's responses to them.
    pub(super) responses: &'a Responses,
    /// Where the target is, from the middle, in units of 1/256 cell.
    pub(super) target: (i32, i32),
    /// How far was searched, in cells.
    pub(super) reach: u16,
}

impl Sample<'_> {
    /// Response less label at all offsets; says how large the largest is.
    #[inline(never)] // its stack is not that of a step
    fn errors(&self, grid: &Grid, errors: &mut [[i32; SPAN]; SPAN]) -> u32 {
        let (bell, span) = (Bell::of(grid), self.responses.span);
        let mut across = [0; SPAN];
        for (offset, part) in across.iter_mut().enumerate() {
            *part = bell.at_offset(offset, self.target.0, self.reach);
        }
        let mut largest = 0;
        errors.as_flattened_mut().fill(0);
        for (row, (errors, responses)) in errors.iter_mut().zip(&self.responses.rows).enumerate().take(span) {
            let down = bell.at_offset(row, self.target.1, self.reach);
            for ((error, response), across) in errors.iter_mut().zip(responses).zip(across).take(span) {
                let label = (across * down + (1 << 13)) >> 14;
                *error = (response - label).clamp(-MOST_ERROR, MOST_ERROR);
                largest = largest.max(error.unsigned_abs());
            }
        }
        largest
    }
}

impl Filter {
    #[inline(always)] // made where it stays
    pub(super) const fn new() -> Self {
        Self { weights: Vec::new() }
    }

    /// Knows nothing.
    pub(super) fn start(&mut self, grid: &Grid) {
        self.weights.clear();
        // Cannot fail: a grid has at most MOST_CELLS cells.
        let _ = self.weights.resize_default(usize::from(grid.across) * usize::from(grid.down) * CHANNELS);
    }

    /// Goes on with these weights, as many as a filter on `grid` has.
    pub(super) fn restore(&mut self, grid: &Grid, weights: impl Iterator<Item = i32>) {
        self.start(grid);
        self.weights.iter_mut().zip(weights).for_each(|(weight, saved)| *weight = saved);
    }

    /// The weights.
    pub(super) fn weights(&self) -> &[i32] {
        &self.weights
    }

    /// Puts the weights on the desk, coded: each stands for itself times 2 to the power that is returned.
    #[inline(never)] // one copy in flash
    pub(super) fn code(&self, desk: &mut Desk) -> u32 {
        let largest = self.weights.iter().map(|weight| weight.unsigned_abs()).max().unwrap_or(0);
        let shift = shift_to(largest.into(), CODED);
        desk.coded.clear();
        for &weight in &self.weights {
            // Cannot fail: there is room for as many. Not extend, which has a path to a panic.
            let _ = desk.coded.push(code_small(weight, shift));
        }
        shift
    }

    /// Begins a step of learning: puts the errors on the desk, coded by the shift that is returned.
    #[inline(never)] // one copy in flash
    pub(super) fn errors(&self, grid: &Grid, sample: &Sample<'_>, desk: &mut Desk) -> u32 {
        let Desk { gradient, sums, errors, .. } = desk;
        let shift = shift_to(sample.errors(grid, sums).into(), GATHERED);
        for (coded, &mut error) in errors.as_flattened_mut().iter_mut().zip(sums.as_flattened_mut()) {
            *coded = code_small(error, shift);
        }
        gradient.clear();
        let _ = gradient.resize_default(self.weights.len());
        shift
    }

    /// Puts the way to go on the desk, coded by the shift that is returned; how steep it is is returned, too. All errors, coded by
    /// `shift`, were gathered.
    #[inline(never)] // one copy in flash
    pub(super) fn slopes(&self, grid: &Grid, desk: &mut Desk, shift: u32) -> (u32, i64) {
        let Desk { coded, gradient, .. } = desk;
        let slope = |(&weight, &sum): (&i32, &i32)| slope(weight, sum, shift + 16);
        let slopes = || self.weights.iter().zip(gradient.iter()).map(slope);
        let steepest = slopes().map(i64::unsigned_abs).max().unwrap_or(0);
        let scale = shift_to(steepest, CODED);
        coded.iter_mut().zip(slopes()).for_each(|(coded, slope)| *coded = code(slope, scale));
        (scale, lessen(grid, coded))
    }

    /// One step of learning, at once. Cost: two products for each weight and each of 289 offsets.
    pub(super) fn learn(
        &mut self,
        grid: &Grid,
        sample: &Sample<'_>,
        desk: &mut Desk,
        (products, learning_rate): (Products, u16),
        room: &mut Room,
    ) {
        let under = (sample.cells, layout(grid, sample.responses.span));
        let shift = self.errors(grid, sample, desk);
        let mut parts = 0..;
        while !desk.gather(products, room, under, parts.next().unwrap_or(0)) {}
        let slopes = self.slopes(grid, desk, shift);
        let mut parts = 0..;
        while !desk.bends(products, room, under, parts.next().unwrap_or(0)) {}
        self.apply(desk, desk.change(slopes, learning_rate));
    }

    /// Changes so far the way that stands on the desk.
    #[inline(never)] // one copy in flash
    pub(super) fn apply(&mut self, desk: &Desk, Change { length, scale }: Change) {
        // Lengths have 44 binary places; a product is below 2^60.
        let back = 44u32.saturating_sub(scale);
        for (weight, &slope) in self.weights.iter_mut().zip(&desk.coded) {
            *weight = moved(*weight, slope, length, back);
        }
    }
}

/// Makes coded slopes the directions of a step: those far from the middle become less. What is returned is how steep it is, the
/// products of slopes and directions: at most 2000 * 8191^2 < 2^37.
#[inline(never)] // one copy in flash
fn lessen(grid: &Grid, slopes: &mut [i16]) -> i64 {
    let [across, down] = Bell::halves(grid);
    // From the target's middle to a cell's, in units of 1/256 cell.
    let from_middle = |at: usize, cells: u16| 128 * (2 * i32::try_from(at).unwrap_or(0) + 1 - i32::from(cells));
    let mut descent = 0;
    for (y, row) in slopes.chunks_mut(usize::from(grid.across.max(1)) * CHANNELS).enumerate() {
        let down = down.at(from_middle(y, grid.down));
        for (x, cell) in row.chunks_mut(CHANNELS).enumerate() {
            let part = (across.at(from_middle(x, grid.across)) * down + (1 << 13)) >> 14;
            for slope in cell {
                // No more than the slope, so 16 bits hold it.
                let direction = (i32::from(*slope) * part + (1 << 13)) >> 14;
                descent += i64::from(*slope) * i64::from(direction);
                *slope = i16::try_from(direction).unwrap_or(0);
            }
        }
    }
    descent
}

/// A sum of products with coded weights as a response.
#[inline(never)] // one copy in flash
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

/// How the sum of squares grows with a weight, by the errors that were gathered for it. Both terms are below 2^48.
#[inline(never)] // one copy in flash, and no loop around it is unrolled
fn slope(weight: i32, gathered: i32, shift: u32) -> i64 {
    PULL * i64::from(weight) + (i64::from(gathered) << shift)
}

/// A weight after a step.
#[inline(never)] // one copy in flash, and no loop around it is unrolled
fn moved(weight: i32, slope: i16, length: i64, back: u32) -> i32 {
    let change = (i64::from(slope) * length + (1 << back >> 1)) >> back;
    i32::try_from(i64::from(weight) - change).unwrap_or(weight)
}

/// `number >> shift`, rounded.
#[inline(never)] // one copy in flash, and no loop around it is unrolled
fn code(number: i64, shift: u32) -> i16 {
    i16::try_from((number + (1 << shift >> 1)) >> shift).unwrap_or(0)
}

/// The same of a number of 32 bits, which the sum might not have room in: what is rounded up is the last bit that is lost.
#[inline(never)] // one copy in flash, and no loop around it is unrolled
fn code_small(number: i32, shift: u32) -> i16 {
    let lost = if shift == 0 { 0 } else { (number >> (shift - 1)) & 1 };
    i16::try_from((number >> shift) + lost).unwrap_or(0)
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
        for number in [i32::MIN, i32::MIN + 1, -70_000, -3, -2, -1, 0, 1, 2, 3, 70_000, i32::MAX - 1, i32::MAX] {
            for shift in 0..32 {
                let wanted = code(number.into(), shift);
                assert_eq!(code_small(number, shift), wanted, "{number} >> {shift}");
            }
        }
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
        let mut room = [0; crate::similarity::ROOM];
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        for _ in 0..25 {
            let sample = Sample { cells: &cells, responses: &responses, target: (512, -256), reach: 8 };
            filter.learn(&grid, &sample, &mut desk, (products, 160), &mut room);
            let shift = filter.code(&mut desk);
            let under = (&cells[..], layout(&grid, SPAN));
            let mut parts = 0..;
            while !desk.responses(products, &mut room, shift, under, parts.next().unwrap(), &mut responses.rows) {}
        }
        let peak = responses.peak(false);
        assert!((peak.x - 512).abs() < 40 && (peak.y + 256).abs() < 40 && peak.response > 13_000, "{peak:?}");
    }
}
