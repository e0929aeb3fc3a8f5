//! Learning of the correlation filter: ridge regression on a Gaussian label. A lock takes `FIRST_STEPS` steps of
//! conjugate gradients, and each later frame with enough evidence one step of steepest descent.
//!
//! ```text
//! minimise   E(w) = sum over offsets d of  (r(d) - y(d))^2  +  lambda * |w|^2
//! error      e(d) = r(d) - y(d),   y = a Gaussian around the target (MOSSE; Bolme et al., 2010)
//! slope      z = m * grad E,       grad E = sum over d of e(d) x(. + d) + lambda * w
//! direction  p = z + beta * p',    beta = (grad E . z) / (grad E . z of the step before); 0 in an update
//! step       w' = w - rate * a * p,   a = (grad E . z) / (sum over d of rp(d)^2 + lambda * |p|^2)
//! responses  r' = r - a * rp,      in a lock
//! ```
//!
//! `rp` is the response to the direction `p`, so `a` is the exact step for this quadratic: of steepest descent (as in
//! ATOM; Danelljan et al., 2019), or of conjugate gradients (Hestenes and Stiefel, 1952) with the preconditioner `m`.
//! Offsets around the target are its negative examples (as in BACF; Galoogahi et al., 2017). `m` is a Gaussian on the
//! filter's cells: cells far from the target's middle show the target less often, so they learn less. An update
//! shortens the step by `rate`, because a whole step would follow each frame too closely. It computes `rp` only at
//! offsets of up to 5/8 of the search radius, and takes the mean square there for that of all offsets.
//!
//! | symbol | what | unit | bound |
//! |---|---|---|---|
//! | `r`, `y` | response, label | 1/16384 | 2^24, 2^14; in a lock `r` is any `i32` |
//! | `e` | error, clamped; coded | 1/16384; a power of two | 65,535; 16,383 |
//! | `grad E`, `z` | coded | a power of two | 8191; with a direction before 2047 |
//! | `p` | coded | a power of two | 2047 + 3/4 * 8191 < 8191 |
//! | `beta` | in units of both directions | 1/65536 | 3/4 |
//! | `grad E . z` | descent | | 2000 * 8191^2 < 2^37 |
//! | `a` | step length | 44 fractional bits | 2^47 |
//!
//! Cost: 410 products for each weight by default, and 578 in a step of a lock.

use super::super::arithmetic::quotient;
use super::super::constants::{CHANNELS, SPAN};
use super::super::features::{Extent, Grid};
use super::correlation::{Coded, FeatureWindow, Filter, LARGEST, add_gradient, shift_below};
use super::gaussian::Gaussian;
use super::response::{self, CODED, Responses};
use crate::kernels::{GradientStep, Packed, Products, ScaledSums, rolled};
use crate::track::update::{Budget, largest, units};

/// The regularisation lambda of the ridge regression: 0.05 * 318^2, because a feature of 1 is the integer 318.
const REGULARISATION: i64 = 5056;
/// The largest error of a response, in units of 1/16384: 65535, about 4.0. Larger errors are clamped to it.
const MAX_ERROR: i32 = 65_535;
/// The bound of a 16-bit coded error (`coded_errors`). A sum of 289 products with 8-bit features stays below 2^31.
const MAX_CODED_ERROR: u32 = 16_383;
/// The learning rate at the lock, in units of 1/256. At 256 each step has its full length.
const WHOLE_STEP: u16 = 256;

/// Units of work for each weight in computing the direction.
const SLOPED: u32 = 64;

pub(crate) const fn most_of_a_lock(extent: Extent) -> u32 {
    without_responses(extent) + response::most_work(extent)
}

/// Upper bound of the work for a learning step of an update, with responses only within 5/8 of the search radius.
pub(crate) const fn most_work(extent: Extent) -> u32 {
    without_responses(extent) + response::most_work(Extent { reach: 5 * extent.reach / 8, ..extent })
}

const fn without_responses(extent: Extent) -> u32 {
    extent.offsets() + response::most_work(extent) + (2 * CODED + SLOPED) * extent.weights()
}

/// Upper bound of the work for a piece: all errors, or the direction, or the last responses and the change of weights.
pub(crate) const fn most_work_of_a_piece(extent: Extent) -> u32 {
    let errors = extent.offsets() + CODED * extent.weights();
    let last = response::most_work_of_a_piece(extent) + CODED * (extent.weights() + extent.offsets());
    largest(&[errors, SLOPED * extent.weights(), last])
}

pub(crate) struct Training<'a> {
    pub(crate) filter: &'a Filter,
    pub(crate) grid: &'a Grid,
    pub(crate) window: FeatureWindow<'a>,
    pub(crate) responses: &'a Responses,
    pub(crate) products: Products,
}

/// Sums for all weights and for all offsets, and 16-bit errors. Other stages reuse this memory: see `run/buffers.rs`.
/// `W` is an array, or by default a slice of one with a sum for each weight of any filter.
pub(crate) struct Sums<W: ?Sized = [i32]> {
    /// In a learning step: errors before coding, in units of 1/16384; then scratch; then responses to the direction.
    pub(super) per_offset: [[i32; SPAN]; SPAN],
    /// Errors of the responses, in units of 2^`error_shift` / 16384.
    coded_errors: [[i16; SPAN]; SPAN],
    /// The gradient, in the unit of `coded_errors`. While responses are computed, scratch memory.
    pub(crate) per_weight: W,
}

impl<const N: usize> Sums<[i32; N]> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { per_offset: [[0; SPAN]; SPAN], coded_errors: [[0; SPAN]; SPAN], per_weight: [0; N] }
    }
}

impl Sums {
    /// Computes the errors, stores them in `coded_errors` (16 bits), clears the gradient. Returns `error_shift`.
    #[inline(never)]
    fn code_errors(&mut self, training: &Training<'_>, target: (i32, i32)) -> u32 {
        let Self { per_weight: gradient, per_offset: errors, coded_errors: coded } = self;
        let shift = shift_below(compute_errors(training, target, errors), MAX_CODED_ERROR);
        ScaledSums::of(errors.as_flattened()).code(shift, coded.as_flattened_mut());
        rolled(gradient.iter_mut()).for_each(|sum| *sum = 0);
        shift
    }

    /// Computes the direction as 16-bit integers. `direction` holds the previous one, `descent_before` the previous
    /// descent (grad E . z), or 0 for steepest descent. Returns the new descent, in the squared unit of the direction.
    ///
    /// A slope is an element of grad E: `REGULARISATION` * weight + 2^(16 + `error_shift`) * gradient. The gradient is
    /// below 2^30 and `error_shift` at most 3, so a slope can exceed 32 bits. The loop tries units of 2^`unit`, the
    /// largest first, until the steepest slope has 8191 units. So it keeps 13 bits, if it has them (11 to add a
    /// direction before):
    ///
    /// | `unit` | condition | bound of slopes |
    /// |---|---|---|
    /// | 16 + `error_shift` | the steepest slope has 8191 units | 2^31 units |
    /// | 14 | else, the steepest slope has 8191 units | 2^18 units, since it was below 8191 * 2^19 |
    /// | 0 | else | 2^27, since the steepest was below 8191 * 2^14 |
    #[inline(never)]
    fn code_direction(
        &mut self,
        training: &Training<'_>,
        error_shift: u32,
        descent_before: i64,
        direction: &mut Coded,
    ) -> i64 {
        // Clears `per_offset`, until now scratch: `step_length` adds up all offsets, even those without a response.
        self.per_offset.as_flattened_mut().fill(0);
        let weights = training.filter.weights();
        let sums = self.per_weight.get_mut(..weights.len()).unwrap_or_default();
        let gradient_unit = 16 + error_shift;
        let mut unit = gradient_unit;
        loop {
            // Slopes in units of 2^`unit`: weight * factor / 2^32 + gradient * 2^left.
            let slopes =
                ScaledSums { weights, factor: REGULARISATION << (32 - unit), sums, left: gradient_unit - unit };
            let steepest = slopes.largest();
            if steepest >= LARGEST || unit == 0 {
                let largest = if descent_before == 0 { LARGEST } else { LARGEST / 4 };
                let shift = shift_below(steepest, largest);
                let ScaledSums { factor, left, .. } = slopes;
                let descent = mask(training.grid, weights, (factor, left, shift), sums);
                direction.set_direction(sums, unit + shift, quotient(descent << 25, descent_before));
                return descent;
            }
            unit = if unit > 14 { 14 } else { 0 };
        }
    }

    /// Applies a step to `responses`: subtracts `length` times the responses to `direction`. Overwrites `coded_errors`.
    #[inline(never)]
    pub(crate) fn descend(&mut self, length: i64, direction: &Coded, responses: &mut Responses) {
        let numbers = ScaledSums::of(self.per_offset.as_flattened());
        let shift = shift_below(numbers.largest(), 32_767);
        let coded = self.coded_errors.as_flattened_mut();
        numbers.code(shift, coded);
        GradientStep { length, back: 60_u32.saturating_sub(direction.shift() + shift) }
            .apply(responses.rows.as_flattened_mut(), coded);
    }

    /// The step length: `rate` / 256 of the one that minimises the error, with 44 fractional bits, as an integer below
    /// 2^47. `offsets` counts all offsets, `measured` those for which the direction's response was computed.
    #[inline(never)] // gives its loops registers of their own
    fn step_length(&self, direction: &[i16], descent: i64, rate: u16, [offsets, measured]: [i64; 2]) -> i64 {
        // The sum is at most 2000 * 8191^2 < 2^37.
        let squared: i64 = rolled(direction.iter()).map(|&number| i64::from(number).pow(2)).sum();
        // A response is below 2^31; shifted right by 9 bits and squared, below 2^44. A sum of 289 squares is below
        // 2^53; shifted right by 8 bits and times 289, it stays below 2^54.
        let responses = rolled(self.per_offset.as_flattened().iter()).map(|&sum| i64::from(sum >> 9).pow(2));
        let responses = quotient((responses.sum::<i64>() >> 8) * offsets, measured) << 8;
        let curvature = ((REGULARISATION * squared) >> 18) + responses;
        (i64::from(rate) * quotient(descent << 26, curvature.max((descent >> 21) + 1))) >> 8
    }
}

/// Computes the errors, response - label, clamped. Returns the largest magnitude. `target` is the target's offset from
/// the window's middle, in units of 1/256 cell.
#[inline(never)] // keeps its stack out of `next_piece`
fn compute_errors(training: &Training<'_>, target: (i32, i32), errors: &mut [[i32; SPAN]; SPAN]) -> u32 {
    let (label, span) = (Gaussian::label(training.grid), training.responses.span);
    let reach = u16::try_from(span / 2).unwrap_or(0);
    let mut across = [0; SPAN];
    for (offset, value) in rolled(across.iter_mut().enumerate()) {
        *value = label.at_offset(offset, target.0, reach);
    }
    let mut largest = 0;
    errors.as_flattened_mut().fill(0);
    for (row, (errors, responses)) in errors.iter_mut().zip(&training.responses.rows).enumerate().take(span) {
        let down = label.at_offset(row, target.1, reach);
        for ((error, response), across) in rolled(errors.iter_mut().zip(responses).zip(&across).take(span)) {
            let label = (across * down + (1 << 13)) >> 14;
            *error = response.saturating_sub(label).clamp(-MAX_ERROR, MAX_ERROR);
            largest = largest.max(error.unsigned_abs());
        }
    }
    largest
}

/// Computes the slopes weight * `factor` / 2^32 + sum * 2^`left`, divided by 2^`shift`, as 16-bit integers. Replaces
/// `sums` by the masked slopes z = m * grad E, and returns grad E . z.
#[inline(never)]
fn mask(grid: &Grid, weights: &[i32], (factor, left, shift): (i64, u32, u32), sums: &mut [i32]) -> i64 {
    let [across, down] = Gaussian::mask(grid);
    // The distance of a cell from the target's middle, in units of 1/256 cell.
    let from_middle = |at: u16, cells: u16| 128 * (2 * i32::from(at) + 1 - i32::from(cells));
    let (mut descent, mut coded) = (0, [0; CHANNELS]);
    let (mut x, mut y, mut vertical) = (grid.across, 0, 0);
    let mut weights = weights.chunks(CHANNELS);
    for sums in sums.chunks_mut(CHANNELS) {
        let weights = weights.next().unwrap_or_default();
        if x == grid.across {
            vertical = down.at(from_middle(y, grid.down));
            (x, y) = (0, y + 1);
        }
        let part = across.at(from_middle(x, grid.across)) * vertical;
        x += 1;
        ScaledSums { weights, factor, sums, left }.code(shift, &mut coded);
        descent += i64::from(mask_cell(sums, &coded, (part + (1 << 13)) >> 14));
    }
    descent
}

/// Masks the slopes grad E of one cell: z = m * grad E. `part` is the mask m, in units of 1/16384. Returns grad E . z.
fn mask_cell(masked: &mut [i32], slopes: &[i16], part: i32) -> i32 {
    let pairs = rolled(masked.iter_mut().zip(slopes));
    let product = |(masked, &slope): (&mut i32, &i16)| {
        *masked = (i32::from(slope) * part + (1 << 13)) >> 14;
        i32::from(slope) * *masked
    };
    pairs.map(product).sum()
}

#[derive(Clone, Copy)]
pub(crate) struct Learning {
    /// The target's offset from the middle of the window, in units of 1/256 cell.
    target: (i32, i32),
    /// The learning rate: the fraction of an exact step, in units of 1/256.
    rate: u16,
    /// True in a lock, which requires the responses to the direction at all offsets.
    locks: bool,
    /// The descent grad E . z of the last direction; 0 before the first direction.
    descent: i64,
    phase: Phase,
}

#[derive(Clone, Copy)]
enum Phase {
    Errors,
    /// Sums the gradient. `piece` is the index of the next piece of work.
    Gradient {
        piece: usize,
        error_shift: u32,
    },
    Direction {
        error_shift: u32,
    },
    /// Computes the filter responses of the search direction, which give the step length along it.
    Curvature {
        piece: usize,
    },
}

impl Learning {
    pub(crate) fn begin(target: (i32, i32), rate: u16) -> Self {
        Self { target, rate, locks: false, descent: 0, phase: Phase::Errors }
    }

    /// Begins the steps of a lock, with the target in the middle of the window.
    pub(crate) fn lock() -> Self {
        Self { locks: true, ..Self::begin((0, 0), WHOLE_STEP) }
    }

    /// Computes a piece of a step. The last piece returns the step length along `direction`, and begins the next step.
    pub(crate) fn next_piece(
        &mut self,
        training: &Training<'_>,
        direction: &mut Coded,
        sums: &mut Sums,
        packed: &mut Packed,
        budget: &mut Budget,
    ) -> Option<i64> {
        let Training { filter, grid, window, products, .. } = training;
        let (layout, count) = (window.layout, filter.weights().len());
        match self.phase {
            Phase::Errors => {
                let error_shift = sums.code_errors(training, self.target);
                budget.spend(units(layout.span.pow(2)) + CODED * grid.work_on_weights());
                self.phase = Phase::Gradient { piece: 0, error_shift };
            }
            Phase::Gradient { piece, error_shift } => {
                budget.spend(units(products.gather_work(piece, layout, count)));
                let Sums { per_weight: gradient, per_offset: spare, coded_errors } = sums;
                let (gradient, spare) = (gradient.get_mut(..count).unwrap_or_default(), spare.as_flattened_mut());
                let done = add_gradient(*products, packed, spare, *window, coded_errors, piece, gradient);
                self.phase = if done {
                    Phase::Direction { error_shift }
                } else {
                    Phase::Gradient { piece: piece + 1, error_shift }
                };
            }
            Phase::Direction { error_shift } => {
                self.descent = sums.code_direction(training, error_shift, self.descent, direction);
                budget.spend(SLOPED * grid.work_on_weights());
                self.phase = Phase::Curvature { piece: 0 };
            }
            Phase::Curvature { piece } => {
                let window = if self.locks { *window } else { window.inner() };
                budget.spend(units(products.work(piece, window.layout, count)));
                if direction.respond(*products, packed, &mut sums.per_weight, window, piece, &mut sums.per_offset) {
                    budget.spend(CODED * grid.work_on_weights());
                    self.phase = Phase::Errors;
                    let offsets = [layout, window.layout].map(|layout| i64::from(units(layout.span.pow(2))));
                    return Some(sums.step_length(direction.numbers(), self.descent, self.rate, offsets));
                }
                self.phase = Phase::Curvature { piece: piece + 1 };
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::response::layout;
    use super::*;
    use crate::kernels::Backend;
    use heapless::Vec;
    use std::vec::Vec as Many;

    const WEIGHTS: usize = 2000;

    /// Compares the coded direction with plain 64-bit sums, for steepest descent and then for a conjugate step.
    #[test]
    fn slopes_are_coded_in_any_unit() {
        let grid = Grid::new(crate::Rect::new(0, 0, 40, 40));
        let count = grid.weights();
        let (filter, sums, direction): (&mut Filter, &mut Sums, &mut Coded) = (
            &mut Filter::<Vec<i32, WEIGHTS>>::new(),
            &mut Sums::<[i32; WEIGHTS]>::new(),
            &mut Coded::<Vec<i16, WEIGHTS>>::new(),
        );
        let responses = Responses::new();
        let mut state = 1_u32;
        let mut noise = |places: u32| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state.cast_signed() >> 3) >> (28 - places)
        };
        let [across, down] = Gaussian::mask(&grid);
        let from_middle = |at: usize| 128 * (2 * at as i32 + 1 - i32::from(grid.across));
        let cell = |at: usize| (at / CHANNELS % usize::from(grid.across), at / CHANNELS / usize::from(grid.across));
        let part = |(x, y)| (i64::from(across.at(from_middle(x)) * down.at(from_middle(y))) + 8192) >> 14;
        filter.start(count);
        filter.code(direction);
        let mut descent = 0;
        for (of_weight, of_sum) in
            [(0, 0), (1, 0), (3, 1), (9, 3), (12, 8), (18, 12), (24, 20), (28, 28), (0, 28), (28, 0), (0, 0), (28, 28)]
        {
            for (shift, follows) in (0..=3).flat_map(|shift| [(shift, false), (shift, true)]) {
                filter.restore(count, core::iter::repeat_with(|| 8 * noise(of_weight)));
                sums.per_weight.fill_with(|| noise(of_sum));
                let pairs = filter.weights().iter().zip(&sums.per_weight);
                let slope = |(&weight, &sum): (&i32, &i32)| {
                    REGULARISATION * i64::from(weight) + (i64::from(sum) << (16 + shift))
                };
                let slopes: Many<i64> = pairs.map(slope).collect();
                let steepest = slopes.iter().map(|slope| slope.unsigned_abs()).max().unwrap();
                let before = if follows { descent } else { 0 };
                let bound = if before == 0 { 8191 } else { 2047 };
                let scale = (0..64).find(|scale| (steepest >> scale) < bound).unwrap();
                let rounded: Many<i64> = slopes.iter().map(|slope| (slope + (1 << scale >> 1)) >> scale).collect();
                let parts = (0..count).map(|at| part(cell(at)));
                let masked: Many<i64> =
                    rounded.iter().zip(parts).map(|(slope, part)| (slope * part + 8192) >> 14).collect();
                let wanted: i64 = rounded.iter().zip(&masked).map(|(slope, masked)| slope * masked).sum();
                let beta = if before == 0 { 0.0 } else { wanted as f64 / before as f64 };
                let beta = (beta * 2_f64.powi(16 + scale - direction.shift() as i32)).min(49_152.0);
                let old: Many<i16> = direction.numbers().to_vec();
                let window = FeatureWindow { cells: &[], layout: layout(&grid, SPAN) };
                let products = Products::new(Backend::Scalar);
                let training = Training { filter, grid: &grid, window, responses: &responses, products };
                descent = sums.code_direction(&training, shift, before, direction);
                assert_eq!((descent, direction.shift()), (wanted, scale as u32), "{of_weight} {of_sum} {shift}");
                for ((&number, masked), old) in direction.numbers().iter().zip(masked).zip(old) {
                    let exact = masked as f64 + beta * f64::from(old) / 65_536.0;
                    assert!((f64::from(number) - exact).abs() <= 1.2, "{number} {exact}, {of_weight} {of_sum} {shift}");
                    assert!(number.unsigned_abs() <= 8191);
                }
            }
        }
    }

    /// Checks that the numbers of a direction stay within +-8191 with the largest beta and with sums of up to +-2047.
    #[test]
    fn a_direction_stays_a_code() {
        let (direction, filter): (&mut Coded, &mut Filter) =
            (&mut Coded::<Vec<i16, 2>>::new(), &mut Filter::<Vec<i32, 2>>::new());
        for (sums, numbers) in [([2047, -2047], [8190, -8191]), ([2047, 2047], [-4096, 8190]), ([-2047, 0], [-8191, 1])]
        {
            filter.restore(2, numbers.into_iter());
            filter.code(direction);
            direction.set_direction(&sums, 0, i64::MAX);
            assert!(direction.numbers().iter().all(|number| u32::from(number.unsigned_abs()) <= LARGEST));
        }
    }

    #[test]
    fn responses_follow_a_step_of_any_length() {
        let (direction, filter, sums): (&mut Coded, &mut Filter, &mut Sums) =
            (&mut Coded::<Vec<i16, 1>>::new(), &mut Filter::<Vec<i32, 1>>::new(), &mut Sums::<[i32; 1]>::new());
        for (length, change) in [(0, 0), (1 << 46, i32::MAX), ((1 << 47) - 1, i32::MIN), (1 << 30, 1 << 24)] {
            filter.restore(1, [i32::MAX].into_iter());
            filter.code(direction);
            let mut responses = Responses { span: SPAN, rows: [[-5; SPAN]; SPAN] };
            sums.per_offset = [[change; SPAN]; SPAN];
            sums.descend(length, direction, &mut responses);
            let exact = -5.0 - length as f64 * f64::from(change) * 2_f64.powi(direction.shift() as i32 - 60);
            let exact = if exact.abs() < 2_f64.powi(31) { exact } else { -5.0 };
            assert!(
                (f64::from(responses.rows[3][4]) - exact).abs() <= exact.abs() / 16_384.0 + 1.0,
                "{length} {change}"
            );
        }
    }

    #[test]
    fn what_the_gradient_leaves_behind_does_not_count() {
        const SMALL: usize = 11;
        let grid = Grid::new(crate::Rect::new(0, 0, 40, 40));
        let cells: Many<i8> =
            (0..24 * 24 * CHANNELS as u32).map(|at| (at.wrapping_mul(40_503) >> 3) as u8 as i8).collect();
        let filter: &mut Filter = &mut Filter::<Vec<i32, WEIGHTS>>::new();
        filter.start(grid.weights());
        let window = FeatureWindow { cells: &cells, layout: layout(&grid, SMALL) };
        let responses = Responses { span: SMALL, ..Responses::new() };
        let products = Products::new(Backend::Scalar);
        let training = Training { filter, grid: &grid, window, responses: &responses, products };
        let length = |left: i32| {
            let (sums, direction): (&mut Sums, &mut Coded) =
                (&mut Sums::<[i32; WEIGHTS]>::new(), &mut Coded::<Vec<i16, WEIGHTS>>::new());
            let (mut packed, mut budget, mut learning) = (Packed::new(), Budget::NOTHING, Learning::begin((0, 0), 160));
            loop {
                let length = learning.next_piece(&training, direction, sums, &mut packed, &mut budget);
                if let Some(length) = length {
                    return length;
                }
                if matches!(learning.phase, Phase::Direction { .. }) {
                    sums.per_offset = [[left; SPAN]; SPAN];
                }
            }
        };
        assert_eq!(length(0), length(1 << 30));
    }
}
