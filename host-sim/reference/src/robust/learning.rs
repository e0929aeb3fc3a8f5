//! Correlation filter: a weight for each feature byte of its cells, and the learning of these weights.
//!
//! Ridge regression by gradient descent, with conjugate gradients at the lock. It minimises the sum over all offsets of
//! (response - label)^2, plus `regularisation` times the sum of squared weights. For integer sums, weights, gradients
//! and errors are divided by a power of two and rounded (`ScaledIntegers`); sums stay below 2^53, so are exact in f64.
//! Units are 2^-14 for responses, labels and errors, and 2^-30 for weights.

use super::Numbers;
use super::gaussian::{ONE, label, label_factor, learning_window};
use super::gradients::{CHANNELS, Cells};
use super::rounding::{divisor, index, nearest, quotient, to_f64};
use super::sampling::Shape;

pub struct Filter {
    pub weights: Vec<f64>,
}

/// Values divided by `divisor` and rounded to small integers, for products with features.
pub struct ScaledIntegers {
    pub numbers: Vec<f64>,
    pub divisor: f64,
}

impl ScaledIntegers {
    fn new(numbers: &[f64], most: f64) -> Self {
        let divisor = divisor(numbers.iter().fold(0.0, |most, number| number.abs().max(most)), most);
        Self { numbers: numbers.iter().map(|number| nearest(number / divisor, 1.0)).collect(), divisor }
    }

    /// Dot product of the values with the features of the block of cells whose top left cell is (`x`, `y`).
    fn sum(&self, shape: &Shape, cells: &Cells, x: i64, y: i64) -> f64 {
        let rows = self.numbers.chunks(index(shape.across) * CHANNELS).zip(y..);
        let product = |(weights, row): (&[f64], i64)| {
            weights.iter().zip(cells.row(x, row, shape.across)).map(|(weight, byte)| weight * byte).sum::<f64>()
        };
        rows.map(product).sum()
    }

    pub fn response(&self, shape: &Shape, cells: &Cells, x: i64, y: i64) -> f64 {
        let most = 16_777_216.0; // 2^24
        (self.sum(shape, cells, x, y) * self.divisor / 65536.0).floor().clamp(-most, most)
    }
}

impl Filter {
    pub fn new(shape: &Shape) -> Self {
        Self { weights: vec![0.0; index(shape.across * shape.down) * CHANNELS] }
    }

    pub fn scaled(&self, numbers: &Numbers) -> ScaledIntegers {
        ScaledIntegers::new(&self.weights, numbers.most_scaled)
    }

    /// Learns the first frame in `first_steps` full steps of conjugate gradients. All weights must be 0.
    pub fn lock(&mut self, numbers: &Numbers, shape: &Shape, cells: &Cells) {
        let reach = numbers.reach;
        let mut responses = vec![0.0; offsets(reach).count()];
        let mut before = None;
        for _ in 0..numbers.first_steps {
            let sample = Sample { cells, responses: &responses, reach, target: (0.0, 0.0) };
            let step = self.learn(numbers, shape, &sample, (1.0, reach), before.as_ref());
            let changes = ScaledIntegers::new(&step.responses, 32_767.0);
            let units = step.length * step.direction.divisor * changes.divisor / 2.0_f64.powi(60);
            for (response, change) in responses.iter_mut().zip(&changes.numbers) {
                *response -= nearest(change * units, 1.0);
            }
            before = Some(step);
        }
    }

    /// Changes the weights by `part` of the step of an exact line search, which measures curvature at offsets up to
    /// `reach` cells from the middle. The search direction is the gradient times the learning window, plus b times the
    /// direction of the step `before`. The factor b is the new descent / that of `before`, at most `most_conjugate`.
    pub fn learn(
        &mut self,
        numbers: &Numbers,
        shape: &Shape,
        sample: &Sample<'_>,
        (part, reach): (f64, i64),
        before: Option<&Step>,
    ) -> Step {
        let errors = ScaledIntegers::new(&errors(numbers, shape, sample), numbers.most_scaled_error);
        let correlated = correlated(shape, sample, &errors.numbers);
        // The unit of weights is 1/65536 of the unit of errors.
        let gradient = |(weight, sum): (&f64, &f64)| numbers.regularisation * weight + sum * errors.divisor * 65536.0;
        let gradients: Vec<f64> = self.weights.iter().zip(&correlated).map(gradient).collect();
        let before = before.filter(|before| before.descent != 0.0);
        let most = if before.is_some() { (numbers.most_scaled / 4.0).floor() } else { numbers.most_scaled };
        let gradients = ScaledIntegers::new(&gradients, most);
        let mut direction = windowed_gradients(numbers, shape, &gradients);
        let descent =
            gradients.numbers.iter().zip(&direction.numbers).map(|(gradient, number)| gradient * number).sum();
        if let Some(before) = before {
            let places = (512.0 * before.direction.divisor / direction.divisor).max(1.0);
            let part = (quotient(descent * 33_554_432.0, before.descent) / places).floor();
            let part = part.min(65_536.0 * numbers.most_conjugate);
            for (number, before) in direction.numbers.iter_mut().zip(&before.direction.numbers) {
                *number += (part * before / 65_536.0).floor();
            }
        }
        let responses: Vec<f64> =
            offsets(sample.reach).map(|(x, y)| direction.sum(shape, sample.cells, x, y)).collect();
        let near = |(x, y): (i64, i64)| (x - sample.reach).abs().max((y - sample.reach).abs()) <= reach;
        let measured = offsets(sample.reach).zip(&responses).filter(|&(offset, _)| near(offset));
        let measured: Vec<f64> = measured.map(|(_, response)| *response).collect();
        let all = responses.len() as f64;
        let length = (best_length(numbers, &direction, descent, &measured, all) * part).floor();
        for (weight, number) in self.weights.iter_mut().zip(&direction.numbers) {
            *weight -= nearest(number * length * direction.divisor / 2.0_f64.powi(44), 1.0);
        }
        Step { direction, descent, responses, length }
    }
}

/// Result of a learning step, which the next step of conjugate gradients needs.
pub struct Step {
    direction: ScaledIntegers,
    /// Dot product of the gradient and the windowed gradient, in units of the squared `divisor` of `direction`.
    descent: f64,
    responses: Vec<f64>,
    /// Step length, in units of 2^-44.
    length: f64,
}

/// Step length of an exact line search, descent / curvature, at most 8.0, in units of 2^-44. The curvature is the sum
/// of the squares of the measured `responses`, times `all` / (number of responses), plus `regularisation` times the sum
/// of the squared values of the direction. Its unit is 2^18, and the lowest nine bits of each response are dropped.
fn best_length(numbers: &Numbers, direction: &ScaledIntegers, descent: f64, responses: &[f64], all: f64) -> f64 {
    let squared: f64 = direction.numbers.iter().map(|number| number * number).sum();
    let curvature: f64 = responses.iter().map(|response| (response / 512.0).floor().powi(2)).sum();
    let curvature = ((curvature / 256.0).floor() * all / responses.len() as f64).floor() * 256.0;
    let curvature = curvature + (numbers.regularisation * squared / 262_144.0).floor();
    quotient(descent * 67_108_864.0, curvature.max((descent / 2_097_152.0).floor() + 1.0))
}

pub struct Sample<'a> {
    pub cells: &'a Cells,
    pub responses: &'a [f64],
    /// Radius of the search window, in cells.
    pub reach: i64,
    /// Offset of the target from the window's middle, in cells.
    pub target: (f64, f64),
}

/// All offsets of a search window, row by row, counted from its top left corner.
fn offsets(reach: i64) -> impl Iterator<Item = (i64, i64)> {
    let span = 2 * reach + 1;
    (0..span).flat_map(move |y| (0..span).map(move |x| (x, y)))
}

/// Response minus label at each offset, clamped to +-`most_error`.
fn errors(numbers: &Numbers, shape: &Shape, sample: &Sample<'_>) -> Vec<f64> {
    let factor = |offset: i64, target: f64| label_factor(numbers, shape, to_f64(offset - sample.reach) - target);
    let error = |((x, y), response): ((i64, i64), &f64)| {
        let label = label(factor(x, sample.target.0), factor(y, sample.target.1));
        (response - label).clamp(-numbers.most_error, numbers.most_error)
    };
    offsets(sample.reach).zip(sample.responses).map(error).collect()
}

/// For each weight, the sum over all offsets of error times feature.
fn correlated(shape: &Shape, sample: &Sample<'_>, errors: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; index(shape.across * shape.down) * CHANNELS];
    for ((x, y), error) in offsets(sample.reach).zip(errors) {
        for (sums, row) in sums.chunks_mut(index(shape.across) * CHANNELS).zip(y..) {
            let bytes = sample.cells.row(x, row, shape.across);
            sums.iter_mut().zip(bytes).for_each(|(sum, byte)| *sum += error * byte);
        }
    }
    sums
}

fn windowed_gradients(numbers: &Numbers, shape: &Shape, gradients: &ScaledIntegers) -> ScaledIntegers {
    let axis = |cells: i64, side: i64| -> Vec<f64> {
        (0..cells).map(|at| learning_window(numbers, side, to_f64(at) + 0.5 - to_f64(cells) / 2.0)).collect()
    };
    let (across, down) = (axis(shape.across, shape.columns), axis(shape.down, shape.rows));
    let parts = down.iter().flat_map(|down| across.iter().map(|across| label(*across, *down)));
    let weighted = |(gradients, part): (&[f64], f64)| {
        gradients.iter().map(|gradient| nearest(gradient * part / ONE, 1.0)).collect()
    };
    let numbers = gradients.numbers.chunks(CHANNELS).zip(parts).flat_map::<Vec<f64>, _>(weighted).collect();
    ScaledIntegers { numbers, divisor: gradients.divisor }
}
