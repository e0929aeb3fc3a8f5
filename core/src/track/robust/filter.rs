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
use crate::kernels::{Layout, Move, Numbers, Products, Room, lessen_by, rolled};
use heapless::Vec;

/// Weights of the largest filter.
const WEIGHTS: usize = MOST_CELLS * CHANNELS;
/// The largest coded number: 2000 of them times a byte stay below 2^31.
const CODED: u32 = 8191;
/// The largest gathered error: 289 of them times a byte stay below 2^31.
const GATHERED: u32 = 16_383;
/// The largest error.
const MOST_ERROR: i32 = 65_535;
/// How much squared weights count: 0.05 where a feature of 1 is 318, which squared is 5056.
const PULL: i64 = 5056;

/// Cells, and how the filter lies on them.
type Under<'a> = (&'a [i8], Layout);

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
    pub(super) fn responses(
        &self,
        products: Products,
        room: &mut Room,
        shift: u32,
        (cells, layout): Under<'_>,
        part: usize,
        out: &mut [[i32; SPAN]; SPAN],
    ) -> bool {
        products.responses(part..part + 1, room, cells, layout, &self.coded, out);
        let last = part + 1 >= products.parts(layout, self.coded.len());
        if last {
            scale(out, shift);
        }
        last
    }

    /// The responses at a few offsets, at once. What stood on the desk to learn by is gone.
    pub(super) fn few(&mut self, products: Products, room: &mut Room, shift: u32, under: Under<'_>) -> &[[i32; SPAN]] {
        let mut parts = 0..;
        while !self.bends(products, room, under, parts.next().unwrap_or(0)) {}
        let rows = self.sums.get_mut(..under.1.span).unwrap_or_default();
        scale(rows, shift);
        rows
    }

    /// A part of what the errors say of each weight; true when this was the last part.
    pub(super) fn gather(&mut self, products: Products, room: &mut Room, under: Under<'_>, part: usize) -> bool {
        let (cells, layout) = under;
        products.gather(part..part + 1, room, cells, layout, &self.errors, &mut self.gradient);
        part + 1 >= products.gather_parts(layout, self.gradient.len())
    }

    /// A part of the responses to the way that stands on the desk; true when this was the last part.
    pub(super) fn bends(&mut self, products: Products, room: &mut Room, under: Under<'_>, part: usize) -> bool {
        let (cells, layout) = under;
        products.responses(part..part + 1, room, cells, layout, &self.coded, &mut self.sums);
        part + 1 >= products.parts(layout, self.coded.len())
    }

    /// How far to go the way that stands on the desk, whose responses are known at all offsets: so many 256ths of the best
    /// length, which is how steep it goes down over what it bends: the pull of the directions, and the responses to them, squared. The whole
    /// length would follow each frame too closely.
    #[inline(never)] // its loops have registers of their own
    pub(super) fn change(&self, (scale, descent): (u32, i64), learning_rate: u16) -> Change {
        // At most 2000 * 8191^2 < 2^37.
        let squared: i64 = rolled(self.coded.iter()).map(|&direction| i64::from(direction).pow(2)).sum();
        // A sum is below 2^31, of which 9 places are taken away; 289 squares of that are below 2^53.
        let bends = rolled(self.sums.as_flattened().iter()).map(|&sum| i64::from(sum >> 9).pow(2));
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
    /// The filter's responses to its cells.
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
        for (offset, part) in rolled(across.iter_mut().enumerate()) {
            *part = bell.at_offset(offset, self.target.0, self.reach);
        }
        let mut largest = 0;
        errors.as_flattened_mut().fill(0);
        for (row, (errors, responses)) in errors.iter_mut().zip(&self.responses.rows).enumerate().take(span) {
            let down = bell.at_offset(row, self.target.1, self.reach);
            for ((error, response), across) in rolled(errors.iter_mut().zip(responses).zip(across).take(span)) {
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
        let numbers = Numbers::of(&self.weights);
        let shift = shift_to(numbers.largest(), CODED);
        // Cannot fail: there is room for as many.
        let _ = desk.coded.resize_default(self.weights.len());
        numbers.code(shift, &mut desk.coded);
        shift
    }

    /// Begins a step of learning: puts the errors on the desk, coded by the shift that is returned.
    #[inline(never)] // one copy in flash
    pub(super) fn errors(&self, grid: &Grid, sample: &Sample<'_>, desk: &mut Desk) -> u32 {
        let Desk { gradient, sums, errors, .. } = desk;
        let shift = shift_to(sample.errors(grid, sums), GATHERED);
        Numbers::of(sums.as_flattened()).code(shift, errors.as_flattened_mut());
        gradient.clear();
        let _ = gradient.resize_default(self.weights.len());
        shift
    }

    /// Puts the way to go on the desk, coded by the shift that is returned; how steep it is is returned, too. All errors, coded by
    /// `shift`, were gathered.
    ///
    /// A slope says how the sum of squares grows with a weight: `PULL` times the weight, and 2^16 times the error that was gathered for
    /// it, which is below 2^30. In units of 2^(16 + shift), at most 2^19, both are below 2^30. If all slopes are then too small to be
    /// coded, they are below 2^32, so that 2^14 is a unit for them; and if they still are, they are below 2^27, and 1 is.
    #[inline(never)] // one copy in flash
    pub(super) fn slopes(&self, grid: &Grid, desk: &mut Desk, shift: u32) -> (u32, i64) {
        let Desk { coded, gradient, .. } = desk;
        let mut way = (0, 0);
        for unit in [16 + shift, 14, 0] {
            let slopes = Numbers {
                weights: &self.weights,
                factor: PULL << (32 - unit),
                sums: gradient,
                left: 16 + shift - unit,
            };
            let steepest = slopes.largest();
            if steepest >= CODED || unit == 0 {
                let more = shift_to(steepest, CODED);
                slopes.code(more, coded);
                way = (unit + more, lessen(grid, coded));
                break;
            }
        }
        way
    }

    /// Changes so far the way that stands on the desk.
    #[inline(never)] // one copy in flash
    pub(super) fn apply(&mut self, desk: &Desk, Change { length, scale }: Change) {
        // Lengths have 44 binary places; a product is below 2^60.
        Move { length, back: 44u32.saturating_sub(scale) }.apply(&mut self.weights, &desk.coded);
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
            descent += i64::from(lessen_by(cell, part));
        }
    }
    descent
}

/// Makes sums of products with weights that were coded by `shift` responses: times 2^shift, less 16 places. They are cut before they are
/// shifted to the left, so nothing is lost there.
#[inline(never)] // one copy in flash
fn scale(rows: &mut [[i32; SPAN]], shift: u32) {
    let (left, right) = (shift.saturating_sub(16), 16_u32.saturating_sub(shift));
    let most = (1 << 24) >> left;
    rolled(rows.as_flattened_mut().iter_mut()).for_each(|sum| *sum = (*sum >> right).min(most).max(-most) << left);
}

/// By how much numbers must be shifted to the right so that the largest is at most `most`, rounded.
fn shift_to(largest: u32, most: u32) -> u32 {
    let mut shift = 0;
    while largest >> shift >= most {
        shift += 1;
    }
    shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coded_numbers_are_bounded() {
        for largest in [0, 1, 8190, 8191, 8192, 1 << 30, i32::MAX] {
            let (mut coded, numbers) = ([0; 2], [largest, -largest]);
            let numbers = Numbers::of(&numbers);
            let shift = shift_to(numbers.largest(), CODED);
            numbers.code(shift, &mut coded);
            assert!(coded.iter().all(|coded| u32::from(coded.unsigned_abs()) <= CODED), "{largest}");
            assert!(shift == 0 || coded[0] > 4000, "{largest}");
        }
    }

    /// Against 64 bits, in which all units are 1.
    #[test]
    fn slopes_are_coded_in_any_unit() {
        let grid = Grid::new(crate::Rect::new(0, 0, 40, 40));
        let (mut filter, mut desk) = (Filter::new(), Desk::new());
        filter.start(&grid);
        let count = filter.weights.len();
        let mut state = 1_u32;
        let mut noise = |places: u32| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state.cast_signed() >> 3) >> (28 - places)
        };
        for (of_weight, of_sum) in
            [(0, 0), (1, 0), (3, 1), (9, 3), (12, 8), (18, 12), (24, 20), (28, 28), (0, 28), (28, 0)]
        {
            for shift in 0..=3 {
                filter.weights.iter_mut().for_each(|weight| *weight = 8 * noise(of_weight));
                desk.gradient = (0..count).map(|_| noise(of_sum)).collect();
                desk.coded.resize_default(count).unwrap();
                let slope = |at| PULL * i64::from(filter.weights[at]) + (i64::from(desk.gradient[at]) << (16 + shift));
                let slopes: std::vec::Vec<i64> = (0..count).map(slope).collect();
                let steepest = slopes.iter().map(|slope| slope.unsigned_abs()).max().unwrap();
                let scale = (0..64).find(|scale| (steepest >> scale) < 8191).unwrap();
                let round = |&slope: &i64| i16::try_from((slope + (1 << scale >> 1)) >> scale).unwrap();
                let mut wanted: std::vec::Vec<i16> = slopes.iter().map(round).collect();
                let descent = lessen(&grid, &mut wanted);
                assert_eq!(filter.slopes(&grid, &mut desk, shift), (scale, descent), "{of_weight} {of_sum} {shift}");
                assert_eq!(desk.coded, *wanted);
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
            (Filter::new(), Desk::new(), Products::new(crate::kernels::Backend::Scalar));
        filter.start(&grid);
        let mut room = [0; crate::kernels::ROOM];
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        for _ in 0..25 {
            let sample = Sample { responses: &responses, target: (512, -256), reach: 8 };
            let under = (&cells[..], layout(&grid, SPAN));
            let shift = filter.errors(&grid, &sample, &mut desk);
            let mut parts = 0..;
            while !desk.gather(products, &mut room, under, parts.next().unwrap()) {}
            let slopes = filter.slopes(&grid, &mut desk, shift);
            let mut parts = 0..;
            while !desk.bends(products, &mut room, under, parts.next().unwrap()) {}
            filter.apply(&desk, desk.change(slopes, 160));
            let shift = filter.code(&mut desk);
            let mut parts = 0..;
            while !desk.responses(products, &mut room, shift, under, parts.next().unwrap(), &mut responses.rows) {}
        }
        let peak = responses.peak(false);
        assert!((peak.x - 512).abs() < 40 && (peak.y + 256).abs() < 40 && peak.response > 13_000, "{peak:?}");
    }
}
