"""Fixtures of the tests: random weights, small synthetic recordings, and a stand-in for host-sim."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from refiner_training.layers import LAYERS

FRAMES = 12


@pytest.fixture
def parameters():
    """Random weights and biases, some of them too large for the weights file."""
    rng = np.random.default_rng(3)
    return [(random_weights(rng, layer), rng.normal(0, 0.5, layer.outputs).astype(np.float32)) for layer in LAYERS]


def random_weights(rng, layer):
    shape = (3, 3, layer.inputs, layer.outputs) if layer.convolution else (layer.inputs, layer.outputs)
    weights = rng.normal(0, (2 / layer.row) ** 0.5, shape).astype(np.float32)
    weights.flat[0] = 3
    return weights


@pytest.fixture
def inputs():
    """Normalised crops: noise, and the least and the largest values."""
    inputs = np.random.default_rng(4).integers(0, 128, (8, 32, 32, 2), dtype=np.uint8)
    inputs[0], inputs[1] = 0, 127
    return inputs


@pytest.fixture
def recordings(tmp_path):
    """A folder of two recordings, one of each half, in which a textured square moves and grows."""
    for seed, name in enumerate(("01_david", "Car1")):
        make_recording(tmp_path / "recordings" / name, np.random.default_rng(seed))
    return tmp_path / "recordings"


def make_recording(folder, rng):
    folder.mkdir(parents=True)
    texture, background = rng.integers(0, 255, (20, 20), dtype=np.uint8), rng.integers(90, 160, (96, 128), dtype=np.uint8)
    video = cv2.VideoWriter(str(folder / "video.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 25, (128, 96), isColor=True)
    lines = []
    for index in range(FRAMES):
        side, left, top = 20 + index, 30 + 2 * index, 20 + index
        frame = background.copy()
        frame[top : top + side, left : left + side] = cv2.resize(texture, (side, side))
        video.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
        lines.append(f"{left},{top},{left + side},{top + side}")
    video.release()
    (folder / "gt.txt").write_text("\n".join(lines) + "\n")


@pytest.fixture
def host_sim(tmp_path):
    """A program that answers with the true box, moved by one pixel, and loses the target once."""
    program = tmp_path / "host-sim"
    program.write_text(
        f"""#!{sys.executable}
import sys
if sys.argv[1] == "--version":
    sys.exit(print("host-sim 0"))
assert sys.argv[3:] == ["--method", "robust", "--set", "refiner=off", "--format", "tld"], sys.argv
for number, line in enumerate(open(sys.argv[2] + "/gt.txt")):
    print("NaN,NaN,NaN,NaN" if number == 5 else ",".join(str(float(word) + 1) for word in line.split(",")))
"""
    )
    program.chmod(0o755)
    return program
