//! Tests every backend against a loop in `i64`.

use super::backends::for_each_backend;
use super::guard::{Guarded, Side};
use super::noise::noise;
use crate::kernels::backend::Backend;
use crate::kernels::dense::{Dense, SPARE};
use crate::kernels::plain::dense::Layer;
use std::vec::Vec;

/// Patches, inputs and outputs: those of the refiner.
const LAYERS: [(usize, usize, usize); 5] = [(16, 20, 8), (8, 72, 16), (8, 144, 24), (4, 216, 24), (1, 384, 24)];

/// The formula of `plain/dense.rs`.
fn expected(layer: Layer<'_>, patches: &[i8]) -> Vec<i8> {
    let mut out = Vec::new();
    for patch in patches.chunks(layer.inputs) {
        for (weights, &bias) in layer.weights.chunks(layer.inputs).zip(layer.biases) {
            let mut sum = i64::from(i32::from_le_bytes(bias));
            for (&x, &w) in patch.iter().zip(weights) {
                sum += i64::from(x) * i64::from(w);
            }
            out.push(i8::try_from((sum >> layer.shift).clamp(0, 127)).unwrap());
        }
    }
    out
}

fn same(backend: Backend, layer: Layer<'_>, patches: &[i8]) {
    let count = patches.len() / layer.inputs;
    let mut memories = [(); 2].map(|()| Guarded::with_room(1 << 14));
    let [for_weights, for_patches] = &mut memories;
    // The scratch memory begins at any place, or there is none.
    let mut spare = std::vec![77; SPARE + 1];
    for (side, room) in [(Side::After, 0..SPARE), (Side::Before, 1..SPARE + 1), (Side::After, 0..0)] {
        let weights = for_weights.copy_signed(layer.weights, side);
        let near = for_patches.copy_signed(patches, side);
        let mut out = std::vec![55; count * layer.biases.len()];
        Dense::new(backend).outputs(Layer { weights, ..layer }, near, &mut spare[room], &mut out);
        assert_eq!(
            out,
            expected(layer, patches),
            "{backend:?}: {count} patches of {}, {} outputs, shift {}",
            layer.inputs,
            layer.biases.len(),
            layer.shift
        );
    }
}

fn shape(backend: Backend, (patches, inputs, outputs): (usize, usize, usize)) {
    let biases: Vec<[u8; 4]> = noise(outputs, 3, 200_000).map(i32::to_le_bytes).collect();
    let weights: Vec<i8> = noise(inputs * outputs, 5, 127).collect();
    let numbers: Vec<i8> = noise(patches * inputs, 7, 127).map(i8::abs).collect();
    for shift in [0, 7, 11, 14, 20] {
        same(backend, Layer { inputs, weights: &weights, biases: &biases, shift }, &numbers);
    }
    // The largest possible sums.
    for sign in [1i8, -1] {
        let weights = std::vec![127 * sign; inputs * outputs];
        let biases = std::vec![(i32::from(sign) << 27).to_le_bytes(); outputs];
        for shift in [0, 20, 21, 22] {
            same(
                backend,
                Layer { inputs, weights: &weights, biases: &biases, shift },
                &std::vec![127; patches * inputs],
            );
        }
    }
}

fn layers_of_the_refiner(backend: Backend) {
    LAYERS.iter().for_each(|&layer| shape(backend, layer));
}

fn odd_shapes(backend: Backend) {
    for inputs in (4..=80).step_by(4).chain([220, 380]) {
        for (patches, outputs) in [(1, 1), (2, 1), (3, 2), (2, 3), (5, 5), (7, 4)] {
            shape(backend, (patches, inputs, outputs));
        }
    }
}

/// With missing weights, an incomplete patch or no inputs the outputs are those of the plain loop, and nothing else is
/// read.
fn wrong_lengths(backend: Backend) {
    let numbers = [100; 64];
    let mut memory = Guarded::with_room(64);
    for (inputs, weights, patches) in [(16, 31, 32), (16, 32, 33), (16, 0, 16), (0, 32, 32), (15, 30, 30), (16, 32, 0)]
    {
        let weights = memory.copy_signed(&numbers[..weights], Side::After);
        let layer = Layer { inputs, weights, biases: &[[1, 0, 0, 0]; 2], shift: 11 };
        let (mut given, mut wanted) = ([9; 7], [9; 7]);
        Dense::new(backend).outputs(layer, &numbers[..patches], &mut [0; SPARE], &mut given);
        Dense::new(Backend::Scalar).outputs(layer, &numbers[..patches], &mut [], &mut wanted);
        assert_eq!(given, wanted, "{backend:?}: {inputs} inputs, {patches} numbers");
    }
}

for_each_backend!(layers_of_the_refiner, odd_shapes, wrong_lengths);
