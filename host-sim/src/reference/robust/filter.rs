//! The filter: weights for the bytes of cells, and how they learn.
//!
//! It lessens, by steepest descent, the sum over all samples, each by its share, and offsets of (response - label)^2, and `pull`
//! times the sum of all weights squared. Weights, slopes and errors are coded for the sums: divided by a power of two, the least by which
//! the largest fits, and rounded. All sums are of whole numbers below 2^53, so f64 has them exactly.
//!
//! Units: responses, labels and errors 1/16384; weights 1/65536 of that; shares 1/65536.

use super::Numbers;
use super::features::{CHANNELS, Cells};
use super::grid::Shape;
use super::label::{label, part};
use super::rounding::{divisor, index, nearest, quotient, real};
use super::samples::{Sample, Samples};

/// The weights, cell by cell.
pub struct Filter {
    pub weights: Vec<f64>,
}

/// The weights as they are multiplied with bytes: each, times `divisor`, is about the weight.
pub struct Coded {
    pub numbers: Vec<f64>,
    pub divisor: f64,
}

impl Coded {
    fn new(numbers: &[f64], most: f64) -> Self {
        let divisor = divisor(numbers.iter().fold(0.0, |most, number| number.abs().max(most)), most);
        Self { numbers: numbers.iter().map(|number| nearest(number / divisor, 1.0)).collect(), divisor }
    }

    /// The sum of their products with cells, the first of which is that at (`x`, `y`).
    fn sum(&self, shape: &Shape, cells: &Cells, x: i64, y: i64) -> f64 {
        let rows = self.numbers.chunks(index(shape.across) * CHANNELS).zip(y..);
        let product = |(weights, row): (&[f64], i64)| {
            weights.iter().zip(cells.row(x, row, shape.across)).map(|(weight, byte)| weight * byte).sum::<f64>()
        };
        rows.map(product).sum()
    }

    /// The response at an offset.
    pub fn response(&self, shape: &Shape, cells: &Cells, x: i64, y: i64) -> f64 {
        let most = 16_777_216.0; // 2^24
        (self.sum(shape, cells, x, y) * self.divisor / 65536.0).floor().clamp(-most, most)
    }
}

impl Filter {
    /// Knows nothing.
    pub fn new(shape: &Shape) -> Self {
        Self { weights: vec![0.0; index(shape.across * shape.down) * CHANNELS] }
    }

    pub fn coded(&self, numbers: &Numbers) -> Coded {
        Coded::new(&self.weights, numbers.most_coded)
    }

    /// One step.
    pub fn learn(&mut self, numbers: &Numbers, shape: &Shape, samples: &Samples) {
        let coded = self.coded(numbers);
        let errors: Vec<f64> = samples.iter().flat_map(|sample| errors(numbers, shape, &coded, sample)).collect();
        let errors = Coded::new(&errors, numbers.most_gathered);
        let gathered = gathered(numbers, shape, samples, &errors.numbers);
        // Errors are in units of 1/256 of their share's: the other 256 comes back here.
        let slope = |(weight, sum): (&f64, &f64)| numbers.pull * weight + sum * errors.divisor * 256.0;
        let slopes: Vec<f64> = self.weights.iter().zip(&gathered).map(slope).collect();
        let slopes = Coded::new(&slopes, numbers.most_coded);
        let length = length(numbers, shape, samples, &slopes);
        for (weight, slope) in self.weights.iter_mut().zip(&slopes.numbers) {
            *weight -= nearest(slope * length * slopes.divisor / 2.0_f64.powi(44), 1.0);
        }
    }
}

/// Offsets at which a sample is learned, row by row, from its corner.
fn offsets(numbers: &Numbers) -> impl Iterator<Item = (i64, i64)> {
    let span = 2 * numbers.learns + 1;
    (0..span).flat_map(move |y| (0..span).map(move |x| (x, y)))
}

/// Of a sample: response less label, at most `most_error`, times its share over 256 and rounded down.
fn errors(numbers: &Numbers, shape: &Shape, coded: &Coded, sample: &Sample) -> Vec<f64> {
    let part = |offset: i64, target: f64| part(numbers, shape, real(offset - numbers.learns) - target);
    let span = 0..2 * numbers.learns + 1;
    let across: Vec<f64> = span.clone().map(|x| part(x, sample.x)).collect();
    let down: Vec<f64> = span.map(|y| part(y, sample.y)).collect();
    let error = |(x, y): (i64, i64)| {
        let error = coded.response(shape, &sample.cells, x, y) - label(across[index(x)], down[index(y)]);
        (error.clamp(-numbers.most_error, numbers.most_error) * sample.share / 256.0).floor()
    };
    offsets(numbers).map(error).collect()
}

/// For each weight the sum of all errors times the byte it lay on.
fn gathered(numbers: &Numbers, shape: &Shape, samples: &Samples, errors: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; index(shape.across * shape.down) * CHANNELS];
    let offsets = samples.iter().flat_map(|sample| offsets(numbers).map(move |at| (sample, at)));
    for ((sample, (x, y)), error) in offsets.zip(errors) {
        for (sums, row) in sums.chunks_mut(index(shape.across) * CHANNELS).zip(y..) {
            let bytes = sample.cells.row(x, row, shape.across);
            sums.iter_mut().zip(bytes).for_each(|(sum, byte)| *sum += error * byte);
        }
    }
    sums
}

/// How far down is best, on a grid of 2^-44: the slopes squared over what the step bends, which is `pull` times the slopes squared
/// and, of each sample by its share, the responses to the slopes squared.
///
/// The bend is in units of 2^18: of a sum 9 binary places are left out, of the squares' sum 15, of its product with the share 1, and 2^16 is
/// the share's unit. What is left out is rounded down each time.
fn length(numbers: &Numbers, shape: &Shape, samples: &Samples, slopes: &Coded) -> f64 {
    let squared: f64 = slopes.numbers.iter().map(|slope| slope * slope).sum();
    let mut bend = (numbers.pull * squared / 262_144.0).floor();
    for sample in samples.iter() {
        let sum = |(x, y): (i64, i64)| (slopes.sum(shape, &sample.cells, x, y) / 512.0).floor().powi(2);
        let sum = (offsets(numbers).map(sum).sum::<f64>() / 32768.0).floor();
        bend += (sum * sample.share / 2.0).floor();
    }
    quotient(squared * 67_108_864.0, bend.max(1.0))
}
