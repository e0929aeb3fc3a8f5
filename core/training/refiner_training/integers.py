"""The network in integers, as the tracker computes it: plain, exact and slow. It specifies the numbers in the weights file.

A layer's output is  clamp((bias + sum of weight * input) >> shift, 0, 127);  the last layer's is the sum itself, in units of 1/4096.
"""

import numpy as np

from . import crops
from .layers import LARGEST_ACTIVATION, LAYERS


def forward(parameters, inputs):
    """Computes the six outputs, i32, for normalised crops (samples, 32, 32, 2) of u8. `parameters`: per layer, biases and weights (output, input)."""
    values = inputs.astype(np.int32)
    for layer, (biases, weights) in zip(LAYERS, parameters):
        # The first layer's inputs are padded by 64, which is mean gray, the others by 0.
        rows = patches(values, layer.stride, crops.ZERO if layer is LAYERS[0] else 0) if layer.convolution else values.reshape(len(values), -1)
        sums = biases + rows @ weights.T.astype(np.int32)
        if layer is LAYERS[-1]:
            return sums
        values = np.clip(sums >> layer.shift, 0, LARGEST_ACTIVATION)


def patches(values, stride, padding):
    """The inputs of each output of a convolution: (samples, rows, columns, 9 * channels), in the order ky, kx, channel."""
    padded = np.pad(values, ((0, 0), (1, 1), (1, 1), (0, 0)), constant_values=padding)
    height, width = values.shape[1:3]
    seen = [padded[:, y : y + height : stride, x : x + width : stride] for y in range(3) for x in range(3)]
    return np.concatenate(seen, -1)


def in_batches(parameters, inputs, size=250):
    """Runs `forward` in batches of `size` samples, to bound the memory."""
    return np.concatenate([forward(parameters, inputs[start : start + size]) for start in range(0, len(inputs), size)])
