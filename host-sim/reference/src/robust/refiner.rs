//! Refiner: a learned network (four convolutions, two fully connected layers) that corrects the box, rates it, and
//! judges whether it shows the target.
//!
//! The caller passes the trained weights (`weights.bin`). A layer's sums are exact in f64, then rounded down.

use super::Numbers;
use super::confidence::{Decision, decided};
use super::rounding::{FINE, POSITION, SCALE, down, index, nearest, to_f64, to_i64};
use super::sampling::{Lattice, Picture};

/// Side of a crop, the network's input, in samples; and the crop's side divided by the box's side.
const SIDE: i64 = 32;
const CROP_OVER_BOX: f64 = 1.75;
/// Network input to which the mean gray level of a crop is mapped.
const MEAN: f64 = 64.0;
/// Resolution of the network's outputs: 1/4096. A logit is four times the last output.
const ESTIMATE: f64 = 4096.0;
const LOGIT: f64 = ESTIMATE / 4.0;

/// Layers: number of inputs (or input channels), number of outputs (or output channels), divisor of the sums. For a
/// convolution, its output side and stride come first.
const CONVOLUTIONS: [(i64, i64, i64, i64, f64); 4] =
    [(16, 2, 2, 8, 64.0), (8, 2, 8, 16, 128.0), (8, 1, 16, 24, 128.0), (4, 2, 24, 24, 128.0)];
const FULLY_CONNECTED: [(i64, i64, f64); 2] = [(384, 24, 256.0), (24, 7, 1.0)];

/// Square feature map with channels, padded with the value `beyond`.
struct Map {
    side: i64,
    channels: i64,
    beyond: f64,
    numbers: Vec<f64>,
}

impl Map {
    fn at(&self, x: i64, y: i64, channel: i64) -> f64 {
        let inside = (0..self.side).contains(&x) && (0..self.side).contains(&y);
        if inside { self.numbers[index((y * self.side + x) * self.channels + channel)] } else { self.beyond }
    }
}

/// Unread bytes of the weight file.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn biases(&mut self, count: i64) -> Vec<f64> {
        let (biases, rest) = self.0.split_at(4 * index(count));
        self.0 = rest;
        biases.chunks(4).map(|bias| f64::from(i32::from_le_bytes(bias.try_into().expect("four bytes")))).collect()
    }

    /// Reads one row of weights for each output. A row is padded to a multiple of four bytes.
    fn weights(&mut self, outputs: i64, inputs: i64) -> Vec<Vec<f64>> {
        let row = index((inputs + 3) / 4 * 4);
        let (weights, rest) = self.0.split_at(index(outputs) * row);
        self.0 = rest;
        let number = |&byte: &u8| f64::from(byte.cast_signed());
        weights.chunks(row).map(|row| row[..index(inputs)].iter().map(number).collect()).collect()
    }
}

fn activation(sum: f64, divisor: f64) -> f64 {
    (sum / divisor).floor().clamp(0.0, 127.0)
}

/// Returns the network's estimates: shift of the centre to the right and down, in sides of the box; logarithms of the
/// factors of width and height; logarithms of the expected errors of position and size (0: e^-1.5 sides); a quarter of
/// the logit for showing the target.
fn network(weights: &[u8], first: &[f64], present: &[f64]) -> Vec<f64> {
    let mut bytes = Bytes(weights);
    let both = first.iter().zip(present).flat_map(|(&first, &present)| [first, present]).collect();
    let mut map = Map { side: SIDE, channels: 2, beyond: MEAN, numbers: both };
    for (side, step, channels, outputs, divisor) in CONVOLUTIONS {
        let (biases, weights) = (bytes.biases(outputs), bytes.weights(outputs, 9 * channels));
        let mut numbers = Vec::new();
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let patch: Vec<f64> = (0..3)
                .flat_map(|down| (0..3).map(move |right| (down, right)))
                .flat_map(|(down, right)| (0..channels).map(move |channel| (down, right, channel)))
                .map(|(down, right, channel)| map.at(x * step + right - 1, y * step + down - 1, channel))
                .collect();
            numbers.extend(biases.iter().zip(&weights).map(|(bias, row)| activation(bias + dot(row, &patch), divisor)));
        }
        map = Map { side, channels: outputs, beyond: 0.0, numbers };
    }
    let mut numbers = map.numbers;
    for (inputs, outputs, divisor) in FULLY_CONNECTED {
        let (biases, weights) = (bytes.biases(outputs), bytes.weights(outputs, inputs));
        let sums = biases.iter().zip(&weights).map(|(bias, row)| bias + dot(row, &numbers));
        // The last layer has no activation.
        numbers = if outputs == 7 { sums.collect() } else { sums.map(|sum| activation(sum, divisor)).collect() };
    }
    numbers.iter().map(|sum| sum / ESTIMATE).collect()
}

/// The logit that the estimates give, at most [`Numbers::most_logit`] in magnitude.
pub fn logit(numbers: &Numbers, estimates: &[f64]) -> f64 {
    (4.0 * estimates[6]).clamp(-numbers.most_logit, numbers.most_logit)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn lattice([x, y, width, height]: [f64; 4]) -> Lattice {
    let step = |side: f64| down(side * CROP_OVER_BOX / to_f64(SIDE), POSITION).max(1.0 / POSITION);
    let middle = |from: f64, side: f64| from + down(side / 2.0, FINE) - 0.5;
    let (step, step_down) = (step(width), step(height));
    Lattice { x: middle(x, width), y: middle(y, height), step, step_down, columns: SIDE, rows: SIDE }
}

/// Samples the crop of a box, normalised to mean 64 and standard deviation 16 s / (s + 4), where s is the standard
/// deviation of the crop in gray levels.
fn crop(numbers: &Numbers, frame: &Picture<'_>, target: [f64; 4]) -> Vec<f64> {
    let pixels = lattice(target).sample(numbers, frame).pixels;
    let mean = nearest(pixels.iter().sum::<f64>() / to_f64(SIDE * SIDE), 1.0);
    let squares: f64 = pixels.iter().map(|pixel| (pixel - mean).powi(2)).sum();
    let gain = (2_097_152.0 / (squares.sqrt().floor() + 128.0)).floor();
    pixels.iter().map(|pixel| (((pixel - mean) * gain / 4096.0).floor() + MEAN).clamp(0.0, 127.0)).collect()
}

/// State of the refiner: crop of the target in the first frame, and the accumulated correction of the box.
pub struct Refiner {
    weights: &'static [u8],
    first: Vec<f64>,
    centre: [f64; 2],
    sides: [f64; 2],
    /// Running mean of the trust in the box. A frame's trust is high if the network expects small errors.
    opinion: f64,
    /// Running mean of the logits for showing the target.
    identity: f64,
    /// Count of frames in a row, up to now, with an opinion below `opinion_uncertain_below`.
    doubted_frames: i64,
}

impl Refiner {
    pub fn new(numbers: &Numbers, weights: &'static [u8], frame: &Picture<'_>, target: [f64; 4]) -> Self {
        let first = crop(numbers, frame, target);
        let (opinion, identity) = (numbers.most_trust, numbers.most_logit);
        Self { weights, first, centre: [0.0; 2], sides: [1.0; 2], opinion, identity, doubted_frames: 0 }
    }

    pub fn correct(&self, [x, y, width, height]: [f64; 4]) -> [f64; 4] {
        let axis = |from: f64, side: f64, moved: f64, factor: f64| {
            let new = nearest(side * factor, FINE);
            (from + down(side / 2.0, FINE) + down(moved * new, FINE) - down(new / 2.0, FINE), new)
        };
        let (x, width) = axis(x, width, self.centre[0], self.sides[0]);
        let (y, height) = axis(y, height, self.centre[1], self.sides[1]);
        [x, y, width, height]
    }

    /// Compares the crop of the corrected box with the first crop. Returns the network's estimates.
    pub fn estimates(&self, numbers: &Numbers, frame: &Picture<'_>, target: [f64; 4]) -> Vec<f64> {
        network(self.weights, &self.first, &crop(numbers, frame, self.correct(target)))
    }

    /// Updates the identity by the logit of a frame.
    pub fn identify(&mut self, numbers: &Numbers, logit: f64) {
        self.identity += down((logit - self.identity) * numbers.identity_rate, LOGIT);
    }

    /// The identity, mapped to 0 to 65535.
    pub fn identity(&self, numbers: &Numbers) -> f64 {
        ((self.identity / numbers.most_logit + 1.0) * 32768.0).floor().min(65535.0)
    }

    /// Updates the opinion. Only if the frame was learned, also adds a quarter of the network's estimates to the
    /// correction and then reduces the correction by a sixteenth.
    pub fn update(&mut self, numbers: &Numbers, estimates: &[f64], learned: bool) {
        self.update_opinion(numbers, -(estimates[4] + estimates[5]));
        if !learned {
            return;
        }
        for (centre, estimate) in self.centre.iter_mut().zip(&estimates[..2]) {
            *centre = down((*centre + estimate.clamp(-1.0, 1.0) / 4.0) * 15.0 / 16.0, ESTIMATE).clamp(-0.5, 0.5);
        }
        for (side, estimate) in self.sides.iter_mut().zip(&estimates[2..4]) {
            let grown = *side + down(*side * estimate.clamp(-1.0, 1.0) / 4.0, SCALE);
            *side = (1.0 + down((grown - 1.0) * 15.0 / 16.0, SCALE)).clamp(0.5, 2.0);
        }
    }

    fn update_opinion(&mut self, numbers: &Numbers, trust: f64) {
        let trust = trust.clamp(0.0, numbers.most_trust);
        let rises = self.opinion < numbers.opinion_uncertain_below && self.opinion < trust;
        let rate = if rises { numbers.opinion_rising_rate } else { numbers.opinion_rate };
        self.opinion += down((trust - self.opinion) * rate, ESTIMATE);
        self.doubted_frames = if self.opinion < numbers.opinion_uncertain_below { self.doubted_frames + 1 } else { 0 };
    }

    /// True if the opinion was bad for `opinion_patience` frames in a row: the target is given up.
    pub fn gives_up(&self, numbers: &Numbers) -> bool {
        self.doubted_frames >= numbers.opinion_patience
    }

    /// Sets opinion and identity to those of a target that was found again.
    pub fn begin_again(&mut self, numbers: &Numbers) {
        (self.opinion, self.identity, self.doubted_frames) = (numbers.opinion_found, numbers.identity_found, 0);
    }

    /// Worse of the decisions by opinion and identity: the best state that the tracker may report.
    pub fn decision(&self, numbers: &Numbers) -> Decision {
        let identity = decided(self.identity, f64::NEG_INFINITY, numbers.same_from);
        decided(self.opinion, numbers.opinion_lost_below, numbers.opinion_uncertain_below).max(identity)
    }

    /// Reduces the correction by a quarter, and feeds full trust to the opinion, because alignment made the box exact.
    pub fn fade(&mut self, numbers: &Numbers) {
        self.update_opinion(numbers, numbers.most_trust);
        self.centre = self.centre.map(|centre| down(centre * 0.75, ESTIMATE));
        self.sides = self.sides.map(|side| 1.0 + down((side - 1.0) * 0.75, SCALE));
    }

    /// Bounds (left, top, right, bottom) of the frame pixels that a crop may read if `target` moves by up to `by`
    /// pixels.
    pub fn region(&self, target: [f64; 4], by: f64, frame_size: (i64, i64)) -> [i64; 4] {
        let Lattice { x, y, step, step_down, .. } = lattice(self.correct(target));
        let blocks = step + step_down + 2.0;
        let pixel = |at: f64, size: i64| to_i64(at.floor()).clamp(0, size - 1);
        let range = |middle: f64, step: f64, size: i64| {
            let (middle, reach) = (middle.clamp(0.0, to_f64(size - 1)), 16.0 * step + blocks + by);
            (pixel(middle - reach, size), pixel(middle + reach, size) + 1)
        };
        let ((left, right), (top, bottom)) = (range(x, step, frame_size.0), range(y, step_down, frame_size.1));
        [left, top, right, bottom]
    }
}
