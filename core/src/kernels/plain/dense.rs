//! Plain loop of a fully connected layer of a small network. It specifies the results of every backend.
//!
//! ```text
//! out[n, o] = min(max((bias[o] + sum over k of  w[o, k] * x[n, k]) >> shift, 0), 127)
//! ```
//!
//! | symbol | what | type |
//! |---|---|---|
//! | x | input of patch n, 0 to 127 | `i8` |
//! | w | weight of output o, -127 to 127 | `i8` |
//! | bias | | `i32`, within +-2^27 |
//!
//! A patch has at most 384 inputs, so a sum stays below 2^27 + 384 * 127 * 127 < 2^28.

use super::super::unrolling::{rolled, rolled_if_rare};

/// The weights of a layer. Each output has `inputs` weights, a multiple of 4.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layer<'a> {
    pub(crate) inputs: usize,
    pub(crate) weights: &'a [i8],
    /// The biases in little-endian order, one for each output.
    pub(crate) biases: &'a [[u8; 4]],
    pub(crate) shift: u32,
}

/// The sum of one output for one patch, before the shift.
#[inline(always)]
pub(crate) fn sum(layer: Layer<'_>, output: usize, patch: &[i8]) -> i32 {
    let bias = layer.biases.get(output).map_or(0, |&bias| i32::from_le_bytes(bias));
    let weights = layer.weights.get(output * layer.inputs..).unwrap_or_default();
    // On Helium, which has a faster loop, only `rolled_if_rare` keeps this one small. Elsewhere `rolled` does.
    let pairs = rolled_if_rare(rolled(patch.iter().zip(weights)));
    let products = pairs.map(|(&x, &w)| i32::from(x) * i32::from(w));
    bias + products.sum::<i32>()
}

#[inline(always)]
pub(crate) fn outputs_inline(layer: Layer<'_>, patches: &[i8], out: &mut [i8]) {
    let patches = patches.chunks(layer.inputs.max(1));
    for (patch, out) in patches.zip(out.chunks_mut(layer.biases.len().max(1))) {
        for (output, out) in out.iter_mut().enumerate() {
            *out = shifted(sum(layer, output, patch), layer.shift);
        }
    }
}

/// Shifts a sum right by `shift` and clamps it to 0..=127, as an input of the next layer.
#[inline(always)]
pub(crate) fn shifted(sum: i32, shift: u32) -> i8 {
    i8::try_from((sum >> shift).max(0)).unwrap_or(i8::MAX)
}

/// [`outputs_inline`] as one copy, which saves flash. The argument without a name is scratch memory of other backends.
#[inline(never)]
pub(crate) fn outputs(layer: Layer<'_>, patches: &[i8], _: &mut [i8], out: &mut [i8]) {
    outputs_inline(layer, patches, out);
}
