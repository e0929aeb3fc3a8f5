"""Tests that the network in JAX and in integers agree, and the weights file."""

import numpy as np
import pytest

from refiner_training import integers, network, weights
from refiner_training.layers import LAYERS, OUTPUT_UNIT


def test_the_size_of_the_file():
    assert weights.SIZE == 4 * (8 + 16 + 24 + 24 + 24 + 7) + 8 * 20 + 16 * 72 + 24 * 144 + 24 * 216 + 24 * 384 + 7 * 24 == 19748


def test_jax_and_integers_agree(parameters, inputs):
    exact = integers.forward(network.whole(parameters), inputs)
    outputs = np.array(network.forward(parameters, inputs, rounded=True)) * OUTPUT_UNIT
    assert np.array_equal(outputs, exact)
    assert np.ptp(exact, axis=0).min() > 1000


def test_rounding_changes_little(parameters, inputs):
    for weights_of_layer, _ in parameters:
        weights_of_layer.flat[0] = 0
    parameters = [(weights_of_layer / 4, biases / 8) for weights_of_layer, biases in parameters]
    exact = np.array(network.forward(parameters, inputs, rounded=False))
    rounded = np.array(network.forward(parameters, inputs, rounded=True))
    assert abs(exact - rounded).max() < 0.05


def test_a_file_holds_what_was_packed(parameters):
    whole = network.whole(parameters)
    data = weights.packed(whole)
    assert len(data) == weights.SIZE
    for (biases, rows), (biases_read, rows_read) in zip(whole, weights.unpacked(data)):
        assert np.array_equal(biases, biases_read) and np.array_equal(rows, rows_read)
    with pytest.raises(ValueError):
        weights.unpacked(data[:-1])


def at(data, kind, place):
    return int(np.frombuffer(data, kind, 1, place)[0])


def forward_plainly(data, inputs):
    """Computes the outputs of one sample from the bytes of the file, number by number."""
    values = inputs.astype(int)
    place = 0
    for number, layer in enumerate(LAYERS):
        biases = [at(data, "<i4", place + 4 * output) for output in range(layer.outputs)]
        place += 4 * layer.outputs
        rows = [
            [at(data, "i1", place + output * layer.padded_row + column) for column in range(layer.padded_row)] for output in range(layer.outputs)
        ]
        place += layer.outputs * layer.padded_row
        seen = seen_plainly(values, layer.stride, 64 if number == 0 else 0) if layer.convolution else [[list(values.ravel())]]
        sums = np.array([[[bias + sum(w * x for w, x in zip(row, patch)) for bias, row in zip(biases, rows)] for patch in line] for line in seen])
        values = np.clip(sums >> layer.shift, 0, 127)
    return sums.ravel()


def seen_plainly(values, stride, padding):
    height, width, channels = values.shape

    def pixel(y, x):
        return list(values[y, x]) if 0 <= y < height and 0 <= x < width else [padding] * channels

    def patch(y, x):
        return [number for ky in (-1, 0, 1) for kx in (-1, 0, 1) for number in pixel(y + ky, x + kx)]

    return [[patch(y, x) for x in range(0, width, stride)] for y in range(0, height, stride)]


def test_the_bytes_mean_what_the_format_says(parameters, inputs):
    whole = network.whole(parameters)
    assert list(forward_plainly(weights.packed(whole), inputs[5])) == list(integers.forward(whole, inputs[5:6])[0])
