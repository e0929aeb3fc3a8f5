"""The network in JAX for training: real parameters, which a forward pass may round to 8 bits.

All rounded values and their sums are multiples of a power of two below 2^24 units, so a rounded forward pass in f32 is exact:
it gives the integers of `integers.forward`.
"""

import os

# Limits XLA to one thread, which is as fast for so small a network and keeps the order of sums.
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")

import jax
import jax.numpy as jnp
import numpy as np

from . import crops
from .layers import ACTIVATION_UNIT, LARGEST_ACTIVATION, LARGEST_WEIGHT, LAYERS

# Standard deviation of the last layer's initial weights: small, so that training begins with small corrections.
LAST_DEVIATION = 0.02


def initial(seed):
    """The initial parameters: weights and biases per layer. Convolution weights are (ky, kx, input, output), full layers' (input, output)."""
    rng = np.random.default_rng(seed)
    return [(initial_weights(rng, layer), jnp.zeros(layer.outputs)) for layer in LAYERS]


def initial_weights(rng, layer):
    shape = (3, 3, layer.inputs, layer.outputs) if layer.convolution else (layer.inputs, layer.outputs)
    deviation = LAST_DEVIATION if layer is LAYERS[-1] else (2 / layer.row) ** 0.5
    return jnp.array(rng.normal(0, deviation, shape), jnp.float32)


def whole_weights(weights, layer):
    """Rounds weights to integers in the unit of the weights file."""
    return jnp.round(jnp.clip(weights * 2**layer.shift, -LARGEST_WEIGHT, LARGEST_WEIGHT))


def whole_biases(biases, layer):
    return jnp.round(biases * (ACTIVATION_UNIT << layer.shift))


def whole(parameters):
    """Rounds parameters to the integers of the weights file: per layer, biases and weights (output, input)."""
    integers = []
    for layer, (weights, biases) in zip(LAYERS, parameters):
        # Makes one row for each output, with its weights in the order ky, kx, input. In all layers the output is the last axis of `weights`.
        rows = np.array(whole_weights(weights, layer)).astype(np.int32).reshape(layer.row, layer.outputs).T
        biases = np.array(whole_biases(biases, layer)).astype(np.int32)
        integers.append((biases - crops.ZERO * rows.sum(1) if layer is LAYERS[0] else biases, rows))
    return integers


def with_gradient_of(value, rounded):
    """Returns `rounded` with the gradient of `value`, because rounding has none (straight-through)."""
    return value + jax.lax.stop_gradient(rounded - value)


def rounded_parameters(weights, biases, layer):
    largest = LARGEST_WEIGHT / 2**layer.shift
    weights = with_gradient_of(jnp.clip(weights, -largest, largest), whole_weights(weights, layer) / 2**layer.shift)
    biases = with_gradient_of(biases, whole_biases(biases, layer) / (ACTIVATION_UNIT << layer.shift))
    return weights, biases


def rounded_activation(sums):
    sums = jnp.clip(sums, 0, LARGEST_ACTIVATION / ACTIVATION_UNIT)
    return with_gradient_of(sums, jnp.floor(sums * ACTIVATION_UNIT) / ACTIVATION_UNIT)


def forward(parameters, inputs, rounded):
    """The six outputs for normalised crops (samples, 32, 32, 2). Unrounded activations have no upper bound, which eases the start of training."""
    values = (inputs.astype(jnp.float32) - crops.ZERO) / ACTIVATION_UNIT
    for layer, (weights, biases) in zip(LAYERS, parameters):
        if rounded:
            weights, biases = rounded_parameters(weights, biases, layer)
        sums = product(values, weights, layer) + biases
        if layer is LAYERS[-1]:
            return sums
        values = rounded_activation(sums) if rounded else jax.nn.relu(sums)


def product(values, weights, layer):
    if not layer.convolution:
        return values.reshape(values.shape[0], -1) @ weights
    stride = (layer.stride, layer.stride)
    return jax.lax.conv_general_dilated(values, weights, stride, ((1, 1), (1, 1)), dimension_numbers=("NHWC", "HWIO", "NHWC"))
