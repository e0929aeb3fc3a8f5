"""Writes test vectors for the tracker's code: inputs and outputs of the network with the given weights.

    python core/training/vectors.py weights.bin vectors.json

Twenty random pairs of crops (32x32 gray levels, row by row), and the seven outputs for each pair, in units of 1/4096.
"""

import argparse
import hashlib
import json
from pathlib import Path

import cv2
import numpy as np

from refiner_training import crops, integers, weights

PAIRS = 20


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("weights", type=Path)
    parser.add_argument("out", type=Path)
    chosen = parser.parse_args()
    data = chosen.weights.read_bytes()
    pairs = drawn(np.random.default_rng(1))
    outputs = integers.forward(weights.unpacked(data), crops.normalised(pairs).transpose(0, 2, 3, 1))
    vectors = [
        {"first": pair[0].ravel().tolist(), "present": pair[1].ravel().tolist(), "outputs": output.tolist()} for pair, output in zip(pairs, outputs)
    ]
    content = {"weights": hashlib.sha256(data).hexdigest(), "vectors": vectors}
    chosen.out.write_text(json.dumps(content).replace('{"first"', '\n{"first"') + "\n")


def drawn(rng):
    """Draws pairs of crops: blobs of many sizes and contrasts, the first crop inside the second. The last pairs are flat, black and white, noise."""
    pairs = np.array([blobs_twice(rng) for _ in range(PAIRS)])
    pairs[-1] = 77
    pairs[-2] = 255 * rng.integers(0, 2, pairs[-2].shape)
    pairs[-3] = rng.integers(0, 256, pairs[-3].shape)
    pairs[-4, 0] = 0
    return pairs


def blobs_twice(rng):
    first = blobs(rng)
    return level(rng, first), level(rng, np.roll(first, rng.integers(-4, 5, 2), (0, 1)) + 0.4 * blobs(rng))


def blobs(rng):
    smooth = cv2.GaussianBlur(rng.normal(0, 1, (crops.SIDE, crops.SIDE)), (0, 0), rng.uniform(0.5, 4))
    return smooth / smooth.std()


def level(rng, picture):
    contrast, brightness = np.exp(rng.uniform(np.log(1), np.log(100))), rng.uniform(40, 215)
    return np.clip(picture * contrast + brightness, 0, 255).astype(np.uint8)


if __name__ == "__main__":
    main()
