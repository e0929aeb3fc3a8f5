//! The layers of a small network at extreme values and in all shapes (features `verify` and `refiner`).

use super::noise::Noise;
use crate::kernels::backend::Backend;
use crate::kernels::dense::{Dense, SPARE};
use crate::kernels::plain::dense::Layer;

/// Patches, inputs and outputs: those of the refiner, and odd ones.
const SHAPES: [(usize, usize, usize); 16] = [
    (16, 20, 8),
    (8, 72, 16),
    (8, 144, 24),
    (4, 216, 24),
    (1, 384, 24),
    (1, 4, 1),
    (2, 4, 1),
    (3, 4, 2),
    (3, 8, 3),
    (2, 12, 4),
    (5, 28, 5),
    (3, 72, 7),
    (2, 220, 3),
    (0, 16, 2),
    (3, 6, 3),
    (2, 17, 5),
];

/// Compares layers with the plain loop: [`Dense::outputs`] does so in each call.
#[inline(never)] // keeps its stack out of the caller's frame
pub(super) fn layers(noise: &mut Noise) {
    for (count, inputs, outputs) in SHAPES {
        for sign in [0, 1, -1] {
            // Noise, or the largest sums.
            let mut number = |most: i32| if sign == 0 { noise.next(most.unsigned_abs()) } else { sign * most };
            let small = |number: i32| i8::try_from(number).unwrap_or(0);
            let biases: heapless::Vec<[u8; 4], 24> = (0..outputs).map(|_| number(1 << 27).to_le_bytes()).collect();
            let weights: heapless::Vec<i8, 9216> = (0..inputs * outputs).map(|_| small(number(127))).collect();
            let patches: heapless::Vec<i8, 1152> = (0..count * inputs).map(|_| small(number(127).abs())).collect();
            // With small biases the products decide.
            let none = [[0; 4]; 24];
            for (biases, shift) in [(&*biases, 20), (&*biases, 21), (&none, 0), (&none, 9), (&none, 13)] {
                let biases = biases.get(..outputs).unwrap_or_default();
                let (mut out, spare) = ([0; 256], &mut [0; SPARE]);
                let out = out.get_mut(..count * outputs).unwrap_or_default();
                let dense = Dense::new(Backend::best());
                dense.outputs(Layer { inputs, weights: &weights, biases, shift }, &patches, spare, out);
                // A weight, an input or an output is missing.
                let short = Layer { inputs, weights: weights.get(1..).unwrap_or_default(), biases, shift };
                dense.outputs(short, &patches, spare, out);
                let layer = Layer { weights: &weights, ..short };
                dense.outputs(layer, patches.get(1..).unwrap_or_default(), spare, out);
                out.fill(0);
                dense.outputs(layer, &patches, &mut [], out.get_mut(1..).unwrap_or_default());
            }
        }
    }
}
