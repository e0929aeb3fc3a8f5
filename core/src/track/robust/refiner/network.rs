//! The network of the refiner: four convolutions and two fully connected layers, in integers.
//!
//! | layer | inputs | outputs | step | shift | products |
//! |---|---|---|---|---|---|
//! | convolution 3x3 | 32x32x2: first and present crop | 16x16x8 | 2 | 6 | 40,960 |
//! | convolution 3x3 | 16x16x8 | 8x8x16 | 2 | 7 | 73,728 |
//! | convolution 3x3 | 8x8x16 | 8x8x24 | 1 | 7 | 221,184 |
//! | convolution 3x3 | 8x8x24 | 4x4x24 | 2 | 7 | 82,944 |
//! | full | 384 | 24 | | 8 | 9,216 |
//! | full | 24 | 7 | | none | 168 |
//!
//! A layer computes min(max((bias + sum of weights * inputs) >> shift, 0), 127): see `kernels/plain/dense.rs`. The unit
//! of inputs and outputs is 1/16, that of weights 2^-shift (2^-8 in the last layer). Beyond the edge, inputs of the
//! first layer are 64, those of later layers 0. The seven outputs, in units of 1/4096: the shift of the centre to the
//! right and down, in sides of the box; the logarithms of the factors of width and height; the logarithms of the spread
//! (the expected error) of place and of size, in units of e^-1.5 sides; and a quarter of the logit for the crop showing
//! the target.
//!
//! `weights.bin` holds for each layer its biases (`i32`, little-endian) and its weights (`i8`): for each output its
//! inputs row by row, with zeroes up to a multiple of 4. `weights.json` documents the training.

use super::crop::{MEAN, SAMPLES, SIDE};
#[cfg(smr_helium)]
use crate::kernels::copy;
use crate::kernels::{Dense, Layer, SPARE, rolled};
use crate::track::update::{Budget, units};

/// The network's estimate: the centre's shift to the right and down, in box sides; natural logarithms of the factors
/// that correct width and height; natural logarithms of the expected errors of place and size, where 0 is an error of
/// e^-1.5 box sides; a quarter of the logit for the crop showing the target. Unit of all seven numbers: 1/4096.
pub(crate) type Outputs = [i32; 7];

const FILE: &[u8; BYTES] = include_bytes!("weights.bin");
const BYTES: usize = 4 * ALL_BIASES + ALL_WEIGHTS;
const ALL_BIASES: usize = 8 + 16 + 24 + 24 + 24 + 7;
const ALL_WEIGHTS: usize = 8 * 20 + 16 * 72 + 24 * 144 + 24 * 216 + 24 * 384 + 7 * 24;

/// The bytes of the weights file, for a reference implementation.
#[cfg(feature = "unstable")]
pub(crate) const REFINER_WEIGHTS: &[u8] = FILE;

static BIASES: [[u8; 4]; ALL_BIASES] = split().0;
static WEIGHTS: [i8; ALL_WEIGHTS] = split().1;

/// Splits the file into the biases and the weights of all layers, at compile time.
#[allow(clippy::indexing_slicing)] // at compile time
const fn split() -> ([[u8; 4]; ALL_BIASES], [i8; ALL_WEIGHTS]) {
    let (mut biases, mut weights) = ([[0; 4]; ALL_BIASES], [0; ALL_WEIGHTS]);
    let (mut at, mut bias, mut weight, mut number) = (0, 0, 0, 0);
    while number < LAYERS.len() {
        let (inputs, outputs) = LAYERS[number];
        let (end, last) = (bias + outputs, weight + inputs * outputs);
        while bias < end {
            biases[bias] = [FILE[at], FILE[at + 1], FILE[at + 2], FILE[at + 3]];
            (at, bias) = (at + 4, bias + 1);
        }
        while weight < last {
            weights[weight] = FILE[at].cast_signed();
            (at, weight) = (at + 1, weight + 1);
        }
        number += 1;
    }
    (biases, weights)
}

/// Two counts for each layer: the inputs of one output, padded to a multiple of 4, and the outputs (for a convolution,
/// its output channels).
const LAYERS: [(usize, usize); 6] = [(20, 8), (72, 16), (144, 24), (216, 24), (384, 24), (24, 7)];

/// The shape of a convolution 3x3. Its inputs have a border of one pixel.
#[derive(Clone, Copy)]
struct Convolution {
    /// Width and height of the outputs, in pixels.
    side: usize,
    step: usize,
    channels: usize,
    shift: u32,
}

const CONVOLUTIONS: [Convolution; 4] = [
    Convolution { side: 16, step: 2, channels: 2, shift: 6 },
    Convolution { side: 8, step: 2, channels: 8, shift: 7 },
    Convolution { side: 8, step: 1, channels: 16, shift: 7 },
    Convolution { side: 4, step: 2, channels: 24, shift: 7 },
];
/// The right shift of the sums of the first fully connected layer.
const FULL_SHIFT: u32 = 8;

impl Convolution {
    /// Width and height of the inputs with their border, in pixels.
    const fn across(self) -> usize {
        self.side * self.step + 2
    }
}

fn layer(number: usize, shift: u32) -> Layer<'static> {
    let (mut biases, mut weights) = (BIASES.as_slice(), WEIGHTS.as_slice());
    for &(inputs, outputs) in LAYERS.iter().take(number) {
        biases = biases.get(outputs..).unwrap_or_default();
        weights = weights.get(inputs * outputs..).unwrap_or_default();
    }
    let (inputs, outputs) = LAYERS.get(number).copied().unwrap_or_default();
    let (biases, weights) = (biases.get(..outputs), weights.get(..inputs * outputs));
    Layer { inputs, weights: weights.unwrap_or_default(), biases: biases.unwrap_or_default(), shift }
}

/// The work of the network, in units: one for each product, and one for each byte of input that is copied.
#[allow(clippy::indexing_slicing, clippy::cast_possible_truncation)] // at compile time
pub(super) const WORK: u32 = {
    let (mut sum, mut number) = (2 * SAMPLES, 0);
    while number < LAYERS.len() {
        let (inputs, outputs) = LAYERS[number];
        sum += if number < CONVOLUTIONS.len() {
            CONVOLUTIONS[number].side * CONVOLUTIONS[number].side * inputs * (outputs + 1)
        } else {
            inputs * outputs
        };
        number += 1;
    }
    sum as u32
};

/// Bytes of scratch memory: the patches of one row, the inputs of even layers, those of odd layers, and `SPARE` bytes
/// for the kernels. The present frame's crop lies at the start, until the first patches overwrite it.
const PATCHES: usize = 1152;
const INPUTS: usize = 2592;
pub(super) const ROOM: usize = PATCHES + 2 * INPUTS + SPARE;
#[allow(clippy::indexing_slicing)] // at compile time
const _: () = {
    let mut number = 0;
    while number < CONVOLUTIONS.len() {
        let Convolution { side, channels, .. } = CONVOLUTIONS[number];
        let across = CONVOLUTIONS[number].across();
        assert!(side * LAYERS[number].0 <= PATCHES && across * across * channels <= INPUTS);
        number += 1;
    }
    assert!(SAMPLES <= PATCHES);
};

pub(super) fn room_for_crop(scratch: &mut [i8]) -> Option<&mut [i8; SAMPLES]> {
    scratch.first_chunk_mut()
}

#[derive(Clone, Copy)]
pub(crate) struct Layers {
    /// Index of the present layer, and of the next row of its outputs.
    number: usize,
    row: usize,
}

impl Layers {
    /// Interleaves the first and the present crop as inputs of the first layer. Fills the border with `MEAN`.
    #[inline(never)]
    pub(super) fn begin(first: &[i8], scratch: &mut [i8], budget: &mut Budget) -> Self {
        let [first_layer, ..] = CONVOLUTIONS;
        if let Some([present, inputs, ..]) = regions(scratch) {
            inputs.fill(MEAN);
            let (pairs, _) = inputs.as_chunks_mut::<2>();
            let rows = pairs.chunks_mut(first_layer.across()).skip(1);
            let (first, (present, _)) = (first.as_chunks::<SIDE>().0, present.as_chunks::<SIDE>());
            for (row, (first, present)) in rows.zip(first.iter().zip(present)) {
                let both = first.iter().zip(present);
                rolled(row.iter_mut().skip(1).zip(both))
                    .for_each(|(pair, (&first, &present))| *pair = [first, present]);
            }
        }
        budget.spend(units(2 * SAMPLES));
        Self { number: 0, row: 0 }
    }

    /// Computes one row of a convolution, or both fully connected layers; the latter return the network's estimate.
    #[inline(never)]
    pub(super) fn next_row(&mut self, dense: Dense, scratch: &mut [i8], budget: &mut Budget) -> Option<Outputs> {
        let Some([patches, even, odd, spare]) = regions(scratch) else { return Some([0; 7]) };
        let Some(&convolution) = CONVOLUTIONS.get(self.number) else {
            return Some(full(dense, even, budget));
        };
        let (inputs, outputs) = if self.number.is_multiple_of(2) { (even, odd) } else { (odd, even) };
        let layer = layer(self.number, convolution.shift);
        let count = gather(convolution, layer.inputs, self.row, inputs, patches);
        let (from, row) = self.place(convolution.side, layer.biases.len());
        if self.row == 0 {
            outputs.fill(0);
        }
        let (patches, outputs) = (patches.get(..count), outputs.get_mut(from..from + row));
        dense.outputs(layer, patches.unwrap_or_default(), spare, outputs.unwrap_or_default());
        budget.spend(units(count * (layer.biases.len() + 1)));
        self.row += 1;
        if self.row == convolution.side {
            *self = Self { number: self.number + 1, row: 0 };
        }
        None
    }

    /// The index of the row's first output, and the row's count of outputs. If the next layer is a convolution, the
    /// outputs have a border of one pixel around them.
    fn place(&self, side: usize, channels: usize) -> (usize, usize) {
        let border = usize::from(self.number + 1 < CONVOLUTIONS.len());
        (((self.row + border) * (side + 2 * border) + border) * channels, side * channels)
    }
}

/// Splits the scratch memory into patches, inputs of even layers, inputs of odd layers, and spare bytes.
fn regions(scratch: &mut [i8]) -> Option<[&mut [i8]; 4]> {
    let (patches, inputs) = scratch.split_at_mut_checked(PATCHES)?;
    let (even, inputs) = inputs.split_at_mut_checked(INPUTS)?;
    let (odd, spare) = inputs.split_at_mut_checked(INPUTS)?;
    Some([patches, even, odd, spare])
}

/// Copies the 3x3 input pixels under each output pixel of a row to `patches`. Returns the total length of the patches.
#[inline(never)]
fn gather(of: Convolution, length: usize, row: usize, inputs: &[i8], patches: &mut [i8]) -> usize {
    let patches = patches.chunks_mut(length.max(1)).take(of.side);
    for (x, patch) in patches.enumerate() {
        for (y, patch) in patch.chunks_mut((3 * of.channels).max(1)).take(3).enumerate() {
            let from = ((row * of.step + y) * of.across() + x * of.step) * of.channels;
            let from = inputs.get(from..).unwrap_or_default();
            #[cfg(smr_helium)]
            copy(from, patch);
            // Copies eight bytes at a time if the count of channels is a multiple of 8, else two.
            #[cfg(not(smr_helium))]
            if of.channels.is_multiple_of(8) { copy::<8>(from, patch) } else { copy::<2>(from, patch) }
        }
    }
    of.side * length
}

#[cfg(not(smr_helium))]
fn copy<const N: usize>(from: &[i8], to: &mut [i8]) {
    let pieces = from.as_chunks::<N>().0.iter().zip(to.as_chunks_mut::<N>().0);
    rolled(pieces).for_each(|(from, to)| *to = *from);
}

#[inline(never)]
fn full(dense: Dense, inputs: &[i8], budget: &mut Budget) -> Outputs {
    let ([.., (count, outputs), (_, last)], mut hidden) = (LAYERS, [0; 24]);
    let number = CONVOLUTIONS.len();
    dense.outputs(layer(number, FULL_SHIFT), inputs.get(..count).unwrap_or_default(), &mut [], &mut hidden);
    budget.spend(units(outputs * (count + last)));
    Dense::sums(layer(number + 1, 0), &hidden)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that no layer's sum for inputs of 0 to 127 reaches 2^28 in magnitude, and that no weight is -128.
    #[test]
    fn the_largest_sums() {
        for (number, (inputs, outputs)) in LAYERS.into_iter().enumerate() {
            let Layer { weights, biases, .. } = layer(number, 0);
            assert_eq!((weights.len(), biases.len()), (inputs * outputs, outputs));
            for (row, &bias) in weights.chunks(inputs).zip(biases) {
                let products: i64 = row.iter().map(|&weight| 127 * i64::from(weight).abs()).sum();
                let largest = i64::from(i32::from_le_bytes(bias)).abs() + products;
                assert!(largest < 1 << 28 && !row.contains(&i8::MIN), "{number}: {largest}");
            }
        }
    }

    #[test]
    fn the_recipe_is_that_of_these_weights() {
        let recipe = include_str!("weights.json");
        let bytes = std::format!("\"bytes\": {BYTES}");
        assert!(recipe.contains(&bytes) && recipe.contains("\"half\": \"all\""));
    }
}
