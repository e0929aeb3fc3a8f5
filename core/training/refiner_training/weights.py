"""The weights file. For each layer its biases, i32 little-endian, then for each output its weights, i8, a row padded with zeros to a multiple of 4.

The weights of an output are in the order ky, kx, channel. The first layer's biases subtract the contribution of mean gray, an input of 64.
"""

import numpy as np

from .layers import LARGEST_WEIGHT, LAYERS

SIZE = sum(4 * layer.outputs + layer.outputs * layer.padded_row for layer in LAYERS)


def packed(integers):
    """Packs integers to the bytes of the file."""
    parts = []
    for layer, (biases, rows) in zip(LAYERS, integers):
        assert abs(rows).max() <= LARGEST_WEIGHT
        padded = np.zeros((layer.outputs, layer.padded_row), np.int8)
        padded[:, : layer.row] = rows
        parts += [biases.astype("<i4").tobytes(), padded.tobytes()]
    return b"".join(parts)


def unpacked(data):
    """Unpacks the integers from the bytes of a file."""
    if len(data) != SIZE:
        raise ValueError(f"{len(data)} bytes: expected {SIZE}")
    integers, place = [], 0
    for layer in LAYERS:
        biases = np.frombuffer(data, "<i4", layer.outputs, place)
        place += biases.nbytes
        rows = np.frombuffer(data, np.int8, layer.outputs * layer.padded_row, place).reshape(layer.outputs, -1)
        place += rows.nbytes
        integers.append((biases.astype(np.int32), rows[:, : layer.row].astype(np.int32)))
    return integers
